//! Files of height maps that cannot be: each is refused in two lines that name file, fault and remedy,
//! and in little memory, whatever sizes it claims.

use std::fmt::Write as _;
use std::process::Command;

use png::{BitDepth, ColorType};
use tiff::encoder::colortype::{Gray16, Gray32Float};
use tiff::tags::Tag;

use crate::map_files::{
    Entry, al3d, array, di, gwy, huge, main_xml, npy, opd, png, sdf, sdf_text, stored, sur, tiff,
    with_tag, x3p, zeros, zip,
};
use crate::program::{Done, Folder, program};
use crate::refusal::{SCAN, faults};

/// Address space of the program, KiB: libraries and stacks included.
const MOST_KIB: u64 = 300 << 10;

/// A name, a content, and what must be said besides the name.
type Case = (&'static str, Vec<u8>, &'static str);

/// Runs `stats`, with its memory limited where the system can.
fn stats(folder: &Folder, file: &str, flags: &str) -> Done {
    if !cfg!(target_os = "linux") {
        return folder.run(&format!("stats {file} {flags}"));
    }
    let line = format!("ulimit -v {MOST_KIB}; exec \"$0\" stats {file} {flags}");
    let mut command = Command::new("sh");
    command.arg("-c").arg(line).arg(program()).current_dir(folder.path("."));
    command.output().expect("a shell").into()
}

#[track_caller]
fn refused(flags: &str, cases: Vec<Case>) {
    let mut report = String::new();
    let folder = Folder::new();
    for (name, content, says) in cases {
        folder.write(name, content);
        let done = stats(&folder, name, flags);
        let found = faults(&done, &[name, says]);
        if !found.is_empty() {
            let _ = writeln!(report, "{name}: {}\n  {:?}", found.join("; "), done.err);
        }
    }
    assert!(report.is_empty(), "\n{report}");
}

/// The first part of a file.
fn cut(mut file: Vec<u8>, bytes: usize) -> Vec<u8> {
    file.truncate(bytes);
    file
}

#[test]
fn what_is_no_map() {
    refused(
        "",
        vec![
            ("empty", vec![], "is empty"),
            ("noise", (0..2000_u32).map(|k| (k * k * 31 / 128) as u8).collect(), "one of x3p"),
            ("prose.txt", b"it was a dark and stormy night\n".to_vec(), "one of x3p"),
            ("scan.csv", SCAN.into(), "one of x3p"),
            ("other.zip", zip(&[stored("readme", "hello")]), "one of x3p"),
            ("unscaled.txt", b"1 2\n3 4\n".to_vec(), "--pixel-um"),
        ],
    );
    let folder = Folder::new();
    std::fs::create_dir(folder.path("folder")).unwrap();
    for (name, says) in [("folder", "it is a folder"), ("none.x3p", "cannot be read")] {
        let done = stats(&folder, name, "");
        assert_eq!(faults(&done, &[name, says]), [""; 0], "{}", done.err);
    }
}

#[test]
fn maps_without_figures() {
    let one = npy(&array("<f8", false, "(1, 1)"), &[0; 8]);
    let nan = npy(&array("<f4", false, "(1, 2)"), &[0xff; 8]);
    let giant = [1e200, -1e200].map(f64::to_le_bytes).concat();
    refused(
        "--pixel-um 1",
        vec![
            ("lost.txt", b"# heights in um\nnan nan\nnan nan\n".to_vec(), "no point of the map"),
            ("lost.npy", nan, "no point of the map"),
            ("one.npy", one, "one point"),
            ("giant.npy", npy(&array("<f8", false, "(1, 2)"), &giant), "too large to compute"),
        ],
    );
}

#[test]
fn text() {
    let long = |last: &str| format!("{}{last}\n", "1 2 3 4\n".repeat(600)).into_bytes();
    let dhm = |pixel: &str| {
        format!("h=2 w=2\npixel size={pixel} m\ndata unit=um\n1 2\n3 4\n").into_bytes()
    };
    let gwyddion = |width: &str, unit: &str| {
        format!("# a: b\n# w: {width}\n# h: 1 um\n# v: {unit}\n1 2\n3 4\n").into_bytes()
    };
    let points = |x: fn(usize) -> f64, last: &str| {
        let rows = (0..2500).map(|k| format!("{} {} 1\n", x(k % 50), k / 50));
        format!("{}{last}", rows.collect::<String>()).into_bytes()
    };
    refused(
        "",
        vec![
            ("short.txt", long("1 2 3"), "line 601 has 3 numbers"),
            ("words.txt", long("1 2 many 4"), "line 601: `many`"),
            ("control.txt", long(&format!("1 2 \u{1b}[2J{} 4", "9".repeat(5000))), "line 601"),
            ("infinite.txt", long("1 2 inf 4"), "`inf`"),
            ("back.txt", dhm("-1e-6"), "pixel size -1 um"),
            ("zero.txt", dhm("0"), "pixel size 0 um"),
            ("nan.txt", dhm("nan"), "pixel size NaN um"),
            ("endless.txt", dhm("inf"), "pixel size inf um"),
            ("gwyddion-0.txt", gwyddion("0 um", "m"), "pixel size 0 um"),
            ("gwyddion-v.txt", gwyddion("1 um", "V"), "unit `V`"),
            ("twice.xyz", points(|k| k as f64, "3 3 3\n"), "comes twice"),
            ("uneven.xyz", points(|k| (k * k) as f64 + k as f64 / 3.0, ""), "uneven spacing"),
            ("words.xyz", points(|k| k as f64, "3 three 3\n"), "`three`"),
            ("columns.xyz", points(|k| k as f64, "3 3 3 3\n"), "has 4 numbers"),
        ],
    );
}

