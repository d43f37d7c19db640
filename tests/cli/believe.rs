//! Verdicts, causes and errors of `fit`, on files that are wrong in one way each.

use std::fmt::Write;

use asperity_needs::data;
use serde_json::Value;

use crate::program::Folder;

/// A scan of a virtual plate with a little noise, the same each time.
pub(crate) fn scan(folder: &Folder, name: &str, model: &str, flags: &str) {
    folder.run(&format!("model {model} --ior 1.49 -o {name}.json")).ok();
    folder.run(&format!("scan {name}.json --step 1 {flags} -o {name}.csv")).ok();
}

/// The rows of a scan: sigma, theta, reading.
fn rows(text: &str) -> Vec<[f64; 3]> {
    let numbers = |line: &str| -> Option<[f64; 3]> {
        let cells: Vec<f64> = line.split(',').filter_map(|c| c.parse().ok()).collect();
        cells.get(..3)?.try_into().ok()
    };
    text.lines().filter_map(numbers).collect()
}

/// The same file with other angles or readings, and noise of 0.1 % of the largest.
pub(crate) fn changed(
    folder: &Folder,
    from: &str,
    to: &str,
    change: impl Fn([f64; 3]) -> [f64; 3],
) {
    let text = folder.text(&format!("{from}.csv"));
    let rows = rows(&text);
    let largest = rows.iter().map(|r| r[2]).fold(0.0, f64::max);
    let mut out: String =
        text.lines().filter(|l| l.starts_with('#')).fold(String::new(), |s, l| s + l + "\n");
    out += "sigma_deg,theta_deg,reading\n";
    let mut seed = 9_u32;
    for row in rows {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = 2e-3 * largest * (f64::from(seed) / f64::from(u32::MAX) - 0.5);
        let [sigma, theta, value] = change([row[0], row[1], row[2]]);
        if theta.abs() < 90.0 {
            let _ =
                writeln!(out, "{sigma},{theta},{}", value + if value > 0.0 { noise } else { 0.0 });
        }
    }
    folder.write(&format!("{to}.csv"), out);
}

pub(crate) fn causes(model: &Value) -> String {
    let causes = model["verdict"]["causes"].as_array().unwrap();
    causes.iter().map(|c| c.as_str().unwrap()).collect::<Vec<_>>().join("; ")
}

pub(crate) fn value(model: &Value, name: &str) -> f64 {
    model["parameters"][name]["value"].as_f64().unwrap()
}

#[test]
fn reflectance_factors_are_no_bsdf() {
    let folder = Folder::new();
    let Some(path) = data("cases/reflectance-factor-as-bsdf/factor.csv") else { return };
    let line = format!(
        "fit {} --columns sigma=ti,theta=to,reading=f --quantity bsdf --method ggx --opaque -o f.json",
        path.display()
    );
    let run = folder.run(&line).with_code(1);
    assert!(run.err.contains("divide by pi") && run.out.contains("unphysical"), "{run:?}");
    let model: Value = serde_json::from_str(&folder.text("f.json")).unwrap();
    assert_eq!(model["verdict"]["grade"], "unphysical");
    folder.run(&format!("{line} --accept")).ok();
    let right = line.replace("--quantity bsdf", "--quantity factor");
    let model = folder.run(&format!("{right} --json")).with_code(0);
    assert!(!model.out.contains("unphysical"), "{}", model.out);
}

#[test]
fn zeros_are_left_out_and_said() {
    let folder = Folder::new();
    let Some(path) = data("cases/relative-objective-zeros/zeros.csv") else { return };
    let line = format!(
        "fit {} --columns sigma=ti,theta=to,reading=f --quantity bsdf --method ggx --opaque --objective relative --json",
        path.display()
    );
    let run = folder.run(&line);
    assert!(run.err.contains("8 readings of exactly 0"), "{}", run.err);
    let model = run.json();
    assert!((value(&model, "alpha") - 0.4).abs() < 2e-3, "{model}");
    assert!((value(&model, "gain") / 0.1176 - 1.0).abs() < 0.01, "{model}");
}

type Change = fn([f64; 3]) -> [f64; 3];

