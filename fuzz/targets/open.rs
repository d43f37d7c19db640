//! Any bytes, by whatever reader claims them first.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::open(bytes));
