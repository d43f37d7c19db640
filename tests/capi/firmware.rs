//! The library linked by `arm-none-eabi-gcc` for a Cortex-M4F: what it takes, and what is not in it.

use std::path::{Path, PathBuf};

use crate::table::Example;
use crate::tools::{capi, compiler, device_library, run, skip};

/// Bytes of flash of a firmware that evaluates GGX.
const GGX: usize = 4096;
/// Of one that evaluates a table, beside the table. The evaluator with its checks takes 1.9 KiB of that; the rest is
/// start-up, which reads the header and makes views of arrays.
const TABLE: usize = 5376;

/// Links a C file with the library for the device.
fn link(source: &Path, to: &Path, settings: &[&str]) -> Result<(), String> {
    let library = device_library()?;
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
    let build = |name: &str| -> Result<PathBuf, String> {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("capi/firmware").join(name);
        let elf = folder.path().join(name).with_extension("elf");
        link(&source, &elf, &["-nostartfiles", "-Wl,-e,reset"])?;
        Ok(elf)
    };
    let (ggx, table) = match (build("ggx.c"), build("table.c")) {
        (Ok(ggx), Ok(table)) => (ggx, table),
        (Err(remedy), _) | (_, Err(remedy)) => return skip(&remedy),
    };
    let arrays = Example::read().bytes();
    let (of_ggx, of_table) = (flash(&ggx), flash(&table) - arrays);
    println!("flash: GGX {of_ggx} bytes, table {of_table} bytes beside {arrays} of arrays");
    assert!(of_ggx <= GGX, "{of_ggx}\n{}", ask("arm-none-eabi-nm", &["-S", "--size-sort"], &ggx));
    assert!(
        of_table <= TABLE,
        "{of_table}\n{}",
        ask("arm-none-eabi-nm", &["-S", "--size-sort"], &table)
    );
    for elf in [&ggx, &table] {
        assert_clean(elf, &[&RUST[..], &["malloc", "_sbrk"]].concat());
    }
}

#[test]
#[allow(clippy::print_stdout, reason = "shown with --nocapture")]
fn the_c_example_links_for_a_cortex_m4f() {
    let folder = tempfile::tempdir().unwrap();
    let elf = folder.path().join("evaluate.elf");
    match link(&capi().join("examples/evaluate.c"), &elf, &[]) {
        Ok(()) => println!("{}", ask("arm-none-eabi-size", &[], &elf)),
        Err(remedy) => return skip(&remedy),
    }
    // printf of newlib allocates; nothing of Rust does
    assert_clean(&elf, &RUST);
}
