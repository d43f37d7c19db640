//! A table as numbers and five flat arrays: how it is kept in files and generated source.

use super::lobe::{Fall, Form, LobeTable, Shape};
use super::side::SideTable;
use super::storage::Storage;
use super::view::{BsdfTableRef, TableError};
use crate::quantity::RelativeIor;

/// The numbers of one lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LobeHeader {
    /// Numbers of nodes.
    pub shape: Shape,
    /// What is divided out.
    pub form: Form,
    /// How the tail falls.
    pub fall: Fall,
    /// Scale of slopes.
    pub scale: f32,
    /// Crowding of incidences towards grazing.
    pub grazing: f32,
    /// Width of the masking that is divided out.
    pub masking: f32,
}

/// The numbers of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Header {
    /// Index of the dielectric over that of air.
    pub eta: RelativeIor<f32>,
    /// Typical slope of the facets.
    pub slope: f32,
    /// Reflection and transmission from the air, reflection and transmission from the dielectric.
    pub lobes: [Option<LobeHeader>; 4],
    /// Incidences of the fluxes, from the air and from the dielectric.
    pub fluxes: [u16; 2],
    /// Crowding of these towards grazing.
    pub grazing: [f32; 2],
}

/// The arrays of all lobes and sides, one after the other in the order of the header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrays<'a, S> {
    /// One an incidence.
    pub gains: &'a [f32],
    /// Radii, azimuths, incidences.
    pub values: &'a [S],
    /// Of the samples.
    pub quantiles: &'a [u16],
    /// Of the samples.
    pub leans: &'a [i8],
    /// Diffuse and coherent light, R, T, R, T.
    pub fluxes: &'a [[u16; 4]],
}

impl Header {
    /// Numbers of gains, values, quantiles, leans and rows of fluxes.
    pub fn lengths(&self) -> [usize; 5] {
        let mut all = [0; 5];
        for lobe in self.lobes.iter().flatten() {
            let shape = lobe.shape;
            let own =
                [usize::from(shape.incidences), shape.values(), shape.quantiles(), shape.leans()];
            for (sum, n) in all.iter_mut().zip(own) {
                *sum += n;
            }
        }
        let [.., rows] = &mut all;
        *rows = self.fluxes.iter().map(|&n| usize::from(n)).sum();
        all
    }

    /// Bytes of the arrays.
    pub fn bytes<S: Storage>(&self) -> usize {
        let [gains, values, quantiles, leans, fluxes] = self.lengths();
        4 * gains + S::BYTES * values + 2 * quantiles + leans + 8 * fluxes
    }

    /// The table in arrays of exactly the lengths it needs.
    ///
    /// # Errors
    /// [`TableError`] for arrays of other lengths and for numbers outside their domains.
    pub fn table<'a, S: Storage>(
        &self,
        arrays: Arrays<'a, S>,
    ) -> Result<BsdfTableRef<'a, S>, TableError> {
        let given = [
            arrays.gains.len(),
            arrays.values.len(),
            arrays.quantiles.len(),
            arrays.leans.len(),
            arrays.fluxes.len(),
        ];
        if given != self.lengths() {
            return Err(TableError::Length);
        }
        let [air, dielectric] = self.split(arrays).ok_or(TableError::Length)?;
        BsdfTableRef::new(self.eta, self.slope, air, dielectric)
    }

    /// The same without a look at the numbers, for arrays that [`Self::table`] has taken before; any others give wrong
    /// values, never a panic.
    #[inline]
    pub fn view<'a, S: Storage>(&self, arrays: Arrays<'a, S>) -> Option<BsdfTableRef<'a, S>> {
        Some(BsdfTableRef::of_checked(self.eta, self.slope, self.split(arrays)?))
    }

    /// The two sides of arrays that are at least as long as they must be.
    pub(super) fn split<'a, S: Storage>(
        &self,
        mut arrays: Arrays<'a, S>,
    ) -> Option<[SideTable<'a, S>; 2]> {
        let mut sides = [SideTable::DARK; 2];
        let [air_r, air_t, inside_r, inside_t] = self.lobes;
        let lobes = [[air_r, air_t], [inside_r, inside_t]];
        for (((side, [r, t]), rows), grazing) in
            sides.iter_mut().zip(lobes).zip(self.fluxes).zip(self.grazing)
        {
            if let Some(header) = r {
                side.reflection = Some(next_lobe(header, &mut arrays)?);
            }
            if let Some(header) = t {
                side.transmission = Some(next_lobe(header, &mut arrays)?);
            }
            side.fluxes = take(&mut arrays.fluxes, usize::from(rows))?;
            side.grazing = grazing;
        }
        Some(sides)
    }
}

fn next_lobe<'a, S: Storage>(
    header: LobeHeader,
    from: &mut Arrays<'a, S>,
) -> Option<LobeTable<'a, S>> {
    let LobeHeader { shape, form, fall, scale, grazing, masking } = header;
    Some(LobeTable {
        shape,
        form,
        fall,
        scale,
        grazing,
        masking,
        cells: shape.cells(),
        gains: take(&mut from.gains, usize::from(shape.incidences))?,
        values: take(&mut from.values, shape.values())?,
        quantiles: take(&mut from.quantiles, shape.quantiles())?,
        leans: take(&mut from.leans, shape.leans())?,
    })
}

fn take<'a, V>(from: &mut &'a [V], count: usize) -> Option<&'a [V]> {
    let (head, rest) = from.split_at_checked(count)?;
    *from = rest;
    Some(head)
}