#[test]
fn faults_of_a_file_are_named_and_their_flags_mend_them() {
    let folder = Folder::new();
    scan(&folder, "plate", "ggx --set alpha=0.2", "");
    changed(&folder, "plate", "sound", |row| row);
    let sound = folder.run("fit sound.csv --method ggx --json").json();
    assert_eq!(sound["verdict"]["grade"], "within-noise", "{}", causes(&sound));
    assert_eq!(causes(&sound), "");
    assert_eq!(sound["fluxes"].as_array().unwrap().len(), 10);

    let faults: [(&str, Change, &str, &str); 4] = [
        ("mirrored", |[s, t, v]| [s, -t, v], "--theta-sign", "--theta-sign minus"),
        ("turned", |[s, t, v]| [s, t + 2.0, v], "zero of theta at 2.0", "--fit-offset=3"),
        ("percent", |[s, t, v]| [s, t, 100.0 * v], "percent", "--fit-gain"),
        ("wide", |[s, t, v]| [s, t, 1.36 * v], "--aperture 0.", "--fit-gain"),
    ];
    for (name, change, word, remedy) in faults {
        changed(&folder, "plate", name, change);
        let line = format!("fit {name}.csv --method ggx --accept --json");
        let wrong = folder.run(&line).json();
        assert!(causes(&wrong).contains(word), "{name}: {}", causes(&wrong));
        assert_ne!(wrong["verdict"]["grade"], "within-noise");
        let mended = folder.run(&format!("{line} {remedy}")).json();
        let alpha = value(&mended, "alpha");
        assert!((alpha - 0.2).abs() < 2e-3, "{name}: {alpha} {}", causes(&mended));
        assert_eq!(mended["verdict"]["grade"], "within-noise", "{name}: {}", causes(&mended));
    }
}

/// The level of each incidence is lost where readings are divided by their own peaks; the shape of the law is not.
#[test]
fn a_law_is_found_where_each_incidence_is_normalised_to_its_peak() {
    let folder = Folder::new();
    scan(&folder, "plate", "ggx --set alpha=0.2", "");
    changed(&folder, "plate", "sound", |row| row);
    let text = folder.text("sound.csv");
    let head = text.lines().filter(|l| l.starts_with('#'));
    let mut own: String = head.fold(String::new(), |s, l| s + l + "\n");
    own += "sigma_deg,theta_deg,reading\n";
    for incidence in rows(&text).chunk_by(|a, b| a[0].total_cmp(&b[0]).is_eq()) {
        let peak = incidence.iter().map(|r| r[2]).fold(0.0, f64::max);
        for [sigma, theta, value] in incidence {
            let _ = writeln!(own, "{sigma},{theta},{}", value / peak);
        }
    }
    folder.write("own.csv", own);
    let wrong = folder.run("fit own.csv --method ggx --accept --json").json();
    assert!(causes(&wrong).contains("--fit-gains=free"), "{}", causes(&wrong));
    let found = folder.run("fit own.csv --method ggx --fit-gains=free --json").json();
    let alpha = value(&found, "alpha");
    assert!((alpha - 0.2).abs() < 2e-3, "{alpha} {}", causes(&found));
    let verdict = (&found["verdict"]["grade"], causes(&found));
    assert_eq!(verdict, (&"within-noise".into(), String::new()));
    let line = "fit own.csv --method ggx --opaque --geometry reflection --fit-gains=free";
    assert!(folder.run(line).with_code(2).err.contains("--fit-gains=PERCENT"));
    let line = "fit own.csv --method ggx --fit-gains=free --fit-gain --gain-prior 1";
    assert!(folder.run(line).with_code(2).err.contains("--gain-prior"));
}

#[test]
fn what_the_readings_do_not_tell_is_refused() {
    let folder = Folder::new();
    let Some(path) = data("scatter/eds10-btdf/inplane.csv") else { return };
    let line = format!(
        "fit {} --columns sigma=A,theta=B,reading=C --quantity bsdf --geometry transmission --ior 1.5 --rough-side detector \
         --method ggx --fit-ior --fit-gain",
        path.display()
    );
    let run = folder.run(&line).with_code(1);
    assert!(
        run.err.contains("not identifiable") && run.err.contains("trade against"),
        "{}",
        run.err
    );
    folder.run(&format!("{line} --accept")).ok();
    // a zero twelve times its prior width away, under a law that does not fit
    let line =
        line.replace("--method ggx --fit-ior --fit-gain", "--method normals --objective log");
    let run = folder.run(&format!("{line} --fit-offset --fit-stray")).with_code(1);
    assert!(run.err.contains("standard deviations from what is known of it"), "{}", run.err);
}

#[test]
fn doubts_enter_the_errors_and_the_bootstrap_agrees() {
    let folder = Folder::new();
    scan(&folder, "plate", "ggx --set alpha=0.2", "");
    changed(&folder, "plate", "noisy", |row| row);
    let line = "fit noisy.csv --method ggx --json";
    let plain = folder.run(line).json();
    let doubts = "--uncertainty offset=0.05,gain=1,drift=0.3 --bootstrap 100";
    let whole = folder.run(&format!("{line} {doubts}")).json();
    let error = |model: &Value| model["parameters"]["alpha"]["std_error"].as_f64().unwrap();
    assert!(error(&whole) > 2.0 * error(&plain), "{} {}", error(&plain), error(&whole));
    let sources: Vec<&str> =
        whole["budget"].as_array().unwrap().iter().map(|c| c["source"].as_str().unwrap()).collect();
    assert_eq!(sources, ["noise", "zero of theta", "zero of sigma", "gain", "drift"]);
    let draws: Vec<f64> =
        whole["samples"].as_array().unwrap().iter().map(|d| d[0].as_f64().unwrap()).collect();
    assert_eq!(draws.len(), 100);
    let mean = draws.iter().sum::<f64>() / 100.0;
    let spread = (draws.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / 99.0).sqrt();
    // 100 draws know a spread to 7 %
    assert!((spread / error(&whole) - 1.0).abs() < 0.25, "{spread} {}", error(&whole));
    let again = folder.run(&format!("{line} {doubts}")).json();
    assert_eq!(again["samples"], whole["samples"]);
    for bad in
        ["--uncertainty weather=1", "--uncertainty gain=-1", "--bootstrap 3", "--fit-offset=0"]
    {
        folder.run(&format!("{line} {bad}")).with_code(2);
    }
}

