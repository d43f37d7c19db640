//! Every mistake is answered in a line or two that say what, where and what to do; nothing is written.

use crate::program::{Done, Folder};
use crate::refusal::{Case, FOREIGN, MODEL, OLDER, SCAN, case, faults, refused};

/// `text` with one place changed.
#[track_caller]
fn changed(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "`{from}` is not there");
    text.replacen(from, to, 1)
}

/// A scan with one place changed, to be fitted.
#[track_caller]
fn scan(from: &str, to: &str, says: &[&'static str]) -> Case {
    case("fit bad.csv --method ggx", says).file("bad.csv", changed(SCAN, from, to))
}

/// A model with one place changed, to be checked.
#[track_caller]
fn model(from: &str, to: &str, says: &[&'static str]) -> Case {
    case("check bad.json", says).file("bad.json", changed(MODEL, from, to))
}

#[test]
fn readings_that_cannot_be() {
    refused(vec![
        scan("0,5,3.0e-4", "0,5,nan", &["bad.csv:10", "reading", "not finite"]),
        scan("0,5,3.0e-4", "0,5,inf", &["bad.csv:10", "not finite"]),
        scan("0,5,3.0e-4", "0,5,-Infinity", &["bad.csv:10", "not finite"]),
        scan("0,5,3.0e-4", "0,5,1e999", &["bad.csv:10", "not finite"]),
        scan("0,5,3.0e-4", "0,nan,3.0e-4", &["bad.csv:10", "theta_deg"]),
        scan("0,5,3.0e-4", "0,5,dark", &["bad.csv:10", "`dark` is not a number"]),
        scan("0,5,3.0e-4", "0,5,", &["bad.csv:10", "not a number"]),
        scan("0,5,3.0e-4", "0,5", &["bad.csv:10", "found 2"]),
        scan("0,5,3.0e-4", "0,5,3,0e-4", &["bad.csv:10", "found 4", "--columns"]),
        scan("0,5,3.0e-4", "0;5;3.0e-4", &["bad.csv:10"]),
        scan("0,5,3.0e-4", "0,5,3.0e-4 W", &["bad.csv:10", "no unit"]),
        scan("0,5,3.0e-4", "0,5,\u{1b}[2J\u{7}", &["bad.csv:10"]),
        scan("0,5,3.0e-4", &format!("0,5,{}", "9x".repeat(50_000)), &["bad.csv:10"]),
        scan("0,5,3.0e-4", "90,5,3.0e-4", &["bad.csv:10", "90 deg"]),
        scan("0,5,3.0e-4", "-5,5,3.0e-4", &["bad.csv:10", "-5 deg"]),
        scan("0,5,3.0e-4", "0,91,3.0e-4", &["bad.csv:10", "91 deg"]),
        scan("0,5,3.0e-4", "0,0.0,3.0e-4", &["bad.csv:10", "line 9"]),
        scan("0,5,3.0e-4", "-0,-0,3.0e-4", &["bad.csv:10", "line 9"]),
        scan("0,5,3.0e-4", "0,5,-3.0e-4", &["bad.csv:10", "below zero"]),
        scan("0,5,3.0e-4", "# ior: 1.5", &["bad.csv:10", "above the column names"]),
    ]);
}

#[test]
fn scans_that_are_none() {
    let fit = |content: &[u8], says: &[&'static str]| {
        case("fit bad.csv --method ggx", says).file("bad.csv", content)
    };
    let (header, rows) = SCAN.split_once("sigma_deg,").unwrap();
    let readings: Vec<&str> = rows.lines().skip(1).collect();
    let dark: String =
        readings.iter().map(|r| r[..r.rfind(',').unwrap()].to_owned() + ",0\n").collect();
    let columns = format!("{header}sigma_deg,theta_deg,reading\n");
    let one = |line: &str| format!("{columns}{line}\n");
    let mut utf16: Vec<u8> =
        [0xff, 0xfe].into_iter().chain(SCAN.bytes().flat_map(|b| [b, 0])).collect();
    utf16.pop();
    refused(vec![
        case("fit none.csv --method ggx", &["none.csv: there is no such file"]),
        case("fit folder --method ggx", &["folder: is a folder"]),
        case("fit scan.csv/x --method ggx", &["scan.csv/x"]),
        fit(b"", &["bad.csv", "empty"]),
        fit(b"\xef\xbb\xbf\n\n  \n", &["bad.csv", "empty"]),
        fit(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\xff\xfe", &["bad.csv:1", "not UTF-8 text"]),
        fit(&[0; 5000], &["bad.csv:1"]),
        // half a character at its end
        fit(&utf16, &["bad.csv:", "UTF-16"]),
        fit(header.as_bytes(), &["bad.csv", "the end of the file"]),
        fit(columns.as_bytes(), &["bad.csv", "no readings"]),
        fit(b"{ \"sigma\": [0, 15] }\n", &["bad.csv:1", "expected the line"]),
        fit(b"{ \"asperity\": 1, \"method\": \"ggx\" }\n", &["bad.csv", "`parameters`"]),
        fit(FOREIGN.as_bytes(), &["bad.csv:1", "--columns"]),
        fit(format!("{columns}{dark}").as_bytes(), &["bad.csv", "no reading is above zero"]),
        fit(readings.join("\n").as_bytes(), &["bad.csv:1", "expected the line"]),
        // fewer readings than parameters
        case("fit bad.csv --method normals", &["bad.csv", "1 reading", "2 parameters"])
            .file("bad.csv", one("0,0,1e-3")),
        case("fit bad.csv --method ggx --opaque --geometry reflection", &["bad.csv", "parameters"])
            .file("bad.csv", one("0,0,1e-3")),
        // too small for any arithmetic
        fit(one("0,0,1e-320\n0,1,1e-321").as_bytes(), &["bad.csv"]),
    ]);
}

#[test]
fn headers_that_cannot_be_meant_or_leave_out_what_is_needed() {
    refused(vec![
        scan("# geometry: transmission\n", "", &["bad.csv", "--geometry transmission"]),
        scan("# ior: 1.49\n", "", &["bad.csv", "--ior N"]),
        scan("# rough_side: source\n", "", &["bad.csv", "--rough-side source"]),
        scan("# aperture_deg: 0.6\n", "", &["bad.csv", "--aperture DEG"]),
        scan("transmission", "sideways", &["bad.csv:2", "`sideways`", "transmission, reflection"]),
        scan("1.49", "-1.49", &["bad.csv:3", "`ior`"]),
        scan("1.49", "149", &["bad.csv:3", "`ior`"]),
        scan("1.49", "1,49", &["bad.csv:3", "`ior`"]),
        scan("1.49", "nan", &["bad.csv:3", "`ior`"]),
        scan(": source", ": up", &["bad.csv:4", "`rough_side`"]),
        scan("0.6", "0", &["bad.csv:5", "`aperture_deg`"]),
        scan("0.6", "31", &["bad.csv:5", "`aperture_deg`"]),
        scan("0.6", "inf", &["bad.csv:5", "`aperture_deg`"]),
        scan("# ior: 1.49", "# geometry: reflection", &["bad.csv:3", "line 2"]),
        scan("# ior: 1.49", "# wavelength_nm: 0.55", &["bad.csv:3", "`wavelength_nm`"]),
        scan("# ior: 1.49", "# seed: -1", &["bad.csv:3", "`seed`"]),
        scan("# ior: 1.49", "# quantity: lumen", &["bad.csv:3", "`quantity`"]),
        scan("# ior: 1.49", "# noise_floor_percent: -2", &["bad.csv:3", "noise_floor_percent"]),
    ]);
}

#[test]
fn flags_of_fit() {
    let fit = |rest: &str, says: &[&'static str]| case(format!("fit scan.csv {rest}"), says);
    refused(vec![
        fit("", &["--method"]),
        fit("--method phong", &["`phong`", "ggx, normals"]),
        fit("--method ggx --method normals", &["--method"]),
        fit("--method ggx --profile gauss", &["--profile", "normals"]),
        fit("--method ggx --fit-theta0", &["--fit-theta0", "normals"]),
        fit("--method normals --profile lorentz", &["lorentz", "gauss, cauchy"]),
        fit("--method ggx --objective least", &["least", "rmsd, relative, log"]),
        fit("--method ggx --max-evaluations 0", &["--max-evaluations"]),
        fit("--method ggx --max-evaluations many", &["--max-evaluations"]),
        fit("--method ggx --max-misfit 0", &["--max-misfit"]),
        fit("--method ggx --max-misfit nan", &["--max-misfit"]),
        fit("--method ggx --ior 0", &["refractive index 0"]),
        fit("--method ggx --ior 1e9", &["refractive index"]),
        fit("--method ggx --ior nan", &["refractive index"]),
        fit("--method ggx --ior 1.5 --opaque", &["--ior", "--opaque"]),
        fit("--method ggx --opaque", &["scan.csv", "opaque", "--geometry reflection"]),
        fit("--method normals --opaque --geometry reflection", &["normals", "opaque", "ggx"]),
        fit("--method ggx --geometry sideways", &["sideways", "transmission, reflection"]),
        fit("--method ggx --aperture 0", &["--aperture 0"]),
        fit("--method ggx --aperture 90", &["--aperture 90"]),
        fit("--method ggx --aperture nan", &["--aperture NaN"]),
        fit("--method ggx --sigma-range 40:50", &["scan.csv", "sigma 0:30", "--sigma-range"]),
        fit("--method ggx --sigma-range 30:0", &["--sigma-range", "FROM <= TO"]),
        fit("--method ggx --theta-range wide", &["--theta-range", "FROM:TO"]),
        fit("--method ggx --theta-range nan:5", &["--theta-range", "FROM:TO"]),
        fit("--method ggx --plot nowhere/fit", &["nowhere", "create"]),
        fit("--method ggx --plot /", &["--plot", "stem"]),
        fit("other.csv --method ggx", &["other.csv"]),
    ]);
}

#[test]
fn foreign_files() {
    const MAP: &str = "--columns sigma=in,theta=out,reading=brdf";
    let fit = |rest: &str, says: &[&'static str]| {
        let known = "--method ggx --opaque --geometry reflection";
        case(format!("fit foreign.csv {known} {rest}"), says)
    };
    let bsdf = |rest: &str, says: &[&'static str]| fit(&format!("--quantity bsdf {rest}"), says);
    let steel = format!("{MAP} --where surface=steel");
    refused(vec![
        fit(MAP, &["--quantity", "flux", "bsdf"]),
        fit("--where surface=steel", &["--columns"]),
        bsdf("--columns sigma=in,theta=out", &["--columns", "sigma=NAME"]),
        bsdf("--columns in,out,brdf", &["--columns", "sigma=NAME"]),
        bsdf("--columns sigma=in,theta=out,reading=btdf", &["foreign.csv:1", "`btdf`", "`brdf`"]),
        bsdf("--columns sigma=2,theta=3,reading=5", &["foreign.csv", "5"]),
        bsdf("--columns sigma=1,theta=3,reading=4", &["foreign.csv"]),
        bsdf(
            &format!("{MAP} --where surface=brass"),
            &["foreign.csv", "`brass`", "`steel`, `paint`"],
        ),
        bsdf(&format!("{MAP} --where colour=red"), &["foreign.csv", "`colour`", "`surface`"]),
        bsdf(&format!("{MAP} --where steel"), &["COLUMN=VALUE"]),
        bsdf(&format!("{steel} --where surface=paint"), &["foreign.csv", "--where"]),
        bsdf(&steel, &["foreign.csv:5", "`nan`", "--skip-missing"]),
        bsdf(&format!("{MAP} --where surface=paint"), &["foreign.csv:7", "line 6"]),
        bsdf(
            &format!("{steel} --skip-missing --theta-range 50:60"),
            &["foreign.csv", "--theta-range"],
        ),
        bsdf(&format!("{steel} --skip-missing --theta-range 20:20"), &["foreign.csv"]),
        bsdf(&format!("{MAP} --delimiter ;"), &["foreign.csv:1", "--delimiter"]),
        bsdf(&format!("{MAP} --delimiter ::"), &["`::`", "one character"]),
        // what a foreign file cannot say is asked for
        case(
            format!("fit foreign.csv --method ggx --quantity flux {steel} --skip-missing"),
            &["foreign.csv", "--geometry"],
        ),
        bsdf(MAP, &["foreign.csv:3"])
            .file("foreign.csv", changed(FOREIGN, "steel,0,0,0.9", "\"st")),
        bsdf(MAP, &["foreign.csv:3"]).file("foreign.csv", changed(FOREIGN, "steel,0,0,0.9", "st")),
    ]);
}

#[test]
fn model_files() {
    let check = |content: &[u8], says: &[&'static str]| {
        case("check bad.json", says).file("bad.json", content)
    };
    let long = "x".repeat(100_000);
    refused(vec![
        case("check none.json", &["none.json", "cannot be read"]),
        case("check folder", &["folder", "cannot be read"]),
        case("scan none.json", &["none.json", "cannot be read"]),
        case("eval none.json", &["none.json", "cannot be read"]),
        check(b"", &["bad.json:1"]),
        check(b"\xff\xfe\x00\x01garbage", &["bad.json", "not text"]),
        check(b"[1, 2]", &["bad.json:1"]),
        check("[".repeat(100_000).as_bytes(), &["bad.json:1"]),
        check(SCAN.as_bytes(), &["bad.json:1", "JSON"]),
        check(&MODEL.as_bytes()[..60], &["bad.json", "EOF"]),
        model("\"asperity\": 1", "\"asperity\": 2", &["bad.json:2", "format 2"]),
        model("\"asperity\": 1", "\"asperity\": -1", &["bad.json:2"]),
        model("  \"asperity\": 1,\n", "", &["bad.json", "`asperity`"]),
        model("\"ggx\"", "\"phong\"", &["bad.json:3", "`phong`", "ggx, normals"]),
        model("\"ggx\"", "7", &["bad.json:3", "invalid type"]),
        model("\"ggx\"", "\"a\\nb\\nc\\u001b[2J\"", &["bad.json:3"]),
        model("\"ggx\"", &format!("\"{long}\""), &["bad.json:3"]),
        model("\"ggx\"", "\"normals\"", &["bad.json:3", "`law`", "gauss or cauchy"]),
        model("\"ggx\"", "\"normals\", \"law\": \"gauss\"", &["bad.json:6", "`alpha`", "delta, n"]),
        model("\"ggx\"", "\"normals\", \"law\": \"lorentz\"", &["bad.json:3", "`lorentz`"]),
        model("1.49", "-1.49", &["bad.json:4", "refractive index"]),
        model("1.49", "0", &["bad.json:4", "refractive index"]),
        model("1.49", "1e6", &["bad.json:4", "refractive index"]),
        model("1.49", "1e999", &["bad.json:4"]),
        model("1.49", "NaN", &["bad.json:4"]),
        model("1.49", "\"1.49\"", &["bad.json:4", "invalid type"]),
        model("1.49", "null", &["bad.json", "`ior` is missing"]),
        model("1.49", "1.49, \"body\": \"opaque\"", &["bad.json:4", "opaque"]),
        model("1.49", "1.49, \"body\": \"glass\"", &["bad.json:4", "`glass`"]),
        model("1.49", "1.49, \"colour\": 3", &["bad.json:4", "unknown field"]),
        model("0.2", "-0.2", &["bad.json:6", "alpha"]),
        model("0.2", "0", &["bad.json:6", "alpha"]),
        model("0.2", "1e300", &["bad.json:6", "alpha"]),
        model("0.2", "null", &["bad.json:6"]),
        model("0.2", "\"wide\"", &["bad.json:6", "invalid type"]),
        model("0.2 }", "0.2, \"unit\": \"deg\" }", &["bad.json:6", "`deg`"]),
        model("\"alpha\"", "\"roughness\"", &["bad.json:6", "`roughness`", "alpha"]),
        model("\"alpha\"", "\"al\\npha\\n\\u001b[2J\"", &["bad.json"]),
        model("\"alpha\": { \"value\": 0.2 }", "", &["bad.json", "`alpha`"]),
        // JSON keeps the last of two: another surface than half of the readers expect
        model("0.2 }", "0.2 },\n    \"alpha\": { \"value\": 0.3 }", &["bad.json", "alpha"]),
    ]);
}

#[test]
fn flags_of_model() {
    let make = |rest: &str, says: &[&'static str]| case(format!("model {rest}"), says);
    refused(vec![
        make("", &["<METHOD>"]),
        make("phong --set alpha=0.2 --ior 1.49", &["`phong`", "ggx, normals"]),
        make("ggx --set alpha=0.2", &["--ior N", "--opaque"]),
        make("ggx --ior 1.49", &["`alpha`", "--set"]),
        make("ggx --ior 1.49 --set", &["--set"]),
        make("ggx --ior 1.49 --set alpha", &["--set alpha", "NAME=VALUE"]),
        make("ggx --ior 1.49 --set =0.2", &["NAME=VALUE"]),
        make("ggx --ior 1.49 --set alpha=", &["alpha="]),
        make("ggx --ior 1.49 --set alpha=wide", &["`wide` is not a finite number"]),
        make("ggx --ior 1.49 --set alpha=nan", &["alpha=nan"]),
        make("ggx --ior 1.49 --set alpha=inf", &["alpha=inf"]),
        make("ggx --ior 1.49 --set alpha=0.2rad", &["alpha=0.2rad"]),
        make("ggx --ior 1.49 --set alpha=0", &["alpha"]),
        make("ggx --ior 1.49 --set alpha=-0.2", &["alpha"]),
        make("ggx --ior 1.49 --set alpha=1e9", &["alpha"]),
        make("ggx --ior 1.49 --set alpha=0.2 alpha=0.3", &["alpha is given twice"]),
        make("ggx --ior 1.49 --set alpha=0.2,delta=5", &["delta", "it has alpha"]),
        make("ggx --ior 1.49 --set alpha=0.2 gain=0.5", &["gain", "it has alpha"]),
        make("ggx --opaque --set alpha=0.2 gain=-1 lambert=0.1", &["gain"]),
        make("ggx --opaque --set alpha=0.2 gain=0.5", &["lambert"]),
        make("ggx --opaque --ior 1.49 --set alpha=0.2", &["--opaque", "--ior"]),
        make("ggx --ior 1.49 --profile gauss --set alpha=0.2", &["--profile"]),
        make("ggx --ior=-1.49 --set alpha=0.2", &["refractive index -1.49", "--ior"]),
        make("ggx --ior -1.49 --set alpha=0.2", &["--ior"]),
        make("ggx --ior 1e9 --set alpha=0.2", &["refractive index", "--ior"]),
        make("ggx --ior nan --set alpha=0.2", &["refractive index NaN", "--ior"]),
        make("ggx --ior 1.4.9 --set alpha=0.2", &["--ior"]),
        make("normals --ior 1.49 --set delta=5", &["`n`", "--set"]),
        make("normals --ior 1.49 --set delta=0 n=2", &["delta"]),
        make("normals --ior 1.49 --set delta=5 n=0", &["`n`"]),
        make("normals --ior 1.49 --set delta=5um n=2", &["delta=5um"]),
        make("normals --ior 1.49 --set delta=5 n=2 theta0=91", &["theta0"]),
        make(
            "normals --ior 1.49 --set delta=5 n=2 --profile lorentz",
            &["lorentz", "gauss, cauchy"],
        ),
        make("normals --opaque --set delta=5 n=2", &["opaque", "ggx"]),
    ]);
}

#[test]
fn flags_of_scan_and_check() {
    let scan = |rest: &str, says: &[&'static str]| case(format!("scan m.json {rest}"), says);
    let check = |rest: &str, says: &[&'static str]| case(format!("check {rest}"), says);
    refused(vec![
        scan("--sigma 90", &["--sigma 90"]),
        scan("--sigma=-1", &["--sigma -1"]),
        scan("--sigma 0,nan", &["--sigma NaN"]),
        scan("--sigma 0,30,0 --step 1", &["--sigma"]),
        scan("--sigma zero", &["--sigma"]),
        scan("--sigma 0,,30", &["--sigma"]),
        scan("--step 0", &["--step 0"]),
        scan("--step=-1", &["--step -1"]),
        scan("--step 1e-9", &["--step", "million"]),
        scan("--step nan", &["--step NaN"]),
        scan("--step inf", &["--step inf"]),
        scan("--theta-range 10:-10", &["--theta-range", "FROM <= TO"]),
        scan("--theta-range 91:120", &["--theta-range"]),
        scan("--theta-range 5", &["--theta-range", "FROM:TO"]),
        scan("--aperture 0", &["--aperture 0"]),
        scan("--aperture=-0.6", &["--aperture -0.6"]),
        scan("--aperture 60", &["--aperture 60"]),
        scan("--aperture nan", &["--aperture NaN"]),
        scan("--quantity bsdf --aperture 0 --rays 1000", &["--aperture"]),
        scan("--quantity lumen", &["lumen", "flux, bsdf"]),
        scan("--rays 0", &["--rays", "from 1 to 1e15"]),
        scan("--rays -1", &["-1"]),
        scan("--rays=-1", &["--rays", "from 1 to 1e15"]),
        scan("--rays 1e99", &["--rays", "from 1 to 1e15"]),
        scan("--rays 1.5", &["--rays", "whole number"]),
        scan("--rays many", &["--rays", "whole number"]),
        scan("--rays 1000 --seed -1", &["-1"]),
        scan("--rays 1000 --seed 1.5", &["--seed"]),
        scan("--rough-side up", &["up", "source, detector"]),
        case("scan opaque.json --geometry transmission", &["opaque", "--geometry reflection"]),
        check("m.json --incidence 90", &["--incidence 90"]),
        check("m.json --incidence=-5", &["--incidence -5"]),
        check("m.json --incidence nan", &["--incidence NaN"]),
        check("m.json --incidence steep", &["--incidence"]),
        check("m.json --side inside", &["inside", "air, dielectric"]),
        check("opaque.json --side dielectric", &["opaque", "--side air"]),
        check("", &["<MODEL>"]),
        case("completions tcsh", &["tcsh", "zsh"]),
        case("measure scan.csv", &["measure"]),
        case("demo -o scan.csv", &["scan.csv", "choose another folder"]),
        case("demo -o scan.csv/new", &["scan.csv/new", "choose another folder"]),
    ]);
}

#[test]
fn pairs_that_are_none() {
    const NAMES: &str = "wix,wiy,wiz,wox,woy,woz";
    let eval = |rows: &str, says: &[&'static str]| {
        case("eval m.json", says).stdin(format!("{NAMES}\n0,0,1,0,0,-1\n{rows}\n"))
    };
    let raw = |input: &[u8], says: &[&'static str]| case("eval m.json", says).stdin(input);
    refused(vec![
        eval("0,0,2,0,0,1", &["stdin:3", "wi has length 2"]),
        eval("0,0,1,0,0,0", &["stdin:3", "wo has length 0"]),
        eval("0,0,1,0,0.5,1", &["stdin:3", "wo has length"]),
        eval("0,0,1e308,0,0,1e308", &["stdin:3", "length"]),
        eval("0,0,1,0,1", &["stdin:3", "5 values"]),
        eval("0,0,1,0,0,1,0", &["stdin:3", "7 values"]),
        eval("0,0,up,0,0,1", &["stdin:3", "`up` is not a finite number"]),
        eval("0,0,nan,0,0,1", &["stdin:3", "`nan`"]),
        eval("0,0,inf,0,0,1", &["stdin:3", "`inf`"]),
        eval("0,0,,0,0,1", &["stdin:3"]),
        eval("0;0;1;0;0;1", &["stdin:3"]),
        eval("0,0,\u{1b}[2J\u{7},0,0,1", &["stdin:3"]),
        eval(&format!("0,0,{},0,0,1", "x".repeat(100_000)), &["stdin:3"]),
        raw(b"", &["stdin:1", NAMES]),
        raw(b"# nothing\n\n", &["stdin", NAMES]),
        raw(b"0,0,1,0,0,1\n", &["stdin:1", NAMES]),
        raw(b"theta_i,theta_o\n0,0\n", &["stdin:1", NAMES]),
        raw(b"\xff\xfe\0\x01", &["stdin", "not text"]),
        case("eval m.json -i none.csv", &["none.csv"]),
        case("eval m.json -i folder", &["folder"]),
        case("eval m.json -i pairs.csv", &["pairs.csv:2", "5 values"])
            .file("pairs.csv", format!("{NAMES}\n0,0,1,0,0\n")),
    ]);
}

#[test]
fn outputs_that_cannot_be() {
    let verbs = [
        "model ggx --set alpha=0.2 --ior 1.49",
        "scan m.json --sigma 0 --step 10",
        "fit scan.csv --method ggx",
        "eval m.json",
    ];
    let pairs = "wix,wiy,wiz,wox,woy,woz\n0,0,1,0,0,-1\n";
    let mut cases = Vec::new();
    for verb in verbs {
        for (output, word) in [
            ("folder", "is a folder"),
            ("folder/", "is a folder"),
            ("new/", "is a folder"),
            ("nowhere/out", "there is no folder"),
            ("m.json/out", "m.json"),
        ] {
            cases.push(case(format!("{verb} -o {output}"), &[word]).stdin(pairs));
        }
        // not even the system's owner creates files here
        if cfg!(target_os = "linux") {
            let line = format!("{verb} -o /proc/asperity-out");
            cases.push(case(line, &["/proc/asperity-out", "cannot be created"]).stdin(pairs));
        }
    }
    refused(cases);
}

/// A folder and a file without the permission to write.
#[test]
fn protected_outputs_stay_as_they_are() {
    let folder = Folder::new();
    let protect = |name: &str, on: bool| {
        let mut permissions = std::fs::metadata(folder.path(name)).unwrap().permissions();
        #[cfg(unix)]
        std::os::unix::fs::PermissionsExt::set_mode(
            &mut permissions,
            if on { 0o555 } else { 0o755 },
        );
        #[cfg(not(unix))]
        permissions.set_readonly(on);
        std::fs::set_permissions(folder.path(name), permissions).unwrap();
    };
    folder.write("old.json", OLDER);
    protect("old.json", true);
    let line = "model ggx --set alpha=0.2 --ior 1.49 -o";
    let done = folder.run(&format!("{line} old.json"));
    assert_eq!(faults(&done, &["old.json", "write-protected"]), [""; 0], "{}", done.err);
    assert_eq!(folder.text("old.json"), OLDER);
    protect("old.json", false);

    std::fs::create_dir(folder.path("locked")).unwrap();
    protect("locked", true);
    // the system's owner may write all the same
    if std::fs::write(folder.path("locked/probe"), "").is_err() {
        let done = folder.run(&format!("{line} locked/new.json"));
        assert_eq!(faults(&done, &["locked/new.json", "permissions"]), [""; 0], "{}", done.err);
        let done = folder.run("demo -o locked/demo");
        assert_eq!(faults(&done, &["locked/demo"]), [""; 0], "{}", done.err);
    }
    protect("locked", false);
}

/// A full disk behind stdout is no success.
#[cfg(target_os = "linux")]
#[test]
fn a_result_that_cannot_be_printed_is_no_success() {
    let folder = Folder::new();
    let mut command = folder.command(["model", "ggx", "--set", "alpha=0.2", "--ior", "1.49"]);
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let done: Done = command.stdout(full).output().unwrap().into();
    assert_eq!(done.code, Some(1), "{}", done.err);
    assert!(done.err.starts_with("error: stdout cannot be written"), "{}", done.err);
}
