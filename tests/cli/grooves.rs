//! `check --engine rigorous`: Maxwell's equations on one period of grooves.

use asperity_needs::data;

use crate::program::Folder;

/// Efficiencies of a table by side, m0, kind and m.
fn efficiencies(text: &str) -> Vec<(String, [f64; 2])> {
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    let of = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let key = format!("{},{},{},{}", cells[0], cells[1], cells[3], cells[4]);
        (key, [6, 7].map(|k| cells[k].parse::<f64>().unwrap()))
    };
    rows.map(of).collect()
}

#[test]
fn orders_of_the_reference_profiles_are_written_as_they_are_there() {
    let folder = Folder::new();
    for name in ["A", "B", "C", "D"] {
        let Some(profile) = data(&format!("reference/rigorous/give_{name}_profile.csv")) else {
            return;
        };
        let Some(orders) = data(&format!("reference/rigorous/give_{name}_orders.csv")) else {
            return;
        };
        let wanted = efficiencies(&std::fs::read_to_string(orders).unwrap());
        let mut found = Vec::new();
        for (side, word) in [("air", "air"), ("dielectric", "inside")] {
            let mut m0: Vec<&str> = wanted
                .iter()
                .filter(|(key, _)| key.starts_with(word))
                .map(|(key, _)| key.split(',').nth(1).unwrap())
                .collect();
            m0.dedup();
            let line = format!(
                "check --engine rigorous --profile {} --ior 1.49 --wavelength-nm 550 --side {side} --incidence-orders {} --orders -o o.csv",
                profile.display(),
                m0.join(",")
            );
            folder.run(&line).ok();
            let text = folder.text("o.csv");
            assert!(text.contains("side,m0,theta_i_deg,kind,m,theta_deg,eff_TE,eff_TM\n"));
            found.extend(efficiencies(&text));
        }
        assert_eq!(found.len(), wanted.len(), "{name}");
        for ((key, a), (other, b)) in found.iter().zip(&wanted) {
            assert_eq!(key, other, "{name}");
            assert!((0..2).all(|k| (a[k] - b[k]).abs() < 1e-5), "{name} {key}: {a:?} {b:?}");
        }
    }
}

#[test]
fn flat_grooves_are_fresnel_s_and_faults_are_named() {
    let folder = Folder::new();
    let flat: Vec<String> = (0..16).map(|k| format!("{},0", 0.25 * f64::from(k))).collect();
    folder.write("flat.csv", format!("x_um,z_um\n{}\n", flat.join("\n")));
    let line = "check --engine rigorous --profile flat.csv --ior 1.5 --wavelength-nm 555";
    let json = folder.run(&format!("{line} --json")).json();
    for incidence in json["incidences"].as_array().unwrap() {
        let orders = incidence["orders"].as_array().unwrap();
        let mirrored = orders.iter().find(|o| o["kind"] == "R" && o["m"] == 0).unwrap();
        for polarisation in ["eff_TE", "eff_TM"] {
            assert!((mirrored[polarisation].as_f64().unwrap() - 0.04).abs() < 1e-8);
        }
    }
    let text = folder.run(line).ok();
    assert!(text.contains("inside") && text.contains("balance of energy"), "{text}");
    // a grazing order is refused with what can be used instead, an order that does not travel with the last that does
    let grazing = folder.run(&line.replace("555", "500")).with_code(2);
    assert!(grazing.err.contains("use a wavelength of"), "{}", grazing.err);
    let far = folder.run(&format!("{line} --side air --incidence-orders=-9")).with_code(2);
    assert!(far.err.contains("last order"), "{}", far.err);
    folder.write("bad.csv", "x_um,z_um\n0,0\n0.25,a\n");
    for (wrong, said) in [
        ("check --profile bad.csv --ior 1.5 --wavelength-nm 555", "bad.csv:3"),
        ("check --profile none.csv --ior 1.5 --wavelength-nm 555", "none.csv"),
        ("check --profile flat.csv --wavelength-nm 555", "give --ior"),
        ("check --profile flat.csv --ior 1.5", "--wavelength-nm"),
        ("check --profile flat.csv --ior 1.5 --wavelength-nm 500,600", "--wavelength-nm"),
        (
            "check --profile flat.csv --ior 1.5 --wavelength-nm 555 --engine ray",
            "--engine rigorous",
        ),
        ("check --profile flat.csv --ior 1.5 --wavelength-nm 555 --period-um 9", "not the period"),
        ("check m.json --incidence-orders 1", "--profile"),
        ("check m.json --orders", "--profile"),
    ] {
        let run = folder.run(wrong).with_code(2);
        assert!(run.err.contains(said), "{wrong}: {}", run.err);
    }
}

