//! `plan`: scenes are read or refused, the impossible is told, and other verbs do what a plan says.

use crate::program::Folder;
use crate::refusal::{Case, case, refused};

const PLATE: &str = "[body]
kind = \"plate\"
ior = 1.52
rough = \"detector\"
[surface]
rq_um = 1.2
correlation_um = 15
[source]
kind = \"collimated\"
incidence_deg = [0, 20]
[wanted]
quantity = \"haze\"
error_percent = 2
[target]
kind = \"host\"
";

/// The plate with one place changed: refused with the line and the remedy.
#[track_caller]
fn scene(from: &str, to: &str, says: &[&'static str]) -> Case {
    assert!(PLATE.contains(from), "`{from}` is not there");
    case("plan bad.toml", says).file("bad.toml", PLATE.replacen(from, to, 1))
}

#[test]
fn malformed_scenes_are_refused_with_line_and_remedy() {
    let guide = "kind = \"light-guide\"\nthickness_mm = 3\nlength_mm = 60";
    refused(vec![
        scene("ior = 1.52", "ior = ", &["bad.toml:3", "--example"]),
        scene("ior = 1.52", "ior = \"glass\"", &["bad.toml:3", "--example"]),
        scene("ior = 1.52", "ior = 1.52\nior = 1.5", &["bad.toml:4", "--example"]),
        scene("ior = 1.52", "index = 1.52", &["bad.toml:3", "unknown field", "--example"]),
        scene("ior = 1.52", "ior = 0.9", &["bad.toml:3", "give 1.01 to 5"]),
        scene("ior = 1.52", "ior = nan", &["bad.toml:3", "give 1.01 to 5"]),
        scene("ior = 1.52\n", "", &["bad.toml:1", "ior is missing; add it"]),
        scene("\"plate\"", "\"cube\"", &["bad.toml:2", "give one of film, plate, light-guide"]),
        scene("\"detector\"", "\"left\"", &["bad.toml:4", "give one of source, detector"]),
        scene("rough = \"detector\"\n", "", &["bad.toml:1", "rough is missing"]),
        scene(
            "ior = 1.52",
            "ior = 1.52\nbehind = \"white\"",
            &["bad.toml:4", "give one of air, black"],
        ),
        scene("ior = 1.52", "ior = 1.52\nbehind = \"black\"", &["bad.toml:5", "write rough"]),
        scene("ior = 1.52", "ior = 1.52\nthickness_mm = 3", &["bad.toml:4", "leave it out"]),
        scene("ior = 1.52", "ior = 1.52\nabbe = 1", &["bad.toml:4", "give 5 to 200"]),
        scene(
            "ior = 1.52",
            "ior = 1.52\nabbe = 50",
            &["bad.toml:9", "wavelength_nm is missing", "add it"],
        ),
        scene("kind = \"plate\"", guide, &["bad.toml:6", "give one of top, bottom"]),
        scene(
            "kind = \"plate\"\nior = 1.52\nrough = \"detector\"",
            "kind = \"light-guide\"\nior = 1.5\nrough = \"top\"",
            &["bad.toml:1", "thickness_mm is missing"],
        ),
        scene(
            "kind = \"plate\"\nior = 1.52\nrough = \"detector\"",
            "kind = \"object\"\nior = 1.5\nrough = \"source\"",
            &["bad.toml:4", "leave it out"],
        ),
        scene("rq_um = 1.2", "rq_um = -1", &["bad.toml:6", "give 0.000001 to 10000"]),
        scene("correlation_um = 15\n", "", &["bad.toml:5", "give rq_um and correlation_um"]),
        scene(
            "correlation_um = 15",
            "correlation_um = 15\nalpha = 0.4",
            &["bad.toml:5", "keep one"],
        ),
        scene(
            "correlation_um = 15",
            "correlation_um = 15\nstatistics = \"fractal\"",
            &["bad.toml:8", "give one of gaussian, ggx"],
        ),
        scene(
            "rq_um = 1.2",
            "map = \"none.npy\"\nrq_um = 1.2",
            &["bad.toml:7", "the map tells it"],
        ),
        scene(
            "rq_um = 1.2\ncorrelation_um = 15",
            "map = \"none.npy\"",
            &["bad.toml:6", "is no file; give a path relative"],
        ),
        scene(
            "rq_um = 1.2\ncorrelation_um = 15",
            "model = \"none.json\"",
            &["bad.toml:6", "is no file; give a path relative"],
        ),
        scene(
            "correlation_um = 15",
            "correlation_um = 15\npixel_um = 1",
            &["bad.toml:8", "there is no map; leave it out"],
        ),
    ]);
}

#[test]
fn malformed_light_and_wishes_are_refused_with_line_and_remedy() {
    refused(vec![
        scene("\"collimated\"", "\"sun\"", &["bad.toml:9", "give one of collimated, lambertian"]),
        scene("[0, 20]", "[20, 0]", &["bad.toml:10", "give the smaller number first"]),
        scene("[0, 20]", "90", &["bad.toml:10", "give 0 to 89"]),
        scene("[0, 20]", "[0, 1, 2]", &["bad.toml:10", "give a number, or two"]),
        scene("incidence_deg = [0, 20]\n", "", &["bad.toml:8", "incidence_deg is missing; add it"]),
        scene("\"collimated\"", "\"lambertian\"", &["bad.toml:10", "leave it out"]),
        scene("\"collimated\"", "\"led\"", &["bad.toml:8", "half_angle_deg is missing"]),
        scene(
            "\"collimated\"",
            "\"laser\"\nwavelength_nm = [400, 700]",
            &["bad.toml:10", "give one, or write lamp"],
        ),
        scene(
            "\"collimated\"",
            "\"collimated\"\nwavelength_nm = 0.55",
            &["bad.toml:10", "give 150 to 20000"],
        ),
        scene("\"haze\"", "\"glow\"", &["bad.toml:12", "give one of flux, haze"]),
        scene("\"haze\"", "\"flux\"", &["bad.toml:11", "face is missing; write face"]),
        scene(
            "\"haze\"",
            "\"glare\"\nface = \"reflected\"",
            &["bad.toml:11", "theta_deg is missing"],
        ),
        scene(
            "\"haze\"",
            "\"glare\"\nface = \"reflected\"\ntheta_deg = 80\nhalf_angle_deg = 20",
            &["bad.toml:15", "give a smaller half_angle_deg"],
        ),
        scene("error_percent = 2", "error_percent = 0", &["bad.toml:13", "give 0.000001 to 50"]),
        scene("error_percent = 2\n", "", &["bad.toml:11", "error_percent is missing"]),
        scene(
            "kind = \"host\"",
            "kind = \"phone\"",
            &["bad.toml:15", "give one of host, cortex-m4f"],
        ),
        scene("kind = \"host\"", "kind = \"cortex-m4f\"", &["bad.toml:14", "kib is missing"]),
        scene("kind = \"host\"", "kind = \"host\"\nkib = 4", &["bad.toml:16", "leave it out"]),
        scene("[target]\nkind = \"host\"\n", "", &["bad.toml:13", "there is no [target]; add it"]),
        scene("[wanted]", "[wished]", &["bad.toml:11", "--example"]),
        case("plan none.toml", &["none.toml", "check the path"]),
        case("plan --example lamp", &["give one of light-guide"]),
    ]);
}

#[test]
fn incidences_from_a_file_have_lines_too() {
    let text = PLATE.replacen(
        "\"collimated\"\nincidence_deg = [0, 20]",
        "\"rays\"\nfile = \"rays.csv\"",
        1,
    );
    let with = |rays: &str, says: &[&'static str]| {
        case("plan bad.toml", says).file("bad.toml", &text).file("rays.csv", rays)
    };
    refused(vec![
        with("0,1\n95,1\n", &["rays.csv:2", "write degrees from 0 to below 90"]),
        with("0,1\n10,-1\n", &["rays.csv:2", "a weight of at least 0"]),
        with("# none\n", &["rays.csv:1", "give at least one incidence"]),
    ]);
}

#[test]
fn a_plan_is_the_same_each_time_and_verbs_do_what_it_says() {
    let folder = Folder::new();
    let device = PLATE
        .replace("rough = \"detector\"", "rough = \"source\"")
        .replace("\"haze\"", "\"flux\"\nface = \"transmitted\"")
        .replace("\"host\"", "\"cortex-m4f\"\nkib = 24\ninstructions = 400");
    folder.write("scene.toml", device);
    let first = folder.run("plan scene.toml -o plan.json --report plan.html").ok();
    let page = folder.text("plan.html");
    crate::happy::is_balanced("plan.html", &page);
    let plan = folder.json("plan.json");
    for branch in ["choices", "left_out"].iter().flat_map(|k| plan[k].as_array().unwrap()) {
        let what = branch["what"].as_str().unwrap().replace('<', "&lt;").replace('>', "&gt;");
        assert!(page.contains(&what), "{what} is not in the page");
    }
    assert!(first.contains("left out") && first.contains("predicted"), "{first}");
    let plan = folder.text("plan.json");
    folder.run("plan scene.toml -o again.json").ok();
    assert_eq!(plan, folder.text("again.json"));
    folder.run("model beckmann --set alpha=0.16 --ior 1.52 -o m.json").ok();
    let table = folder.run("tabulate m.json --plan plan.json -o t.bsdft --json").json();
    let planned: serde_json::Value = serde_json::from_str(&plan).unwrap();
    let (bytes, most) =
        (table["bytes"].as_u64().unwrap(), planned["table_bytes"].as_u64().unwrap());
    assert!(bytes <= most && 2 * bytes > most, "{bytes} of {most}");
    let lobes = table["lobes"].as_array().unwrap().len();
    assert_eq!(lobes, planned["lobes"].as_array().unwrap().len());
    // what contradicts the plan is refused, other flags win
    let refusal =
        folder.run("tabulate m.json --plan plan.json --side air -o t2.bsdft").with_code(2).err;
    assert!(refusal.contains("contradicts --plan"), "{refusal}");
    let own =
        folder.run("tabulate m.json --plan plan.json --bytes 16384 -o t2.bsdft --json").json();
    assert!(own["bytes"].as_u64().unwrap() > most);
    let refusal = folder.run("export m.json --plan plan.json -o e.bsdf").with_code(2).err;
    assert!(refusal.contains("the plan has no export"), "{refusal}");
    // a schedule is told from a plan by its content
    let dry = folder.run("acquire --plan plan.json --dry-run --json").json();
    assert_eq!(dry["points"], planned["measure"]["points"]);
    // the planned measurement, the planned fit
    let draft = &planned["measure"]["schedule"];
    let list = |value: &serde_json::Value| {
        value.as_array().unwrap().iter().map(ToString::to_string).collect::<Vec<_>>().join(",")
    };
    let line = format!(
        "scan m.json --sigma {} --theta-range={}:{} --step {} -o scan.csv",
        list(&draft["sigma_deg"]),
        draft["theta_from_deg"],
        draft["theta_to_deg"],
        draft["theta_step_deg"]
    );
    folder.run(&line).ok();
    let fit = folder.run("fit scan.csv --plan plan.json --json").json();
    assert_eq!(fit["method"], "beckmann");
    assert!((fit["parameters"]["alpha"]["value"].as_f64().unwrap() - 0.16).abs() < 1e-3, "{fit}");
    folder.run("compare scan.csv --plan plan.json -o all").ok();
    let found = folder.text("all/compare.json");
    assert!(found.contains("beckmann") && !found.contains("measured-ray"), "{found}");
}

#[test]
fn an_export_is_as_planned() {
    let folder = Folder::new();
    folder.write("scene.toml", PLATE.replace("\"host\"", "\"zemax\""));
    folder.run("plan scene.toml -o plan.json").ok();
    let plan = folder.json("plan.json");
    folder.run("model beckmann --set alpha=0.16 --ior 1.52 -o m.json").ok();
    assert_eq!(plan["lobes"], serde_json::json!(["inside T"]));
    let line = "export m.json --plan plan.json --accept -o e.bsdf --json";
    let made = folder.run(line).json();
    assert_eq!(
        (&made["format"], &made["side"], &made["lobe"]),
        (&"zemax".into(), &"dielectric".into(), &"transmission".into()),
        "{made}"
    );
    let refusal = folder
        .run("export m.json --plan plan.json --side air --lobe reflection -o f.bsdf")
        .with_code(2)
        .err;
    assert!(refusal.contains("which the plan leaves out"), "{refusal}");
}

#[test]
fn the_impossible_is_told_with_the_nearest() {
    let folder = Folder::new();
    let device = |kib: u32, percent: f64| {
        PLATE
            .replace("error_percent = 2", &format!("error_percent = {percent}"))
            .replace("\"host\"", &format!("\"cortex-m4f\"\nkib = {kib}\ninstructions = 400"))
    };
    folder.write("scene.toml", device(2, 0.01));
    let message = folder.run("plan scene.toml").with_code(1).err;
    assert!(
        message.contains("the nearest that is possible") && message.contains("In the way"),
        "{message}"
    );
    // waves on a map whose pixels cannot hold them: smooth enough to keep its phase, 2 um a pixel
    let heights: Vec<f64> = (0..128 * 128)
        .map(|k| {
            let (x, y) = (f64::from(k % 128), f64::from(k / 128));
            0.03 * ((0.37 * x + 0.11 * y).sin()
                + (0.23 * y - 0.31 * x).cos()
                + (0.71 * x).sin() * (0.53 * y).cos())
        })
        .collect();
    folder.write("map.npy", npy(128, &heights));
    let waves = PLATE
        .replace("rq_um = 1.2\ncorrelation_um = 15", "map = \"map.npy\"\npixel_um = 2")
        .replace(
            "\"collimated\"\nincidence_deg = [0, 20]",
            "\"laser\"\nincidence_deg = 0\nwavelength_nm = 550",
        );
    folder.write("waves.toml", waves);
    let message = folder.run("plan waves.toml").with_code(1).err;
    assert!(message.contains("pixels of 2 um") && message.contains("0.28 um or less"), "{message}");
}

/// A square array of doubles in numpy's format.
fn npy(side: usize, values: &[f64]) -> Vec<u8> {
    let mut header =
        format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({side}, {side}), }}");
    while (header.len() + 11) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes());
    for v in values {
        bytes.extend(v.to_le_bytes());
    }
    bytes
}
