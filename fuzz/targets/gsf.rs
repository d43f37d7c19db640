//! Any bytes for the reader of Gwyddion gsf.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("Gwyddion gsf", bytes));
