//! Graphs for the tests and benches of the workspace, and an allocator that counts.

pub mod allocations;
pub mod families;
pub mod graphs;

/// The generators of [`graphs`] with their graphs in the type that says what they guarantee.
///
/// A macro, because that type is one in the unit tests of the crate that defines it and another everywhere else.
#[macro_export]
macro_rules! checked_graphs {
    ($Graph:path) => {
        $crate::checked_graphs! { $Graph:
            from_edges(n: usize, edges: &[(usize, usize)]);
            from_weighted_edges(n: usize, edges: &[(usize, usize, f64)]);
            path(n: usize);
            cycle(n: usize);
            complete(n: usize);
            star(n: usize);
            hypercube(d: usize);
            grid(rows: usize, cols: usize);
            rooms(rows: usize, cols: usize, side: usize);
            maze(rows: usize, cols: usize, loops: f64, seed: u64);
            random(n: usize, mean_degree: f64, seed: u64);
        }

        /// The graph of a generator, checked.
        pub fn checked(graph: $crate::graphs::Csr) -> $Graph {
            <$Graph>::new(graph).expect("generators give undirected graphs")
        }

        #[allow(dead_code)]
        pub fn disjoint(parts: &[$Graph]) -> $Graph {
            let parts: Vec<_> = parts.iter().map(|part| part.as_csr().clone()).collect();
            checked($crate::graphs::disjoint(&parts))
        }

        #[allow(dead_code)]
        pub fn discovered(graph: &$Graph, seed: u64) -> $Graph {
            checked($crate::graphs::discovered(graph.as_csr(), seed))
        }

        #[allow(dead_code)]
        pub fn shuffled(graph: &$Graph, seed: u64) -> $Graph {
            checked($crate::graphs::shuffled(graph.as_csr(), seed))
        }

        #[allow(dead_code)]
        pub fn prefix(graph: &$Graph, m: usize) -> $Graph {
            checked($crate::graphs::prefix(graph.as_csr(), m))
        }
    };
    ($Graph:path: $($name:ident($($argument:ident: $type:ty),*);)*) => {
        $(
            #[allow(dead_code)]
            pub fn $name($($argument: $type),*) -> $Graph {
                checked($crate::graphs::$name($($argument),*))
            }
        )*
    };
}
