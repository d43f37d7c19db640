//! Tables of both formats, written here byte by byte: values that are one constant are GGX facets, exactly.

use std::path::Path;

use asperity_core::bsdf::{Bsdf as _, Ggx};
use asperity_core::direction::Direction;
use asperity_core::quantity::{Alpha, RelativeIor};

use super::{EmbeddedTable, Record, of_bytes, to_bytes};

const ALPHA: f32 = 0.25;

/// One lobe of 3 x 2 x 4 nodes and 2 intervals, the first or the second of four; storage u8.
fn payload() -> Vec<u8> {
    let mut bytes = Vec::new();
    // v = 255 of each node is worth 1/pi: the gain of D of GGX
    for _ in 0..17 {
        bytes.extend((std::f32::consts::FRAC_1_PI / (255.0 * 255.0)).to_le_bytes());
    }
    bytes.extend([255; 24]);
    for _ in 0..3 {
        bytes.extend([0_u16, 20_000, 65_000].iter().flat_map(|q| q.to_le_bytes()));
    }
    bytes.extend([30; 6]);
    for _ in 0..2 {
        bytes.extend([9000_u16, 0, 0, 0].iter().flat_map(|f| f.to_le_bytes()));
    }
    bytes
}

/// The first line; `ends` are its last keys.
fn file(format: u32, eta: &str, transmits: bool, ends: &str) -> Vec<u8> {
    let lobe = "{\"incidences\":3,\"azimuths\":2,\"radii\":4,\"intervals\":2,\"form\":\"masked\",\"fall\":4,\
                \"scale\":0.25,\"grazing\":1.0,\"masking\":0.25}";
    let lobes = if transmits { ["null", lobe] } else { [lobe, "null"] };
    let payload = payload();
    let line = format!(
        "{{\"asperity_table\":{format},\"method\":\"ggx\",\"storage\":\"u8\",\"payload_bytes\":{},\"eta\":{eta},\
         \"slope\":0.25,\"lobes\":[{},{},null,null],\"flux_incidences\":[2,0],\"flux_grazing\":[0.0,0.0]{ends}}}\n",
        payload.len(),
        lobes[0],
        lobes[1],
    );
    [line.as_bytes(), &payload].concat()
}

fn read(bytes: &[u8]) -> Result<(EmbeddedTable, Record), String> {
    of_bytes(Path::new("t.bsdft"), bytes).map_err(|e| e.to_string())
}

/// `ars` from the air to either side, at directions of all kinds.
fn values(law: impl Fn(Direction<f64>, Direction<f64>) -> f64, down: bool) -> Vec<f64> {
    (0..60)
        .map(|k| {
            let x = f64::from(k);
            let wi = Direction::from_angles(0.024 * x, 0.7 * x);
            let wo = Direction::from_angles((0.041 * x) % 1.5, 0.7 * x + 3.0);
            law(wi, if down { Direction::from_unit(wo.xyz()[0], wo.xyz()[1], -wo.z()) } else { wo })
        })
        .collect()
}

fn assert_ggx(table: &EmbeddedTable, eta: f64, down: bool) {
    let ggx = Ggx::new(Alpha::new(f64::from(ALPHA)).unwrap(), RelativeIor::new(eta).unwrap());
    let (got, exact) = (values(|i, o| table.ars(i, o), down), values(|i, o| ggx.ars(i, o), down));
    for (got, exact) in got.iter().zip(&exact) {
        assert!((got - exact).abs() <= 1e-5 * exact + 1e-9, "{got} {exact}");
    }
    assert!(exact.iter().filter(|x| **x > 1e-3).count() > 20);
    let other = values(|i, o| table.ars(i, o), !down);
    assert!(other.iter().all(|x| x.to_bits() == 0), "a lobe that is not there");
}

#[test]
fn a_dielectric_of_format_1_has_the_values_of_its_law_and_no_checksum() {
    let (table, record) = read(&file(1, "1.5", true, "")).unwrap();
    assert!(record.notice().is_some_and(|said| said.contains("no checksum")));
    assert_eq!((table.eta(), table.header().opaque), (Some(1.5), false));
    assert_ggx(&table, 1.5, true);
    // distances were written in both formats
    let (with, _) = read(&file(1, "1.5", true, ",\"distance_percent\":0.5")).unwrap();
    assert_eq!(with, table);
}

#[test]
fn an_index_of_10_and_nothing_but_reflection_was_an_opaque_body_in_format_1_alone() {
    let (table, record) = read(&file(1, "10.0", false, "")).unwrap();
    assert_eq!((table.eta(), table.header().opaque), (None, true));
    assert!(record.notice().is_some());
    assert_ggx(&table, 10.0, false);
    for (eta, transmits) in [("10.0", true), ("9.5", false)] {
        let (table, _) = read(&file(1, eta, transmits, "")).unwrap();
        assert!(!table.header().opaque && table.eta().is_some(), "{eta} {transmits}");
    }
}

#[test]
fn format_2_says_opaque_by_its_flag_and_seals_the_file() {
    for (eta, transmits, opaque) in
        [("1.5", true, false), ("10.0", false, false), ("10.0", false, true)]
    {
        let early = format!(",\"opaque\":{opaque},\"crc32c\":\"00000000\"");
        let unsealed = file(2, eta, transmits, &early);
        assert!(read(&unsealed).unwrap_err().contains("checksum"), "zeros are no sum");
        // as an early program sealed it, an opaque body with the number that stands for its index
        let record: Record =
            serde_json::from_slice(unsealed.split(|b| *b == b'\n').next().unwrap()).unwrap();
        let (old, _) = read(&file(1, eta, transmits, "")).unwrap();
        let (table, _) = read(&to_bytes(&old, &record)).unwrap();
        assert_eq!(table.header().opaque, opaque);
        // and as it is written now
        let bytes = super::bytes(&table, "ggx", None);
        let (again, record) = read(&bytes).unwrap();
        assert_eq!((&again, record.notice()), (&table, None));
        assert_eq!(record.eta.is_none(), opaque);
        assert_ggx(&again, eta.parse().unwrap(), transmits);
        let start = bytes.len() - payload().len();
        for at in (0..bytes.len()).filter(|at| *at < start || at % 7 == 0) {
            let mut turned = bytes.clone();
            turned[at] ^= 0x04;
            assert!(read(&turned).is_err(), "a bit of byte {at}");
        }
    }
}

#[test]
fn a_first_line_that_contradicts_itself_is_refused() {
    for (format, eta, transmits, ends) in [
        (1, "null", false, ""),
        (1, "1.5", true, ",\"opaque\":false"),
        (2, "1.5", true, ""),
        (3, "1.5", true, ""),
    ] {
        assert!(read(&file(format, eta, transmits, ends)).is_err(), "{format} {eta} {ends}");
    }
    let sealed = |eta: &str, transmits, opaque: bool| {
        let ends = format!(",\"opaque\":{opaque},\"crc32c\":\"00000000\"");
        let bytes = file(2, eta, transmits, &ends);
        let record: Record =
            serde_json::from_slice(bytes.split(|b| *b == b'\n').next().unwrap()).unwrap();
        let (table, _) = read(&file(1, "1.5", transmits, "")).unwrap();
        read(&to_bytes(&table, &record)).map(drop)
    };
    assert!(sealed("1.5", true, true).unwrap_err().contains("opaque"), "it transmits");
    assert!(sealed("null", true, false).unwrap_err().contains("eta"), "no index");
    assert!(sealed("null", false, true).is_ok());
}
