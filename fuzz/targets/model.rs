//! The model file.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::model(bytes));
