//! Height maps of many instruments: figures, the maps of a file of several, and broken files.

use crate::program::Folder;
use crate::refusal::faults;

/// Files beside which figures stand, and the flags that they need.
const FILES: [(&str, &str); 9] = [
    ("metropro-1.dat", ""),
    ("frt-2.frt", ""),
    ("tmd-1.tmd", ""),
    ("nms-1.nms", ""),
    ("mnt-1.mnt", ""),
    ("nid-1.nid", ""),
    ("opdx-3.opdx", ""),
    ("nid-1.nid", "--channel 3"),
    ("10x10-one_channel_without_name.ibw", "--xy-unit um --z-unit um"),
];

fn path(name: &str) -> Option<String> {
    asperity_needs::data(&format!("topography/more/{name}")).map(|path| path.display().to_string())
}

#[test]
fn figures_are_those_of_another_reader() {
    let folder = Folder::new();
    for (name, flags) in FILES {
        let Some(path) = path(name) else { return };
        let channel = usize::from(flags.starts_with("--channel")) * 3;
        let figures: serde_json::Value =
            serde_json::from_slice(&std::fs::read(format!("{path}.json")).unwrap()).unwrap();
        let figures = &figures["channels"][channel];
        let unit = match figures["unit"].as_str() {
            Some("m") => 1e6,
            Some("mm") => 1e3,
            _ => 1.0,
        };
        let line = ["stats", &path, "--json", "--form", "mean"];
        let done = folder.run_args(line.into_iter().chain(flags.split_whitespace()));
        let err = done.err.clone();
        let read = done.json()["rq_um"].as_f64().unwrap();
        let said = figures["rms_mean_removed"].as_f64().unwrap() * unit;
        // the numbers of nms go to 65535, of which that reader makes 65534
        assert!((read / said - 1.0).abs() < 2e-5, "{name}: {read} for {said}");
        let profile = err.contains("this is a profile, not a map");
        assert_eq!(profile, name.ends_with("opdx"), "{name}: {err}");
        let several = err.contains("--channel reads another");
        assert_eq!(several, name.ends_with("nid") && flags.is_empty(), "{name}: {err}");
    }
}

#[test]
fn a_map_that_is_not_there_and_light_on_a_profile_are_refused() {
    let folder = Folder::new();
    for (name, line, says) in [
        ("nid-1.nid", "stats --channel 4", "3 `Scan backward (Z-AxisSensor)`"),
        ("tmd-1.tmd", "stats --channel 1", "--channel 1"),
        ("10x10-one_channel_without_name.ibw", "stats", "give --xy-unit and --z-unit"),
        ("opdx-3.opdx", "scan --ior 1.49 --map", "this is a profile, not a map"),
    ] {
        let Some(path) = path(name) else { return };
        let line = line.split_whitespace().chain([path.as_str()]);
        let done = folder.run_args(line).with_code(2);
        assert!(done.err.contains(says), "{name}: {}", done.err);
    }
}

#[test]
fn files_that_end_early_are_refused() {
    let folder = Folder::new();
    for (name, flags) in FILES {
        let Some(path) = path(name) else { return };
        let bytes = std::fs::read(path).unwrap();
        // the first channel of the largest file ends at a quarter of it
        for percent in [2, 5, 8, 11, 14] {
            folder.write(name, &bytes[..bytes.len() * percent / 100]);
            let line = ["stats", name].into_iter().chain(flags.split_whitespace());
            let found = faults(&folder.run_args(line), &[name]);
            assert!(found.is_empty(), "{name} {percent} %: {found:?}");
        }
    }
}
