//! A foreign CSV file with named columns.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::foreign(bytes));
