//! An x3p file whose parts are arbitrary but whose archive is sound: checksums of the archive stop damage to a whole one.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::x3p_content(bytes));
