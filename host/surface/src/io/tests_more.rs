//! Files of many instruments, against the figures of `SurfaceTopography` 1.27.1 beside them.

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg32;

use super::{OpenOptions, RawMap, parse};

/// Agreement of figures.
const SAME: f64 = 1e-5;

/// A file of the data, and its figures.
fn shared(name: &str) -> Option<(Vec<u8>, serde_json::Value)> {
    let path = asperity_needs::data(&format!("topography/more/{name}"))?;
    let json = std::fs::read(path.with_file_name(format!("{name}.json"))).unwrap();
    Some((std::fs::read(path).unwrap(), serde_json::from_slice(&json).unwrap()))
}

/// Root mean square of the heights over their mean, um, and their skewness.
fn moments(map: &RawMap) -> (f64, f64) {
    let known: Vec<f64> = map.heights_um.iter().copied().filter(|z| z.is_finite()).collect();
    let mean =
        |f: &dyn Fn(f64) -> f64| known.iter().map(|z| f(*z)).sum::<f64>() / known.len() as f64;
    let middle = mean(&|z| z);
    let rms = mean(&|z| (z - middle).powi(2)).sqrt();
    (rms, mean(&|z| (z - middle).powi(3)) / rms.powi(3))
}

#[track_caller]
fn check(name: &str, map: &RawMap, figures: &serde_json::Value, lateral: f64) {
    let unit = match figures["unit"].as_str() {
        Some("m") => 1e6,
        Some("mm") => 1e3,
        _ => 1.0,
    };
    let list = |key: &str| -> Vec<f64> {
        figures[key].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
    };
    // columns first
    let sizes = [map.nx as f64 * map.dx_um.unwrap(), map.ny as f64 * map.dy_um.unwrap_or(1.0)];
    let shape = [map.nx as f64, map.ny as f64];
    for (k, (n, size)) in list("shape").into_iter().zip(list("sizes")).enumerate() {
        assert!((shape[k] - n).abs() < 1e-9, "{name}: {shape:?} for {n}");
        let size = size * unit * lateral;
        assert!((sizes[k] / size - 1.0).abs() < SAME, "{name}: {} um for {size} um", sizes[k]);
    }
    let lost = map.heights_um.iter().filter(|z| z.is_nan()).count();
    assert_eq!(figures["missing"].as_u64(), Some(lost as u64), "{name}");
    let extreme = |pick: fn(f64, f64) -> f64| map.heights_um.iter().copied().fold(f64::NAN, pick);
    let (rms, skew) = moments(map);
    // the header of nms says that numbers go to 65535, of which this reader makes 65534
    let same = if name.ends_with("nms") { 1.6 * SAME } else { SAME };
    for (what, read, said) in [
        ("rms", rms, figures["rms_mean_removed"].as_f64().unwrap() * unit),
        ("min", extreme(f64::min), figures["min"].as_f64().unwrap() * unit),
        ("max", extreme(f64::max), figures["max"].as_f64().unwrap() * unit),
        ("skewness", skew, figures["skew"].as_f64().unwrap()),
    ] {
        let all = said.abs().max(if what == "min" { rms } else { 0.0 });
        assert!((read - said).abs() <= same * all, "{name}: {what} {read} for {said}");
    }
}

fn open(bytes: &[u8], channel: Option<usize>) -> RawMap {
    parse(bytes, &OpenOptions { channel, ..OpenOptions::default() }).unwrap()
}

#[test]
fn figures_of_another_reader() {
    for (name, lateral) in [
        ("metropro-1.dat", 1.0),
        ("frt-2.frt", 1.0),
        ("mnt-1.mnt", 1.0),
        ("tmd-1.tmd", 1.0),
        // nanometres taken as millimetres
        ("nms-1.nms", 1e-6),
    ] {
        let Some((bytes, json)) = shared(name) else { return };
        let map = open(&bytes, None);
        check(name, &map, &json["channels"][0], lateral);
        assert!(map.channels.is_empty() && map.into_map(None).is_ok());
    }
}

#[test]
fn channels_of_a_force_microscope() {
    let Some((bytes, json)) = shared("nid-1.nid") else { return };
    let channels = json["channels"].as_array().unwrap();
    for (k, figures) in channels.iter().enumerate() {
        let map = open(&bytes, Some(k));
        check("nid-1.nid", &map, figures, 1.0);
        assert_eq!(map.channels[k], figures["name"].as_str().unwrap());
        assert_eq!(map.channels.len(), channels.len());
    }
    assert_eq!(open(&bytes, None), open(&bytes, Some(0)));
    let beyond = OpenOptions { channel: Some(channels.len()), ..OpenOptions::default() };
    assert!(
        parse(&bytes, &beyond)
            .unwrap_err()
            .to_string()
            .contains("3 `Scan backward (Z-AxisSensor)`")
    );
}

#[test]
fn a_wave_without_units_needs_them() {
    let name = "10x10-one_channel_without_name.ibw";
    let Some((bytes, json)) = shared(name) else { return };
    let fault = parse(&bytes, &OpenOptions::default()).unwrap_err().to_string();
    assert!(fault.contains("give --xy-unit and --z-unit"), "{fault}");
    let um = "um".parse().ok();
    let options = OpenOptions { xy_unit: um, z_unit: um, ..OpenOptions::default() };
    check(name, &parse(&bytes, &options).unwrap(), &json["channels"][0], 1.0);
}

#[test]
fn a_stylus_file_is_a_profile() {
    let Some((bytes, json)) = shared("opdx-3.opdx") else { return };
    let map = open(&bytes, None);
    assert!(
        map.note.as_ref().is_some_and(|note| note.contains("a profile, not a map: 3001 heights"))
    );
    check("opdx-3.opdx", &map, &json["channels"][0], 1.0);
}

#[test]
fn random_damage_of_measured_files_never_panics() {
    let mut random = Pcg32::seed_from_u64(2);
    for name in [
        "metropro-1.dat",
        "frt-2.frt",
        "tmd-1.tmd",
        "nms-1.nms",
        "nid-1.nid",
        "mnt-1.mnt",
        "opdx-3.opdx",
        "10x10-one_channel_without_name.ibw",
    ] {
        let Some((bytes, _)) = shared(name) else { return };
        // half of the damage goes where headers are
        let ends = [bytes.len(), bytes.len().min(5000)];
        for round in 0..30 {
            let mut damaged = bytes.clone();
            for _ in 0..=random.next_u32() % 8 {
                let at = random.next_u32() as usize % ends[round % 2];
                damaged[at] = random.next_u32() as u8;
            }
            if round % 3 == 0 {
                damaged.truncate(random.next_u32() as usize % ends[round / 2 % 2]);
            }
            drop(parse(&damaged, &OpenOptions::default()));
        }
    }
}
