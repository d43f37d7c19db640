//! The device side, run: the self test on a Cortex-M4F must give this machine's bits.
//!
//! Needs `qemu-system-arm` and the Rust target `thumbv7em-none-eabihf`. Without them the tests say what
//! to install and pass; where the environment variable `CI` is set they fail. `ASPERITY_DEVICE_ENV`,
//! assignments separated by blanks, is given to the compiler run for the device (see `.ci/run`).
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests may fail")]

mod corruption;
mod elf;
mod emulator;
mod protocol;

use std::io::Write as _;

use asperity_firmware_sim::selftest;

/// Says that a test cannot run here; `cargo test` shows what goes to standard error directly.
fn skip(remedy: &str) {
    let ci = std::env::var("CI").is_ok_and(|v| !v.is_empty() && v != "false");
    assert!(!ci, "{remedy} (a failure, not a skip, because CI is set)");
    let _ = writeln!(std::io::stderr(), "skipped: {remedy}");
}

#[test]
#[allow(clippy::print_stdout, reason = "shown with --nocapture")]
fn the_self_test_gives_the_same_bits_on_a_cortex_m4f() {
    let firmware = match emulator::firmware().and_then(|elf| emulator::run(&elf)) {
        Ok(output) => output,
        Err(remedy) => return skip(&remedy),
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

#[test]
#[allow(clippy::print_stdout, reason = "shown with --nocapture")]
fn the_firmware_has_no_allocator_and_fits_a_small_flash() {
    let elf = match emulator::firmware() {
        Ok(path) => std::fs::read(path).unwrap(),
        Err(remedy) => return skip(&remedy),
    };
    let names = elf::symbols(&elf).unwrap();
    // if the names were stripped, finding no allocator would mean nothing
    assert!(names.iter().any(|n| n.contains("Reset")), "no symbols in the firmware");
    for name in &names {
        let allocator =
            ["__rust_alloc", "__rg_alloc", "__rdl_alloc"].iter().any(|a| name.contains(a));
        assert!(!allocator, "the firmware allocates: {name}");
    }
    let flash = elf::loaded_bytes(&elf).unwrap();
    println!("flash: {flash} bytes");
    assert!(flash < 128 * 1024, "{flash} bytes: too large for a small instrument");
}
