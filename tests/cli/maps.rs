//! `stats` on height maps: filling, cropping, direction, plots, refusals.

use asperity_tests::golden;
use serde_json::Value;

use crate::program::Folder;
use crate::refusal::{case, refused};

/// Matrix text of 48 x 40 heights in um.
fn matrix(height: impl Fn(f64, f64) -> f64) -> String {
    let row = |y: i32| {
        let heights = (0..48).map(|x| format!("{:.9}", height(f64::from(x), f64::from(y))));
        heights.collect::<Vec<_>>().join(" ")
    };
    let rows = (0..40).map(row).collect::<Vec<_>>().join("\n");
    format!("# heights in um\n{rows}")
}

fn wavy(x: f64, y: f64) -> f64 {
    (0.9 * x).sin() + (0.8 * y + 0.3).cos() + 0.5 * (0.31 * x * y).sin()
}

#[track_caller]
fn close(found: &Value, expected: f64, tolerance: f64) {
    let found = found.as_f64().unwrap_or(f64::NAN);
    assert!((found - expected).abs() <= tolerance, "{found} is not {expected}");
}

#[test]
fn a_gap_in_a_plane_is_filled_with_the_plane_and_still_counted() {
    let folder = Folder::new();
    let gap = |x: f64, y: f64| {
        if (10.0..20.0).contains(&x) && y < 7.5 { f64::NAN } else { 3.0 + 0.25 * x - 0.125 * y }
    };
    folder.write("gap.txt", matrix(gap));
    for fill in ["plane", "harmonic"] {
        let line = format!("stats gap.txt --pixel-um 0.5 --form none --fill {fill} --json");
        let filled = folder.run(&line).json();
        close(&filled["missing_fraction"], 80.0 / 1920.0, 1e-12);
        close(&filled["rms_slope_x"], 0.5, 1e-9);
        close(&filled["rms_slope_y"], 0.25, 1e-9);
        assert_eq!(filled["edges"], "mirrored");
    }
    let open = folder.run("stats gap.txt --pixel-um 0.5 --json").json();
    assert!(open["anisotropy"].is_null() && open["directional"].is_null());
    assert!(folder.run("stats gap.txt --pixel-um 0.5").ok().contains("4.167 % missing"));
}

#[test]
fn a_part_has_the_figures_of_the_part() {
    let folder = Folder::new();
    folder.write("map.txt", matrix(|x, y| if x < 20.0 { 100.0 } else { wavy(x, y) }));
    let part = folder.run("stats map.txt --pixel-um 1 --crop 20:48,4:40 --json").json();
    assert_eq!((&part["nx"], &part["ny"]), (&28.into(), &36.into()));
    assert!(part["rp_um"].as_f64().unwrap() < 5.0);
}

#[test]
fn grooves_and_periods_are_noticed() {
    let folder = Folder::new();
    let turn = std::f64::consts::TAU / 48.0;
    folder.write("grooves.txt", matrix(|x, y| (6.0 * turn * x).sin() + 1e-3 * (y * 0.7).sin()));
    let grooves = folder.run("stats grooves.txt --pixel-um 1 --json").json();
    assert!(grooves["anisotropy"].as_f64().unwrap() > 0.9 && grooves["directional"] == true);
    close(&Value::from(grooves["lay_deg"].as_f64().unwrap().abs()), 90.0, 1.0);
    assert!(folder.run("stats grooves.txt --pixel-um 1").ok().contains("grooves at"));
    let periodic =
        |x: f64, y: f64| (5.0 * turn * x).sin() + (std::f64::consts::TAU * y / 10.0).cos();
    folder.write("periodic.txt", matrix(periodic));
    let edges = |flags: &str| {
        let line = format!("stats periodic.txt --pixel-um 1 --json {flags}");
        folder.run(&line).json()["edges"].as_str().unwrap().to_owned()
    };
    assert_eq!(edges(""), "periodic");
    assert_eq!(edges("--edges auto"), "periodic");
    assert_eq!(edges("--edges mirrored"), "mirrored");
}

#[test]
fn a_seeded_surface_without_grooves_has_no_direction() {
    let folder = Folder::new();
    let path = golden::path("traced_map.npy");
    let line = ["stats", path.to_str().unwrap(), "--pixel-um", "1", "--form", "mean", "--json"];
    let found = folder.run_args(line).json();
    assert_eq!((&found["directional"], &found["edges"]), (&false.into(), &"periodic".into()));
    close(&found["rq_um"], 1.2, 1e-6);
}

#[test]
fn measured_grooves_have_a_direction_and_the_virtual_samples_have_none() {
    let folder = Folder::new();
    for (file, directional, edges) in [
        ("topography/SurfaceTopography/matrix-4.txt", true, "mirrored"),
        ("topography/SurfaceTopography/al3d-1.al3d", false, "mirrored"),
        ("samples/sample5.npy", false, "periodic"),
        ("samples/sample8.npy", false, "periodic"),
    ] {
        let Some(path) = asperity_tests::data::find(file) else { continue };
        let path = path.to_str().unwrap();
        let found = folder.run_args(["stats", path, "--pixel-um", "1", "--json"]).json();
        assert_eq!(found["directional"], directional, "{file}: {found:#}");
        assert_eq!(found["edges"], edges, "{file}");
    }
}

