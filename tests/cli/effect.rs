//! Consistency: flags without effect are refused, `-h` fits a screen, old names still work, and the user says how much is said.

use crate::program::Folder;

const GGX: &str =
    r#"{"asperity": 1, "method": "ggx", "ior": 1.49, "parameters": {"alpha": {"value": 0.2}}}"#;
const MAP: &str = "# x [um] y [um] z [um]\n0 0 0\n1 0 0.1\n2 0 0\n0 1 0.1\n1 1 0\n2 1 0.1\n0 2 0\n1 2 0.1\n2 2 0\n";

/// A folder with a model, a scan of it, and a map.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("m.json", GGX);
    folder.write("map.xyz", MAP);
    folder.run("scan m.json --sigma 0,30 --step 1 -o scan.csv").ok();
    folder.run("tabulate m.json --bytes 8192 -o m.bsdft").ok();
    folder
}

#[test]
fn a_flag_without_effect_is_refused() {
    let folder = folder();
    for (line, flag) in [
        ("fit scan.csv --method ggx --crop 1:2,1:2", "--crop"),
        ("fit scan.csv --method ggx --edges mirrored", "--edges"),
        ("fit scan.csv --method ggx --wavelength-nm 550", "--wavelength-nm"),
        (
            "fit scan.csv --method normals --speckle kept --shadowing on",
            "--speckle and --shadowing",
        ),
        ("fit scan.csv --method ggx --rays 1e5", "--rays"),
        ("fit scan.csv --method normals --fit-rays 1e5 --seed 3", "--fit-rays and --seed"),
        (
            "fit scan.csv --method measured-wave --map map.xyz --wavelength-nm 550 --seed 3",
            "--seed",
        ),
        (
            "fit scan.csv --method ggx --opaque --geometry reflection --rough-side source",
            "--rough-side",
        ),
        ("compare scan.csv --fill nearest -o out", "--fill"),
        ("compare scan.csv --wavelength-nm 550 -o out", "--wavelength-nm"),
        ("compare scan.csv --methods ggx,normals --rays 1e5 -o out", "--rays"),
        ("trade m.json --seed 3", "--seed"),
        ("trade m.json --ior 1.5 --columns sigma=a,theta=b,reading=c", "--ior and --columns"),
        ("trade scan.csv --methods ggx --form none", "--form"),
        ("scan m.json --pixel-um 1", "--pixel-um"),
        ("scan m.json --speckle kept", "--speckle"),
        ("scan m.json --seed 3", "--seed"),
        ("scan --map map.xyz --ior 1.5 --engine wave --wavelength-nm 550 --seed 3", "--seed"),
        ("check m.json --allow-steep", "--allow-steep"),
        ("model ggx --set alpha=0.2 --ior 1.5 --seed 3", "--seed"),
        ("model ggx --set alpha=0.2 --ior 1.5 --z-um 0.1", "--z-um"),
        ("model ggx --set alpha=0.2 --ior 1.5 --wavelength-nm 550", "--wavelength-nm"),
    ] {
        let pairs = "wix,wiy,wiz,wox,woy,woz\n0,0,1,0,0,1\n";
        let done = folder.pipe(line, pairs.as_bytes()).with_code(2);
        assert!(done.out.is_empty(), "{line}: {}", done.out);
        assert!(done.err.contains(&format!("error: {flag} ha")), "{line}: {}", done.err);
        assert!(
            done.err.contains("no effect") && done.err.contains("leave"),
            "{line}: {}",
            done.err
        );
    }
}

#[test]
fn rays_for_a_model_without_are_no_mistake_and_said() {
    let folder = folder();
    for line in [
        "check m.json --rays 1e5",
        "check m.bsdft --rays 1e5",
        "tabulate m.json --rays 1e5 -o t.bsdft",
    ] {
        let done = folder.run(line).with_code(0);
        assert!(done.err.contains("note: --rays has no effect"), "{line}: {}", done.err);
    }
}

