//! `plot`: models, tables, scans with models, and maps as pictures.

use crate::happy::{is_balanced, is_plot};
use crate::map_verbs::waves;
use crate::program::Folder;
use crate::refusal::{case, refused};

fn folder() -> Folder {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o ggx.json").ok();
    folder.run("model normals --set delta=9 --set n=2 --ior 1.49 -o normals.json").ok();
    folder.run("scan ggx.json --sigma 0,30 --step 1 --aperture 1 -o scan.csv").ok();
    folder
}

#[test]
fn laws_are_drawn_from_both_sides_over_each_other() {
    let folder = folder();
    folder.run("plot ggx.json normals.json -o laws").ok();
    is_plot(&folder, "laws.svg");
    let svg = folder.text("laws.svg");
    is_balanced("laws.svg", &svg);
    for word in [
        "from the air, 0°, reflection",
        "from inside, 45°, transmission",
        "BSDF (1/sr)",
        ">ggx<",
        ">normals<",
    ] {
        assert!(svg.contains(word), "{word} is not in the picture");
    }
    folder.run("plot ggx.json --side inside --incidence 0,60 --linear -o inside").ok();
    let svg = folder.text("inside.svg");
    assert!(svg.contains("from inside, 60°, reflection") && !svg.contains("from the air"));
    folder.run("plot ggx.json normals.json --view flux -o flux").ok();
    let svg = folder.text("flux.svg");
    for word in ["from the air, lost", "from inside, transmitted", "share of the light"] {
        assert!(svg.contains(word), "{word} is not in the picture");
    }
    // a table is a law too
    folder.run("tabulate ggx.json --bytes 8192 -o t.bsdft").ok();
    folder.run("plot ggx.json t.bsdft -o table").ok();
    assert!(folder.text("table.svg").contains(">t (ggx)<"));
    assert!(folder.path("table.png").exists());
    // the ending of a picture is no part of the stem
    folder.run("plot ggx.json -o named.png").ok();
    assert!(folder.path("named.png").exists() && !folder.path("named.png.png").exists());
}

#[test]
fn laws_are_drawn_as_polar_diagrams_and_over_the_hemisphere() {
    let folder = folder();
    folder.run("plot ggx.json normals.json --view polar --incidence 30 -o polar").ok();
    is_plot(&folder, "polar.svg");
    let svg = folder.text("polar.svg");
    is_balanced("polar.svg", &svg);
    for word in [
        "from the air, 30°",
        "from inside, 30°",
        ">ggx<",
        ">normals<",
        ">air<",
        ">material<",
        "−60°",
    ] {
        assert!(svg.contains(word), "{word} is not in the picture");
    }
    let line = "plot ggx.json --view hemisphere --incidence 30 --decades 3 -o h";
    folder.run(line).ok();
    let svg = folder.text("h.svg");
    is_balanced("h.svg", &svg);
    // two sides with two lobes each, in two rows with a bar of colours each
    assert_eq!(svg.matches("<image").count(), 4 + 2);
    for word in [
        "from the air, 30°, reflection",
        "from inside, 30°, transmission",
        "BSDF (1/sr)",
        "below scale",
        ">60°<",
    ] {
        assert!(svg.contains(word), "{word} is not in the picture");
    }
    assert!(folder.text("h.svg").len() < 500_000 && folder.path("h.png").exists());
    // beyond the critical angle nothing is transmitted by a flat face, of a rough one some is
    folder.run("plot ggx.json --view hemisphere --incidence 60 --side inside --linear -o i").ok();
    assert_eq!(folder.text("i.svg").matches("from inside, 60°").count(), 2);
}

#[test]
fn the_folder_of_a_sample_stands_for_its_models() {
    let folder = folder();
    folder.run("compare scan.csv --ior 1.49 --rough-side source --methods ggx,beckmann -o r");
    folder.run("plot r/scan --incidence 30 -o both").ok();
    let svg = folder.text("both.svg");
    assert!(svg.contains(">ggx<") && svg.contains(">beckmann<"), "{svg}");
    folder.run("plot scan.csv r/scan --view residuals -o residuals").ok();
    let run = folder.run("plot r -o none").with_code(2);
    assert!(run.err.contains("r/SAMPLE"), "{}", run.err);
}

