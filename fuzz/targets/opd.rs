//! Any bytes for the reader of Wyko opd.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("Wyko opd", bytes));
