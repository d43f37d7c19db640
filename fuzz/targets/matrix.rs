//! Any bytes for the reader of matrix text.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("matrix text", bytes));
