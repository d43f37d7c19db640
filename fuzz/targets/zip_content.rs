//! Any bytes as a file in a zip archive.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::zip_content(bytes));
