//! Any bytes for the reader of Vision opdx.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("Vision opdx", bytes));
