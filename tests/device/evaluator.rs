//! The least firmware that evaluates one law: what it takes, what is not in it, and that it is right.

use std::fs;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use asperity::embedded::{self, Values};
use asperity::output::AtomicFile;
use asperity_core::bsdf::{Bsdf, Ggx, Normals};
use asperity_core::direction::Direction;
use asperity_core::math::{Fast, Real};
use asperity_core::ndf::law::{Law, Profile};
use asperity_core::ndf::normals::NormalDensity;
use asperity_core::quantity::{Alpha, RelativeIor};
use asperity_needs::absent;

use crate::elf;
use crate::emulator::{TARGET, build};
/// What `FROM_SENSOR` of the firmware holds.
const WI: [f32; 3] = [-0.36, 0.0, 0.8];
const WO: [f32; 3] = [0.28, 0.1, -0.9];

/// Where the RAM of the board is, and how much of it the firmware has.
const RAM: (usize, usize) = (0x2000_0000, 16 * 1024);

/// What `cortex-m-rt` paints the stack with.
const PAINT: u32 = 0xcccc_cccc;

fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().into()
}

/// Builds the firmware with a law, or with none.
fn firmware(law: &str) -> Result<Vec<u8>, String> {
    let package = ["--package", "asperity-evaluator", "--profile", "firmware", "--features", law];
    let folder = build(&package, "")?;
    Ok(fs::read(folder.join(TARGET).join("firmware").join("evaluator")).unwrap())
}

fn value<T: Real>(law: &impl Bsdf<T>) -> f32 {
    let w = |v: [f32; 3]| {
        let [x, y, z] = v.map(|x| T::from_f64(f64::from(x)));
        Direction::new(x, y, z).unwrap()
    };
    law.eval(w(WI), w(WO)).to_f64() as f32
}

/// What the host makes of the same law.
fn expected(law: &str) -> f32 {
    let eta = RelativeIor::new(1.49_f32).unwrap();
    match law {
        "ggx" => value(&Ggx::new(Alpha::new(0.25_f32).unwrap(), eta)),
        "normals" => {
            let angles = Law::new(Profile::Gauss, Fast(0.2_f32), Fast(2.0), Fast(0.0)).unwrap();
            value(&Normals::<_, 64>::new(NormalDensity::new(angles), eta.cast()))
        }
        _ => {
            let (table, _) = embedded::read(&example()).unwrap();
            let Values::U16(values) = table.values() else { panic!("another storage") };
            value::<f32>(&table.view(values).unwrap())
        }
    }
}

fn example() -> PathBuf {
    workspace().join("host/capi/examples/bsdf_example.bsdft")
}

/// Bytes of RAM as words, when the firmware has put a value at an address.
fn memory(elf: &Path, result: usize) -> Result<Vec<u32>, String> {
    let settings = ["-M", "mps2-an386", "-cpu", "cortex-m4", "-display", "none", "-serial", "null"];
    for patience in [300, 1000, 4000, 15000, 60000] {
        let started = Command::new("qemu-system-arm")
            .args(settings)
            .args(["-monitor", "stdio", "-kernel"])
            .arg(elf)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn();
        let mut qemu = match started {
            Err(e) if e.kind() == ErrorKind::NotFound => {
                return Err("no qemu-system-arm; on Debian: apt-get install qemu-system-arm".into());
            }
            started => started.unwrap(),
        };
        std::thread::sleep(Duration::from_millis(patience));
        let ask = format!("xp /{}xw {:#x}\nquit\n", RAM.1 / 4, RAM.0);
        qemu.stdin.take().unwrap().write_all(ask.as_bytes()).unwrap();
        let out = qemu.wait_with_output().unwrap();
        // "0000000020000000: 0x00000000 0x12345678 ..."
        let words: Vec<u32> = String::from_utf8_lossy(&out.stdout)
            .lines()
            .filter_map(|line| line.split_once(": 0x"))
            .flat_map(|(_, words)| words.split_whitespace().map(String::from).collect::<Vec<_>>())
            .map(|word| u32::from_str_radix(word.trim_start_matches("0x"), 16).unwrap())
            .collect();
        assert_eq!(words.len(), RAM.1 / 4);
        // before the program runs, its variable is zero; its start paints the stack, then sets NaN
        let word = words[(result - RAM.0) / 4];
        if word != 0 && word != PAINT && !f32::from_bits(word).is_nan() {
            return Ok(words);
        }
    }
    panic!("the firmware gives no value");
}

