//! Any bytes for the reader of Keyence CSV.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("Keyence CSV", bytes));
