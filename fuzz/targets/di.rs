//! Any bytes for the reader of Bruker/DI.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("Bruker/DI", bytes));
