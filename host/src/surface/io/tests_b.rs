//! Tests over the readers of text, arrays and images: measured files, and damage to synthetic ones.

use std::path::PathBuf;

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use tiff::encoder::Compression;

use super::{MapFault, RawMap};
use super::{gwy, gwyddion_text, matrix, npy, png16, sur, tiff_float, xyz};

/// A file of the shared data; says so and gives `None` where there is none.
#[expect(clippy::print_stderr, reason = "a skipped test must not pass in silence")]
fn data(name: &str) -> Option<Vec<u8>> {
    let folder = std::env::var_os("ASPERITY_DATA").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"),
        PathBuf::from,
    );
    let path = folder.join(name);
    let bytes = std::fs::read(&path);
    if let Err(error) = &bytes {
        eprintln!("skipped: no data ({}: {error})", path.display());
    }
    bytes.ok()
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
    check(name, &matrix::read(&bytes).unwrap());
}

#[test]
fn the_profilometer_gives_its_figures() {
    let name = "topography/nanovea-roughness/test1.txt";
    let Some(bytes) = data(name) else { return };
    assert!(xyz::detect(&bytes) && !matrix::detect(&bytes));
    check(name, &xyz::read(&bytes).unwrap());
}

#[test]
fn a_sample_of_numpy_is_read() {
    let Some(bytes) = data("samples/sample5.npy") else { return };
    assert!(npy::detect(&bytes));
    let map = npy::read(&bytes).unwrap();
    assert_eq!((map.nx, map.ny), (1024, 1024));
    assert!(map.heights_um.iter().all(|h| h.is_finite()));
}

type Reader = fn(&[u8]) -> Result<RawMap, MapFault>;
type Detect = fn(&[u8]) -> bool;

fn png(bytes: &[u8]) -> Result<RawMap, MapFault> {
    png16::read(bytes, None)
}

/// Name, recogniser, reader and a file for each.
fn samples() -> Vec<(&'static str, Detect, Reader, Vec<u8>)> {
    let dhm = "h=3 w=2\npixel size=3.7e-007 m\ndata unit=rad\n\
               height conversion factor (-> m)=2.9e-008\n-4.4 1 \n2.5 -1e-3 \n0 7\n";
    let gwyddion = "# Channel: a\n# Width: 2 \u{b5}m\n# Height: 1 \u{b5}m\n# Value units: m\n\
                    1e-9\t2e-9\n3e-9\tnan\n";
    let points = "# Lateral units: mm\nx;y;z [um]\n0;0;1\n1;0;2\n0;0,5;3\n1;0,5;-4\n2;0,5;0\n";
    let scalar =
        npy::tests::npy(1, "{'descr': '<f8', 'fortran_order': False, 'shape': ()}", &[0; 8]);
    let npz = |deflate| {
        npy::tests::npz(&[("a.npy", scalar.clone()), ("b.npy", npy::tests::sample())], deflate)
    };
    let png_file =
        png16::tests::sample(&[(b"pCAL", png16::tests::PCAL), (b"sCAL", png16::tests::SCAL)]);
    let deflate = Compression::Deflate(tiff::encoder::DeflateLevel::default());
    vec![
        ("sur 16", sur::detect, sur::read, sur::tests::sample(false, 16)),
        ("sur 32", sur::detect, sur::read, sur::tests::sample(false, 32)),
        ("sur zipped", sur::detect, sur::read, sur::tests::sample(true, 32)),
        ("gwy", gwy::detect, gwy::read, super::tests_gwy::sample()),
        ("gwyddion text", gwyddion_text::detect, gwyddion_text::read, gwyddion.into()),
        ("dhm", matrix::detect, matrix::read, dhm.into()),
        ("matrix", matrix::detect, matrix::read, "1,5;2;3\n4;5;6,5\n".into()),
        ("xyz", xyz::detect, xyz::read, points.into()),
        ("npy", npy::detect, npy::read, npy::tests::sample()),
        ("npz", npy::detect, npy::read, npz(false)),
        ("npz zipped", npy::detect, npy::read, npz(true)),
        ("png", png16::detect, png, png_file),
        (
            "tiff",
            tiff_float::detect,
            tiff_float::read,
            tiff_float::tests::sample(Compression::Uncompressed),
        ),
        (
            "tiff lzw",
            tiff_float::detect,
            tiff_float::read,
            tiff_float::tests::sample(Compression::Lzw),
        ),
        ("tiff zipped", tiff_float::detect, tiff_float::read, tiff_float::tests::sample(deflate)),
    ]
}

#[test]
fn each_file_is_claimed_by_its_reader_alone() {
    for (name, _, own, file) in samples() {
        own(&file).unwrap_or_else(|fault| panic!("{name}: {fault}"));
        for (other, detect, read, _) in samples() {
            assert_eq!(detect(&file), read as usize == own as usize, "{other} on {name}");
        }
    }
}

#[test]
fn damage_is_refused_or_read_but_never_panics() {
    let mut rng = Pcg64Mcg::seed_from_u64(20220711);
    // so many files can be read for longer by setting the variable
    let rounds = std::env::var("ASPERITY_FUZZ").ok().and_then(|n| n.parse().ok()).unwrap_or(300);
    for (name, _, read, file) in samples() {
        let mut refused = 0;
        for _ in 0..rounds {
            let mut bytes = file.clone();
            for _ in 0..=rng.next_u32() % 4 {
                let at = rng.next_u32() as usize % bytes.len();
                match rng.next_u32() % 6 {
                    0 => bytes.truncate(at.max(1)),
                    1 => bytes[at] = 255,
                    2 => bytes[at] = 0,
                    3 => bytes[at] = bytes[rng.next_u32() as usize % bytes.len()],
                    4 => bytes.insert(at, rng.next_u32() as u8),
                    _ => bytes[at] ^= 1 << (rng.next_u32() % 8),
                }
            }
            for detect in DETECT {
                detect(&bytes);
            }
            match read(&bytes) {
                Ok(map) => assert_eq!(map.nx * map.ny, map.heights_um.len(), "{name}"),
                Err(_) => refused += 1,
            }
        }
        assert!(refused > rounds / 10, "{name}: {refused} of {rounds} refused");
    }
}

/// The recognisers.
const DETECT: [Detect; 8] = [
    sur::detect,
    gwy::detect,
    gwyddion_text::detect,
    matrix::detect,
    xyz::detect,
    npy::detect,
    png16::detect,
    tiff_float::detect,
];
