//! A table of one of the three storages, in arrays of the caller.

use asperity_core::direction::{Direction, Side};
use asperity_core::quantity::RelativeIor;
use asperity_core::table::{BsdfTableRef, Fall, Form, Header, LobeHeader, Shape, Storage};

use crate::law::{AsperityRay, Law, exact_ray, exact_value, fast_ray};
use crate::options::{AsperityQuantity as Quantity, AsperityTier as Tier};
use crate::status::AsperityStatus as Status;

/// Most nodes of an axis.
const MOST_NODES: u16 = 4096;
/// Most values of a lobe, so that no count of bytes overflows 32 bits.
const MOST_VALUES: u64 = 1 << 26;

/// The numbers of a table as the generated C header has them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Numbers<'a> {
    pub(crate) eta: f32,
    pub(crate) opaque: bool,
    pub(crate) slope: f32,
    pub(crate) lobes: &'a [[u16; 6]; 4],
    pub(crate) scales: &'a [[f32; 3]; 4],
    pub(crate) flux_incidences: [u16; 2],
    pub(crate) flux_grazing: [f32; 2],
}

impl Numbers<'_> {
    /// The index, which must be one.
    #[inline(always)]
    pub(crate) fn eta(&self) -> Result<RelativeIor<f32>, Status> {
        Ok(RelativeIor::new(self.eta)?)
    }

    /// The header of the table without its lobes.
    #[inline(always)]
    pub(crate) fn without_lobes(&self, eta: RelativeIor<f32>) -> Header {
        Header {
            eta,
            opaque: self.opaque,
            slope: self.slope,
            // no constant: that would be copied
            lobes: [None, None, None, None],
            fluxes: self.flux_incidences,
            grazing: self.flux_grazing,
        }
    }

    /// Adds the lobes; the arrays then have lengths that can be computed. In place: a `Result` of a header is copied
    /// by a `memcpy`, which costs a device more than the rest of its making.
    pub(crate) fn add_lobes(&self, header: &mut Header) -> Result<(), Status> {
        for ((to, row), scale) in header.lobes.iter_mut().zip(self.lobes).zip(self.scales) {
            *to = lobe(row, *scale)?;
        }
        if header.fluxes.iter().any(|n| *n > MOST_NODES) {
            return Err(Status::TableShape);
        }
        Ok(())
    }
}

/// A lobe from a row of numbers; zeros are a lobe left out.
fn lobe(row: &[u16; 6], [scale, grazing, masking]: [f32; 3]) -> Result<Option<LobeHeader>, Status> {
    let &[incidences, azimuths, radii, intervals, form, fall] = row;
    if row.iter().all(|n| *n == 0) {
        return Ok(None);
    }
    let nodes = [incidences, azimuths, radii, intervals];
    let values = u64::from(incidences) * u64::from(azimuths) * u64::from(radii);
    if nodes.iter().any(|n| *n > MOST_NODES) || values > MOST_VALUES {
        return Err(Status::TableShape);
    }
    let form = Form::of_number(form).ok_or(Status::TableNumber)?;
    let fall = Fall::of_number(fall).ok_or(Status::TableNumber)?;
    let shape = Shape { incidences, azimuths, radii, intervals };
    Ok(Some(LobeHeader { shape, form, fall, scale, grazing, masking }))
}

/// A table of whatever storage this library was built for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Stored<'a> {
    #[cfg(feature = "table-u8")]
    U8(BsdfTableRef<'a, u8>),
    #[cfg(feature = "table-u16")]
    U16(BsdfTableRef<'a, u16>),
    #[cfg(feature = "table-f32")]
    F32(BsdfTableRef<'a, f32>),
}

/// A kind of value this library was built for.
pub(crate) trait Value: Storage {
    /// A table of nothing.
    fn dark(header: &Header) -> Stored<'static>;
    /// The view of a table of this kind.
    fn view<'b, 'a>(stored: &'b mut Stored<'a>) -> Option<&'b mut BsdfTableRef<'a, Self>>;
}

macro_rules! value {
    ($feature:literal, $t:ty, $variant:ident) => {
        #[cfg(feature = $feature)]
        impl Value for $t {
            #[inline(always)]
            fn dark(header: &Header) -> Stored<'static> {
                Stored::$variant(BsdfTableRef::dark(header.eta, header.opaque, header.slope))
            }
            #[inline(always)]
            fn view<'b, 'a>(stored: &'b mut Stored<'a>) -> Option<&'b mut BsdfTableRef<'a, Self>> {
                match stored {
                    Stored::$variant(view) => Some(view),
                    #[allow(unreachable_patterns, reason = "a library of one kind")]
                    _ => None,
                }
            }
        }
    };
}

value!("table-u8", u8, U8);
value!("table-u16", u16, U16);
value!("table-f32", f32, F32);

#[cfg(not(any(feature = "table-u8", feature = "table-u16", feature = "table-f32")))]
compile_error!("choose a storage of tables: a feature `table-u8`, `table-u16` or `table-f32`");

/// A table. Its values need no elementary function, so only samples differ between the tiers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TableLaw<'a> {
    pub(crate) table: Stored<'a>,
    pub(crate) tier: Tier,
}

/// Runs an expression with the view of a table, whatever its storage.
macro_rules! with_view {
    ($stored:expr, $view:ident => $body:expr) => {
        match &$stored {
            #[cfg(feature = "table-u8")]
            Stored::U8($view) => $body,
            #[cfg(feature = "table-u16")]
            Stored::U16($view) => $body,
            #[cfg(feature = "table-f32")]
            Stored::F32($view) => $body,
        }
    };
}

impl TableLaw<'_> {
    /// Whether the body is opaque.
    #[inline(always)]
    pub(crate) fn is_opaque(&self) -> bool {
        with_view!(self.table, view => view.is_opaque())
    }

    /// Diffusely reflected and transmitted fractions of the flux.
    #[inline(always)]
    pub(crate) fn fluxes(&self, cos: f32, side: Side) -> Result<[f32; 2], Status> {
        if !cos.is_finite() {
            return Err(Status::NotFinite);
        }
        if cos.abs() > 1.0 {
            return Err(Status::OutOfDomain);
        }
        Ok(
            with_view!(self.table, view => [view.reflectance(cos, side), view.transmittance(cos, side)]),
        )
    }
}

impl Law for TableLaw<'_> {
    #[inline(always)]
    fn value(&self, what: Quantity, wi: Direction<f32>, wo: Direction<f32>) -> f32 {
        with_view!(self.table, view => exact_value(view, what, wi, wo))
    }

    fn draw(&self, wi: Direction<f32>, uniform: &mut impl FnMut() -> f32) -> AsperityRay {
        with_view!(self.table, view => match self.tier {
            Tier::Fast => fast_ray(view, wi, uniform),
            Tier::Exact => exact_ray(view, wi, uniform),
        })
    }
}
