//! A table as numbers and five flat arrays: how it is kept in files and generated source.

use super::error::TableError;
use super::lobe::{Fall, Form, LobeTable, Shape, unit};
use super::side::{SideTable, fine};
use super::storage::Storage;
use super::view::BsdfTableRef;
use crate::bsdf::LobeSet;
use crate::quantity::RelativeIor;
use crate::scope;

/// The numbers of one lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LobeHeader {
    /// Numbers of nodes.
    pub shape: Shape,
    /// The factors divided out.
    pub form: Form,
    /// The fall of the tail.
    pub fall: Fall,
    /// Scale of slopes.
    pub scale: f32,
    /// Crowding of incidences: towards the normal above 0, towards grazing below.
    pub grazing: f32,
    /// Width of the masking that is divided out.
    pub masking: f32,
}

impl LobeHeader {
    /// The lobe over arrays of its own.
    #[inline(always)]
    pub const fn over<'a, S>(
        &self,
        gains: &'a [f32],
        values: &'a [S],
        quantiles: &'a [u16],
        leans: &'a [i8],
    ) -> LobeTable<'a, S> {
        let Self { shape, form, fall, scale, grazing, masking } = *self;
        let (cells, unit) = (shape.cells(), unit(shape, scale));
        LobeTable {
            shape,
            form,
            fall,
            scale,
            grazing,
            masking,
            gains,
            cells,
            unit,
            values,
            quantiles,
            leans,
        }
    }
}

/// The numbers of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Header {
    /// Index of the dielectric over that of air; of an opaque body [`Self::STAND_IN`], which is no property of it.
    pub eta: RelativeIor<f32>,
    /// Whether the body is opaque: it reflects light from the air, and there is nothing else.
    pub opaque: bool,
    /// Typical slope of the facets.
    pub slope: f32,
    /// One a lobe, in the order of [`LobeSet::ORDER`].
    pub lobes: [Option<LobeHeader>; 4],
    /// Incidences of the fluxes, from the air and from the dielectric.
    pub fluxes: [u16; 2],
    /// Crowding of these.
    pub grazing: [f32; 2],
}

/// The arrays of all lobes and sides, one after the other in the order of the header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrays<'a, S> {
    /// Steps of incidence.
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
    /// The index whose Fresnel factor is divided out of what an opaque body reflects: it hardly changes with the angle. A number
    /// of the format; that a body is opaque is said by the flag alone.
    pub const STAND_IN: f32 = 10.0;

    /// The lobes that are there.
    pub fn holds(&self) -> LobeSet {
        let there = LobeSet::ORDER.into_iter().zip(&self.lobes).filter(|(_, lobe)| lobe.is_some());
        there.map(|(one, _)| one).collect()
    }

    /// Numbers of gains, values, quantiles, leans and rows of fluxes.
    pub fn lengths(&self) -> [usize; 5] {
        let mut all = [0; 5];
        for lobe in self.lobes.iter().flatten() {
            let shape = lobe.shape;
            let own = [shape.gains(), shape.values(), shape.quantiles(), shape.leans()];
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
    /// [`TableError`] for arrays of other lengths, for numbers outside their domains, and for more than reflection from the
    /// air of an opaque body.
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
        let view = self.view(arrays).ok_or(TableError::Length)?;
        view.check()?;
        view.check_energy()?;
        Ok(view)
    }

    /// The same without a check of the numbers, for arrays that [`Self::table`] has accepted before; others give
    /// wrong values, never a panic. In a constant it costs the device nothing.
    #[inline]
    pub const fn view<'a, S: Storage>(&self, arrays: Arrays<'a, S>) -> Option<BsdfTableRef<'a, S>> {
        let mut view = BsdfTableRef::dark(self.eta, self.opaque, self.slope);
        if self.fill(arrays, &mut view) { Some(view) } else { None }
    }

    /// The same in place, for storage that is none of Rust's: a copy of a whole view costs a device a `memcpy`.
    ///
    /// `view` is a [dark](BsdfTableRef::dark) table; `false` if the arrays have too few numbers for the rest of it.
    #[inline(always)]
    pub const fn fill<'a, S: Storage>(
        &self,
        mut arrays: Arrays<'a, S>,
        view: &mut BsdfTableRef<'a, S>,
    ) -> bool {
        let [air, dielectric] = view.sides_mut();
        self.split(&mut arrays, air, dielectric)
    }

    const fn split<'a, S: Storage>(
        &self,
        from: &mut Arrays<'a, S>,
        air: &mut SideTable<'a, S>,
        dielectric: &mut SideTable<'a, S>,
    ) -> bool {
        let ([air_r, air_t, inside_r, inside_t], [above, below]) = (&self.lobes, self.fluxes);
        let [grazing_above, grazing_below] = self.grazing;
        let (r, t) = (&mut dielectric.reflection, &mut dielectric.transmission);
        next_lobe(air_r, from, &mut air.reflection, scope::AIR && scope::REFLECTION)
            && next_lobe(air_t, from, &mut air.transmission, scope::AIR && scope::TRANSMISSION)
            && next_lobe(inside_r, from, r, scope::DIELECTRIC && scope::REFLECTION)
            && next_lobe(inside_t, from, t, scope::DIELECTRIC && scope::TRANSMISSION)
            && next_fluxes(above, grazing_above, from, air, scope::AIR)
            && next_fluxes(below, grazing_below, from, dielectric, scope::DIELECTRIC)
    }
}

/// Takes the numbers of a lobe, and puts them where they belong if they are wanted.
#[inline(never)]
#[allow(clippy::ref_option, reason = "a reference in an option costs every call 10 bytes of code")]
const fn next_lobe<'a, S: Storage>(
    header: &Option<LobeHeader>,
    from: &mut Arrays<'a, S>,
    to: &mut Option<LobeTable<'a, S>>,
    wanted: bool,
) -> bool {
    let Some(lobe) = header else {
        return true;
    };
    let shape = lobe.shape;
    let Some(gains) = take(&mut from.gains, shape.gains()) else { return false };
    let Some(values) = take(&mut from.values, shape.values()) else { return false };
    let Some(quantiles) = take(&mut from.quantiles, shape.quantiles()) else { return false };
    let Some(leans) = take(&mut from.leans, shape.leans()) else { return false };
    if wanted {
        *to = Some(lobe.over(gains, values, quantiles, leans));
    }
    true
}

/// The same for the fluxes of a side.
#[inline(always)]
const fn next_fluxes<'a, S: Storage>(
    rows: u16,
    grazing: f32,
    from: &mut Arrays<'a, S>,
    to: &mut SideTable<'a, S>,
    wanted: bool,
) -> bool {
    let Some(fluxes) = take(&mut from.fluxes, rows as usize) else { return false };
    if wanted {
        to.steps = fine(fluxes.len());
        to.fluxes = fluxes;
        to.grazing = grazing;
    }
    true
}

const fn take<'a, V>(from: &mut &'a [V], count: usize) -> Option<&'a [V]> {
    let Some((head, rest)) = from.split_at_checked(count) else { return None };
    *from = rest;
    Some(head)
}
