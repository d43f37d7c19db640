//! Files of real instruments, against figures that two independent readers agreed on.

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg32;

use super::{MapFault, OpenOptions, RawMap, al3d, di, opd, sdf, x3p};

type Read = fn(&[u8]) -> Result<RawMap, MapFault>;
type Detect = fn(&[u8]) -> bool;

const READERS: [(Detect, Read); 5] = [
    (al3d::detect, al3d::read),
    (di::detect, |bytes| di::read(bytes, &OpenOptions::default())),
    (opd::detect, opd::read),
    (sdf::detect, sdf::read),
    (x3p::detect, |bytes| x3p::read(bytes, false)),
];

/// A file of the measured surfaces.
fn shared(name: &str) -> Option<Vec<u8>> {
    asperity_needs::data(&format!("topography/{name}")).map(|path| std::fs::read(path).unwrap())
}

/// Reads a file with the one reader that knows it.
fn map(bytes: &[u8]) -> Result<RawMap, MapFault> {
    let mut readers = READERS.iter().filter(|(detect, _)| detect(bytes));
    let (_, read) = readers.next().expect("a reader");
    assert!(readers.next().is_none());
    read(bytes)
}

/// Root mean square of the heights over their least-squares plane, um.
fn rq_um(map: &RawMap) -> f64 {
    let known = || map.heights_um.iter().enumerate().filter(|(_, z)| !z.is_nan());
    let place = |k: usize| [1.0, (k % map.nx) as f64, (k / map.nx) as f64];
    let mut rows = [[0.0; 4]; 3];
    for (k, z) in known() {
        let v = place(k);
        for (row, a) in rows.iter_mut().zip(v) {
            for (sum, b) in row.iter_mut().zip([v[0], v[1], v[2], *z]) {
                *sum += a * b;
            }
        }
    }
    for k in 0..3 {
        let pivot = rows[k];
        for (_, row) in rows.iter_mut().enumerate().filter(|(j, _)| *j != k) {
            let factor = row[k] / pivot[k];
            row.iter_mut().zip(pivot).for_each(|(x, p)| *x -= factor * p);
        }
    }
    let plane = [0, 1, 2].map(|k| rows[k][3] / rows[k][k]);
    let squares = known().map(|(k, z)| {
        let v = place(k);
        (z - plane[0] * v[0] - plane[1] * v[1] - plane[2] * v[2]).powi(2)
    });
    (squares.sum::<f64>() / known().count() as f64).sqrt()
}

#[test]
fn figures_of_measured_surfaces() {
    for (name, instrument) in [
        ("SurfaceTopography/al3d-1.al3d", Some("Alicona, MeasureSuite 5.3.6")),
        ("SurfaceTopography/opd-1.opd", None),
        ("SurfaceTopography/di-3.di", Some("Dimension Icon")),
        ("x3ptools/sample-land.x3p", Some("Sensofar Sneox1")),
        ("OpenFMC-x3p/KautschukInfiniteFocus.x3p", Some("Alicona Imaging GmbH OpenGPS Export")),
    ] {
        let (Some(bytes), Some(json)) = (shared(name), shared(&format!("{name}.json"))) else {
            return;
        };
        let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
        let map = map(&bytes).unwrap();
        assert_eq!(json["shape"], serde_json::json!([map.ny, map.nx]), "{name}");
        assert_eq!(map.instrument.as_deref(), instrument);
        let lost = map.heights_um.iter().filter(|z| z.is_nan()).count();
        let lost = lost as f64 / map.heights_um.len() as f64;
        for (what, read, agreed) in [
            ("dx", map.dx_um.unwrap(), &json["pixel_um"]["dx"]),
            ("dy", map.dy_um.unwrap(), &json["pixel_um"]["dy"]),
            ("Rq", rq_um(&map), &json["statistics"]["Sq_um_plane"]),
            ("missing", lost, &json["statistics"]["missing_fraction"]),
        ] {
            let agreed = agreed.as_f64().unwrap();
            assert!((read - agreed).abs() <= 1e-4 * agreed, "{name}: {what} {read} for {agreed}");
        }
        assert!(map.into_map(None).is_ok());
    }
}

