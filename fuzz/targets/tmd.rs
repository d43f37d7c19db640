//! Any bytes for the reader of TrueMap tmd.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("TrueMap tmd", bytes));
