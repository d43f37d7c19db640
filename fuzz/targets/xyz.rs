//! Any bytes for the reader of xyz.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("xyz", bytes));
