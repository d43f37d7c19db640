//! The table of the examples, read from its file: what the C header must hold, and what core makes of it.

use std::fs;

use asperity_core::table::{Arrays, BsdfTableRef, Header};

use crate::tools::capi;

/// A table of 16-bit values with the arrays of its payload.
#[derive(Debug)]
pub(crate) struct Example {
    header: Header,
    gains: Vec<f32>,
    values: Vec<u16>,
    quantiles: Vec<u16>,
    leans: Vec<i8>,
    fluxes: Vec<[u16; 4]>,
}

impl Example {
    /// The file beside the examples.
    pub(crate) fn read() -> Self {
        let path = capi().join("examples/bsdf_example.bsdft");
        let (table, _) = asperity::embedded::read(&path).unwrap();
        let header = *table.header();
        let bytes = fs::read(path).unwrap();
        let start = bytes.iter().position(|b| *b == b'\n').unwrap() + 1;
        let [gains, values, quantiles, leans, _] = header.lengths();
        let (gains, rest) = bytes[start..].split_at(4 * gains);
        let (values, rest) = rest.split_at(2 * values);
        let (quantiles, rest) = rest.split_at(2 * quantiles);
        let (leans, fluxes) = rest.split_at(leans);
        let words = |b: &[u8]| {
            b.as_chunks::<2>().0.iter().map(|w| u16::from_le_bytes(*w)).collect::<Vec<_>>()
        };
        Self {
            header,
            gains: gains.as_chunks::<4>().0.iter().map(|w| f32::from_le_bytes(*w)).collect(),
            values: words(values),
            quantiles: words(quantiles),
            leans: leans.iter().map(|b| b.cast_signed()).collect(),
            fluxes: words(fluxes).as_chunks::<4>().0.to_vec(),
        }
    }

    /// Bytes of its arrays.
    pub(crate) fn bytes(&self) -> usize {
        self.header.bytes::<u16>()
    }

    /// The table.
    pub(crate) fn view(&self) -> BsdfTableRef<'_, u16> {
        let Self { header, gains, values, quantiles, leans, fluxes } = self;
        header.table(Arrays { gains, values, quantiles, leans, fluxes }).unwrap()
    }
}

#[test]
fn the_header_of_the_example_holds_its_table() {
    let (table, record) =
        asperity::embedded::read(&capi().join("examples/bsdf_example.bsdft")).unwrap();
    let fresh = asperity::embedded::c_header(&table, &record.method, "example");
    let path = capi().join("examples/bsdf_example.h");
    if std::env::var_os("ASPERITY_BLESS").is_some() {
        fs::write(&path, &fresh).unwrap();
    }
    assert!(
        fresh == fs::read_to_string(path).unwrap_or_default(),
        "examples/bsdf_example.h is not that of bsdf_example.bsdft; make it anew: \
         ASPERITY_BLESS=1 cargo test -p asperity-tests --test capi example"
    );
}
