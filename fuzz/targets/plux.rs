//! Any bytes for the reader of Sensofar plux.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("Sensofar plux", bytes));
