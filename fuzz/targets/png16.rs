//! Any bytes for the reader of PNG.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("PNG", bytes));
