//! `render`: a scene with models, in images and numbers.

use serde_json::Value;

use crate::program::Folder;

/// Three models: closed forms with one bounce and with all, and a traced map.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o one.json").ok();
    folder.run("model ggx-ms --set alpha=0.2 --ior 1.49 -o all.json").ok();
    folder.run("model heights --set delta=1.5 --ior 1.49 -o map.json").ok();
    folder
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// A body of a model in the numbers.
fn body<'a>(numbers: &'a Value, model: &str, name: &str) -> &'a Value {
    let models = numbers["models"].as_array().unwrap();
    let bodies = models.iter().find(|m| m["model"] == model).unwrap()["bodies"].as_array().unwrap();
    bodies.iter().find(|b| b["body"] == name).unwrap()
}

#[test]
fn models_are_seen_side_by_side() {
    let folder = folder();
    let line = "render one.json all.json map.json --reference all --size 64x48 --paths 32 -o booth";
    let first = folder.run(&format!("{line} --json")).json();
    for name in ["one", "all", "map"] {
        assert!(folder.bytes(&format!("booth/{name}.png")).starts_with(b"\x89PNG"));
        assert!(folder.bytes(&format!("booth/{name}.exr")).starts_with(&[0x76, 0x2f, 0x31, 0x01]));
        let sphere = body(&first, name, "sphere");
        let mean = number(&sphere["mean"]);
        assert!((0.15..0.3).contains(&mean), "{name}: {mean}");
    }
    for sheet in ["sheet.png", "differences.png"] {
        assert!(folder.bytes(&format!("booth/{sheet}")).starts_with(b"\x89PNG"));
    }
    // what single bounces lose is missing at the limb; the reference has no difference from itself
    let lost = number(&body(&first, "one", "sphere")["difference"]["mean_percent"]);
    assert!(lost < -5.0, "{lost}");
    assert!(body(&first, "all", "sphere")["difference"].is_null());
    // the same again: everything is taken as it is
    let tiles = folder.bytes("booth/one.tiles");
    assert_eq!(folder.run(&format!("{line} --json")).json(), first);
    assert!(folder.bytes("booth/one.tiles") == tiles);
    // more paths go on from there, and other images are refused
    folder.run(&line.replace("--paths 32", "--paths 48")).ok();
    assert!(folder.bytes("booth/one.tiles") != tiles);
    let other = folder.run(&line.replace("64x48", "48x64")).with_code(2);
    assert!(other.err.contains("another scene, other models"), "{}", other.err);
}

/// A sphere in uniform light cannot be told from its surroundings if its surface loses nothing.
#[test]
fn all_bounces_lose_no_light() {
    let folder = Folder::new();
    for (line, most) in [
        ("ggx-ms --set alpha=0.2", 2e-3),
        ("ggx-ms --set alpha=0.5", 2e-3),
        ("ggx --set alpha=0.5 --bounces walk", 2e-3),
        ("heights --set delta=1.5", 2e-3),
    ] {
        folder.run(&format!("model {line} --ior 1.49 -o m.json")).ok();
        let line = "render m.json --scene furnace --size 60x60 --paths 32 -o furnace.png --json";
        let numbers = folder.run(line).json();
        let sphere = body(&numbers, "m", "sphere");
        let (mean, error) = (number(&sphere["mean"]), number(&sphere["se"]));
        assert!((mean - 1.0).abs() < most + 4.0 * error, "{line}: {mean} +- {error}");
    }
}

#[test]
fn shares_of_the_tiles_are_put_together() {
    let folder = folder();
    let line = "render one.json --size 70x50 --paths 16";
    folder.run(&format!("{line} -o whole")).ok();
    folder.run(&format!("{line} -o whole.png")).ok();
    assert!(folder.bytes("whole/one.png") == folder.bytes("whole.png"));
    for of in [1, 2, 7] {
        let make = |part: usize| {
            folder.run(&format!("{line} --shard {part}/{of} -o p{of}-{part}")).ok();
            format!("p{of}-{part}")
        };
        let parts = (1..=of).rev().map(make).collect::<Vec<_>>().join(" ");
        folder.run(&format!("merge {parts} -o m{of}")).ok();
        folder.run(&format!("{line} -o m{of}")).ok();
        for name in ["one.tiles", "one.png", "one.exr", "render.json", "numbers.json"] {
            let [a, b] = ["whole".to_owned(), format!("m{of}")]
                .map(|f| folder.bytes(&format!("{f}/{name}")));
            assert!(a == b, "{name} of {of} parts differs");
        }
    }
    folder.run(&format!("{line} --seed 2 --shard 2/2 -o seed")).ok();
    folder.run("render one.json --size 70x50 --paths 32 --shard 2/2 -o paths").ok();
    for (parts, said) in [
        ("p2-1", "parts are missing: 2/2"),
        ("p2-1 p2-1", "are both part 1/2"),
        ("p2-1 p7-2", "different numbers of parts"),
        ("p2-1 seed", "different images"),
        ("p2-1 paths", "different --paths"),
        ("p2-1 whole", "is no part"),
    ] {
        let run = folder.run(&format!("merge {parts} -o wrong")).with_code(2);
        assert!(run.err.contains(said), "{parts}: {}", run.err);
    }
    folder.run(&format!("{line} --shard 1/2 -o part.png")).with_code(2);
}

