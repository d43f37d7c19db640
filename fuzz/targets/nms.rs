//! Any bytes for the reader of NanoFocus nms.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("NanoFocus nms", bytes));
