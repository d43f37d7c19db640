//! Any bytes for the reader of npy/npz.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("npy/npz", bytes));
