//! The library linked by `arm-none-eabi-gcc` for a Cortex-M4F: what it takes, and what is not in it.

use std::path::Path;

use asperity_needs::absent;
use asperity_tests::code;

use crate::table::Example;
use crate::tools::{Scope, capi, compiler, device_library, run};

/// Bytes of flash of a firmware that evaluates GGX.
const GGX: usize = 4096;
/// The same for a table, beside its arrays: the transmission of one, and all four lobes.
const TABLE: [usize; 2] = [4096, 5120];

/// Links a C file with the library for the device.
fn link(source: &Path, scope: Scope, to: &Path, settings: &[&str]) -> Result<(), String> {
    let library = device_library(scope)?;
    let mut gcc = compiler("arm-none-eabi-gcc", "c99");
    gcc.args(["-mcpu=cortex-m4", "-mthumb", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard", "-Os"])
        .args([
            "-ffunction-sections",
            "-fdata-sections",
            "-Wl,--gc-sections",
            "--specs=nosys.specs",
        ])
        .args(settings)
        .arg(source)
        .arg("-o")
        .arg(to)
        .arg(library)
        .arg("-lm");
    run(&mut gcc, "gcc-arm-none-eabi libnewlib-arm-none-eabi").map(drop)
}

/// What a binary utility says about a program.
fn ask(utility: &str, settings: &[&str], elf: &Path) -> String {
    let mut command = std::process::Command::new(utility);
    let out = run(command.args(settings).arg(elf), "binutils-arm-none-eabi").unwrap();
    String::from_utf8(out.stdout).unwrap()
}

/// Code, constants and initial values.
fn flash(elf: &Path) -> usize {
    let said = ask("arm-none-eabi-size", &[], elf);
    let mut numbers = said.lines().nth(1).unwrap().split_whitespace();
    let mut next = || numbers.next().unwrap().parse::<usize>().unwrap();
    next() + next()
}

fn assert_clean(elf: &Path, unwanted: &[&str]) {
    let names = ask("arm-none-eabi-nm", &[], elf);
    assert!(names.contains("asperity_ggx_eval") || names.contains("asperity_table_eval"));
    for name in names.lines() {
        assert!(!unwanted.iter().any(|u| name.contains(u)), "in the firmware: {name}");
    }
}

/// Panics, their texts and Rust's allocator.
const RUST: [&str; 6] =
    ["panicking", "rust_begin_unwind", "core3fmt", "__rust_alloc", "__rg_alloc", "__rdl_alloc"];

#[test]
#[allow(clippy::print_stdout, reason = "shown with --nocapture")]
fn a_firmware_in_c_is_small_and_neither_panics_nor_allocates() {
    let folder = tempfile::tempdir().unwrap();
    let arrays = Example::read().bytes();
    for (name, scope, beside, most) in [
        ("ggx", Scope::Whole, 0, GGX),
        ("ggx", Scope::Transmission, 0, GGX),
        ("table", Scope::Transmission, arrays, TABLE[0]),
        ("table", Scope::Whole, arrays, TABLE[1]),
    ] {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("capi/firmware").join(name);
        let elf = folder.path().join(name).with_extension("elf");
        let settings = ["-nostartfiles", "-Wl,-e,reset"];
        if let Err(remedy) = link(&source.with_extension("c"), scope, &elf, &settings) {
            return absent(&remedy);
        }
        let bytes = flash(&elf) - beside;
        let most = code::limit(most);
        println!("flash: {name}, {scope:?}: {bytes} bytes beside {beside} of arrays");
        let symbols = || ask("arm-none-eabi-nm", &["-S", "--size-sort"], &elf);
        assert!(bytes <= most, "{bytes}\n{}", symbols());
        assert_clean(&elf, &[&RUST[..], &["malloc", "_sbrk"]].concat());
    }
}

#[test]
#[allow(clippy::print_stdout, reason = "shown with --nocapture")]
fn the_c_example_links_for_a_cortex_m4f() {
    let folder = tempfile::tempdir().unwrap();
    let elf = folder.path().join("evaluate.elf");
    match link(&capi().join("examples/evaluate.c"), Scope::Whole, &elf, &[]) {
        Ok(()) => println!("{}", ask("arm-none-eabi-size", &[], &elf)),
        Err(remedy) => return absent(&remedy),
    }
    // printf of newlib allocates; nothing of Rust does
    assert_clean(&elf, &RUST);
}
