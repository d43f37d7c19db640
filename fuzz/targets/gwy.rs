//! Any bytes for the reader of Gwyddion gwy.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("Gwyddion gwy", bytes));
