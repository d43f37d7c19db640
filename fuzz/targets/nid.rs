//! Any bytes for the reader of Nanosurf nid.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("Nanosurf nid", bytes));
