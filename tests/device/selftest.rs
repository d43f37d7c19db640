//! The self test, on the device and here: the same bits.

use asperity_firmware_sim::selftest;
use asperity_needs::absent;

use crate::emulator::{self, Firmware};
#[test]
#[allow(clippy::print_stdout, reason = "shown with --nocapture")]
fn the_self_test_gives_the_same_bits_on_a_cortex_m4f() {
    let firmware = match Firmware::SelfTest.path().and_then(|elf| emulator::run(&elf)) {
        Ok(output) => output,
        Err(remedy) => return absent(&remedy),
    };
    println!("{firmware}");
    let mut lines = firmware.lines();
    for (name, digest) in selftest::sections() {
        let line = lines.next().unwrap_or_default();
        let expected = format!("section {name} {digest:016x} ");
        assert!(line.starts_with(&expected), "host: {expected}\ndevice: {line}\n{firmware}");
    }
    assert_eq!(lines.next(), Some(&*format!("digest {:016x}", selftest::digest())));
    let per_call = lines.next().and_then(|l| l.strip_prefix("ggx-eval-f32 ")).unwrap();
    let per_call: u32 = per_call.parse().unwrap();
    // 72 in November 2026; software square roots would add 70 each
    assert!((10..150).contains(&per_call), "{per_call} instructions for one GGX evaluation");
    assert_eq!(lines.next(), Some("ok"));
}