#[test]
fn readings_are_drawn_with_what_models_give_in_their_place() {
    let folder = folder();
    folder.run("plot scan.csv ggx.json normals.json --title plate-7 -o r").ok();
    let svg = folder.text("r.svg");
    for word in
        ["plate-7", "σ = 30°", "flux into the detector", ">measured<", "ggx (0.0", "normals ("]
    {
        assert!(svg.contains(word), "{word} is not in the picture");
    }
    folder.run("plot scan.csv normals.json --view residuals -o residuals").ok();
    assert!(folder.text("residuals.svg").contains("fitted less measured"));
    folder.run("plot scan.csv normals.json --view quantiles -o quantiles").ok();
    assert!(folder.text("quantiles.svg").contains("normal noise"));
    folder.run("scan ggx.json --sigma 40.1 --step 0.1 --aperture 1 -o fine.csv").ok();
    let fine = folder.text("fine.csv");
    let angles = fine.lines().filter_map(|line| line.strip_prefix("40.1,")?.split(',').next());
    let angles: Vec<&str> = angles.collect();
    // 40.1, not 40.099999999999994
    assert!(angles.len() == 1801 && angles.iter().all(|angle| angle.len() <= 5), "{angles:?}");
    folder.run("plot scan.csv -o alone").ok();
    is_plot(&folder, "alone.svg");
}

#[test]
fn maps_are_drawn_and_what_cannot_be_is_refused() {
    let folder = Folder::new();
    folder.write("map.txt", waves(0.6));
    folder.run("plot map.txt --pixel-um 1 -o m").ok();
    for name in ["m-map.svg", "m-histogram.svg", "m-spectrum.svg"] {
        is_plot(&folder, name);
        assert!(folder.text(name).contains("µm") && !folder.text(name).contains("(um"), "{name}");
        assert!(folder.text(name).contains(">map.txt, Rq "), "{name}");
    }
    let model = crate::refusal::MODEL;
    let with_model = |line: &str, says: &[&'static str]| case(line, says).file("m.json", model);
    refused(vec![
        case("plot -o p", &["FILE"]),
        case("plot none.json -o p", &["none.json"]),
        case("plot scan.csv", &["--output"]),
        with_model("plot m.json scan.csv -o p", &["scan.csv", "one scan and models after it"]),
        with_model("plot m.json --view residuals -o p", &["--view", "needs a scan"]),
        with_model("plot m.json --incidence 90 -o p", &["--incidence 90"]),
        with_model("plot m.json --incidence 0,10,20,30 -o p", &["panels", "--incidence"]),
        with_model("plot m.json --view flux --linear -o p", &["--linear has no effect"]),
        with_model("plot m.json --sigma-range 0:1 -o p", &["--sigma-range has no effect"]),
        case("plot scan.csv --view residuals -o p", &["residuals need a model"]),
        case("plot scan.csv --view flux -o p", &["leave the scan out"]),
        case("plot scan.csv --side air -o p", &["--side has no effect"]),
        case("plot bad.txt -o p", &["as a scan", "as a height map"]).file("bad.txt", "hello"),
    ]);
}

#[test]
fn laws_with_one_name_and_left_models_are_told_apart() {
    let folder = folder();
    folder.run("tabulate ggx.json --bytes 8192 -o ggx.bsdft").ok();
    folder.run("plot ggx.json ggx.bsdft -o two").ok();
    let picture = folder.text("two.svg");
    assert!(picture.contains("ggx.json") && picture.contains("ggx.bsdft"));
    // of a comparison only what its index lists is drawn
    folder.run("scan ggx.json --sigma 0,30 --step 2 --aperture 2 -o s.csv").ok();
    folder.run("compare s.csv --methods ggx -o c").ok();
    std::fs::copy(folder.path("normals.json"), folder.path("c/s/normals.json")).unwrap();
    folder.run("plot c/s --view flux -o c").ok();
    let picture = folder.text("c.svg");
    assert!(picture.contains("ggx") && !picture.contains("normals"));
}
