//! Any bytes for the reader of MountainsMap mnt.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asperity_fuzz::reader("MountainsMap mnt", bytes));
