//! A model written into the flash of the device's program, where firmware would keep it.
//!
//! The program `firmware-sim/src/bin/trade.rs` holds an empty slot that begins with four known words and the lengths of its
//! parts; the copy that is run has the model in them.

use asperity_core::bsdf::{Ggx, Normals};
use asperity_core::direction::Side;
use asperity_core::ndf::law::Profile;
use asperity_core::table::{BsdfTableRef, LobeTable, Storage};

use super::pairs::Pairs;
use crate::embedded::{EmbeddedTable, Values};

const MAGIC: [u32; 4] = [0x6173_7065, 0x7269_7479, 0x7472_6164, 0x6531_8d5f];
/// Words of the model's numbers, and where those of the first lobe begin; ten per lobe.
const WORDS: usize = 64;
const LOBES: usize = 16;
/// Bytes of an element of each part after the lengths: words, pairs, gains, fluxes, quantiles, leans, bytes, halves.
const ELEMENTS: [usize; 8] = [4, 24, 4, 8, 2, 1, 1, 2];

/// Why a model does not run on the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum Unfit {
    /// The file is no such program.
    #[error("is not the program `trade` of asperity-firmware-sim")]
    Program,
    /// An array is larger than its part.
    #[error("the table is larger than the program has room for")]
    Room,
}

/// The parts of a slot.
#[derive(Clone, Debug)]
pub(super) struct Payload {
    words: [u32; WORDS],
    /// Gains, fluxes, quantiles, leans, 8-bit and 16-bit values.
    arrays: [Vec<u8>; 6],
}

impl Payload {
    fn new(kind: u32) -> Self {
        let mut words = [0; WORDS];
        words[0] = kind;
        Self { words, arrays: Default::default() }
    }

    fn number(&mut self, at: usize, x: f64) {
        let bits = x.to_bits();
        self.words[at] = bits as u32;
        self.words[at + 1] = (bits >> 32) as u32;
    }

    pub(super) fn ggx(law: &Ggx<f64>) -> Self {
        let mut payload = Self::new(1);
        payload.number(2, law.eta.get());
        payload.number(4, law.alpha.get());
        payload
    }

    pub(super) fn normals(normals: &Normals<f64>) -> Self {
        let mut payload = Self::new(2);
        let law = normals.density.law();
        payload.words[1] = u32::from(law.profile() == Profile::Cauchy);
        for (k, x) in [normals.eta.get(), law.delta(), law.n(), law.centre()].iter().enumerate() {
            payload.number(2 + 2 * k, *x);
        }
        payload
    }

    /// `None` for a table whose values are floats: the program has no room for these.
    pub(super) fn table(table: &EmbeddedTable) -> Option<Self> {
        match table.values() {
            Values::U8(v) => {
                let view = table.view(v)?;
                Some(Self::of_view(3, table, &view, |v, arrays| arrays[4].push(v)))
            }
            Values::U16(v) => {
                let view = table.view(v)?;
                Some(Self::of_view(4, table, &view, |v, arrays| arrays[5].extend(v.to_le_bytes())))
            }
            Values::F32(_) => None,
        }
    }

    fn of_view<S: Storage>(
        kind: u32,
        table: &EmbeddedTable,
        view: &BsdfTableRef<'_, S>,
        keep: impl Fn(S, &mut [Vec<u8>; 6]),
    ) -> Self {
        let mut payload = Self::new(kind);
        let header = table.header();
        let [flux_air, flux_inside] = header.fluxes.map(u32::from);
        let [grazing_air, grazing_inside] = header.grazing.map(f32::to_bits);
        let (eta, slope) = (header.eta.get().to_bits(), header.slope.to_bits());
        payload.words[10..16].copy_from_slice(&[
            eta,
            slope,
            flux_air,
            flux_inside,
            grazing_air,
            grazing_inside,
        ]);
        let mut add = |at: usize, lobe: &LobeTable<'_, S>| {
            payload.words[at..at + 10].copy_from_slice(&lobe_words(lobe));
            let arrays = &mut payload.arrays;
            arrays[0].extend(lobe.gains.iter().flat_map(|x| x.to_le_bytes()));
            arrays[2].extend(lobe.quantiles.iter().flat_map(|x| x.to_le_bytes()));
            arrays[3].extend(lobe.leans.iter().flat_map(|x| x.to_le_bytes()));
            lobe.values.iter().for_each(|v| keep(*v, arrays));
        };
        for (k, side) in [Side::Air, Side::Dielectric].into_iter().enumerate() {
            let side = view.side(side);
            for (j, lobe) in [&side.reflection, &side.transmission].into_iter().enumerate() {
                if let Some(lobe) = lobe {
                    add(LOBES + 10 * (2 * k + j), lobe);
                }
            }
        }
        for side in [Side::Air, Side::Dielectric] {
            let rows = view.side(side).fluxes.iter().flatten();
            payload.arrays[1].extend(rows.flat_map(|x| x.to_le_bytes()));
        }
        payload
    }

    /// Whether a program has a slot.
    pub(super) fn fits(elf: &[u8]) -> bool {
        start(elf).is_some()
    }

    /// A copy of the program with the model in its slot.
    pub(super) fn in_program(&self, elf: &[u8], pairs: &Pairs) -> Result<Vec<u8>, Unfit> {
        let start = start(elf).ok_or(Unfit::Program)?;
        let lengths = elf.get(start..start + 32).ok_or(Unfit::Program)?.as_chunks::<4>().0;
        let words: Vec<u8> = self.words.iter().flat_map(|w| w.to_le_bytes()).collect();
        let pairs: Vec<u8> = pairs.0.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let parts = [&words, &pairs].into_iter().chain(&self.arrays);
        let mut program = elf.to_vec();
        let mut at = start + 32;
        for ((part, length), element) in parts.zip(lengths).zip(ELEMENTS) {
            let room = u32::from_le_bytes(*length) as usize * element;
            if part.len() > room {
                return Err(Unfit::Room);
            }
            let place = program.get_mut(at..at + part.len()).ok_or(Unfit::Program)?;
            place.copy_from_slice(part);
            at += room;
        }
        Ok(program)
    }
}

/// Where the lengths stand.
fn start(elf: &[u8]) -> Option<usize> {
    let magic: Vec<u8> = MAGIC.iter().flat_map(|w| w.to_le_bytes()).collect();
    elf.windows(magic.len()).position(|w| w == magic).map(|at| at + magic.len())
}

fn lobe_words<S>(lobe: &LobeTable<'_, S>) -> [u32; 10] {
    let shape = lobe.shape;
    let nodes = [shape.incidences, shape.azimuths, shape.radii, shape.intervals].map(u32::from);
    let [form, fall] = [lobe.form.number(), lobe.fall.number()].map(u32::from);
    let [a, b, c, d] = nodes;
    let [scale, grazing, masking] = [lobe.scale, lobe.grazing, lobe.masking].map(f32::to_bits);
    [1, a, b, c, d, form, fall, scale, grazing, masking]
}