#[test]
fn plots_are_written_whole_and_the_same_with_any_number_of_threads() {
    let folder = Folder::new();
    folder.write("map.txt", matrix(wavy));
    let mut seen = Vec::new();
    for threads in ["1", "3"] {
        let line = "stats map.txt --pixel-um 0.5 --plot s --json";
        let mut command = folder.command(line.split_whitespace());
        let done = command.env("RAYON_NUM_THREADS", threads).output().expect("the program runs");
        assert!(done.status.success());
        seen.push((done.stdout, folder.content()));
    }
    assert!(seen[0] == seen[1], "threads change bits");
    for what in ["map", "histogram", "spectrum"] {
        let svg = folder.text(&format!("s-{what}.svg"));
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>") && svg.contains("map.txt"));
        assert!(svg.len() < 2_000_000);
        let png = std::fs::read(folder.path(&format!("s-{what}.png"))).unwrap();
        assert_eq!(png[..8], *b"\x89PNG\r\n\x1a\n");
    }
    // without a spectrum its files are not begun
    let folder = Folder::new();
    folder.write("gap.txt", matrix(|x, y| if x + y < 9.0 { f64::NAN } else { wavy(x, y) }));
    let done = folder.run("stats gap.txt --pixel-um 0.5 --plot s").with_code(0);
    assert!(done.err.contains("note: no spectrum") && done.err.contains("--fill"));
    assert_eq!(folder.names().len(), 5, "{:?}", folder.names());
}

#[test]
fn what_does_not_fit_the_map_is_refused() {
    let map = matrix(wavy);
    let stats = |flags: &str, says: &[&'static str]| {
        case(format!("stats map.txt --pixel-um 1 {flags}"), says).file("map.txt", &map)
    };
    refused(vec![
        stats("--crop 0:49,0:40", &["--crop", "48 x 40 points", "end at 48 and 40 at most"]),
        stats("--crop 5:5,0:40", &["--crop", "holds no point"]),
        stats("--crop 5-9", &["--crop", "x0:x1,y0:y1"]),
        stats("--fill spline", &["--fill", "harmonic"]),
        stats("--edges open", &["--edges", "mirrored"]),
        stats("--plot nowhere/s", &["nowhere", "create it"]),
        stats("--plot .. --form mean", &["add a file name"]),
        case("stats map.txt", &["--pixel-um"]).file("map.txt", &map),
        case("stats map.txt --pixel-um 0", &["positive"]).file("map.txt", &map),
        case("stats map.txt --pixel-um 1 --crop 0:2,0:2 --fill nearest", &["no point", "choose"])
            .file("map.txt", matrix(|x, y| if x < 3.0 { f64::NAN } else { wavy(x, y) })),
    ]);
}

#[test]
fn stats_speak_iso_25178_and_say_what_was_levelled() {
    let folder = Folder::new();
    // a plane of slopes 0.3 and -0.4, with a wave across x
    let k = std::f64::consts::TAU / 16.0;
    let row = |y: i32| {
        let heights = (0..64).map(|x| {
            let (x, y) = (f64::from(x), f64::from(y));
            format!("{:.9}", 0.3 * x - 0.4 * y + 0.2 * (k * x).sin())
        });
        heights.collect::<Vec<_>>().join(" ")
    };
    let rows: Vec<String> = (0..48).map(row).collect();
    folder.write("map.txt", format!("# heights in um, pixel 1 um\n{}\n", rows.join("\n")));
    let flat = folder.run("stats map.txt --form none --json").json();
    assert_eq!(flat["form"], "nothing");
    // slopes 0.3 +- chords of the wave, and 0.4
    let chord = 0.2 * 2.0 * (0.5 * k).sin() / 2.0_f64.sqrt();
    let sdq = flat["iso25178"]["sdq"].as_f64().unwrap();
    assert!((sdq - (0.25 + chord * chord).sqrt()).abs() < 3e-3, "{sdq}");
    let levelled = folder.run("stats map.txt --json").json();
    assert_eq!(levelled["form"], "plane");
    let of = |name: &str| levelled["iso25178"][name].as_f64();
    close(&levelled["iso25178"]["sq_um"], levelled["rq_um"].as_f64().unwrap(), 0.0);
    assert!((of("sdq").unwrap() / chord - 1.0).abs() < 0.05, "{levelled}");
    assert!((of("sal_um").unwrap() / (0.2_f64.acos() / k) - 1.0).abs() < 0.05, "{levelled}");
    assert!(of("str").is_none() && of("str_at_most").unwrap() < 0.2, "{levelled}");
    let text = folder.run("stats map.txt").ok();
    for part in [
        "ISO 25178-2, plane subtracted",
        "\nSq          0.1",
        "\nSdr         ",
        "\nStr         at most 0.",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn a_unit_that_the_file_gives_already_is_said_to_change_nothing() {
    let folder = Folder::new();
    folder.write("map.txt", "# heights in nm, pixel 1 um\n0 10 0 10\n10 0 10 0\n0 10 0 10\n");
    let plain = folder.run("stats map.txt --json").json();
    let done = folder.run("stats map.txt --json --z-um 0.001").with_code(0);
    assert!(done.err.contains("--z-um says the same"), "{}", done.err);
    let again: serde_json::Value = serde_json::from_str(&done.out).unwrap();
    assert_eq!(again, plain);
    let done = folder.run("stats map.txt --z-um 1").with_code(2);
    assert!(done.err.contains("contradicts"), "{}", done.err);
}
