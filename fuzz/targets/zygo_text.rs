//! Any bytes for the reader of Zygo text.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("Zygo text", bytes));
