#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| tests_fuzz::link::converse(input));