#[test]
fn instruments() {
    const PITCH: [f64; 3] = [1e-6, 1e-6, 1e-9];
    let sdf_pitch = |dx| sdf(5, [2, 1], [dx, 1e-6, 1e-9], &[0; 4]);
    refused(
        "",
        vec![
            ("short.sdf", cut(sdf(5, [2, 2], PITCH, &[0; 8]), 85), "ends early at byte 85"),
            ("header.sdf", cut(sdf(5, [2, 2], PITCH, &[0; 8]), 40), "ends early"),
            ("huge.sdf", sdf(7, [u16::MAX; 2], PITCH, &[]), "crop the map"),
            ("large.sdf", sdf(7, [16000; 2], PITCH, &[]), "ends early"),
            ("none.sdf", sdf(5, [0, 2], PITCH, &[]), "0 x 2 points"),
            ("type.sdf", sdf(9, [2, 1], PITCH, &[0; 4]), "DataType 9"),
            ("zero.sdf", sdf_pitch(0.0), "pixel size 0 um"),
            ("nan.sdf", sdf_pitch(f64::NAN), "pixel size NaN um"),
            ("back.sdf", sdf_pitch(-1.0), "pixel size -1000000 um"),
            ("few.sdf", sdf_text("2", "1e-6", "1 2 3").into(), "only 3 of 4"),
            ("many.sdf", sdf_text("2", "1e-6", "1 2 3 4 5").into(), "more than 4"),
            ("words.sdf", sdf_text("2", "1e-6", &"x ".repeat(5)).into(), "point 1"),
            ("endless.sdf", sdf_text("2", "inf", "1 2 3 4").into(), "pixel size inf um"),
            ("count.sdf", sdf_text("1e9", "1e-6", "1 2 3 4").into(), "NumPoints"),
            ("version.sdf", b"bISO-2.0 and so on".to_vec(), "version 2.0"),
            ("short.al3d", cut(al3d("2", "1e-6"), 390), "ends early"),
            ("huge.al3d", al3d("4000000000", "1e-6"), "crop the map"),
            ("back.al3d", al3d("2", "-1e-6"), "pixel size -1 um"),
            ("words.al3d", al3d("two", "1e-6"), "Cols"),
            ("short.opd", cut(opd("RAW_DATA", 1e-3), 120), "ends early"),
            ("none.opd", opd("Title", 1e-3), "no block of heights"),
            ("endless.opd", opd("RAW_DATA", f32::INFINITY), "pixel size inf um"),
            ("short.di", cut(di("2", "nm/V"), 1006), "ends early"),
            ("header.di", cut(di("2", "nm/V"), 200), "no end"),
            ("huge.di", di("16000000000", "nm/V"), "crop the map"),
            ("current.di", di("2", "nA/V"), "channel of heights"),
            ("short.sur", cut(sur(b"DIGITAL SURF", 2, 1.0, &[0; 16]), 520), "ends early"),
            ("back.sur", sur(b"DIGITAL SURF", -2, 1.0, &[0; 16]), "-2 points"),
            ("nan.sur", sur(b"DIGITAL SURF", 2, f32::NAN, &[0; 16]), "pixel size NaN um"),
            ("huge.sur", sur(b"DIGITAL SURF", 16384, 1.0, &[0; 16]), "ends early"),
            ("bomb.sur", sur(b"DSCOMPRESSED", 16384, 1.0, &zeros(64)), "save it unpacked"),
            ("short.gwy", cut(gwy(2, "m"), 100), "ends early"),
            ("volts.gwy", gwy(2, "V"), "units: V"),
            ("huge.gwy", gwy(i32::MAX, "m"), "crop the map"),
            ("wide.gwy", gwy(3, "m"), "do not fill 3 x 2"),
        ],
    );
}

