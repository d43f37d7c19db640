//! Units of height maps: read where the file says them, asked for where it does not.

use asperity_tests::golden;
use serde_json::Value;

use crate::map_files::{array, npy};
use crate::program::Folder;
use crate::refusal::{case, refused};

const N: usize = 24;
/// Pitches and rms height of the map, um.
const DX: f64 = 1.634;
const DY: f64 = 0.817;

/// Heights in um.
fn height(x: usize, y: usize) -> f64 {
    let phase = |k: usize, n: f64| std::f64::consts::TAU * n * k as f64 / N as f64;
    0.7 * (phase(x, 2.0).sin() + phase(y, 1.0).cos())
}

const RQ: f64 = 0.7;

/// Points with columns in the given units, below a head.
fn points(head: &str, [x, y, z]: [f64; 3]) -> String {
    let place = |k: usize| (k % N, k / N);
    let row = |k: usize| {
        let (i, j) = place(k);
        format!("{:.9e} {:.9e} {:.9e}\n", i as f64 * DX / x, j as f64 * DY / y, height(i, j) / z)
    };
    head.to_owned() + &(0..N * N).map(row).collect::<String>()
}

/// Rows of heights in a unit, below a head.
fn matrix(head: &str, z: f64) -> String {
    let row = |y: usize| {
        let all = (0..N).map(|x| format!("{:.9e}", height(x, y) / z)).collect::<Vec<_>>();
        all.join("\t") + "\n"
    };
    head.to_owned() + &(0..N).map(row).collect::<String>()
}

#[track_caller]
fn near(found: &Value, expected: f64) {
    let found = found.as_f64().unwrap_or(f64::NAN);
    assert!((found / expected - 1.0).abs() < 1e-6, "{found} is not {expected}");
}

/// The map has its pitches and its rms height.
#[track_caller]
fn is_right(folder: &Folder, file: &str, flags: &str, pitches: [f64; 2]) {
    let figures = folder.run(&format!("stats {file} --form mean --json {flags}")).json();
    near(&figures["dx_um"], pitches[0]);
    near(&figures["dy_um"], pitches[1]);
    near(&figures["rq_um"], RQ);
}

#[test]
fn points_say_their_units_in_many_ways() {
    let folder = Folder::new();
    for (head, units) in [
        ("# x [um] y [um] z [um]\n", [1.0; 3]),
        ("x [um]\ty [um]\tz [nm]\n", [1.0, 1.0, 1e-3]),
        ("\"X (mm)\" \"Y (mm)\" \"Z (µm)\"\n", [1e3, 1e3, 1.0]),
        ("X_um,Y_um,Height_nm\n", [1.0, 1.0, 1e-3]),
        ("# x/mm, y/mm, z/um\n", [1e3, 1e3, 1.0]),
        ("% x, y in microns, z in nanometers\n", [1.0, 1.0, 1e-3]),
        ("// Lateral units: m\n// Value units: m\n", [1e6; 3]),
        ("# all lengths in metres\n", [1e6; 3]),
        ("# unit: mm\n", [1e3; 3]),
        ("x y z\nmm mm um\n", [1e3, 1e3, 1.0]),
        ("# XY unit: mm\nx y z\n# z in \u{3bc}m\n", [1e3, 1e3, 1.0]),
        ("# x [um], y [nm], z [\u{c5}]\n", [1.0, 1e-3, 1e-4]),
    ] {
        folder.write("p.xyz", points(head, units));
        is_right(&folder, "p.xyz", "", [DX, DY]);
    }
    folder.write("p.xyz", points("", [1.0; 3]));
    is_right(&folder, "p.xyz", "--xy-unit um --z-unit um", [DX, DY]);
    is_right(&folder, "p.xyz", "--xy-unit um --z-um 1", [DX, DY]);
    // a pixel size says the lateral unit, and nothing is said of one in the file
    folder.write("p.xyz", points("", [1e3, 1e3, 1e-3]));
    let done = folder.run("stats p.xyz --pixel-um 1.634 --z-unit nm");
    assert!(!done.err.contains("its own pixel size"), "{}", done.err);
    is_right(&folder, "p.xyz", "--pixel-um 1.634 --z-unit nm", [DX, DY]);
    let said = points("# x [um] y [um] z [um]\n", [1.0; 3]);
    folder.write("p.xyz", said);
    let done = folder.run("stats p.xyz --pixel-um 9").with_code(0);
    assert!(done.err.contains("its own pixel size"), "{}", done.err);
}

