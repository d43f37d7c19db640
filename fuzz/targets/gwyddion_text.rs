//! Any bytes for the reader of Gwyddion text.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("Gwyddion text", bytes));