#[test]
fn a_measured_response_is_taken_for_the_cone() {
    let folder = Folder::new();
    scan(&folder, "plate", "ggx --set alpha=0.2", "--aperture 4");
    // a detector of 4 deg sees a narrow beam as a top hat
    let rows: String = (-120_i32..=120).fold(String::new(), |mut s, k| {
        let value = match k.abs() {
            ..40 => 1.0,
            40 => 0.5,
            _ => 0.0,
        };
        let _ = writeln!(s, "0,{},{value}", f64::from(k) * 0.05);
        s
    });
    folder.write("scan0.csv", format!("sigma_deg,theta_deg,reading\n{rows}"));
    let seen = folder.run("fit plate.csv --method ggx --signature scan0.csv --json").json();
    assert!((value(&seen, "alpha") / 0.2 - 1.0).abs() < 1e-3, "{}", value(&seen, "alpha"));
    folder.write("open.csv", "sigma_deg,theta_deg,reading\n0,-1,1\n0,0,1\n0,1,1\n0,2,1\n0,3,1\n");
    let bad = folder.run("fit plate.csv --method ggx --signature open.csv").with_code(2);
    assert!(bad.err.contains("open.csv"), "{}", bad.err);
}

#[test]
fn values_of_the_boundary_have_a_band_that_holds_the_truth() {
    let folder = Folder::new();
    scan(&folder, "plate", "ggx --set alpha=0.2", "");
    changed(&folder, "plate", "noisy", |row| row);
    folder.run("fit noisy.csv --method ggx -o f.json --plot f").ok();
    let text = folder.text("f-boundary.csv");
    assert!(text.starts_with("side,lobe,incidence_deg,theta_deg,bsdf_per_sr,std_per_sr\n"));
    // the same of the true law and of the fit by `eval`, from inside at 30 deg, transmitted
    let rows = text.lines().filter(|l| l.starts_with("dielectric,transmission,30,"));
    let rows: Vec<[f64; 3]> = rows
        .map(|l| {
            let cells: Vec<f64> = l.split(',').filter_map(|c| c.parse().ok()).collect();
            [cells[1], cells[2], cells[3]]
        })
        .collect();
    assert_eq!(rows.len(), 357);
    let pairs = rows.iter().fold("theta_i,phi_i,theta_o,phi_o\n".to_owned(), |text, row| {
        let (polar, azimuth) = (row[0].abs(), if row[0] < 0.0 { 180 } else { 0 });
        text + &format!("150,180,{polar},{azimuth}\n")
    });
    folder.write("pairs.csv", pairs);
    let values = |line: &str| -> Vec<[f64; 2]> {
        let rows = folder.run(line).json();
        let of = |row: &Value, key: &str| row[key].as_f64().unwrap_or(0.0);
        rows.as_array().unwrap().iter().map(|r| [of(r, "f"), of(r, "f_std")]).collect()
    };
    let fitted = values("eval f.json -i pairs.csv --uncertainty --json");
    let truth = values("eval plate.json -i pairs.csv --json");
    let peak = truth.iter().map(|t| t[0]).fold(0.0, f64::max);
    for ((row, fitted), truth) in rows.iter().zip(&fitted).zip(&truth) {
        assert!((row[1] - fitted[0]).abs() <= 1e-9 * peak, "{row:?} {fitted:?}");
        assert!((row[2] - fitted[1]).abs() <= 1e-9 * peak, "{row:?} {fitted:?}");
        if truth[0] > 1e-3 * peak {
            assert!(fitted[1] > 0.0 && fitted[1] < 0.05 * truth[0], "{row:?}");
            // one draw of the noise moves all values together
            assert!((fitted[0] - truth[0]).abs() < 3.5 * fitted[1], "{row:?} {truth:?}");
        }
    }
    let csv = folder.run("eval f.json -i pairs.csv --uncertainty").ok();
    assert!(csv.starts_with("theta_i,phi_i,theta_o,phi_o,f,ars,pdf,f_std\n"), "{}", csv);
    let refused = folder.run("eval plate.json -i pairs.csv --uncertainty").with_code(2);
    assert!(refused.err.contains("standard error"), "{}", refused.err);
}
