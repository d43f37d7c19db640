//! The same for an npz file of one array.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::npz_content(bytes));
