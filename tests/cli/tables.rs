//! Tables in place of models: `eval`, `check` and `scan` of a `.bsdft`, and what is refused.

use std::fmt::Write as _;
use std::sync::OnceLock;

use asperity_core::metric::rmsd_percent;
use asperity_tests::tolerance;

use crate::program::Folder;
use crate::refusal::{MODEL, case, refused};

/// What `tabulate` writes of a model of GGX, alpha 0.2.
fn made(flags: &str) -> Vec<u8> {
    let folder = Folder::new();
    folder.write("m.json", MODEL);
    folder.run(&format!("tabulate m.json {flags} -o t.bsdft")).ok();
    std::fs::read(folder.path("t.bsdft")).unwrap()
}

/// The same with all lobes in 32 KiB.
fn whole() -> &'static [u8] {
    static TABLE: OnceLock<Vec<u8>> = OnceLock::new();
    TABLE.get_or_init(|| made("--bytes 32768"))
}

/// The same of what a detector behind a plate sees at once.
fn part() -> &'static [u8] {
    static TABLE: OnceLock<Vec<u8>> = OnceLock::new();
    TABLE.get_or_init(|| made("--bytes 4096 --side air --lobe transmission"))
}

/// A folder with a model and its table.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("m.json", MODEL);
    folder.write("t.bsdft", whole());
    folder
}

/// The last number of every row.
fn readings(text: &str) -> Vec<f64> {
    let rows = text.lines().filter(|l| !l.starts_with(['#', 's']));
    rows.map(|l| l.rsplit(',').next().unwrap().parse().unwrap()).collect()
}

/// Directions of light to one side of a beam, in the plane of incidence and out of it.
fn fan(incidence_deg: f64, (below, to_below): (bool, bool)) -> String {
    let mut text = String::from("wix,wiy,wiz,wox,woy,woz\n");
    let z = |below: bool, cos: f64| if below { -cos } else { cos };
    let (s, c) = incidence_deg.to_radians().sin_cos();
    for theta in (-85..=85).step_by(5) {
        for psi in [0.0_f64, 4.0, 30.0] {
            let ((a, b), (out, along)) =
                (f64::from(theta).to_radians().sin_cos(), psi.to_radians().sin_cos());
            let (x, z_o) = (along * a, z(to_below, along * b));
            writeln!(text, "{},0,{},{x},{out},{z_o}", -s, z(below, c)).unwrap();
        }
    }
    text
}

#[test]
#[allow(clippy::print_stdout, reason = "shown with --nocapture")]
fn values_of_a_table_are_those_of_its_model() {
    let folder = folder();
    for beam in [(false, false), (false, true), (true, false), (true, true)] {
        for incidence_deg in [0.0, 20.0, 35.0, 60.0] {
            let pairs = fan(incidence_deg, beam);
            let values = |file: &str| -> Vec<[f64; 2]> {
                let rows = folder.pipe(&format!("eval {file} --json"), pairs.as_bytes()).json();
                let of = |row: &serde_json::Value| ["f", "ars"].map(|v| row[v].as_f64().unwrap());
                rows.as_array().unwrap().iter().map(of).collect()
            };
            let (model, table) = (values("m.json"), values("t.bsdft"));
            for k in 0..2 {
                let peak = model.iter().map(|v| v[k]).fold(0.0, f64::max);
                let worst = model.iter().zip(&table).map(|(m, t)| (m[k] - t[k]).abs());
                let worst = worst.fold(0.0, f64::max);
                println!("{beam:?} {incidence_deg}: {:.6} % of the peak", 100.0 * worst / peak);
                assert!(
                    worst <= tolerance::TABLE_VALUES.allowed * peak,
                    "{beam:?} {incidence_deg}: {worst} of {peak}"
                );
            }
        }
    }
    let done = folder.pipe("eval t.bsdft", fan(0.0, (false, true)).as_bytes()).with_code(0);
    let said = "note: t.bsdft is a table of a model of method ggx, ";
    assert!(done.err.starts_with(said) && done.err.lines().count() == 1, "{}", done.err);
}

