//! Measured files of text and arrays, against figures that another reader gave.

use super::{OpenOptions, RawMap, gwyddion_text, matrix, npy, xyz};

/// A file of the measured data.
fn data(name: &str) -> Option<Vec<u8>> {
    asperity_needs::data(name).map(|path| std::fs::read(path).unwrap())
}

/// Root mean square of the heights over their least-squares plane.
fn rq_um(map: &RawMap) -> f64 {
    let (nx, ny) = (map.nx as f64, map.ny as f64);
    // on a full centred grid the columns x, y and 1 are orthogonal
    let centred =
        |k: usize| ((k % map.nx) as f64 - (nx - 1.0) / 2.0, (k / map.nx) as f64 - (ny - 1.0) / 2.0);
    let n = nx * ny;
    let (mut s, mut sx, mut sy) = (0.0, 0.0, 0.0);
    for (k, h) in map.heights_um.iter().enumerate() {
        let (x, y) = centred(k);
        (s, sx, sy) = (s + h, sx + h * x, sy + h * y);
    }
    let (ax, ay) = (sx / (n * (nx * nx - 1.0) / 12.0), sy / (n * (ny * ny - 1.0) / 12.0));
    let square = |(k, h): (usize, &f64)| {
        let (x, y) = centred(k);
        (h - s / n - ax * x - ay * y).powi(2)
    };
    (map.heights_um.iter().enumerate().map(square).sum::<f64>() / n).sqrt()
}

/// Compares with the figures beside the file.
fn check(name: &str, map: &RawMap) {
    let Some(figures) = data(&format!("{name}.json")) else { return };
    let figures: serde_json::Value = serde_json::from_slice(&figures).unwrap();
    let number = |path: &str| figures.pointer(path).and_then(serde_json::Value::as_f64).unwrap();
    for (found, path) in [
        (map.ny as f64, "/shape/0"),
        (map.nx as f64, "/shape/1"),
        (map.dx_um.unwrap(), "/pixel_um/dx"),
        (map.dy_um.unwrap(), "/pixel_um/dy"),
        (rq_um(map), "/statistics/Sq_um_plane"),
    ] {
        assert!((found / number(path) - 1.0).abs() < 1e-4, "{name} {path}: {found}");
    }
    assert!(map.heights_um.iter().all(|h| h.is_finite()));
}

#[test]
fn the_holographic_microscope_gives_its_figures() {
    let name = "topography/SurfaceTopography/matrix-4.txt";
    let Some(bytes) = data(name) else { return };
    assert!(matrix::detect(&bytes) && !xyz::detect(&bytes) && !gwyddion_text::detect(&bytes));
    check(name, &matrix::read(&bytes, &OpenOptions::default()).unwrap());
}

#[test]
fn the_profilometer_gives_its_figures() {
    let name = "topography/nanovea-roughness/test1.txt";
    let Some(bytes) = data(name) else { return };
    assert!(xyz::detect(&bytes) && !matrix::detect(&bytes));
    let unit = |name: &str| name.parse().ok();
    let options = OpenOptions { xy_unit: unit("mm"), z_unit: unit("um"), ..OpenOptions::default() };
    check(name, &xyz::read(&bytes, &options).unwrap());
    let fault = xyz::read(&bytes, &OpenOptions::default()).unwrap_err().to_string();
    assert!(fault.contains("--xy-unit and --z-unit"), "{fault}");
}

#[test]
fn a_sample_of_numpy_is_read() {
    let Some(bytes) = data("samples/sample5.npy") else { return };
    assert!(npy::detect(&bytes));
    let map = npy::read(&bytes, &OpenOptions::default()).unwrap();
    assert_eq!((map.nx, map.ny), (1024, 1024));
    assert!(map.heights_um.iter().all(|h| h.is_finite()));
}
