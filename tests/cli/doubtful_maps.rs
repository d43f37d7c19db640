//! Maps that cannot be right, as those of heights in nm taken as um, and maps that are hardly measured.

use crate::program::Folder;
use crate::refusal::{case, refused};

/// Matrix text of heights in um: waves of rms slope `slope` along x at a pitch of 1 um.
fn waves(slope: f64) -> String {
    let tau = std::f64::consts::TAU;
    // neighbours of sin(2 pi x / 6) differ by its amplitude, rms 1 / sqrt 2
    let height = slope * 2.0_f64.sqrt();
    let at = |x: i32, y: i32| {
        height * (tau * f64::from(x) / 6.0).sin() + 0.3 * height * (tau * f64::from(y) / 8.0).cos()
    };
    let row = |y| (0..48).map(|x| format!("{:.9}", at(x, y))).collect::<Vec<_>>().join(" ");
    format!("# heights in um\n{}", (0..40).map(row).collect::<Vec<_>>().join("\n"))
}

const MAP: &str = "--map map.txt --pixel-um 1 --ior 1.49";

#[test]
fn slopes_that_no_surface_has_are_refused_by_every_verb() {
    let map = waves(51.7);
    let scan = "# geometry: transmission\n# ior: 1.49\n# rough_side: source\n# aperture_deg: 4\n\
                sigma_deg,theta_deg,reading\n0,0,0.1\n0,1,0.2\n0,2,0.1\n";
    let says = &["map.txt", "rms slope is 51", "--z-unit", "--allow-steep"];
    let lines = [
        "stats map.txt --pixel-um 1".to_owned(),
        format!("check {MAP}"),
        format!("check {MAP} --engine wave --wavelength-nm 550"),
        format!("scan {MAP} --rays 1e4"),
        format!("model measured-ray --set scale=1 {MAP}"),
        format!("fit scan.csv --method measured-ray {MAP}"),
        format!("fit scan.csv --method measured-wave --wavelength-nm 550 {MAP}"),
        format!("compare scan.csv {MAP} -o r"),
        format!("trade scan.csv {MAP}"),
    ];
    let cases = lines.map(|line| case(line, says).file("map.txt", &map).file("scan.csv", scan));
    refused(cases.into());
}

#[test]
fn steep_maps_are_warned_of_and_taken_if_they_are_right() {
    let folder = Folder::new();
    let check = format!("check {MAP} --incidence 0 --side air --rays 2e3");
    for (slope, flag, warned) in [(0.5, "", false), (6.0, "", true), (51.7, "--allow-steep", true)]
    {
        folder.write("map.txt", waves(slope));
        for line in ["stats map.txt --pixel-um 1", &check] {
            let done = folder.run(&format!("{line} {flag}")).with_code(0);
            let says = done.err.contains("are the units of heights and pixel size right?");
            assert_eq!(says, warned, "{slope}: {}", done.err);
        }
    }
}

#[test]
fn a_map_that_is_mostly_filled_is_said_to_be() {
    let folder = Folder::new();
    for (lost, warned) in [(40, false), (60, true)] {
        let point =
            |k: i32| if k * 37 % 100 < lost { "nan".into() } else { format!("0.{}", k % 7) };
        let row = |y: i32| (0..30).map(|x| point(30 * y + x)).collect::<Vec<_>>().join(" ");
        let rows = (0..30).map(row).collect::<Vec<_>>().join("\n");
        folder.write("map.txt", format!("# heights in um\n{rows}\n"));
        let done = folder.run("stats map.txt --pixel-um 1 --fill nearest").with_code(0);
        assert_eq!(done.err.contains("are filled, not measured"), warned, "{}", done.err);
    }
}

#[test]
fn pixels_that_no_map_for_light_has_are_refused_before_any_work() {
    let map = waves(0.2);
    let lines = ["1e6", "1e9", "1e300", "1e-9", "1e-300"].map(|um| {
        let map = format!("--map map.txt --pixel-um {um} --ior 1.49");
        [
            format!("check {map} --allow-steep"),
            format!("check {map} --engine wave --wavelength-nm 550 --allow-steep"),
            format!("scan {map} --engine wave --wavelength-nm 550 --allow-steep"),
        ]
    });
    let says = &["map.txt", "pixel"];
    refused(lines.iter().flatten().map(|line| case(line, says).file("map.txt", &map)).collect());
}
