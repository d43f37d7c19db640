//! Any bytes for the reader of x3p.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("x3p", bytes));
