//! Tables for microcontrollers on the host: the arrays, their file, and their source code.
//!
//! The evaluator is [`asperity_core::table`]; this module holds its arrays in any storage. [`crate::tabulate`] makes them.

mod holds;
mod file;
mod generate;
#[cfg(test)]
mod tests;

pub use file::{Record, TableFileError, bytes, is_table, of_bytes, read, to_bytes, write};
pub use generate::{c_header, rust_source};
pub use holds::MissingLobes;

use asperity_core::bsdf::{Bsdf, CoherentFlux, Lobe, Scatter, Scattered};
use asperity_core::direction::Direction;
use asperity_core::table::{Arrays, BsdfTableRef, Header, Storage, TableError};

/// Values of one of the storages.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// 8 bits.
    U8(Vec<u8>),
    /// 16 bits.
    U16(Vec<u16>),
    /// Single precision.
    F32(Vec<f32>),
}

/// A table that owns its arrays.
#[derive(Clone, Debug, PartialEq)]
pub struct EmbeddedTable {
    header: Header,
    gains: Vec<f32>,
    values: Values,
    quantiles: Vec<u16>,
    leans: Vec<i8>,
    fluxes: Vec<[u16; 4]>,
}

/// All arrays but the values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rest {
    /// One per incidence.
    pub gains: Vec<f32>,
    /// Of the samples.
    pub quantiles: Vec<u16>,
    /// Of the samples.
    pub leans: Vec<i8>,
    /// Of both sides.
    pub fluxes: Vec<[u16; 4]>,
}

/// Runs an expression with the view of a table, whatever its storage.
macro_rules! with_view {
    ($table:expr, $view:ident => $body:expr, else $none:expr) => {
        match $table.values() {
            $crate::embedded::Values::U8(v) => $table.view(v).map_or_else(|| $none, |$view| $body),
            $crate::embedded::Values::U16(v) => $table.view(v).map_or_else(|| $none, |$view| $body),
            $crate::embedded::Values::F32(v) => $table.view(v).map_or_else(|| $none, |$view| $body),
        }
    };
}
pub(crate) use with_view;

impl EmbeddedTable {
    /// Checks arrays against a header.
    ///
    /// # Errors
    /// [`TableError`] if they do not belong together.
    pub fn new(header: Header, values: Values, rest: Rest) -> Result<Self, TableError> {
        let Rest { gains, quantiles, leans, fluxes } = rest;
        let table = Self { header, gains, values, quantiles, leans, fluxes };
        match &table.values {
            Values::U8(v) => header.table(table.arrays(v)).map(drop)?,
            Values::U16(v) => header.table(table.arrays(v)).map(drop)?,
            Values::F32(v) => header.table(table.arrays(v)).map(drop)?,
        }
        Ok(table)
    }

    fn arrays<'a, S>(&'a self, values: &'a [S]) -> Arrays<'a, S> {
        let Self { gains, quantiles, leans, fluxes, .. } = self;
        Arrays { gains, values, quantiles, leans, fluxes }
    }

    /// All arrays but the values.
    pub(crate) fn rest(&self) -> Rest {
        let Self { gains, quantiles, leans, fluxes, .. } = self.clone();
        Rest { gains, quantiles, leans, fluxes }
    }

    /// The evaluator of values that are this table's own.
    pub fn view<'a, S: Storage>(&'a self, values: &'a [S]) -> Option<BsdfTableRef<'a, S>> {
        self.header.view(self.arrays(values))
    }

    /// The numbers.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The values.
    pub fn values(&self) -> &Values {
        &self.values
    }

    /// CRC-32C of the numbers and arrays, as firmware checks it.
    pub fn checksum(&self) -> u32 {
        match &self.values {
            Values::U8(v) => self.header.checksum(&self.arrays(v)),
            Values::U16(v) => self.header.checksum(&self.arrays(v)),
            Values::F32(v) => self.header.checksum(&self.arrays(v)),
        }
    }

    /// Name of the storage.
    pub fn storage(&self) -> &'static str {
        match self.values {
            Values::U8(_) => <u8 as Storage>::NAME,
            Values::U16(_) => <u16 as Storage>::NAME,
            Values::F32(_) => <f32 as Storage>::NAME,
        }
    }

    /// Bytes of all arrays.
    pub fn bytes(&self) -> usize {
        match self.values {
            Values::U8(_) => self.header.bytes::<u8>(),
            Values::U16(_) => self.header.bytes::<u16>(),
            Values::F32(_) => self.header.bytes::<f32>(),
        }
    }
}

impl Scatter<f64> for EmbeddedTable {
    fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        with_view!(self, view => view.sample(wi, uniform), else None)
    }
}

impl Bsdf<f64> for EmbeddedTable {
    fn eval(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        with_view!(self, view => view.eval(wi, wo), else 0.0)
    }
    fn ars(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        with_view!(self, view => view.ars(wi, wo), else 0.0)
    }
    fn pdf(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        with_view!(self, view => view.pdf(wi, wo), else 0.0)
    }
    fn sample_lobe(&self, wi: Direction<f64>, lobe: Lobe, u: [f64; 2]) -> Option<Scattered<f64>> {
        with_view!(self, view => view.sample_lobe(wi, lobe, u), else None)
    }
    fn slope(&self) -> f64 {
        f64::from(self.header.slope)
    }
    fn coherent_flux(&self, wi: Direction<f64>) -> CoherentFlux<f64> {
        self.coherent(wi)
    }
}
