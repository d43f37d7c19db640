//! Scatter as other programs write it: separators, decimal marks, encodings, quantities, units of angles, headers.

use std::fmt::Write as _;

use serde_json::Value;

use crate::program::{Done, Folder};

const COLUMNS: &str = "--columns sigma=in,theta=out,reading=r";

/// A reading of the law: angles in degrees, BSDF in 1/sr.
type Row = [f64; 3];

/// A folder with the readings of a metal of alpha 0.3 and gain 0.5.
fn metal() -> (Folder, Vec<Row>) {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.3 gain=0.5 lambert=0 --opaque -o o.json").ok();
    let text = folder.run("scan o.json --sigma 10,40 --step 2 --quantity bsdf --aperture 0").ok();
    let rows = text.lines().skip_while(|line| !line.starts_with("sigma_deg")).skip(1);
    let row = |line: &str| -> Row {
        let values: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        values.try_into().unwrap()
    };
    let inside = |row: &Row| row[1].abs() <= 80.0;
    (folder, rows.map(row).filter(inside).collect())
}

/// The table with lines of a header, each value as `number` writes it.
fn table(header: &str, rows: &[Row], of: impl Fn(&Row) -> Row) -> String {
    let mut text = format!("{header}in,out,r\n");
    for row in rows {
        let [sigma, theta, value] = of(row);
        writeln!(text, "{sigma},{theta},{value:.8e}").unwrap();
    }
    text
}

#[track_caller]
fn is_the_metal(done: Done) -> Done {
    let done = done.with_code(0);
    let fit: Value = serde_json::from_str(&done.out).unwrap();
    for (name, expected) in [("alpha", 0.3), ("gain", 0.5)] {
        let found = fit["parameters"][name]["value"].as_f64().unwrap();
        assert!((found / expected - 1.0).abs() < 1e-3, "{name} {found}\n{}", done.err);
    }
    done
}

#[test]
fn a_layout_is_found_and_said_in_one_line() {
    let (folder, rows) = metal();
    let plain = table("", &rows, |row| *row);
    let comma = plain.replace(',', ";").replace('.', ",");
    let wide = |text: &str, bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
        let marked = "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(bytes);
        marked.collect()
    };
    for (content, says) in [
        (plain.clone().into_bytes(), ""),
        (comma.clone().into_bytes(), "the file is separated by `;`, with decimal commas"),
        (plain.replace(',', "\t").into_bytes(), "the file is separated by tabs"),
        (plain.replace(',', "  ").into_bytes(), "the file is separated by blanks"),
        (
            wide(&comma, u16::to_le_bytes),
            "the file is UTF-16, separated by `;`, with decimal commas",
        ),
        (wide(&plain, u16::to_be_bytes), "the file is UTF-16"),
        ([b"\xef\xbb\xbf", plain.as_bytes()].concat(), "the file is UTF-8 with a byte order mark"),
    ] {
        folder.write("f.csv", content);
        let line = format!("fit f.csv --method ggx --opaque --quantity bsdf {COLUMNS} --json");
        let done = is_the_metal(folder.run(&line));
        let said: Vec<&str> = done.err.lines().filter(|l| l.contains("the file is")).collect();
        let expected = if says.is_empty() { vec![] } else { vec![format!("f.csv: {says}")] };
        assert_eq!(said, expected, "{}", done.err);
    }
    // the standard file in the same clothes
    let own = plain.replace("in,out,r", "sigma_deg,theta_deg,reading");
    let own = format!("# geometry: reflection\n# quantity: bsdf\n{own}").replace(',', "\t");
    folder.write("f.csv", wide(&own, u16::to_le_bytes));
    let done = is_the_metal(folder.run("fit f.csv --method ggx --opaque --json"));
    assert!(done.err.contains("the file is UTF-16, separated by tabs"), "{}", done.err);
}