/// Gentle bumps, 160 x 160 points 0.1 um apart, Rq near 0.05 um.
fn bumps() -> String {
    let wave = |x: f64, length: f64, phase: f64| (std::f64::consts::TAU * x / length + phase).sin();
    let height = |x: f64, y: f64| {
        0.03 * (wave(x, 1.9, 0.3) * wave(y, 2.3, 1.0)
            + wave(x + 0.7 * y, 3.1, 2.0)
            + wave(x - 0.9 * y, 2.6, 0.7))
    };
    let row = |y: u32| {
        let cells: Vec<String> = (0..160)
            .map(|x| format!("{:.6}", height(0.1 * f64::from(x), 0.1 * f64::from(y))))
            .collect();
        cells.join(" ") + "\n"
    };
    let rows: String = (0..160).map(row).collect();
    format!("# heights in um, pixel size 0.1 um\n{rows}")
}

#[test]
fn waves_and_rays_are_measured_on_cuts_of_a_map() {
    let folder = Folder::new();
    folder.write("bumps.txt", bumps());
    let light = "--ior 1.49 --wavelength-nm 550";
    let line = format!("stats bumps.txt {light} --incidence 0,30 --rigorous=3");
    let found = &folder.run(&format!("{line} --json")).json()["rigorous"];
    assert!(found["energy_error"].as_f64().unwrap() < 1e-6);
    let lobes = found["lobes"].as_array().unwrap();
    // two sides, two incidences, two lobes, three lights
    assert_eq!(lobes.len(), 24);
    let through = |light: &str| {
        let is_it = |l: &&serde_json::Value| {
            l["side"] == "air"
                && l["lobe"] == "transmission"
                && l["light"] == light
                && l["incidence_deg"].as_f64().unwrap().abs() < 1.0
        };
        lobes.iter().find(is_it).unwrap()
    };
    // gentle and shallow: waves hold, rays do not
    let off =
        |k: usize| through("unpolarised")["engines"][k]["reading"]["percent"].as_f64().unwrap();
    assert!(off(0) < 0.5 && off(1) > 2.0, "{} {}", off(0), off(1));
    let text = folder.run(&format!("{line} --plot own")).ok();
    assert!(text.contains("solved by Maxwell's equations"), "{text}");
    // the point of this map among the curves of the atlas, three engines in three lobes
    let picture = folder.text("own-rigorous.svg");
    let shape = found["filtered"]["rms_slope"].as_f64().unwrap();
    assert!(picture.contains(&format!("this map, slope {shape:.2}")));
    for engine in ["waves", "rays", "single facets"] {
        let caption = format!("{engine}: from air, transmission, 30");
        assert!(picture.contains(&caption), "{caption}");
    }
    assert!(picture.contains("rays: from inside, transmission, 30"));
    let check =
        format!("check --engine rigorous --map bumps.txt {light} --incidence 0 --side air --json");
    assert_eq!(folder.run(&check).json()["lobes"].as_array().unwrap().len(), 6);
    for (wrong, said) in [
        ("stats bumps.txt --rigorous".to_owned(), "--ior"),
        (format!("stats bumps.txt {light} --rigorous --period-um 2"), "10 wavelengths"),
        (
            "stats bumps.txt --ior 1.49 --wavelength-nm 450,550 --rigorous".to_owned(),
            "one wavelength",
        ),
        (format!("scan --map bumps.txt {light} --engine rigorous"), "check --engine rigorous"),
    ] {
        let run = folder.run(&wrong).with_code(2);
        assert!(run.err.contains(said), "{wrong}: {}", run.err);
    }
}