#[test]
fn rows_say_the_unit_of_heights_and_the_pixel_size() {
    let folder = Folder::new();
    for (head, unit, flags, pitches) in [
        ("# heights in nm, pixel 1.634 um\n", 1e-3, "", [DX, DX]),
        ("# Height units: nm\n# Pixel size: 1.634 \u{b5}m x 0.817 \u{b5}m\n", 1e-3, "", [DX, DY]),
        ("Heights in mm\nPixel size [nm]: 1634\n", 1e3, "", [DX, DX]),
        ("# Value units: m\n", 1e6, "--pixel-um 1.634", [DX, DX]),
        ("", 1e-3, "--pixel-um 1.634 --z-unit nm", [DX, DX]),
        ("", 1e-3, "--pixel-um 1.634 --z-um 0.001", [DX, DX]),
        ("# heights in nm\n", 1e-3, "--pixel-um 1.634 --z-um 0.001", [DX, DX]),
        ("# pixel size: 1.634\n", 1.0, "--xy-unit um --z-unit \u{b5}m", [DX, DX]),
    ] {
        folder.write("m.txt", matrix(head, unit));
        is_right(&folder, "m.txt", flags, pitches);
    }
    // the same in UTF-16 of both orders, and behind the mark of UTF-8
    let text = matrix("# heights in \u{b5}m, pixel size 1.634 \u{b5}m\n", 1.0);
    let utf16 = |bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
        std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(bytes).collect()
    };
    let utf8 = [b"\xef\xbb\xbf", text.as_bytes()].concat();
    for file in [utf16(u16::to_le_bytes), utf16(u16::to_be_bytes), utf8] {
        folder.write("m.txt", file);
        is_right(&folder, "m.txt", "", [DX, DX]);
    }
}

#[test]
fn arrays_are_um_as_documented_unless_the_user_says_otherwise() {
    let folder = Folder::new();
    let data = |scale: f64| -> Vec<u8> {
        let heights = (0..N * N).map(|k| height(k % N, k / N) / scale);
        heights.flat_map(f64::to_le_bytes).collect()
    };
    let shape = format!("({N}, {N})");
    let file = |scale| npy(&array("<f8", false, &shape), &data(scale));
    folder.write("a.npy", file(1.0));
    is_right(&folder, "a.npy", "--pixel-um 1.634", [DX, DX]);
    let done = folder.run("stats a.npy --pixel-um 1.634").with_code(0);
    assert!(done.err.contains("taken as um") && done.err.contains("--z-unit"), "{}", done.err);
    folder.write("a.npy", file(1e-3));
    for flags in ["--z-unit nm", "--z-um 0.001"] {
        is_right(&folder, "a.npy", &format!("--pixel-um 1.634 {flags}"), [DX, DX]);
        let done = folder.run(&format!("stats a.npy --pixel-um 1.634 {flags}")).with_code(0);
        assert!(!done.err.contains("taken as um"), "{}", done.err);
    }
}

