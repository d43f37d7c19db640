//! A table and what it is made of: the numbers and arrays, as C has them.

use core::mem::MaybeUninit;

use asperity_core::table::{Arrays, Header};

use super::pointer::{Storage, begin, check_all, finish, read, slice};
use crate::options::{self, AsperityTier};
use crate::status::AsperityStatus as Status;
use crate::table::{Numbers, TableLaw, Value};

/// A table made by `asperity tabulate`, in arrays of the caller. Opaque: only functions of this library look inside; it may be copied.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct AsperityTable {
    /// Room for it.
    opaque: [MaybeUninit<usize>; 104],
}

impl AsperityTable {
    /// Storage without an object in it.
    pub const EMPTY: Self = Self { opaque: [MaybeUninit::new(0); 104] };
}

impl Storage for AsperityTable {
    type Law = TableLaw<'static>;
    const MARK: u32 = 0x5441_4231;
}

/// The numbers and arrays of a table: those of the C header that `asperity tabulate --c` writes, under the same names.
/// `ASPERITY_TABLE_SOURCE` fills it. Lengths count numbers, not bytes. A missing array is null, of length 0.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct AsperityTableSource {
    /// Index of the dielectric over that of air; of an opaque body a number of the format, and no index of anything.
    pub eta: *const f32,
    /// Typical slope of the facets.
    pub slope: *const f32,
    /// 4 rows of 6: incidences, azimuths, radii, intervals, form, fall; zeros for a lobe left out.
    pub lobes: *const u16,
    /// 4 rows of 3: scale of slopes, crowding of incidences, width of masking.
    pub scales: *const f32,
    /// Incidences of the fluxes from the air and from the dielectric.
    pub flux_incidences: *const u16,
    /// Crowding of these.
    pub flux_grazing: *const f32,
    /// One an incidence of a lobe.
    pub gains: *const f32,
    /// Of `value_bytes` each.
    pub values: *const core::ffi::c_void,
    /// Of the samples.
    pub quantiles: *const u16,
    /// Of the samples.
    pub leans: *const i8,
    /// Four an incidence of the fluxes.
    pub fluxes: *const u16,
    /// CRC-32C of all the numbers and arrays; null for a table without one, whose damage goes unseen.
    pub checksum: *const u32,
    /// Length of `gains`.
    pub gains_length: usize,
    /// Length of `values`.
    pub values_length: usize,
    /// Length of `quantiles`.
    pub quantiles_length: usize,
    /// Length of `leans`.
    pub leans_length: usize,
    /// Length of `fluxes`.
    pub fluxes_length: usize,
    /// Bytes of a value: 1 and 2 are unsigned integers, 4 is `float`.
    pub value_bytes: u32,
    /// 1 for an opaque body, which reflects light from the air and does nothing else; 0 for a dielectric.
    pub opaque: u32,
}

impl AsperityTableSource {
    /// The numbers.
    #[inline(always)]
    unsafe fn numbers(&self) -> Result<Numbers<'_>, Status> {
        check_all(&[self.eta, self.slope, self.scales, self.flux_grazing])?;
        check_all(&[self.lobes, self.flux_incidences])?;
        // SAFETY: checked here, and by the promise of `abi` readable and unchanging
        unsafe {
            Ok(Numbers {
                eta: *self.eta,
                opaque: self.opaque != 0,
                slope: *self.slope,
                lobes: &*self.lobes.cast(),
                scales: &*self.scales.cast(),
                flux_incidences: self.flux_incidences.cast::<[u16; 2]>().read(),
                flux_grazing: self.flux_grazing.cast::<[f32; 2]>().read(),
            })
        }
    }

    /// Puts the table in its storage, checked, but for the numbers in the arrays of a trusted one.
    #[inline(always)]
    pub(super) unsafe fn init(
        &self,
        to: *mut AsperityTable,
        tier: u32,
        trusted: bool,
    ) -> Result<(), Status> {
        let tier = options::tier(tier)?;
        // SAFETY: the promise of `abi`
        unsafe {
            let numbers = self.numbers()?;
            let mut header = numbers.without_lobes(numbers.eta()?);
            numbers.add_lobes(&mut header)?;
            match self.value_bytes {
                #[cfg(feature = "table-u8")]
                1 => self.view::<u8>(&header, to, tier, trusted),
                #[cfg(feature = "table-u16")]
                2 => self.view::<u16>(&header, to, tier, trusted),
                #[cfg(feature = "table-f32")]
                4 => self.view::<f32>(&header, to, tier, trusted),
                _ => Err(Status::UnknownOption),
            }
        }
    }

    #[inline(always)]
    unsafe fn view<S: Value>(
        &self,
        header: &Header,
        to: *mut AsperityTable,
        tier: AsperityTier,
        trusted: bool,
    ) -> Result<(), Status> {
        if !self.fluxes_length.is_multiple_of(4) {
            return Err(Status::TableLength);
        }
        // SAFETY: the promise of `abi`; all of the caller's memory is read before its storage is written
        unsafe {
            let arrays = Arrays::<S> {
                gains: slice(self.gains, self.gains_length)?,
                values: slice(self.values.cast(), self.values_length)?,
                quantiles: slice(self.quantiles, self.quantiles_length)?,
                leans: slice(self.leans, self.leans_length)?,
                fluxes: slice(self.fluxes.cast(), self.fluxes_length / 4)?,
            };
            let checked = if trusted {
                None
            } else if self.checksum.is_null() {
                Some(header.table(arrays)?)
            } else {
                Some(header.verified(arrays, read(self.checksum)?)?)
            };
            let law = begin(to, TableLaw { table: S::dark(header), tier });
            let Some(view) = S::view(&mut law.table) else { return Err(Status::UnknownOption) };
            if let Some(table) = checked {
                *view = table;
            } else if !header.fill(arrays, view) {
                return Err(Status::TableLength);
            }
            finish(to);
        }
        Ok(())
    }

    /// The same numbers with the arrays of a payload.
    pub(super) unsafe fn over(&self, payload: *const u8, bytes: usize) -> Result<Self, Status> {
        if cfg!(target_endian = "big") || !matches!(self.value_bytes, 1 | 2 | 4) {
            return Err(Status::UnknownOption);
        }
        if payload.is_null() {
            return Err(Status::NullPointer);
        }
        if !payload.addr().is_multiple_of(align_of::<f32>()) {
            return Err(Status::Misaligned);
        }
        // SAFETY: the promise of `abi`
        let numbers = unsafe { self.numbers() }?;
        let mut header = numbers.without_lobes(numbers.eta()?);
        numbers.add_lobes(&mut header)?;
        let [gains, values, quantiles, leans, rows] = header.lengths();
        let ends = [4 * gains, self.value_bytes as usize * values, 2 * quantiles, leans, 8 * rows];
        if ends.iter().sum::<usize>() != bytes {
            return Err(Status::TableLength);
        }
        let [at_values, at_quantiles, at_leans, at_fluxes] = {
            let [a, b, c, d, _] = ends;
            [a, a + b, a + b + c, a + b + c + d]
        };
        Ok(Self {
            gains: payload.cast(),
            values: payload.wrapping_add(at_values).cast(),
            quantiles: payload.wrapping_add(at_quantiles).cast(),
            leans: payload.wrapping_add(at_leans).cast(),
            fluxes: payload.wrapping_add(at_fluxes).cast(),
            gains_length: gains,
            values_length: values,
            quantiles_length: quantiles,
            leans_length: leans,
            fluxes_length: 4 * rows,
            ..*self
        })
    }
}
