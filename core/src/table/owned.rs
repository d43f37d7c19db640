//! A table that owns its arrays, of sizes known when the program is built.

use super::error::TableError;
use super::header::{Arrays, Header};
use super::storage::Storage;
use super::view::BsdfTableRef;

/// Room for `V` values, `Q` quantiles (and leans), and `N` incidences of lobes and of fluxes.
///
/// The [view](Self::view) does all the work, compiled once per storage instead of once per size.
#[derive(Clone, Debug, PartialEq)]
pub struct BsdfTable<S, const V: usize, const Q: usize, const N: usize> {
    header: Header,
    gains: [f32; N],
    values: [S; V],
    quantiles: [u16; Q],
    leans: [i8; Q],
    fluxes: [[u16; 4]; N],
}

impl<S: Storage, const V: usize, const Q: usize, const N: usize> BsdfTable<S, V, Q, N> {
    /// Copies and checks arrays of exactly the lengths of the header.
    ///
    /// # Errors
    /// [`TableError::Length`] without room, else those of [`Header::table`].
    pub fn new(header: Header, arrays: Arrays<'_, S>) -> Result<Self, TableError> {
        header.table(arrays)?;
        let mut table = Self {
            header,
            gains: [0.0; N],
            values: [S::default(); V],
            quantiles: [0; Q],
            leans: [0; Q],
            fluxes: [[0; 4]; N],
        };
        copy(&mut table.gains, arrays.gains)?;
        copy(&mut table.values, arrays.values)?;
        copy(&mut table.quantiles, arrays.quantiles)?;
        copy(&mut table.leans, arrays.leans)?;
        copy(&mut table.fluxes, arrays.fluxes)?;
        Ok(table)
    }

    /// The numbers.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The table itself.
    pub fn view(&self) -> BsdfTableRef<'_, S> {
        let Self { header, gains, values, quantiles, leans, fluxes } = self;
        let arrays = Arrays { gains, values, quantiles, leans, fluxes };
        // never none: the lengths were checked when it was made
        header.view(arrays).unwrap_or(BsdfTableRef::dark(header.eta, header.opaque, header.slope))
    }
}

fn copy<T: Copy>(to: &mut [T], from: &[T]) -> Result<(), TableError> {
    to.get_mut(..from.len()).ok_or(TableError::Length)?.copy_from_slice(from);
    Ok(())
}