#[test]
fn scans_of_a_table_are_those_of_its_model() {
    let folder = folder();
    for flags in [
        // beside the beam that the smooth face mirrors
        "--geometry reflection --rough-side detector --sigma 0,15 --theta-range -90:-2",
        "--geometry transmission --rough-side source",
        "--geometry transmission --rough-side detector",
        "--geometry reflection --rough-side source",
        "--geometry reflection --rough-side detector",
        "--quantity bsdf --aperture 0",
    ] {
        let scan = |file: &str| folder.run(&format!("scan {file} --step 0.5 {flags}")).ok();
        let (model, table) = (scan("m.json"), scan("t.bsdft"));
        assert!(table.contains("# ior: 1.49\n"), "{table:.400}");
        assert!(table.contains("# table: of a model of method ggx, "), "{table:.400}");
        let distance = rmsd_percent(&readings(&model), &readings(&table)).unwrap();
        assert!(distance <= tolerance::TABLE_32_KIB.allowed, "{flags}: {distance} %");
    }
    // rays that follow the samples of the table find its readings again
    let line = "scan t.bsdft --sigma 0,45 --step 1 --aperture 4";
    let exact = folder.run(line).ok();
    let rays = folder.run(&format!("{line} --rays 200000 --seed 3")).ok();
    let floor = rays.lines().find_map(|l| l.strip_prefix("# noise_floor_percent: ")).unwrap();
    let distance = rmsd_percent(&readings(&exact), &readings(&rays)).unwrap();
    assert!(distance < 1.5 * floor.parse::<f64>().unwrap(), "{distance} {floor}");
}

#[test]
fn a_balance_of_a_table_is_that_of_its_model() {
    let folder = folder();
    let check = |file: &str| folder.run(&format!("check {file} --json")).json();
    let (model, table) = (check("m.json"), check("t.bsdft"));
    assert_eq!((&table["method"], &table["ior"]), (&"ggx".into(), &1.49.into()));
    assert_eq!(table["conserves_energy"], true);
    assert!(table["table"].as_str().unwrap().contains(" bytes, u16"), "{table}");
    let both = model["energy"].as_array().unwrap().iter().zip(table["energy"].as_array().unwrap());
    for (m, t) in both {
        for part in ["reflected", "transmitted"] {
            let far = (m[part].as_f64().unwrap() - t[part].as_f64().unwrap()).abs();
            assert!(far <= tolerance::TABLE_FLUX.allowed, "{m} {t}");
        }
    }
    let text = folder.run("check t.bsdft --incidence 0").ok();
    assert!(text.starts_with("table of a model of method ggx, "), "{text}");
}

#[test]
fn a_table_without_all_lobes_does_what_it_can() {
    let folder = folder();
    folder.write("part.bsdft", part());
    let pairs = "wix,wiy,wiz,wox,woy,woz\n0,0,1,0,0,-1\n0,0,1,0,0,1\n0,0,-1,0,0,1\n";
    let done = folder.pipe("eval part.bsdft --json", pairs.as_bytes()).with_code(0);
    let said = "warning: part.bsdft: the table holds no reflection of light from the air, no transmission of light \
                from the dielectric: no values for 2 of 3 pairs\n";
    assert!(done.err.ends_with(said), "{}", done.err);
    let values = done.json();
    assert!(values[0]["f"].as_f64().unwrap() > 60.0, "{values}");
    assert!(values[1]["f"].is_null() && values[2]["pdf"].is_null(), "{values}");
    let csv = folder.pipe("eval part.bsdft", pairs.as_bytes()).ok();
    assert!(csv.ends_with("0,0,-1,0,0,1,NaN,NaN,NaN\n"), "{csv}");

    folder.write("air.bsdft", made("--bytes 4096 --side air"));
    let check = folder.run("check air.bsdft --side air --json").json();
    assert!(check["conserves_energy"] == true && check["reciprocal"].is_null(), "{check}");
    let text = folder.run("check air.bsdft --side air --incidence 0").ok();
    assert!(text.ends_with("reciprocity is not known without all lobes\n"), "{text}");
    // light that enters through the smooth face and is mirrored by the rough one meets no other lobe
    folder.write("inside.bsdft", made("--bytes 4096 --side dielectric --lobe reflection"));
    let line =
        "--rough-side detector --geometry reflection --step 1 --sigma 0,15 --theta-range -90:-2";
    let scan = |file: &str| readings(&folder.run(&format!("scan {file} {line}")).ok());
    let distance = rmsd_percent(&scan("m.json"), &scan("inside.bsdft")).unwrap();
    assert!(distance <= tolerance::TABLE_8_KIB.allowed, "{distance} %");
}

