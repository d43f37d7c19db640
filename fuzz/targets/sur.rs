//! Any bytes for the reader of Digital Surf sur.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("Digital Surf sur", bytes));
