//! Any bytes for the reader of SDF.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("SDF", bytes));
