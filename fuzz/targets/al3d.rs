//! Any bytes for the reader of Alicona al3d.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("Alicona al3d", bytes));
