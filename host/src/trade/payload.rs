//! A model written into the flash of the device's program, where firmware would keep it.
//!
//! The program `firmware-sim/src/bin/trade.rs` holds an empty [`Slot`]; the copy that is run has the model in it.

use std::mem::offset_of;

use asperity_core::bsdf::{Ggx, Normals};
use asperity_core::slot::{self, Slot, Words};

use super::pairs::Pairs;
use crate::embedded::{EmbeddedTable, Rest, Values};

/// Why a model does not run on the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum Unfit {
    /// The file is no such program.
    #[error("is not the program `trade` of asperity-firmware-sim")]
    Program,
    /// The program's slot is laid out in another way.
    #[error("is the program `trade` of another version of asperity-firmware-sim")]
    Version,
    /// An array is larger than its part.
    #[error("the table is larger than the program has room for")]
    Room,
}

/// A model as it stands in a slot.
#[derive(Clone, Debug)]
pub(super) struct Payload {
    words: Words,
    /// Of a table.
    arrays: Option<Arrays>,
}

/// The arrays of a table; its values are of one kind.
#[derive(Clone, Debug)]
struct Arrays {
    rest: Rest,
    bytes: Vec<u8>,
    halves: Vec<u16>,
}

impl Payload {
    pub(super) fn ggx(law: &Ggx<f64>) -> Self {
        Self { words: Words::of_ggx(law), arrays: None }
    }

    pub(super) fn normals(normals: &Normals<f64>) -> Self {
        Self { words: Words::of_normals(normals), arrays: None }
    }

    /// `None` for a table whose values are floats: the program has no room for these.
    pub(super) fn table(table: &EmbeddedTable) -> Option<Self> {
        let (bytes, halves) = match table.values() {
            Values::U8(v) => (v.clone(), Vec::new()),
            Values::U16(v) => (Vec::new(), v.clone()),
            Values::F32(_) => return None,
        };
        let words = Words::of_table(table.header(), bytes.is_empty());
        Some(Self { words, arrays: Some(Arrays { rest: table.rest(), bytes, halves }) })
    }

    /// Whether a program has a slot of this layout.
    pub(super) fn fits(elf: &[u8]) -> Result<(), Unfit> {
        start(elf).map(drop)
    }

    /// A copy of the program with the model in its slot.
    pub(super) fn in_program(&self, elf: &[u8], pairs: &Pairs) -> Result<Vec<u8>, Unfit> {
        let start = start(elf)?;
        let mut program = elf.to_vec();
        let slot = program.get_mut(start..).ok_or(Unfit::Program)?;
        let words = self.words.as_slice().iter().flat_map(|w| w.to_le_bytes());
        put(slot, offset_of!(Slot, words), 4 * slot::WORDS, words)?;
        let numbers = pairs.0.iter().flatten().flat_map(|x| x.to_le_bytes());
        put(slot, offset_of!(Slot, pairs), 24 * slot::PAIRS, numbers)?;
        if let Some(arrays) = &self.arrays {
            arrays.put(slot)?;
        }
        Ok(program)
    }
}

impl Arrays {
    fn put(&self, slot: &mut [u8]) -> Result<(), Unfit> {
        let Self { rest: Rest { gains, quantiles, leans, fluxes }, bytes, halves } = self;
        let gains = gains.iter().flat_map(|x| x.to_le_bytes());
        put(slot, offset_of!(Slot, gains), 4 * slot::GAINS, gains)?;
        let fluxes = fluxes.iter().flatten().flat_map(|x| x.to_le_bytes());
        put(slot, offset_of!(Slot, fluxes), 8 * slot::FLUXES, fluxes)?;
        let quantiles = quantiles.iter().flat_map(|x| x.to_le_bytes());
        put(slot, offset_of!(Slot, quantiles), 2 * slot::QUANTILES, quantiles)?;
        let leans = leans.iter().map(|x| x.cast_unsigned());
        put(slot, offset_of!(Slot, leans), slot::LEANS, leans)?;
        put(slot, offset_of!(Slot, bytes), slot::BYTES, bytes.iter().copied())?;
        let halves = halves.iter().flat_map(|x| x.to_le_bytes());
        put(slot, offset_of!(Slot, halves), 2 * slot::HALVES, halves)
    }
}

/// Writes a part of a slot that has `room` bytes.
fn put(
    slot: &mut [u8],
    at: usize,
    room: usize,
    bytes: impl Iterator<Item = u8>,
) -> Result<(), Unfit> {
    let bytes: Vec<u8> = bytes.collect();
    if bytes.len() > room {
        return Err(Unfit::Room);
    }
    slot.get_mut(at..at + bytes.len()).ok_or(Unfit::Program)?.copy_from_slice(&bytes);
    Ok(())
}

/// Where the slot begins in a program.
fn start(elf: &[u8]) -> Result<usize, Unfit> {
    let bytes = |words: &[u32]| words.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<u8>>();
    let (magic, lengths) = (bytes(&Slot::MAGIC), bytes(&Slot::LENGTHS));
    let found = elf.windows(magic.len()).position(|w| w == magic).ok_or(Unfit::Program)?;
    let layout = elf.get(found + offset_of!(Slot, lengths)..).unwrap_or(&[]);
    if layout.starts_with(&lengths) { Ok(found) } else { Err(Unfit::Version) }
}

#[cfg(test)]
mod tests {
    use asperity_core::bsdf::Ggx;
    use asperity_core::quantity::{Alpha, RelativeIor};
    use asperity_core::slot::Slot;

    use super::{Payload, Unfit};
    use crate::trade::pairs::Pairs;

    /// A file with an empty slot after some bytes, as the linker writes it.
    fn program(lengths: [u32; 8]) -> Vec<u8> {
        let head = Slot::MAGIC.into_iter().chain(lengths).flat_map(u32::to_le_bytes);
        let mut file: Vec<u8> = b"\x7fELF........".iter().copied().chain(head).collect();
        file.resize(12 + size_of::<Slot>(), 0);
        file
    }

    #[test]
    fn a_model_is_written_where_the_slot_has_it() {
        let law = Ggx::new(Alpha::new(0.2).unwrap(), RelativeIor::new(1.49).unwrap());
        let (file, pairs) = (program(Slot::LENGTHS), Pairs::of(&law, false));
        let filled = Payload::ggx(&law).in_program(&file, &pairs).unwrap();
        assert_eq!(filled.len(), file.len());
        let word = |k: usize| u32::from_le_bytes(*filled[60 + 4 * k..].first_chunk().unwrap());
        assert_eq!(word(0), 1);
        let double = |k| f64::from_bits(u64::from(word(k)) | u64::from(word(k + 1)) << 32);
        assert_eq!([double(2), double(4)].map(f64::to_bits), [1.49, 0.2].map(f64::to_bits));
        let first = f32::from_bits(word(64));
        assert_eq!(first.to_bits(), pairs.0[0][0].to_bits());
    }

    #[test]
    fn another_program_and_another_layout_are_told_apart() {
        assert_eq!(Payload::fits(&program(Slot::LENGTHS)), Ok(()));
        assert_eq!(Payload::fits(b"#!/bin/sh\n"), Err(Unfit::Program));
        let mut lengths = Slot::LENGTHS;
        lengths[3] += 1;
        assert_eq!(Payload::fits(&program(lengths)), Err(Unfit::Version));
    }
}
