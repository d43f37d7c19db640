//! Malformed scans: each must be refused with the line and the remedy, and none may panic.

use super::csv::parse;

const HEAD: &str = "sigma_deg,theta_deg,reading\n";

/// What is wrong, the file, the line that must be named (0: none), words of the message.
type Case = (&'static str, &'static [u8], u64, &'static [&'static str]);

/// Files that fail before or in the line with the column names.
const TOPS: [Case; 23] = [
    ("empty", b"", 0, &["empty", "sigma_deg,theta_deg,reading"]),
    ("blank", b"\xef\xbb\xbf \r\n\n", 0, &["empty"]),
    ("header only", b"# ior: 1.5\n", 0, &["the end of the file", "--columns"]),
    ("no column line", b"# x: y\n0,0,1\n", 2, &["expected", "`0,0,1`", "--columns"]),
    ("wrong names", b"\nsigma,theta,r\n", 2, &["sigma_deg,theta_deg,reading", "--columns"]),
    ("column twice", b"sigma_deg,theta_deg,reading,phi_deg,phi_deg\n", 1, &["--columns"]),
    ("other column", b"sigma_deg,theta_deg,reading,azimuth\n", 1, &["azimuth", "--columns"]),
    ("bars", b"sigma_deg|theta_deg|reading\n", 1, &["--columns"]),
    ("no rows", b"sigma_deg,theta_deg,reading\n# nothing\n", 0, &["no readings", "one line per"]),
    ("latin 1", b"# sample: geb\xfcrstet\n", 1, &["not UTF-8", "encoding UTF-8"]),
    ("half of utf 16", b"\xff\xfes\0\n\0i\0g", 2, &["not UTF-8", "UTF-16"]),
    ("binary", b"\x7fELF\x02\x01\n\0\0\0", 2, &["not UTF-8"]),
    ("ior word", b"# a: b\n# ior: glass\n", 2, &["`glass`", "`ior`", "1.49"]),
    ("ior zero", b"# ior: 0\n", 1, &["0.1..=10"]),
    ("ior negative", b"# ior: -1.5\n", 1, &["0.1..=10"]),
    ("ior nan", b"# ior: nan\n", 1, &["0.1..=10"]),
    ("ior infinite", b"# IOR: inf\n", 1, &["0.1..=10"]),
    ("aperture", b"# aperture_deg: 31\n", 1, &["full angle", "30"]),
    ("geometry", b"# geometry: btdf\n", 1, &["`btdf`", "transmission, reflection"]),
    ("rough side", b"# rough_side: top\n", 1, &["`top`", "source, detector"]),
    ("quantity", b"# quantity: brdf\n", 1, &["flux, bsdf"]),
    ("seed", b"# seed: 1.5\n", 1, &["whole number"]),
    ("key twice", b"# ior: 1.5\n# sample: x\n# Ior: 1.5\n", 3, &["line 1", "keep one"]),
];

/// Rows that fail, below the line with the column names, which is line 1.
const ROWS: [Case; 24] = [
    ("two values", b"0,1,1\n0,1\n", 3, &["expected 3", "found 2", "--columns"]),
    ("four values", b"0,1,1,1\n", 2, &["found 4"]),
    ("decimal comma", b"0,1,1,25\n", 2, &["found 4", "decimals with a point"]),
    ("word", b"0,1,1\n\n0,2,dark\n", 4, &["column reading", "`dark`", "1.25e-3"]),
    ("empty value", b"0,,1\n", 2, &["column theta_deg", "not a number"]),
    ("unit", b"0deg,1,1\n", 2, &["column sigma_deg", "no unit"]),
    ("nan", b"0,1,nan\n", 2, &["not finite", "delete the row"]),
    ("infinite", b"0,1,1\n0,2,-inf\n", 3, &["not finite"]),
    ("overflow", b"0,1,1e999\n", 2, &["not finite"]),
    ("angle nan", b"NaN,1,1\n", 2, &["column sigma_deg", "not finite"]),
    ("negative", b"0,1,1\n0,2,-0.06\n0,3,1\n", 3, &["below zero", "dark signal"]),
    ("sigma 90", b"90,1,1\n", 2, &["incidence 90", "[0, 90)", "--sigma-range"]),
    ("sigma negative", b"-15,1,1\n", 2, &["incidence -15"]),
    ("theta", b"0,90.1,1\n", 2, &["observation 90.1", "[-90, 90]", "--theta-range"]),
    ("radians of theta", b"0,0,1\r\n0,-100,1\r\n", 3, &["observation -100"]),
    ("twice", b"0,1,1\n0,2,1\n\n0,1.0,1\n", 5, &["line 2", "average", "--where"]),
    ("twice zero", b"0,-0,1\n0,0,1\n", 3, &["line 2"]),
    ("all zero", b"0,1,0\n0,2,0\n", 0, &["no reading is above zero", "lamp"]),
    ("all negative", b"0,1,-1\n0,2,-1\n", 0, &["no reading is above zero"]),
    ("late key", b"0,1,1\n# ior: 1.5\n", 3, &["`ior`", "move it above"]),
    ("second column line", b"0,1,1\nsigma_deg,theta_deg,reading\n", 3, &["`sigma_deg`"]),
    ("garbage", b"0,1,1\n\xf0\x9f\x92\xa9\n", 3, &["column sigma_deg", "not a number"]),
    ("cut short", b"0,1,1\n0,2,\n", 3, &["column reading", "not a number"]),
    ("bad bytes", b"0,1,1\n0,2,1\n0,3,\xff\n", 4, &["not UTF-8"]),
];

fn check(case: &Case, bytes: &[u8]) {
    let (what, _, line, words) = *case;
    let error = parse(bytes, "folder/scan.csv").expect_err(what);
    let message = error.to_string();
    assert_eq!(error.line.unwrap_or(0), line, "{what}: {message}");
    let place =
        if line == 0 { "folder/scan.csv: ".into() } else { format!("folder/scan.csv:{line}") };
    assert!(message.starts_with(&place), "{what}: {message}");
    assert!(!message.contains('\n') && message.len() < 280, "{what}: {message}");
    for word in words {
        assert!(message.contains(word), "{what}: `{word}` is not in: {message}");
    }
}

#[test]
fn malformed_scans_are_refused_with_line_and_remedy() {
    for case in &TOPS {
        check(case, case.1);
    }
    for case in &ROWS {
        check(case, &[HEAD.as_bytes(), case.1].concat());
    }
}

#[test]
fn no_truncation_or_flipped_byte_panics() {
    let text =
        "\u{feff}# sample: ü\n# ior: 1.49\nsigma_deg,theta_deg,reading\n0,-1.5,1e-3\n15,2,3\n";
    let bytes = text.as_bytes();
    for position in 0..bytes.len() {
        let _ = parse(&bytes[..position], "cut.csv");
        for value in [0, b',', b'\n', b'9', b'#', 0xff] {
            let mut flipped = bytes.to_vec();
            flipped[position] = value;
            let _ = parse(flipped, "flipped.csv");
        }
    }
}
