//! The atlas of true errors where people meet it: `stats`, `fit`, `compare`.

use asperity::surface::GaussianSurface;
use serde_json::Value;

use crate::program::Folder;

/// Matrix text of 64 x 64 points of half a micrometre, with Gaussian heights and autocorrelation.
fn map(rq_um: f64, slope: f64) -> String {
    let length = std::f64::consts::SQRT_2 * rq_um / slope;
    let surface = GaussianSurface {
        size: (64, 64),
        pitches_um: (0.5, 0.5),
        rq_um,
        lengths_um: (length, length),
        seed: 3,
    };
    let map = surface.map().unwrap();
    let row =
        |y| (0..64).map(|x| format!("{:.7}", map.height_um(x, y).unwrap())).collect::<Vec<_>>();
    let rows: Vec<String> = (0..64).map(|y| row(y).join(" ")).collect();
    format!("# heights in um\n{}", rows.join("\n"))
}

const LIGHT: &str = "--pixel-um 0.5 --edges periodic --ior 1.49 --wavelength-nm 550";

fn number(value: &Value, keys: &[&str]) -> f64 {
    keys.iter().fold(value, |value, key| &value[key]).as_f64().unwrap()
}

#[test]
fn stats_quotes_true_errors_beside_the_verdict() {
    let folder = Folder::new();
    folder.write("map.txt", map(0.45, 0.25));
    let line = format!("stats map.txt {LIGHT} --incidence 0,30,45");
    let json = folder.run(&format!("{line} --json")).json();
    let atlas = &json["atlas"];
    assert_eq!(atlas["holds_for"], "grooves, Gaussian, n 1.49");
    let lobes = atlas["lobes"].as_array().unwrap();
    assert_eq!(lobes.len(), json["kirchhoff"]["lobes"].as_array().unwrap().len());
    for lobe in lobes {
        let inside = lobe["side"] == "dielectric" && number(lobe, &["incidence_deg"]) > 40.0;
        assert_eq!(lobe["outside"].is_string(), inside, "{lobe:#}");
        if inside {
            assert!(lobe["kirchhoff"].is_null(), "{lobe:#}");
            continue;
        }
        for engine in
            ["kirchhoff", "rays", "facet", "kirchhoff_diffuse", "rays_diffuse", "facet_diffuse"]
        {
            let of = |key| number(lobe, &[engine, key]);
            let (low, error, high) = (of("low_percent"), of("error_percent"), of("high_percent"));
            assert!(0.0 < low && low < error && error < high && high < 30.0 * low, "{lobe:#}");
            let nearest = [0.4, 0.8, 1.5]
                .iter()
                .any(|rq| (rq - number(lobe, &[engine, "nearest", "rq_over_lambda"])).abs() < 1e-9);
            assert!(nearest, "{lobe:#}");
        }
    }
    // transmission from air along the normal: waves are right, rays less so
    let air = lobes.iter().find(|l| {
        l["side"] == "air" && l["lobe"] == "transmission" && number(l, &["incidence_deg"]) < 1.0
    });
    let air = air.unwrap();
    assert!(number(air, &["kirchhoff", "error_percent"]) < 0.2, "{air:#}");
    assert!(number(air, &["rays", "error_percent"]) > 0.4, "{air:#}");
    let text = folder.run(&line).ok();
    for part in
        ["atlas ", "grooves, Gaussian, n 1.49", "waves, diffuse", " to ", "outside the atlas"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    // without light there is nothing to quote
    let without = folder.run("stats map.txt --pixel-um 0.5 --json").json();
    assert!(without["atlas"].is_null());
}

#[test]
fn what_is_outside_is_said_to_be() {
    let folder = Folder::new();
    folder.write("smooth.txt", map(0.03, 0.01));
    folder.write("map.txt", map(0.45, 0.25));
    let of = |map: &str, light: &str| {
        let json = folder.run(&format!("stats {map} {light} --incidence 0,30 --json")).json();
        let lobes = json["atlas"]["lobes"].as_array().unwrap();
        assert!(lobes.iter().all(|l| l["rays"].is_null()), "{json:#}");
        let why = lobes[0]["outside"].as_str().unwrap().to_owned();
        let text = folder.run(&format!("stats {map} {light} --incidence 0,30")).ok();
        assert_eq!(text.matches("outside the atlas").count(), 1, "{text}");
        why
    };
    assert!(of("smooth.txt", LIGHT).contains("slope 0.01"));
    let silicon = LIGHT.replace("1.49", "3.5");
    assert!(of("map.txt", &silicon).contains("index of 3.5"));
    let short = LIGHT.replace("550", "100");
    assert!(of("map.txt", &short).contains("Rq of 4."));
}

#[test]
fn fit_and_compare_quote_the_geometry_that_was_measured() {
    let folder = Folder::new();
    folder.write("map.txt", map(0.45, 0.25));
    let light = LIGHT.replace(" --ior 1.49", "");
    let scan = format!(
        "scan --map map.txt {LIGHT} --engine ray --sigma 0,30 --step 1 --aperture 4 --rays 40000 --seed 5 -o scan.csv"
    );
    folder.run(&scan.replace(" --wavelength-nm 550", "")).ok();
    let few = "--rough-side source --fit-rays 10000 --rays 20000 --accept";
    let fit = format!(
        "fit scan.csv --method measured-ray --map map.txt --no-cutoff {light} {few} -o fit.json"
    );
    let text = folder.run(&fit).ok();
    let [first, second] = text.lines().filter(|l| l.starts_with("atlas")).collect::<Vec<_>>()[..]
    else {
        panic!("{text}")
    };
    assert!(first.contains("grooves, Gaussian, n 1.49; Rq 0.8"), "{first}");
    assert!(
        first.contains("transmission from air: waves err by 0.") && first.contains("rays by"),
        "{first}"
    );
    assert!(
        second.contains("reflection inside") && second.contains("transmission from inside"),
        "{second}"
    );
    let lines = folder.json("fit.json")["atlas"].clone();
    assert_eq!(lines.as_array().unwrap().len(), 2, "{lines}");
    // the model file is read again
    folder.run("check fit.json --incidence 0 --side air --rays 1e4").ok();
    // without a wavelength there is nothing to say
    let blind = fit.replace(" --wavelength-nm 550", "");
    assert!(!folder.run(&blind).ok().contains("atlas"));
    // towards the detector, light meets the rough face from inside
    let inside = folder.run(&fit.replace("side source", "side detector")).ok();
    assert!(inside.contains("transmission from inside: waves err by"), "{inside}");

    let compare = format!(
        "compare scan.csv --map map.txt --methods ggx,measured-ray {light} {} --max-misfit 60 -o r",
        few.replace(" --accept", "")
    );
    let done = folder.run(&compare);
    assert!(done.out.contains("Atlas: grooves, Gaussian"), "{}\n{}", done.out, done.err);
    let sample = folder.json("r/compare.json")["samples"][0].clone();
    assert_eq!(sample["atlas"], lines, "{sample:#}");
    for file in ["r/compare.md", "r/report.html"] {
        assert_eq!(folder.text(file).matches("Atlas: ").count(), 2, "{file}");
    }
}