#[test]
fn what_nobody_says_is_asked_for_and_what_is_said_twice_must_agree() {
    let map = |line: &str, says: &[&'static str], file: &str| case(line, says).file("m", file);
    let (plain, said) = (points("", [1.0; 3]), points("# x [um] y [um] z [um]\n", [1.0; 3]));
    let (rows, nm) = (matrix("", 1.0), matrix("# heights in nm\n", 1e-3));
    let volts = points("# x [um] y [um] z [V]\n", [1.0; 3]);
    let counts = npy(&array("<i2", false, "(2, 3)"), &[0; 12]);
    refused(vec![
        map("stats m", &["m: ", "--xy-unit and --z-unit"], &plain),
        map("stats m --z-unit um", &["unit of x and y", "--xy-unit"], &plain),
        map("stats m --xy-unit um", &["unit of its heights", "--z-unit"], &plain),
        map("stats m --pixel-um 1", &["unit of its heights", "--z-unit"], &plain),
        map("stats m --xy-unit mm", &["--xy-unit mm contradicts", "um"], &said),
        map("stats m --z-um 0.001", &["--z-um 0.001 contradicts", "um"], &said),
        map("stats m", &["unit `v`", "--z-unit"], &volts),
        map("stats m", &["--z-unit", "--pixel-um"], &rows),
        map("stats m --pixel-um 1", &["unit of its heights", "--z-unit", "--z-um"], &rows),
        map("stats m --pixel-um 1 --z-unit um", &["contradicts", "nm"], &nm),
        map("stats m --pixel-um 1 --z-unit um --xy-unit um", &["--xy-unit um"], &rows),
        map("stats m --pixel-um 1 --z-unit furlong", &["--z-unit", "furlong", "angstrom"], &rows),
        map("stats m --pixel-um 1 --z-unit um --z-um 1", &["--z-um", "--z-unit"], &rows),
        case("stats m --pixel-um 1", &["--z-um"]).file("m", counts),
        map("check --map m --ior 1.49", &["--xy-unit and --z-unit"], &plain),
    ]);
}

#[test]
fn a_profile_is_called_a_profile() {
    let profile =
        |row: fn(f64) -> String| -> String { (0..64).map(|k| row(f64::from(k))).collect() };
    let two = profile(|k| format!("{:.4} {:.4}\n", 0.5 * k, (0.2 * k).sin()));
    let csv = format!("x [um],z [um]\n{}", two.replace(' ', ","));
    let one = profile(|k| format!("{:.4}\n", (0.2 * k).sin()));
    let row = one.replace('\n', " ");
    let traces = profile(|k| format!("{:.4} {:.4} {:.4}\n", 0.5 * k, k.sin(), k.cos()));
    let says = &["this is a profile, not a map"];
    let cases = |file: &String| {
        ["stats p --pixel-um 1", "stats p", "scan --map p --pixel-um 1 --z-unit um --ior 1.49"]
            .map(|line| case(line, says).file("p", file))
    };
    refused([two, csv, one, row, traces].iter().flat_map(cases).collect());
}

/// Arrays and other binary files hold profiles too: they have figures, and scatter no light.
#[test]
fn one_line_of_an_array_is_no_map_for_light() {
    let folder = Folder::new();
    let numbers = |count: usize, of: &dyn Fn(usize) -> f64| -> Vec<u8> {
        (0..count).flat_map(|k| of(k).to_le_bytes()).collect()
    };
    let z = |k: usize| (0.7 * (k * k) as f64).sin();
    let line = |shape| npy(&array("<f8", false, shape), &numbers(64, &z));
    folder.write("row.npy", line("(1, 64)"));
    folder.run("stats row.npy --pixel-um 1").with_code(0);
    let positions = |k: usize| if k.is_multiple_of(2) { 0.25 * k as f64 } else { z(k) };
    let two = npy(&array("<f8", false, "(64, 2)"), &numbers(128, &positions));
    let says = &["this is a profile, not a map", "give heights over x and y"];
    let mut cases = vec![case("stats p --pixel-um 1", says).file("p", &two)];
    for flags in ["", "--engine wave --wavelength-nm 550", "--engine hybrid --wavelength-nm 550"] {
        for file in [line("(1, 64)"), line("(64, 1)"), two.clone()] {
            for verb in ["scan", "check"] {
                let line = format!("{verb} --map p --pixel-um 1 --ior 1.49 {flags}");
                cases.push(case(line, says).file("p", file.clone()));
            }
        }
    }
    refused(cases);
}

/// A matrix with a row and a column of positions around its heights.
#[test]
fn positions_around_a_matrix_are_not_taken_for_heights() {
    let line = |of: &dyn Fn(usize) -> f64| {
        (0..16).map(|x| format!("{:.4}", of(x))).collect::<Vec<_>>().join(" ")
    };
    let first = line(&|x| 0.36 * x as f64);
    let row = |y: usize| line(&|x| height(x, y));
    let rows = |begin: &dyn Fn(usize) -> String| {
        (0..12).map(|y| begin(y) + " " + &row(y) + "\n").collect::<String>()
    };
    let number = |y: usize| y.to_string();
    let cases = [
        (format!("0 {first}\n{}", rows(&number)), "first row"),
        (format!("{first}\n{}", rows(&|_| String::new())), "first row"),
        (rows(&number), "first column"),
    ];
    let line = "scan --map p --pixel-um 1 --z-unit um --ior 1.49";
    let says = |(text, what): &(String, &'static str)| {
        case(line, &[what, "evenly spaced, as positions are", "delete"]).file("p", text)
    };
    refused(cases.iter().map(says).collect());
}

#[test]
fn a_model_remembers_the_units_of_its_map() {
    let folder = Folder::new();
    folder.write("p.xyz", points("", [1e3, 1e3, 1e-3]));
    let flags = "--map p.xyz --xy-unit mm --z-unit nm --ior 1.49";
    folder.run(&format!("model measured-ray --set scale=1 {flags} -o m.json")).ok();
    let model = folder.json("m.json");
    assert_eq!(model["map"]["preparation"]["z_unit"], "nm", "{model:#}");
    let line = "--incidence 0 --side air --rays 1e4 --json";
    let (of_model, of_map) =
        (folder.run(&format!("check m.json {line}")), folder.run(&format!("check {flags} {line}")));
    assert_eq!(of_model.json()["energy"], of_map.json()["energy"]);
}

/// A file that goes wrong where units are guessed: file, flags, its distances of columns and its rms height over the mean plane, um.
type Case = (&'static str, &'static str, f64, f64);

#[test]
fn files_of_others_have_their_right_answers() {
    let folder = Folder::new();
    let right: [Case; 8] = [
        ("matrix_nm.txt", "", 1.634, 0.5065),
        ("matrix_nm.txt", "--pixel-um 1.634 --z-um 0.001", 1.634, 0.5065),
        ("ec.spm", "", 0.125, 0.025_048),
        ("xyz16.txt", "--xy-unit um --z-unit um", 1.0, 0.3260),
        ("stale.x3p", "--ignore-checksum", 1.5, 1.394_433),
        ("gwy_noheader.xyz", "--xy-unit m --z-unit m", 1.634_241, 0.506_486),
        ("um_c.xyz", "", 1.634_241, 0.506_486),
        ("um.xyz", "--xy-unit um --z-unit um", 1.634_241, 0.506_486),
    ];
    for (name, flags, dx, rq) in right {
        let path = golden::path(&format!("cases/{name}"));
        let line = ["stats", path.to_str().unwrap(), "--json"];
        let figures = |form| {
            folder.run_args(line.into_iter().chain(flags.split_whitespace()).chain(form)).json()
        };
        let of = |form: &'static str| figures(["--form", form])["rq_um"].as_f64().unwrap();
        let found = [of("mean"), of("plane")];
        assert!(found.iter().any(|f| (f / rq - 1.0).abs() < 2e-4), "{name}: {found:?} is not {rq}");
        let found = figures(["--form", "mean"])["dx_um"].as_f64().unwrap();
        assert!((found / dx - 1.0).abs() < 1e-4, "{name}: {found} is not {dx}");
    }
    for (name, flags, says) in [
        ("gwy_noheader.xyz", "", "--xy-unit and --z-unit"),
        ("um.xyz", "", "--xy-unit and --z-unit"),
        ("um.xyz", "--pixel-um 1.634", "--z-unit"),
        ("stale.x3p", "", "--ignore-checksum"),
        ("profile.txt", "--pixel-um 1", "this is a profile, not a map"),
        ("matrix_nm.txt", "--z-um 1", "contradicts"),
    ] {
        let path = golden::path(&format!("cases/{name}"));
        let line = ["stats", path.to_str().unwrap()];
        let done = folder.run_args(line.into_iter().chain(flags.split_whitespace())).with_code(2);
        assert!(done.err.contains(says), "{name}: {}", done.err);
        assert!(!done.err.contains("its own pixel size"), "{name}: {}", done.err);
    }
}
