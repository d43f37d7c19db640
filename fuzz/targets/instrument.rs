//! Bytes from anybody to the simulated instrument.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::instrument(bytes));
