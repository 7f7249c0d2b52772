#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| eigentrail::fuzzing::checkpoint(bytes));
