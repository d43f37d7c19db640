//! Files of scatter of every format.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::scatter(bytes));