#[test]
fn arrays_and_images() {
    let f4 = |fortran, shape: &str, bytes| npy(&array("<f4", fortran, shape), &vec![0; bytes]);
    let grey = || png(ColorType::Grayscale, BitDepth::Sixteen, 8);
    let float = || tiff::<Gray32Float>(&[1.0; 4]);
    let bomb = Entry { name: "a.npy", packed: zeros(2048), method: 8, size: 2 << 30 };
    refused(
        "--pixel-um 1",
        vec![
            ("objects.npy", npy(&array("|O", false, "(2, 2)"), &[0; 99]), "'|O'"),
            ("half.npy", npy(&array("<f2", false, "(2, 2)"), &[0; 8]), "'<f2'"),
            ("fortran.npy", f4(true, "(2, 3)", 23), "need 24 bytes"),
            ("short.npy", f4(false, "(2, 3)", 20), "need 24 bytes"),
            ("back.npy", f4(false, "(-2, 3)", 24), "its header"),
            ("deep.npy", f4(false, "(1, 2, 3)", 24), "3 dimensions"),
            ("huge.npy", f4(false, "(16384, 16384)", 24), "need 1073741824 bytes"),
            ("overflow.npy", f4(false, "(9999999999, 9999999999)", 24), "crop the map"),
            ("header.npy", cut(f4(false, "(2, 3)", 24), 30), "ends early in its header"),
            ("bomb.npz", zip(&[bomb]), "save it unpacked"),
            (
                "two.npz",
                zip(&["a.npy", "b.npy"].map(|name| stored(name, f4(false, "(2, 2)", 16)))),
                "several arrays",
            ),
            (
                "short.npz",
                cut(zip(&[stored("a.npy", f4(false, "(2, 2)", 16))]), 150),
                "zip is broken",
            ),
            ("grey.png", grey(), "without the height of a count"),
        ],
    );
    refused(
        "--pixel-um 1 --z-um 0.1",
        vec![
            ("eight.png", png(ColorType::Grayscale, BitDepth::Eight, 4), "of 8 bits"),
            ("colour.png", png(ColorType::Rgb, BitDepth::Sixteen, 24), "Rgb of 16 bits"),
            ("short.png", cut(grey(), 45), "PNG"),
            ("huge.png", huge(grey()), "save it unpacked"),
            ("integers.tif", tiff::<Gray16>(&[1; 4]), "Gray(16)"),
            ("short.tif", cut(float(), 20), "TIFF"),
            ("header.tif", cut(float(), 6), "TIFF"),
            ("offsets.tif", with_tag(float(), Tag::StripOffsets, u32::MAX), "TIFF"),
            ("counts.tif", with_tag(float(), Tag::StripByteCounts, u32::MAX), "TIFF"),
            ("wide.tif", with_tag(float(), Tag::ImageWidth, 16384), "cannot be in so few bytes"),
            ("huge.tif", with_tag(float(), Tag::ImageWidth, u32::MAX), "crop the map"),
        ],
    );
}

#[test]
fn archives_of_xml() {
    let data = || vec![stored("data.bin", [0; 48])];
    let main = main_xml("3", "1e-6", "");
    let bomb = |name, size| Entry { name, packed: zeros(2048), method: 8, size };
    let summed = |sum: &str| {
        let more = format!("<MD5ChecksumPointData>{sum}</MD5ChecksumPointData>");
        x3p(&main_xml("3", "1e-6", &more), data())
    };
    let sum = stored("md5checksum.hex", "d41d8cd98f00b204e9800998ecf8427e *main.xml");
    let nested = "<a>".repeat(100_000);
    refused(
        "",
        vec![
            ("short.x3p", cut(x3p(&main, data()), 300), "cannot be unpacked"),
            ("sum.x3p", x3p(&main, data().into_iter().chain([sum]).collect()), "MD5 of main.xml"),
            ("sums.x3p", summed("d41d8cd98f00b204e9800998ecf8427e"), "MD5 of data.bin"),
            ("none.x3p", x3p(&main, vec![]), "no data.bin"),
            ("few.x3p", x3p(&main, vec![stored("data.bin", [0; 47])]), "47 bytes, not 48"),
            ("huge.x3p", x3p(&main_xml("4000000000", "1e-6", ""), data()), "crop the map"),
            ("words.x3p", x3p(&main_xml("three", "1e-6", ""), data()), "SizeX"),
            ("zero.x3p", x3p(&main_xml("3", "0", ""), data()), "pixel size 0 um"),
            ("nan.x3p", x3p(&main_xml("3", "nan", ""), data()), "pixel size NaN um"),
            ("back.x3p", x3p(&main_xml("3", "-1e-6", ""), data()), "pixel size -1 um"),
            ("nested.x3p", x3p(&nested, data()), "nested too deep"),
            ("cut.x3p", x3p(&main[..main.len() / 2], data()), "main.xml"),
            (
                "bomb.x3p",
                x3p(&main_xml("134217728", "1e-6", ""), vec![bomb("data.bin", 2 << 30)]),
                "save it unpacked",
            ),
            ("main.x3p", zip(&[bomb("main.xml", 2 << 30)]), "save it unpacked"),
            ("lie.x3p", zip(&[bomb("main.xml", 5000)]), "larger than its declared"),
        ],
    );
}