#[test]
fn a_verb_that_needs_a_missing_lobe_refuses() {
    let of_part = |line: &str, says: &[&'static str]| case(line, says).file("p.bsdft", part());
    let inside =
        "no reflection of light from the dielectric, which this scan needs; give one made by";
    refused(vec![
        of_part("scan p.bsdft", &["p.bsdft: the table holds", inside]),
        of_part("scan p.bsdft --rough-side detector", &["no reflection or transmission of light"]),
        of_part("scan p.bsdft --rays 1e4", &["reflection of light from the air"]),
        of_part("check p.bsdft", &["use --side, or give", "--side both --lobe both"]),
        of_part("check p.bsdft --side air", &["no reflection of light from the air"]),
    ]);
}

#[test]
fn a_table_is_known_by_its_name_or_its_first_line() {
    let folder = Folder::new();
    folder.write("t.json", whole());
    assert_eq!(folder.run("check t.json --json").json()["method"], "ggx");
    let end = whole().iter().position(|b| *b == b'\n').unwrap();
    let line = String::from_utf8(whole()[..end].to_vec()).unwrap();
    let later = format!("{}\n", line.replacen(":2,", ":900,", 1));
    let strange = format!("{}\n", line.replacen("\"u16\"", "\"\\u001b[2J\"", 1));
    let many = format!("{}\n", line.replacen("\"radii\":", "\"radii\":6", 1));
    let wild = [b"{\"asperity_table\":", &[0xff, 0x00, b'\n'][..]].concat();
    let model = "is a table, and a model is needed here; give the model it was made of";
    let of =
        |line: &str, says: &[&'static str], bytes: &[u8]| case(line, says).file("t.bsdft", bytes);
    refused(vec![
        of("check t.bsdft", &["t.bsdft: ", "cut or damaged"], &whole()[..whole().len() - 1]),
        of("scan t.bsdft", &["t.bsdft: ", "is no table"], MODEL.as_bytes()),
        of("eval t.bsdft", &["t.bsdft: ", "is no table"], b""),
        of("check t.bsdft", &["t.bsdft: ", "format 900"], later.as_bytes()),
        case("check t.json", &["t.json: is no table"]).file("t.json", wild),
        case("check none.bsdft", &["none.bsdft: cannot be read", "asperity tabulate"]),
        of(
            "check t.bsdft --wavelength-nm 550",
            &["no effect", "a model has its own light"],
            whole(),
        ),
        of("check t.bsdft", &["t.bsdft: ", "storage `\u{fffd}"], strange.as_bytes()),
        of("check t.bsdft", &["t.bsdft: ", "damaged"], many.as_bytes()),
        of("tabulate t.bsdft -o again.bsdft", &["t.bsdft: ", model], whole()),
        of("trade t.bsdft", &["t.bsdft: "], whole()),
    ]);
}

#[test]
fn a_table_of_an_opaque_body_is_opaque() {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.3 gain=0.5 lambert=0.02 --opaque -o o.json").ok();
    folder.run("tabulate o.json --bytes 8192 -o o.bsdft").ok();
    let scan = |file: &str| readings(&folder.run(&format!("scan {file} --step 1")).ok());
    let distance = rmsd_percent(&scan("o.json"), &scan("o.bsdft")).unwrap();
    assert!(distance <= tolerance::TABLE_8_KIB.allowed, "{distance} %");
    let check = folder.run("check o.bsdft --incidence 0,30 --json").json();
    assert!(check["ior"].is_null() && check["conserves_energy"] == true, "{check}");
    assert_eq!(check["energy"].as_array().map(Vec::len), Some(2));
    let pairs = "wix,wiy,wiz,wox,woy,woz\n0,0,1,0,0,-1\n";
    assert!(folder.pipe("eval o.bsdft", pairs.as_bytes()).ok().ends_with(",0e0,0e0,0e0\n"));
    refused(vec![
        case("scan o.bsdft --geometry transmission", &["opaque"])
            .file("o.bsdft", std::fs::read(folder.path("o.bsdft")).unwrap()),
    ]);
}

/// A table as programs wrote it before there were checksums.
fn without_sum(table: &[u8]) -> Vec<u8> {
    let end = table.iter().position(|b| *b == b'\n').unwrap();
    let mut line: serde_json::Value = serde_json::from_slice(&table[..end]).unwrap();
    let keys = line.as_object_mut().unwrap();
    assert!(keys.remove("crc32c").is_some() && keys.remove("opaque").is_some());
    keys.insert("asperity_table".into(), 1.into());
    [line.to_string().as_bytes(), &table[end..]].concat()
}

#[test]
fn a_table_without_a_checksum_is_read_with_a_warning() {
    let folder = folder();
    folder.write("one.bsdft", without_sum(whole()));
    let warned =
        "warning: one.bsdft: format 1 has no checksum, so damage goes unseen; make the table anew";
    let pairs = "wix,wiy,wiz,wox,woy,woz\n0,0,1,0,0,-1\n";
    let [old, new] = ["one.bsdft", "t.bsdft"].map(|file| {
        let done = folder.pipe(&format!("eval {file}"), pairs.as_bytes()).with_code(0);
        assert_eq!(done.err.contains(warned), file == "one.bsdft", "{}", done.err);
        done.out
    });
    assert_eq!(old, new);
    let done = folder.run("check one.bsdft --incidence 0").with_code(0);
    assert!(done.err.contains(warned), "{}", done.err);
    // a sum that is another, and one in a file of the format without
    let end = whole().iter().position(|b| *b == b'\n').unwrap();
    let mut turned = whole().to_vec();
    turned[end + 200] ^= 0x10;
    let line = String::from_utf8_lossy(&whole()[..end]).replacen(":2,", ":1,", 1);
    let mixed = [line.as_bytes(), &whole()[end..]].concat();
    refused(vec![
        case("check t.bsdft", &["t.bsdft: its checksum is another", "damaged"])
            .file("t.bsdft", turned),
        case("check t.bsdft", &["t.bsdft: its first line is not", "damaged"])
            .file("t.bsdft", mixed),
    ]);
}

/// An index of 10 once stood for an opaque body.
#[test]
fn a_table_of_a_dielectric_of_any_index_is_one() {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.3 --ior 10 -o m.json").ok();
    folder.run("tabulate m.json --side air --lobe reflection --bytes 4096 -o t.bsdft").ok();
    let check = folder.run("check t.bsdft --side air --incidence 0 --json");
    assert!(check.with_code(2).err.contains("no transmission of light from the air"));
}

/// A map of grooves: waves along x alone, and a few weak ones across.
fn grooves() -> String {
    let tau = std::f64::consts::TAU;
    let height = |x: i32, y: i32| {
        let wave = |k: i32| (tau * f64::from(k * x) / 64.0 + 1.3 * f64::from(k)).sin();
        let across = 0.1 * (tau * f64::from(3 * y) / 64.0).sin();
        0.2 * ((2..9).map(wave).sum::<f64>() + across)
    };
    let row = |y| (0..64).map(|x| format!("{:.6}", height(x, y))).collect::<Vec<_>>();
    let rows = (0..64).map(|y| row(y).join(" ")).collect::<Vec<_>>().join("\n");
    format!("# heights in um\n{rows}")
}

#[test]
fn a_surface_with_a_direction_is_refused_with_the_figure() {
    let folder = Folder::new();
    folder.write("map.txt", grooves());
    let map = "--map map.txt --pixel-um 1 --ior 1.49";
    folder.run(&format!("model measured-ray --set scale=1 {map} -o ray.json")).ok();
    let light = "--set scale=1 --wavelength-nm 550";
    folder.run(&format!("model measured-wave {light} {map} -o wave.json")).ok();
    // facets of the hybrid know no azimuth
    let hybrid = folder.run(&format!("model measured-hybrid {light} {map} -o hybrid.json"));
    assert!(hybrid.with_code(2).err.contains("must have no direction"));
    for (file, says) in [
        ("ray.json", "% of their peak from one azimuth of the light to another"),
        ("wave.json", "a table holds the mean of its waves over all azimuths"),
    ] {
        for flags in ["--bytes 8192", "--max-error 50", "--side air --lobe transmission"] {
            let done = folder.run(&format!("tabulate {file} {flags} --rays 1e5 -o t.bsdft"));
            assert!(done.err.contains("the surface has a direction"), "{file}: {}", done.err);
            assert!(done.with_code(2).err.contains(says), "{file}");
            assert!(!folder.path("t.bsdft").exists());
        }
    }
    let trade = folder.run("trade ray.json --table-kib 4,8 --table-rays 1e5 --json");
    let answer: serde_json::Value = serde_json::from_str(&trade.out).unwrap();
    let rows = answer["rows"].as_array().unwrap();
    assert!(rows.iter().all(|row| row["evaluator"]["kind"] == "model"), "{answer:#}");
    let notes = answer["notes"].to_string();
    assert_eq!(notes.matches("the surface has a direction").count(), 1, "{notes}");
}

/// Salts are added to it.
#[test]
fn the_largest_seed_is_a_seed() {
    let folder = Folder::new();
    let seed = format!("--seed {}", u64::MAX);
    folder.write("m.json", MODEL);
    folder.run(&format!("model heights --set delta=1 --ior 1.49 {seed} -o h.json")).ok();
    for model in ["m.json", "h.json"] {
        folder
            .run(&format!("tabulate {model} --bytes 8192 --rays 1e4 {seed} -o t.bsdft"))
            .with_code(0);
    }
}
