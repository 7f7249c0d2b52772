//! An allocator that counts, for tests of what allocates nothing and for measurements of memory.
//!
//! ```
//! use eigentrail_testing::allocations::{Counting, allocations};
//!
//! #[global_allocator]
//! static ALLOCATOR: Counting = Counting;
//!
//! let before = allocations();
//! let _boxed = Box::new(1);
//! assert_eq!(allocations() - before, 1);
//! ```

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicIsize, Ordering};

/// The system's allocator, counting what each thread asks for and what all of them hold.
#[derive(Clone, Copy, Debug)]
pub struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

static HELD: AtomicIsize = AtomicIsize::new(0);

/// Bytes that the program holds; 0 for ever unless [`Counting`] is its allocator.
pub fn held_bytes() -> isize {
    HELD.load(Ordering::Relaxed)
}

/// How often the present thread has asked for memory; 0 for ever unless [`Counting`] is the program's allocator.
pub fn allocations() -> u64 {
    ALLOCATIONS.get()
}

#[allow(unsafe_code, reason = "allocators are")]
// SAFETY: hands everything on to the system's allocator; the counters are a plain cell of the thread and an atomic number.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        HELD.fetch_add(layout.size() as isize, Ordering::Relaxed);
        // SAFETY: as the caller vouches.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size() as isize, Ordering::Relaxed);
        // SAFETY: as the caller vouches.
        unsafe { System.dealloc(pointer, layout) }
    }
}