/// A program without texts of a panic and without an allocator.
fn assert_clean(elf: &[u8]) {
    let names = elf::symbols(elf).unwrap();
    assert!(names.iter().any(|n| n.contains("Reset")), "no symbols in the firmware");
    let unwanted = [
        "panicking",
        "panic_fmt",
        "core3fmt",
        "__rust_alloc",
        "__rg_alloc",
        "__rdl_alloc",
        "malloc",
    ];
    for name in &names {
        assert!(!unwanted.iter().any(|u| name.contains(u)), "in the firmware: {name}");
    }
}

/// Bytes of the values and gains of the table in the firmware.
fn numbers_of_the_table() -> usize {
    let (table, _) = asperity::embedded::read(&example()).unwrap();
    let [gains, values, ..] = table.header().lengths();
    4 * gains + 2 * values
}

#[test]
#[allow(clippy::print_stdout, reason = "shown with --nocapture")]
fn the_least_firmware_of_each_law_is_small_clean_and_right() {
    let folder = tempfile::tempdir().unwrap();
    // numbers of the table that are looked at: its values and gains
    let numbers = numbers_of_the_table();
    // law, flash with all numbers of the law, RAM with the stack
    for (law, most_flash, most_ram) in
        [("ggx", 4096, 1024), ("table", 4096 + numbers, 1024), ("normals", 32 * 1024, 8 * 1024)]
    {
        let elf = match firmware(law) {
            Ok(elf) => elf,
            Err(remedy) => return absent(&remedy),
        };
        assert_clean(&elf);
        let path = folder.path().join(law);
        fs::write(&path, &elf).unwrap();
        let of = |section: &str| elf::section(&elf, section).unwrap();
        let flash = of(".text") + of(".rodata") + of(".data");
        let (result, end) =
            (elf::address(&elf, "TO_MOTOR").unwrap(), elf::address(&elf, "_stack_end").unwrap());
        let words = match memory(&path, result) {
            Ok(words) => words,
            Err(remedy) => return absent(&remedy),
        };
        let got = f32::from_bits(words[(result - RAM.0) / 4]);
        assert!(got > 0.0);
        assert_eq!(got.to_bits(), expected(law).to_bits(), "{law}: {got}, here {}", expected(law));
        let unused = words[(end - RAM.0) / 4..].iter().take_while(|word| **word == PAINT).count();
        let (variables, stack) = (end - RAM.0, RAM.0 + RAM.1 - end - 4 * unused);
        println!(
            "{law}: flash {flash} bytes and {} of vectors; RAM: {variables} of variables, {stack} of stack",
            of(".vector_table")
        );
        assert!(flash <= most_flash && stack > 0 && variables + stack <= most_ram);
    }
}

#[test]
fn the_table_of_the_evaluator_is_the_generated_one() {
    let (table, record) = embedded::read(&example()).unwrap();
    if std::env::var_os("ASPERITY_BLESS").is_some() && record.notice().is_some() {
        let file = AtomicFile::create(example()).unwrap();
        embedded::write(file, &table, &record.method, record.distance_percent).unwrap();
    }
    let fresh = embedded::rust_source(&table, &record.method);
    let path = workspace().join("firmware-sim/evaluator/src/example.rs");
    if std::env::var_os("ASPERITY_BLESS").is_some() {
        fs::write(&path, &fresh).unwrap();
    }
    assert!(
        fs::read_to_string(&path).unwrap_or_default() == fresh,
        "firmware-sim/evaluator/src/example.rs is not that of bsdf_example.bsdft; make it anew: \
         ASPERITY_BLESS=1 cargo test -p asperity-tests --test device generated"
    );
}
