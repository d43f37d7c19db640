//! CRC-32C over the numbers and arrays of a table; against flipped bits in a flash or a file.
//!
//! Summed are, little-endian: `eta` and `slope` (f32), the bytes of a value, and 256 of an opaque body (u16); of each of the four lobes incidences, azimuths,
//! radii, intervals, form and fall (u16), scale, grazing and masking (f32), zeros for one left out; both numbers of fluxes (u16)
//! and their crowding (f32); then the arrays in the order of [`Arrays`], as they follow the first line of a `.bsdft` file.

use crc::{CRC_32_ISCSI, Crc, Digest, NoTable};

use super::error::TableError;
use super::header::{Arrays, Header, LobeHeader};
use super::storage::Storage;
use super::view::BsdfTableRef;

/// Bit by bit: a table of its own would take a device a kilobyte.
static CRC_32C: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISCSI);

/// A sum that grows.
struct Sum(Digest<'static, u32, NoTable>);

impl Sum {
    fn u16(&mut self, x: u16) {
        self.0.update(&x.to_le_bytes());
    }

    fn f32(&mut self, x: f32) {
        self.0.update(&x.to_le_bytes());
    }

    fn lobe(&mut self, lobe: Option<&LobeHeader>) {
        let (words, numbers) = lobe.map_or(([0; 6], [0.0; 3]), |lobe| {
            let shape = lobe.shape;
            let (form, fall) = (lobe.form.number(), lobe.fall.number());
            let nodes = [shape.incidences, shape.azimuths, shape.radii, shape.intervals];
            let [a, b, c, d] = nodes;
            ([a, b, c, d, form, fall], [lobe.scale, lobe.grazing, lobe.masking])
        });
        for x in words {
            self.u16(x);
        }
        for x in numbers {
            self.f32(x);
        }
    }
}

impl Header {
    /// The checksum of a table.
    pub fn checksum<S: Storage>(&self, arrays: &Arrays<'_, S>) -> u32 {
        let mut sum = Sum(CRC_32C.digest());
        sum.f32(self.eta.get());
        sum.f32(self.slope);
        sum.u16(S::BYTES as u16 | u16::from(self.opaque) << 8);
        self.lobes.iter().for_each(|lobe| sum.lobe(lobe.as_ref()));
        self.fluxes.iter().for_each(|n| sum.u16(*n));
        self.grazing.iter().for_each(|k| sum.f32(*k));
        arrays.gains.iter().for_each(|gain| sum.f32(*gain));
        for value in arrays.values {
            let bytes = value.little_endian();
            sum.0.update(bytes.get(..S::BYTES).unwrap_or(&bytes));
        }
        arrays.quantiles.iter().for_each(|q| sum.u16(*q));
        arrays.leans.iter().for_each(|lean| sum.0.update(&lean.to_le_bytes()));
        arrays.fluxes.iter().flatten().for_each(|flux| sum.u16(*flux));
        sum.0.finalize()
    }

    /// [`Self::table`] of arrays with a checksum.
    ///
    /// # Errors
    /// As [`Self::table`], and [`TableError::Checksum`] for another sum.
    pub fn verified<'a, S: Storage>(
        &self,
        arrays: Arrays<'a, S>,
        checksum: u32,
    ) -> Result<BsdfTableRef<'a, S>, TableError> {
        let table = self.table(arrays)?;
        if self.checksum(&arrays) == checksum { Ok(table) } else { Err(TableError::Checksum) }
    }
}