#[test]
fn the_short_help_fits_a_screen() {
    let folder = Folder::new();
    for verb in ["demo", "model", "scan", "fit", "compare", "trade", "eval", "check", "tabulate"] {
        let short = folder.run(&format!("{verb} -h")).ok();
        assert!(short.lines().count() <= 48, "{verb}: {} lines\n{short}", short.lines().count());
        assert!(!short.contains("--ignore-checksum"), "{verb}\n{short}");
        assert!(short.contains("--help"), "{verb}\n{short}");
    }
    assert!(folder.run("stats -h").ok().contains("--ignore-checksum"));
}

#[test]
fn completion_offers_the_methods() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish"] {
        let text = folder.run(&format!("completions {shell}")).ok();
        for method in ["normals", "heights", "measured-ray", "measured-wave", "measured-hybrid"] {
            assert!(text.contains(method), "{shell}: {method} is missing");
        }
    }
    let unknown = folder.run("fit scan.csv --method phong").with_code(2);
    assert!(
        unknown.err.contains("method `phong` is unknown; the methods are ggx"),
        "{}",
        unknown.err
    );
}

#[test]
fn names_of_earlier_versions_still_work() {
    let folder = folder();
    folder.run("model normals --law cauchy --set delta=4 n=2 --ior 1.5 -o n.json").ok();
    folder.run("model normals --profile cauchy --set delta=4 n=2 --ior 1.5 -o p.json").ok();
    assert_eq!(folder.text("n.json"), folder.text("p.json"));
    let scan = "scan --map map.xyz --edges periodic --ior 1.5 --rays 4000 --sigma 0 --step 10 --aperture 5";
    let (old, new) =
        (folder.run(&format!("{scan} --method ray")), folder.run(&format!("{scan} --engine ray")));
    assert_eq!(old.ok(), new.ok());
    folder.write("s.toml", "sigma_deg = [0]\n");
    let old = folder.run("acquire --dry-run --plan s.toml").ok();
    assert_eq!(old, folder.run("acquire --dry-run --schedule s.toml").ok());
}

#[test]
fn eval_takes_angles() {
    let folder = folder();
    let (c, s) = (0.75_f64.sqrt(), 0.5);
    let pair = format!("wix,wiy,wiz,wox,woy,woz\n{s},0,{c},0,{s},{c}\n");
    let vectors = folder.pipe("eval m.json", pair.as_bytes()).ok();
    let angles = folder.pipe("eval m.json", b"theta_i,phi_i,theta_o,phi_o\n30,0,30,90\n").ok();
    assert!(angles.starts_with("theta_i,phi_i,theta_o,phi_o,f,ars,pdf\n30,0,30,90,"), "{angles}");
    let value = |text: &str| -> f64 {
        let row = text.lines().nth(1).unwrap();
        row.rsplit(',').nth(2).unwrap().parse().unwrap()
    };
    assert!((value(&vectors) / value(&angles) - 1.0).abs() < 1e-12, "{vectors}{angles}");
}

#[test]
fn the_user_says_how_much_is_said() {
    let folder = folder();
    let scan = "scan --map map.xyz --edges periodic --ior 1.5 --rays 4000 --sigma 0 --step 10 --aperture 5 -o o.csv";
    let said = |flags: &str| folder.run(&format!("{flags} {scan}")).with_code(0).err;
    let (usual, quiet, verbose) = (said(""), said("--quiet"), said("-v"));
    assert!(usual.contains("points of"), "{usual}");
    assert!(quiet.is_empty(), "{quiet}");
    assert!(verbose.starts_with(&usual) && verbose.contains(" s\n"), "{verbose}");
    // errors are said in any case
    let wrong = folder.run("--quiet scan no.json").with_code(2);
    assert!(wrong.err.starts_with("error: no.json"), "{}", wrong.err);
}