#[test]
fn heights_of_measured_surfaces() {
    for name in ["SurfaceTopography/al3d-1.al3d", "SurfaceTopography/di-3.di"] {
        let (Some(bytes), Some(npy)) = (shared(name), shared(&format!("{name}.npy"))) else {
            return;
        };
        let map = map(&bytes).unwrap();
        let header = 10 + usize::from(u16::from_le_bytes([npy[8], npy[9]]));
        let agreed = npy[header..].as_chunks().0.iter().map(|z| f64::from_le_bytes(*z));
        assert_eq!(agreed.len(), map.heights_um.len());
        for (k, (read, agreed)) in map.heights_um.iter().zip(agreed).enumerate() {
            assert!((read - agreed).abs() <= 1e-9 * agreed.abs(), "{name} {k}: {read} {agreed}");
        }
    }
}

/// The ISO's samples are one surface of 4 x 4 points, stored in six ways.
#[test]
fn reference_files_of_the_iso() {
    let z = [
        [0.486219, 0.00346341, -0.808369, -0.579793],
        [0.857622, 1.04760, 1.01879, f64::NAN],
        [0.823684, 0.797872, -0.557459, -0.233248],
        [0.675397, 0.420738, 0.642069, -0.215697],
    ];
    let mm16 = 16016.0;
    for (name, pixel_um, tolerance_um) in [
        ("1", [mm16, mm16], 10.0),
        ("1_bin", [mm16, mm16], 10.0),
        ("2", [1.0, 1.0], 10.0),
        ("3", [mm16, 2e6], 10.0),
        ("4", [mm16, mm16], 510.0),
        ("4_bin", [mm16, mm16], 510.0),
    ] {
        let Some(bytes) = shared(&format!("OpenFMC-x3p/ISO5436-sample{name}.x3p")) else {
            return;
        };
        let map = map(&bytes).unwrap();
        assert_eq!((map.nx, map.ny), (4, 4), "{name}");
        for (read, put) in [map.dx_um, map.dy_um].iter().zip(pixel_um) {
            assert!((read.unwrap() / put - 1.0).abs() < 1e-9, "{name}: {read:?} {put}");
        }
        // samples 2 and 3 lift the map by 2 m; sample 2 has a number in place of the hole
        let lift = if matches!(name, "2" | "3") { 2e6 } else { 0.0 };
        for (read, put) in map.heights_um.iter().zip(z.as_flattened()) {
            let put = if put.is_nan() && name == "2" { 0.00346341 } else { *put };
            let same = (read - lift - 1e6 * put).abs() < tolerance_um;
            assert!(same || (read.is_nan() && put.is_nan()), "{name}: {read} {put}");
        }
    }
}

#[test]
fn small_files_of_x3ptools() {
    for (name, shape, pixel_um) in
        [("pyramid", (5, 5), 1e6), ("testing", (30, 20), 0.0274999996026357e6)]
    {
        let Some(bytes) = shared(&format!("x3ptools/{name}.x3p")) else { return };
        let map = map(&bytes).unwrap();
        assert_eq!((map.nx, map.ny), shape);
        assert!((map.dx_um.unwrap() / pixel_um - 1.0).abs() < 1e-9);
        assert!(map.heights_um.iter().any(|z| z.is_finite()));
    }
}

#[test]
fn random_damage_of_measured_files_never_panics() {
    let mut random = Pcg32::seed_from_u64(1);
    for name in [
        "SurfaceTopography/al3d-1.al3d",
        "SurfaceTopography/opd-1.opd",
        "SurfaceTopography/di-3.di",
        "OpenFMC-x3p/ISO5436-sample4_bin.x3p",
        "x3ptools/testing.x3p",
        "x3ptools/sample-land.x3p",
    ] {
        let Some(bytes) = shared(name) else { return };
        // half of the damage goes where headers are
        let ends = [bytes.len(), bytes.len().min(25_000)];
        for round in 0..300 {
            let mut damaged = bytes.clone();
            for _ in 0..=random.next_u32() % 8 {
                let at = random.next_u32() as usize % ends[round % 2];
                damaged[at] = random.next_u32() as u8;
            }
            if round % 3 == 0 {
                damaged.truncate(random.next_u32() as usize % ends[round / 2 % 2]);
            }
            for (detect, read) in READERS {
                let known = detect(&damaged);
                // readers get foreign bytes too, as long as these are short
                if known || damaged.len() < 5000 {
                    let _ = read(&damaged);
                }
            }
        }
    }
}
