//! Every verb does what it says.

use std::fmt::Write as _;

use serde_json::Value;

use crate::program::Folder;

const GGX: &str = "model ggx --set alpha=0.2 --ior 1.49";

#[track_caller]
pub(crate) fn close(found: &Value, expected: f64, tolerance: f64) {
    let found = found.as_f64().unwrap_or_else(|| panic!("{found} is not a number"));
    assert!((found - expected).abs() <= tolerance, "{found} is not {expected}");
}

#[track_caller]
fn keys(value: &Value) -> Vec<&str> {
    value.as_object().expect("an object").keys().map(String::as_str).collect()
}

/// The rows of a standard scan file.
fn rows(text: &str) -> Vec<[f64; 3]> {
    let mut lines = text.lines().skip_while(|l| l.starts_with('#'));
    assert_eq!(lines.next(), Some("sigma_deg,theta_deg,reading"));
    let row = |line: &str| {
        let numbers: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        <[f64; 3]>::try_from(numbers).unwrap()
    };
    lines.map(row).collect()
}

#[test]
fn model_writes_what_was_set() {
    let folder = Folder::new();
    let model = folder.run(GGX).json();
    assert_eq!((&model["asperity"], &model["method"]), (&1.into(), &"ggx".into()));
    close(&model["ior"], 1.49, 0.0);
    close(&model["parameters"]["alpha"]["value"], 0.2, 0.0);
    assert_eq!(model["provenance"]["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(model["provenance"]["references"][0], "Walter2007");

    // stdout and file hold the same; -o is silent, --json is not
    assert!(folder.run(&format!("{GGX} -o m.json")).ok().is_empty());
    assert_eq!(folder.json("m.json"), model);
    assert_eq!(folder.run(&format!("{GGX} -o m.json --json")).json(), model);
    assert_eq!(folder.names(), ["m.json"]);
}

#[test]
fn model_takes_angles_in_degrees_and_radians() {
    let folder = Folder::new();
    let delta = |text: &str| {
        let line = format!("model normals --set delta={text} n=1.66 --ior 1.49");
        folder.run(&line).json()["parameters"]["delta"].clone()
    };
    for text in ["6.9", "6.9deg", "0.12042771838760874rad"] {
        close(&delta(text)["value"], 6.9, 1e-12);
        assert_eq!(delta(text)["unit"], "deg");
    }
    let line = "model normals --set delta=5,n=2,theta0=3 --profile cauchy --ior 1.49";
    let model = folder.run(line).json();
    assert_eq!(model["law"], "cauchy");
    close(&model["parameters"]["theta0"]["value"], 3.0, 0.0);
}

#[test]
fn model_knows_an_opaque_body() {
    let folder = Folder::new();
    let line = "model ggx --opaque --set alpha=0.3 --set gain=0.5 --set lambert=0.02";
    let model = folder.run(line).json();
    assert_eq!((&model["body"], &model["ior"]), (&"opaque".into(), &Value::Null));
    assert_eq!(keys(&model["parameters"]), ["alpha", "gain", "lambert"]);
    assert_eq!(model["parameters"]["lambert"]["unit"], "1/sr");
}

#[test]
fn scan_by_quadrature_is_a_scan_file() {
    let folder = Folder::new();
    folder.run(&format!("{GGX} -o m.json")).ok();
    let text = folder.run("scan m.json --sigma 0,30 --step 0.5 --theta-range -60:60").ok();
    for line in [
        "# geometry: transmission",
        "# ior: 1.49",
        "# rough_side: source",
        "# aperture_deg: 0.6",
        "# calibration: relative to the beam without sample",
    ] {
        assert!(text.lines().any(|l| l == line), "{line} is not in\n{}", &text[..400]);
    }
    let scan = rows(&text);
    assert_eq!(scan.len(), 2 * 241);
    assert!(scan.iter().all(|r| r[2] >= 0.0 && r[2] < 1.0));
    // symmetric at normal incidence, to what the peak is computed to
    let peak = scan[..241].iter().map(|r| r[2]).fold(0.0, f64::max);
    for k in 0..120 {
        let (a, b) = (scan[k][2], scan[240 - k][2]);
        assert!((a - b).abs() <= 1e-4 * peak, "theta {}: {a} and {b}", scan[k][1]);
    }
    // the undeviated beam is at theta = +sigma: the lobe is there, not on the other side
    let peak = scan[241..].iter().copied().fold([0.0; 3], |a, b| if b[2] > a[2] { b } else { a });
    assert!((peak[1] - 30.0).abs() < 5.0, "the lobe of sigma 30 is at {}", peak[1]);

    let summary = folder.run("scan m.json --sigma 0 --step 1 -o scan.csv").ok();
    assert!(summary.contains("181 readings"), "{summary}");
    let json = folder.run("scan m.json --sigma 0 --step 1 -o scan.csv --json").json();
    assert_eq!((&json["asperity"], &json["readings"]), (&1.into(), &181.into()));
    assert_eq!(folder.names(), ["m.json", "scan.csv"]);
}

#[test]
fn scan_by_monte_carlo_agrees_within_its_noise_floor() {
    let folder = Folder::new();
    folder.run(&format!("{GGX} -o m.json")).ok();
    let line = "scan m.json --sigma 0,30 --step 1 --aperture 1";
    let exact = rows(&folder.run(line).ok());
    let json = folder.run(&format!("{line} --rays 1e6 --seed 7 -o mc.csv --json")).json();
    let floor = json["noise_floor_percent"].as_f64().unwrap();
    assert!(floor > 0.0 && floor < 2.0, "{floor}");
    let text = folder.text("mc.csv");
    assert!(text.contains("\n# seed: 7\n") && text.contains("\n# noise_floor_percent: "));
    let noisy = rows(&text);
    let largest = exact.iter().map(|r| r[2]).fold(0.0, f64::max);
    let squares: f64 = exact.iter().zip(&noisy).map(|(a, b)| (a[2] - b[2]).powi(2)).sum();
    let rmsd = 100.0 * (squares / exact.len() as f64).sqrt() / largest;
    assert!(rmsd > 0.5 * floor && rmsd < 2.0 * floor, "{rmsd} % beside a floor of {floor} %");
    for flux in json["flux"].as_array().unwrap() {
        let part = |name: &str| flux[name].as_f64().unwrap();
        let sum = part("reflected") + part("transmitted") + part("lost");
        assert!((sum - 1.0).abs() < 1e-9, "{flux}");
    }
}

#[test]
fn scan_knows_reflection_the_rough_side_and_bsdf_values() {
    let folder = Folder::new();
    folder.run(&format!("{GGX} -o m.json")).ok();
    folder.run("model ggx --set alpha=0.2 gain=0.5 lambert=0.02 --opaque -o o.json").ok();
    let line = "scan m.json --sigma 30 --step 1 --geometry reflection --rough-side detector";
    let text = folder.run(line).ok();
    assert!(text.contains("# geometry: reflection\n# ior: 1.49\n# rough_side: detector\n"));
    // an opaque body is measured in reflection, unasked
    let text = folder.run("scan o.json --sigma 30 --step 1 --quantity bsdf --aperture 0").ok();
    assert!(text.contains("# geometry: reflection\n") && text.contains("# quantity: bsdf\n"));
    assert!(!text.contains("ior") && !text.contains("rough_side"), "{}", &text[..300]);
    // reflected light: the mirror direction is at theta = +sigma
    let scan = rows(&text);
    let at = |theta: f64| scan.iter().find(|r| (r[1] - theta).abs() < 1e-9).unwrap()[2];
    assert!(at(30.0) > 5.0 * at(-30.0), "{} and {}", at(30.0), at(-30.0));
    // far from the lobe the Lambert floor, 0.02 1/sr, is what is left
    assert!(at(-60.0) > 0.02 && at(-60.0) < 0.05, "{}", at(-60.0));
}

/// The scan of a known plate, fitted.
#[test]
fn fit_finds_the_model_that_made_the_scan() {
    let folder = Folder::new();
    folder.run(&format!("{GGX} -o m.json")).ok();
    folder.run("scan m.json --sigma 0,30,60 --step 0.5 --rays 1e6 --seed 3 -o scan.csv").ok();
    let done = folder.run("fit scan.csv --method ggx -o fit.json --plot fit").with_code(0);
    for word in ["alpha        0.", "ior          1.4900", "RMSD", "noise floor", "converged"] {
        assert!(done.out.contains(word), "{word} is not in\n{}", done.out);
    }
    let fit = folder.json("fit.json");
    // the contract's keys
    for key in [
        "asperity",
        "method",
        "ior",
        "parameters",
        "rmsd_percent",
        "noise_floor_percent",
        "evaluations",
        "termination",
        "provenance",
        "timing",
    ] {
        assert!(!fit[key].is_null(), "{key} is missing in\n{fit:#}");
    }
    assert_eq!((&fit["asperity"], &fit["method"]), (&1.into(), &"ggx".into()));
    assert_eq!(keys(&fit["parameters"]), ["alpha"]);
    let alpha = &fit["parameters"]["alpha"];
    assert_eq!(keys(alpha), ["value", "unit", "std_error"]);
    let error = alpha["std_error"].as_f64().unwrap();
    assert!(error > 0.0 && error < 0.01, "{error}");
    close(&alpha["value"], 0.2, 5.0 * error);
    let (rmsd, floor) = (&fit["rmsd_percent"], fit["noise_floor_percent"].as_f64().unwrap());
    close(rmsd, floor, 0.5 * floor);
    assert_eq!(fit["termination"], "converged");
    assert!(fit["evaluations"].as_u64().is_some_and(|n| n > 0));
    assert!(fit["timing"]["seconds"].as_f64().is_some_and(|s| s > 0.0));

    let provenance = &fit["provenance"];
    assert_eq!(keys(provenance), ["tool", "version", "seed", "inputs", "references"]);
    assert_eq!(provenance["version"], env!("CARGO_PKG_VERSION"));
    let input = &provenance["inputs"][0];
    assert_eq!(input["path"], "scan.csv");
    assert_eq!(input["sha256"].as_str().unwrap().len(), 64);
    assert_eq!(provenance["references"][0], "Walter2007");

    // --json prints what the file holds
    let mut printed = folder.run("fit scan.csv --method ggx --json").json();
    printed["timing"] = fit["timing"].clone();
    assert_eq!(printed, fit);

    for name in ["fit-linear.svg", "fit-log.svg"] {
        is_plot(&folder, name);
        assert!(done.err.contains(name), "{}", done.err);
    }
    // a fit is a model
    folder.run("check fit.json --incidence 0").ok();
    folder.run("scan fit.json --sigma 0 --step 10").ok();
}

#[test]
fn fit_tries_both_laws_of_normals_and_keeps_the_better() {
    let folder = Folder::new();
    let line = "model normals --set delta=6.9 n=1.66 --profile gauss --ior 1.49 -o m.json";
    folder.run(line).ok();
    folder.run("scan m.json --sigma 0,45 --step 1 -o scan.csv").ok();
    let fit = folder.run("fit scan.csv --method normals --json").json();
    assert_eq!((&fit["method"], &fit["law"]), (&"normals".into(), &"gauss".into()));
    close(&fit["parameters"]["delta"]["value"], 6.9, 0.01);
    close(&fit["parameters"]["n"]["value"], 1.66, 0.01);
    assert_eq!(fit["parameters"]["delta"]["unit"], "deg");
    assert!(fit["provenance"]["references"][0].as_str().unwrap().contains("Sokolov"));
}

#[test]
fn fit_finds_the_index_and_the_gain_when_asked() {
    let folder = Folder::new();
    folder.run(&format!("{GGX} -o m.json")).ok();
    let text = folder.run("scan m.json --sigma 0,30,60 --step 1").ok();
    let (header, _) = text.split_once("sigma_deg,").unwrap();
    let mut scaled = format!("{header}sigma_deg,theta_deg,reading\n");
    for [sigma, theta, value] in rows(&text) {
        writeln!(scaled, "{sigma},{theta},{}", 1.3 * value).unwrap();
    }
    folder.write("scan.csv", scaled);
    let fit = folder.run("fit scan.csv --method ggx --fit-gain --json").json();
    close(&fit["parameters"]["gain"]["value"], 1.3, 0.001);
    let line = "fit scan.csv --method ggx --fit-gain --fit-ior --ior 1.45 --json -o fit.json";
    let fit = folder.run(line).json();
    close(&fit["parameters"]["ior"]["value"], 1.49, 0.01);
    close(&fit["ior"], 1.49, 0.01);
    folder.run("check fit.json --incidence 0").ok();
}

#[test]
fn fit_reads_a_foreign_file() {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.3 gain=0.5 lambert=0.02 --opaque -o o.json").ok();
    let text = folder.run("scan o.json --sigma 10,40 --step 2 --quantity bsdf --aperture 0").ok();
    let mut foreign = String::from("# not ours: x\nsurface;in;out;brdf\n");
    for [sigma, theta, value] in rows(&text) {
        let value = value.to_string().replace('.', ",");
        writeln!(foreign, "steel;{sigma};{theta};{value}\npaint;{sigma};{theta};1").unwrap();
    }
    foreign += "steel;10;3,5;\n";
    folder.write("foreign.csv", foreign);
    let line = "fit foreign.csv --method ggx --opaque --quantity bsdf --where surface=steel \
                --columns sigma=in,theta=out,reading=brdf --delimiter ; --decimal-comma \
                --skip-missing --theta-range -80:80 --json";
    let done = folder.run(line).with_code(0);
    assert!(done.err.contains("162 of 365 rows used"), "{}", done.err);
    let fit: Value = serde_json::from_str(&done.out).unwrap();
    assert_eq!(fit["ior"], Value::Null);
    close(&fit["parameters"]["alpha"]["value"], 0.3, 0.001);
    close(&fit["parameters"]["gain"]["value"], 0.5, 0.005);
    close(&fit["parameters"]["lambert"]["value"], 0.02, 0.001);
}

/// Pairs in the plane of incidence: `wi` at `theta_i`, `wo` at `theta_o` from +z on the other side.
fn pairs(angles: &[(f64, f64)]) -> String {
    let mut text = String::from("wix,wiy,wiz,wox,woy,woz\n");
    for (theta_i, theta_o) in angles {
        let (i, o) = (theta_i.to_radians(), theta_o.to_radians());
        writeln!(text, "{},0,{},{},0,{}", -i.sin(), i.cos(), o.sin(), o.cos()).unwrap();
    }
    text
}

#[test]
fn eval_agrees_with_values_computed_elsewhere() {
    let folder = Folder::new();
    folder.run(&format!("{GGX} -o m.json")).ok();
    // Walter et al. 2007, eqs 20, 21, 33, 34, in double precision by another program: (f, ars)
    let expected = [
        (0.0, 180.0, 70.73234854125963, 70.73234854125963),
        (30.0, 160.0, 59.21937722884163, 55.64801178947953),
        (30.0, 40.0, 0.08863201537404242, 0.06789606285972102),
    ];
    let angles: Vec<_> = expected.iter().map(|e| (e.0, e.1)).collect();
    let input = pairs(&angles);
    let out = folder.pipe("eval m.json", input.as_bytes()).ok();
    let mut lines = out.lines();
    assert_eq!(lines.next(), Some("wix,wiy,wiz,wox,woy,woz,f,ars,pdf"));
    for ((line, given), (_, _, f, ars)) in lines.zip(input.lines().skip(1)).zip(expected) {
        let added = line.strip_prefix(given).and_then(|l| l.strip_prefix(',')).unwrap();
        let v: Vec<f64> = added.split(',').map(|x| x.parse().unwrap()).collect();
        assert_eq!(v.len(), 3);
        assert!((v[0] - f).abs() < 1e-9 * f && (v[1] - ars).abs() < 1e-9 * ars, "{line}");
        assert!(v[2] > 0.0 && v[2].is_finite(), "{line}");
    }
    assert_eq!(out.lines().count(), 4);

    // the same from a file, to a file, as JSON
    folder.write("pairs.csv", &input);
    folder.run("eval m.json -i pairs.csv -o out.csv").ok();
    assert_eq!(folder.text("out.csv"), out);
    let json = folder.run("eval m.json -i pairs.csv --json").json();
    assert_eq!(json.as_array().map(Vec::len), Some(3));
    assert_eq!(keys(&json[1]), ["wi", "wo", "f", "ars", "pdf"]);
    close(&json[1]["ars"], 55.64801178947953, 1e-8);
}

#[test]
fn eval_gives_zero_where_nothing_goes_and_takes_a_header_alone() {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 gain=0.5 lambert=0.02 --opaque -o o.json").ok();
    let json = folder.pipe("eval o.json --json", pairs(&[(0.0, 180.0), (0.0, 0.0)]).as_bytes());
    let json = json.json();
    close(&json[0]["f"], 0.0, 0.0);
    assert!(json[1]["f"].as_f64().unwrap() > 0.5, "{json}");
    let out = folder.pipe("eval o.json", pairs(&[]).as_bytes()).ok();
    assert_eq!(out, "wix,wiy,wiz,wox,woy,woz,f,ars,pdf\n");
}

#[test]
fn check_accounts_for_all_flux() {
    let folder = Folder::new();
    folder.run(&format!("{GGX} -o ggx.json")).ok();
    let line = "model normals --set delta=6.9 n=1.66 --ior 1.49 -o normals.json";
    folder.run(line).ok();
    for model in ["ggx.json", "normals.json"] {
        let answer = folder.run(&format!("check {model} --json --incidence 0,30,60")).json();
        assert_eq!(answer["conserves_energy"], true);
        let energy = answer["energy"].as_array().unwrap();
        assert_eq!(energy.len(), 6, "both sides, three angles");
        for (k, e) in energy.iter().enumerate() {
            assert_eq!(
                keys(e),
                [
                    "incidence_deg",
                    "side",
                    "reflected",
                    "transmitted",
                    "lost",
                    "coherent_reflected",
                    "coherent_transmitted"
                ]
            );
            assert_eq!(e["side"], if k < 3 { "air" } else { "dielectric" });
            close(&e["incidence_deg"], [0.0, 30.0, 60.0][k % 3], 0.0);
            let part = |name: &str| e[name].as_f64().unwrap();
            let sum = part("reflected") + part("transmitted") + part("lost");
            assert!((sum - 1.0).abs() < 1e-12, "{e}");
            assert!(part("lost") > -1e-4 && part("lost") < 0.3, "{e}");
            assert!(part("reflected") > 0.0 && part("transmitted") > 0.0, "{e}");
            close(&e["coherent_reflected"], 0.0, 0.0);
            close(&e["coherent_transmitted"], 0.0, 0.0);
        }
        // beyond the critical angle, 42.2 deg, most comes back
        assert!(energy[5]["reflected"].as_f64().unwrap() > 0.5, "{}", energy[5]);
        assert_eq!(answer["reciprocal"], model == "ggx.json");
    }
    let text = folder.run("check ggx.json").ok();
    assert!(text.contains("light from the air") && text.contains("light from the dielectric"));
    assert!(text.contains("85.00 deg") && text.contains("reciprocal"), "{text}");
    let one = folder.run("check ggx.json --side dielectric --incidence 10 --json").json();
    assert_eq!(one["energy"].as_array().map(Vec::len), Some(1));
    assert_eq!(one["energy"][0]["side"], "dielectric");
}

#[test]
fn a_reader_that_leaves_early_is_no_failure() {
    let folder = Folder::new();
    folder.run(&format!("{GGX} -o m.json")).ok();
    let mut child = folder.command(["scan", "m.json", "--sigma", "0"]).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// That an SVG file is one and holds no number that is none.
#[track_caller]
pub(crate) fn is_plot(folder: &Folder, name: &str) {
    let text = folder.text(name);
    assert!(text.contains("<svg") && text.trim_end().ends_with("</svg>"), "{name}");
    without_nan(name, &text);
    let png = std::fs::read(folder.path(&name.replace(".svg", ".png"))).unwrap();
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"), "{name}");
    assert!(png.ends_with(b"IEND\xaeB`\x82"), "{name}");
    let size = |k: usize| u32::from_be_bytes(png[k..k + 4].try_into().unwrap());
    assert!(size(16) >= 300 && size(20) >= 200, "{name}: {} x {}", size(16), size(20));
}

/// `NaN` and `inf` as words; `info` and the like are innocent.
#[track_caller]
pub(crate) fn without_nan(name: &str, text: &str) {
    let mut words = text.split(|c: char| !c.is_ascii_alphanumeric());
    let found = words.find(|w| ["nan", "inf", "infinity"].contains(&w.to_lowercase().as_str()));
    assert_eq!(found, None, "{name}");
}

/// A page without what its scripts and its styles say.
pub(crate) fn without_scripts(html: &str) -> String {
    let mut text = String::new();
    let mut rest = html;
    while let Some(at) = rest.find("<script") {
        text += &rest[..at];
        rest = rest[at..].split_once("</script>").expect("a script ends").1;
    }
    text + rest
}

/// Elements that are opened are closed, in order; enough of HTML for pages made by a program.
#[track_caller]
pub(crate) fn is_balanced(name: &str, html: &str) {
    const VOID: [&str; 7] = ["meta", "link", "br", "hr", "img", "input", "col"];
    let mut open: Vec<String> = Vec::new();
    let mut rest = html;
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        if let Some(after) = rest.strip_prefix("!--") {
            rest = &after[after.find("-->").expect("a comment ends")..];
            continue;
        }
        let end = rest.find('>').unwrap_or_else(|| panic!("{name}: a tag without an end"));
        let tag = &rest[..end];
        rest = &rest[end + 1..];
        let word: String =
            tag.trim_start_matches('/').chars().take_while(char::is_ascii_alphanumeric).collect();
        if tag.starts_with('/') {
            assert_eq!(open.pop().as_deref(), Some(word.as_str()), "{name}: </{word}>");
        } else if !tag.starts_with(['!', '?'])
            && !tag.ends_with('/')
            && !VOID.contains(&word.as_str())
        {
            if let "style" | "script" = word.as_str() {
                let close = format!("</{word}>");
                rest = &rest[rest.find(&close).expect("style ends") + close.len()..];
            } else {
                open.push(word);
            }
        }
    }
    assert!(open.is_empty(), "{name}: {open:?} are left open");
}

#[test]
fn demo_does_the_whole_job_and_says_that_its_data_are_virtual() {
    let folder = Folder::new();
    let done = folder.run("demo -o new/results --rays 3e5 --json").with_code(0);
    assert!(done.err.contains("irtual sample") && done.err.contains("No measured data"));
    let answer: Value = serde_json::from_str(&done.out).unwrap();
    assert_eq!((&answer["asperity"], &answer["truth"]["scale"]), (&1.into(), &1.0.into()));
    // every method there is, in its order
    let fits = answer["fits"].as_array().unwrap();
    let found: Vec<&str> = fits.iter().map(|f| f["method"].as_str().unwrap()).collect();
    assert_eq!(found, asperity::method::Kind::of_paper());
    // the map is the truth, the others are models of it
    let of = |method: &str| fits.iter().find(|f| f["method"] == method).unwrap();
    close(&of("measured-ray")["parameters"]["scale"]["value"], 1.0, 0.02);
    let rmsd = |method: &str| of(method)["rmsd_percent"].as_f64().unwrap();
    for other in ["ggx", "normals", "heights", "measured-wave"] {
        let (ray, other) = (rmsd("measured-ray"), rmsd(other));
        assert!(ray < other && other < 6.0, "{ray} and {other}");
    }

    assert_eq!(folder.names(), ["new"]);
    let mut names: Vec<_> = std::fs::read_dir(folder.path("new/results")).unwrap().collect();
    assert!(names.iter().all(Result::is_ok));
    names.retain(|n| n.as_ref().is_ok_and(|n| n.file_name().to_string_lossy().starts_with('.')));
    assert!(names.is_empty(), "temporary files are left: {names:?}");
    for fit in fits {
        let file = format!("new/results/virtual/{}.json", fit["method"].as_str().unwrap());
        assert_eq!(&folder.json(&file), fit);
        // also from elsewhere: a map is found beside its model
        folder.run(&format!("check {file} --incidence 0 --rays 1e4")).ok();
    }
    let stats = folder.run("stats new/results/virtual/map.sdf --form mean --json").json();
    close(&stats["rq_um"], 0.7, 1e-6);
    let scan = folder.text("new/results/virtual/scan.csv");
    assert!(scan.contains("virtual plate") && scan.contains("no measured data"));
    assert_eq!(rows(&scan).len(), 5 * 1801);
    for name in ["all-linear", "all-log", "sigma0-linear", "sigma60-log"] {
        let name = format!("new/results/virtual/{name}.svg");
        is_plot(&folder, &name);
        is_balanced(&name, &folder.text(&name));
    }
    let html = folder.text("new/results/report.html");
    assert!(html.to_lowercase().starts_with("<!doctype html>"), "{}", &html[..100]);
    for word in ["<title>", "Virtual sample", "No measured data", "ggx", "measured-ray", "<svg"] {
        assert!(html.contains(word), "{word} is not in the report");
    }
    assert!(!html.contains("src=\"http") && !html.contains("href=\"http"), "nothing from outside");
    let html = without_scripts(&html);
    without_nan("report.html", &html);
    is_balanced("report.html", &html);
    // the scan is a scan like any other
    folder.run("fit new/results/virtual/scan.csv --method ggx --sigma-range 0:15").ok();
}

#[test]
fn tabulate_makes_a_table_and_its_sources() {
    let folder = Folder::new();
    folder.run(&format!("{GGX} -o m.json")).ok();
    let answer =
        folder.run("tabulate m.json --bytes 8192 -o t.bsdft --rust t.rs --c t.h --json").json();
    assert_eq!((&answer["asperity"], &answer["storage"]), (&1.into(), &"u8".into()));
    assert!(answer["bytes"].as_u64().unwrap() <= 8192);
    assert!(answer["distance_percent"].as_f64().unwrap() < 1.0, "{answer}");
    let (rust, c) = (folder.text("t.rs"), folder.text("t.h"));
    assert!(rust.contains("static VALUES: [u8; ") && rust.contains("pub fn table()"));
    assert!(c.contains("static const uint8_t bsdf_t_values[") && c.contains("#endif"));
    let bytes = std::fs::read(folder.path("t.bsdft")).unwrap();
    let line = bytes.iter().position(|b| *b == b'\n').unwrap();
    let header: Value = serde_json::from_slice(&bytes[..line]).unwrap();
    assert_eq!(header["payload_bytes"], bytes.len() - line - 1);
    let one = folder
        .run("tabulate m.json --side air --lobe transmission --max-error 0.3 -o s.bsdft")
        .ok();
    assert!(one.contains("air, transmission") && !one.contains("reflection"), "{one}");
    assert!(
        folder.run("tabulate m.json --bytes 100 -o u.bsdft").with_code(2).err.contains("too few")
    );
    let line = "tabulate m.json --side air --lobe reflection --max-error 1e-9 -o u.bsdft";
    folder.run(line).with_code(1);
    assert!(!folder.path("u.bsdft").exists());
}