#[test]
fn every_quantity_and_both_units_of_angles_give_the_same_law() {
    let (folder, rows) = metal();
    let pi = std::f64::consts::PI;
    for (quantity, scale) in [("bsdf", 1.0), ("factor", pi), ("ars", 0.0)] {
        let of = |[sigma, theta, f]: &Row| {
            let scale = if quantity == "ars" { theta.to_radians().cos() } else { scale };
            [*sigma, *theta, f * scale]
        };
        let run = |header: &str, flag: &str| {
            folder.write("f.csv", table(header, &rows, of));
            let line = format!("fit f.csv --method ggx --opaque {COLUMNS} {flag} --json");
            is_the_metal(folder.run(&line))
        };
        run("", &format!("--quantity {quantity}"));
        // the header says it too, and the flag goes before it
        let done = run(&format!("# quantity: {quantity}\n# sample: x\n"), "");
        let says = "its header gives sample x, quantity bsdf";
        assert!(done.err.contains(says), "{}", done.err);
        run("# quantity: counts\n", &format!("--quantity {quantity}"));
    }
    let radians = |[sigma, theta, f]: &Row| [sigma.to_radians(), theta.to_radians(), *f];
    folder.write("f.csv", table("", &rows, radians));
    let line = format!("fit f.csv --method ggx --opaque {COLUMNS} --quantity bsdf --json");
    is_the_metal(folder.run(&format!("{line} --angle-unit rad")));
    let done = folder.run(&line);
    assert!(done.err.contains("--angle-unit rad"), "{}", done.err);
    // who says degrees is not asked again, but the verdict remembers
    let done = folder.run(&format!("{line} --angle-unit deg"));
    assert!(!done.err.lines().any(|l| !l.starts_with("no:") && l.contains("--angle-unit")));
}

#[test]
fn counts_are_fitted_with_a_gain_whatever_their_unit() {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o m.json").ok();
    let text = folder.run("scan m.json --sigma 0,30 --step 1").ok();
    let (header, rows) = text.split_once("sigma_deg,theta_deg,reading\n").unwrap();
    for unit in [3.7e7, 1e-11] {
        let mut counts = format!("{header}in,out,r\n");
        for line in rows.lines() {
            let (angles, value) = line.rsplit_once(',').unwrap();
            let value: f64 = value.parse().unwrap();
            writeln!(counts, "{angles},{:e}", value * unit).unwrap();
        }
        folder.write("f.csv", counts);
        let line = format!("fit f.csv --method ggx {COLUMNS} --quantity counts --json");
        let done = folder.run(&line).with_code(0);
        assert!(done.err.contains("counts have no level"), "{}", done.err);
        assert!(done.err.contains("geometry transmission, ior 1.49"), "{}", done.err);
        let fit: Value = serde_json::from_str(&done.out).unwrap();
        let alpha = fit["parameters"]["alpha"]["value"].as_f64().unwrap();
        assert!((alpha - 0.2).abs() < 1e-4 && fit["parameters"]["gain"].is_object(), "{alpha}");
    }
    let line = format!("fit f.csv --method abg {COLUMNS} --quantity counts");
    let done = folder.run(&line).with_code(2);
    assert!(done.err.contains("f.csv: counts have no level"), "{}", done.err);
}

#[test]
fn flags_go_before_the_header_of_a_foreign_file() {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o m.json").ok();
    let text = folder.run("scan m.json --sigma 0 --step 1").ok();
    let wrong = text.replace("ior: 1.49", "ior: glass");
    folder.write("f.csv", wrong);
    let columns = "--columns sigma=sigma_deg,theta=theta_deg,reading=3";
    let done =
        folder.run(&format!("fit f.csv --method ggx {columns} --quantity flux")).with_code(2);
    assert!(done.err.contains("`glass` is not a value of the header key `ior`"), "{}", done.err);
    let line = format!("fit f.csv --method ggx {columns} --quantity flux --ior 1.49 --json");
    let done = folder.run(&line).with_code(0);
    assert!(done.err.contains("; flags give ior, quantity"), "{}", done.err);
    let fit: Value = serde_json::from_str(&done.out).unwrap();
    assert!((fit["parameters"]["alpha"]["value"].as_f64().unwrap() - 0.2).abs() < 1e-4);
}

#[test]
fn a_zemax_table_is_a_scan() {
    let (folder, _) = metal();
    folder.run("export o.json --format zemax --side air --lobe reflection -o f.bsdf --accept").ok();
    is_the_metal(folder.run("fit f.bsdf --method ggx --opaque --json"));
    // the same saved as Unicode text
    let text = folder.text("f.bsdf");
    let wide: Vec<u8> =
        "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    folder.write("f.bsdf", wide);
    is_the_metal(folder.run("fit f.bsdf --method ggx --opaque --json"));
}