#[test]
fn compare_sets_the_errors_on_the_map_beside_each_method() {
    let folder = Folder::new();
    folder.write("bumps.txt", bumps());
    let light = "--wavelength-nm 550";
    folder
        .run(&format!(
            "scan --map bumps.txt {light} --ior 1.49 --engine wave --sigma 0,30 --step 1 --aperture 4 -o scan.csv"
        ))
        .ok();
    let compare = format!(
        "compare scan.csv --map bumps.txt --methods ggx,measured-ray,measured-wave {light} --rough-side source --fit-rays 10000 \
         --rays 20000 --max-misfit 90 --no-timing --rigorous=3 -o r"
    );
    folder.run(&compare);
    let sample = folder.json("r/compare.json")["samples"][0].clone();
    let lobes = sample["rigorous"]["lobes"].as_array().unwrap();
    // 0 and 30 degrees from air and from inside, each with both lobes
    assert_eq!(lobes.len(), 8, "{sample:#}");
    let measured: Vec<_> = lobes.iter().filter(|l| l["measured"] == true).collect();
    assert_eq!(measured.len(), 2);
    assert!(measured.iter().all(|l| l["side"] == "air" && l["lobe"] == "transmission"));
    // the figure of the engine stands beside each method, the largest of the measured angles
    for (method, engine) in
        [("ggx", "single facets"), ("measured-ray", "rays"), ("measured-wave", "waves")]
    {
        let results = sample["results"].as_array().unwrap();
        let found = results.iter().find(|r| r["method"] == method).unwrap();
        let of = |l: &&serde_json::Value| l[engine]["percent"].as_f64().unwrap();
        let worst = measured.iter().map(of).fold(0.0, f64::max);
        assert_eq!(found["engine_error"]["percent"].as_f64(), Some(worst), "{method}");
    }
    for file in ["r/compare.md", "r/report.html"] {
        let text = folder.text(file);
        assert_eq!(text.matches("Maxwell's equations on 3 of ").count(), 1, "{file}");
        assert!(text.contains("engine off") && !text.contains("Atlas: "), "{file}");
    }
    assert!(folder.text("r/report.html").contains("this map, slope"));
    // what was solved is kept, and the tables are the same
    let before = ["r/compare.md", "r/scan/rigorous.json"].map(|file| folder.text(file));
    let again = folder.run(&compare);
    assert!(!again.err.contains("solving"), "{}", again.err);
    assert_eq!(before, ["r/compare.md", "r/scan/rigorous.json"].map(|file| folder.text(file)));
    // the header knows the wavelength
    folder.write("dark.csv", folder.text("scan.csv").replace("# wavelength_nm: 550\n", ""));
    for (wrong, said) in [
        ("compare scan.csv --methods ggx --rigorous -o s", "give --map FILE"),
        ("compare dark.csv --map bumps.txt --methods ggx --rigorous -o s", "--wavelength-nm"),
    ] {
        let run = folder.run(&format!("{wrong} --rough-side source")).with_code(2);
        assert!(run.err.contains(said), "{wrong}: {}", run.err);
    }
}

#[test]
fn a_plan_quotes_the_errors_on_the_map_of_its_scene() {
    let folder = Folder::new();
    folder.write("bumps.txt", bumps());
    let scene = "[body]\nkind = \"plate\"\nior = 1.49\nrough = \"source\"\n[surface]\nmap = \"bumps.txt\"\n[source]\n\
                 kind = \"collimated\"\nincidence_deg = 20\nwavelength_nm = 550\n[wanted]\nquantity = \"haze\"\n\
                 error_percent = 30\n[target]\nkind = \"host\"\n";
    folder.write("scene.toml", scene);
    let of_atlas = folder.run("plan scene.toml").out;
    let solved = folder.run("plan scene.toml --rigorous=3").out;
    assert!(solved.contains("Maxwell's equations on 3 of "), "{solved}");
    assert!(of_atlas.contains("true error of rays") && !of_atlas.contains("Maxwell"), "{of_atlas}");
    folder.write("none.toml", scene.replace("map = \"bumps.txt\"", "rms_slope = 0.1"));
    let run = folder.run("plan none.toml --rigorous").with_code(2);
    assert!(run.err.contains("give the surface as map"), "{}", run.err);
}