#[test]
fn regions_are_known_to_a_fifth_of_a_percent() {
    let folder = folder();
    folder.write(
        "r.csv",
        "# of the image\nregion,x0,y0,x1,y1\nwall,150,40,170,60\nsphere,130,105,190,165\n",
    );
    let found = folder.run("render --model one.json --regions r.csv --json").json();
    let regions = found["regions"].as_array().unwrap();
    for (region, name, wanted) in
        [(&regions[0], "wall", 0.259_027), (&regions[1], "sphere", 0.211_185)]
    {
        let (mean, error) = (number(&region["mean"]), number(&region["se"]));
        assert_eq!(region["region"], name);
        assert!(error <= 0.002 * mean, "{region}");
        assert!((mean / wanted - 1.0).abs() < 0.01, "{region}");
    }
    for (text, said) in [
        ("region,x0,y0,x1\na,1,1,2\n", "the column y1 is missing"),
        ("region,x0,y0,x1,y1\na,1,1,b,2\n", "r.csv:2"),
        ("region,x0,y0,x1,y1\na,1,1,400,2\n", "x0 < x1 <= 320"),
        ("region,x0,y0,x1,y1\n", "no region"),
    ] {
        folder.write("r.csv", text);
        let run = folder.run("render one.json --regions r.csv").with_code(2);
        assert!(run.err.contains(said), "{text}: {}", run.err);
    }
}

#[test]
fn scenes_with_faults_are_refused_with_their_line() {
    let folder = folder();
    let booth = folder.run("render --scene-example booth").ok();
    for (from, to, said) in [
        ("reflectance = 0.45", "reflectance = 1.45", "reflectance is 0 to 1"),
        ("radius = 0.06", "radius = -0.06", "a sphere needs"),
        ("tube = 0.022", "tube = 0.22", "0 < tube < ring"),
        ("material = \"wall\"", "material = \"wal\"", "there is no material wal"),
        ("ior = 1.49", "ior = 0", "ior is 0.1 to 10"),
        ("field_deg = 36", "field_deg = 200", "field_deg"),
        ("up = [0, 0, 1]", "up = [0, 0]", "array"),
        ("shape = \"torus\"", "shape = \"donut\"", "donut"),
        ("closed = false", "is_closed = false", "is_closed"),
        ("to = [-0.12, 0.285, 0.145]", "to = [-0.30, 0.285, 0.145]", "a box needs the corners"),
        ("pixels = [320, 240]", "pixels = [0, 240]", "pixels 1 to 16384"),
        ("kind = \"model\"", "kind = \"paint\"", "paint"),
        ("radiance = 10", "radiance = -1", "radiance is a finite number"),
        ("open = [\"front\"]", "open = [\"nowhere\"]", "nowhere"),
    ] {
        assert!(booth.contains(from), "{from}");
        folder.write("s.toml", booth.replacen(from, to, 1));
        let run = folder.run("render one.json --scene s.toml -o x.png").with_code(2);
        let line = run.err.split("s.toml:").nth(1).and_then(|rest| rest.split(':').next());
        let line = line.and_then(|line| line.parse::<usize>().ok());
        assert!(line.is_some_and(|line| line > 0) && run.err.contains(said), "{to}: {}", run.err);
    }
    folder.run("render one.json -o no/such/folder.png").with_code(2);
    folder.run("render one.json").with_code(2);
    folder.run("render -o x.png").with_code(2);
    folder.run("render one.json --scene nowhere.toml -o x.png").with_code(2);
    folder.run("render one.json all.json -o x.png").with_code(2);
    folder.run("render one.json --reference two --size 8x8 -o x").with_code(2);
}

#[test]
fn a_comparison_shows_its_methods_in_the_booth() {
    let folder = folder();
    folder.run("scan one.json --sigma 0,30 --step 4 --aperture 4 -o s.csv").ok();
    let line = "compare s.csv --methods ggx,beckmann --render --no-timing -o c";
    folder.run(line).with_code(0);
    for name in ["ggx.png", "beckmann.exr", "sheet.png", "differences.png", "numbers.json"] {
        assert!(!folder.bytes(&format!("c/s/booth/{name}")).is_empty());
    }
    assert!(folder.text("c/report.html").contains("rendered with each method"));
    // with one method more the images are made anew
    folder.run(&line.replace("beckmann", "beckmann,student")).with_code(0);
    assert!(!folder.bytes("c/s/booth/student.png").is_empty());
}

#[test]
fn the_scene_goes_to_other_renderers() {
    let folder = folder();
    folder.run("render one.json --export mitsuba -o mitsuba").ok();
    let xml = folder.text("mitsuba/scene.xml");
    assert!(
        xml.contains("roughdielectric") && xml.contains("name=\"alpha\" value=\"0.2\""),
        "{xml}"
    );
    assert!(folder.text("mitsuba/torus.ply").starts_with("ply\n"));
    folder.run("render one.json --export pbrt -o pbrt").ok();
    let pbrt = folder.text("pbrt/scene.pbrt");
    assert!(pbrt.contains("\"float roughness\" [0.2]"), "{pbrt}");
    let left_out = folder.run("render map.json --export mitsuba -o other").with_code(0);
    assert!(left_out.err.contains("smooth glass"), "{}", left_out.err);
}
