//! Any bytes for the reader of FRT MicroProf.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("FRT MicroProf", bytes));
