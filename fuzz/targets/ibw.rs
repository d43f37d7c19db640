//! Any bytes for the reader of Igor ibw.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("Igor ibw", bytes));
