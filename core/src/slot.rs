//! Where a program for a device keeps a model that another program writes into it.
//!
//! `asperity trade` measures the user's own model on a device: it finds the [`Slot`] in the program's file by its first words,
//! fills a copy of it, and runs that. Host and device share this file, so neither knows the layout by heart. All numbers are
//! little-endian.

use crate::bsdf::{Ggx, Normals};
use crate::math::Real;
use crate::ndf::law::{Law, Profile};
use crate::ndf::normals::NormalDensity;
use crate::quantity::{Alpha, RelativeIor};
use crate::table::{Fall, Form, Header, LobeHeader, Shape};

/// Numbers of a [`Slot`]'s elements.
pub const WORDS: usize = 64;
/// Pairs of directions.
pub const PAIRS: usize = 256;
/// Gains of a table.
pub const GAINS: usize = 1024;
/// Rows of fluxes.
pub const FLUXES: usize = 256;
/// Quantiles.
pub const QUANTILES: usize = 4096;
/// Leans.
pub const LEANS: usize = 4096;
/// Values of 8 bits.
pub const BYTES: usize = 16 << 10;
/// Values of 16 bits.
pub const HALVES: usize = 32 << 10;

/// Directions from and to.
pub type Pair = [f32; 6];

/// A model, and what it is asked for.
#[derive(Clone, Debug)]
#[repr(C)]
pub struct Slot {
    /// By which it is found.
    pub magic: [u32; 4],
    /// Lengths of the parts that follow: those of another layout are another program's.
    pub lengths: [u32; 8],
    /// The numbers of the model.
    pub words: Words,
    /// Directions it is evaluated for.
    pub pairs: [Pair; PAIRS],
    /// Of a table: gains of all lobes.
    pub gains: [f32; GAINS],
    /// Fluxes of both sides.
    pub fluxes: [[u16; 4]; FLUXES],
    /// Of the samples.
    pub quantiles: [u16; QUANTILES],
    /// Of the samples.
    pub leans: [i8; LEANS],
    /// Values of 8 bits.
    pub bytes: [u8; BYTES],
    /// Values of 16 bits.
    pub halves: [u16; HALVES],
}

impl Slot {
    /// The first words.
    pub const MAGIC: [u32; 4] = [0x6173_7065, 0x7269_7479, 0x7472_6164, 0x6531_8d5f];
    /// The lengths of this layout.
    pub const LENGTHS: [u32; 8] = [
        WORDS as u32,
        PAIRS as u32,
        GAINS as u32,
        FLUXES as u32,
        QUANTILES as u32,
        LEANS as u32,
        BYTES as u32,
        HALVES as u32,
    ];

    /// A slot without a model.
    #[allow(clippy::large_stack_arrays, reason = "for a static, which lies in flash")]
    pub const EMPTY: Self = Self {
        magic: Self::MAGIC,
        lengths: Self::LENGTHS,
        words: Words([0; WORDS]),
        pairs: [[0.0; 6]; PAIRS],
        gains: [0.0; GAINS],
        fluxes: [[0; 4]; FLUXES],
        quantiles: [0; QUANTILES],
        leans: [0; LEANS],
        bytes: [0; BYTES],
        halves: [0; HALVES],
    };
}

/// What a slot holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Nothing.
    Empty,
    /// GGX facets.
    Ggx,
    /// Facets drawn from a law of angles.
    Normals,
    /// A table with values of 8 bits.
    TableOfBytes,
    /// A table with values of 16 bits.
    TableOfHalves,
}

impl Kind {
    const ALL: [Self; 5] =
        [Self::Empty, Self::Ggx, Self::Normals, Self::TableOfBytes, Self::TableOfHalves];
}

/// The numbers of a model in words.
///
/// Word 0 is the [`Kind`]. Of a law: word 1 the profile, then doubles of two words each: index and width, or index, `delta`, `n` and
/// `theta0`. Of a table: word 1 whether it is opaque, 10 to 15 index, slope, rows and crowding of fluxes, then ten words a lobe.
#[derive(Clone, Debug, PartialEq)]
#[repr(transparent)]
pub struct Words([u32; WORDS]);

/// The first double.
const DOUBLES: usize = 2;
/// Where the numbers of a table begin.
const TABLE: usize = 10;
/// Where those of its lobes begin, and how many each has.
const LOBES: usize = 16;
const LOBE: usize = 10;

impl Words {
    fn of(kind: Kind) -> Self {
        let mut words = Self([0; WORDS]);
        words.put(0, [kind as u32]);
        words
    }

    /// A law of GGX facets.
    pub fn of_ggx(law: &Ggx<f64>) -> Self {
        let mut words = Self::of(Kind::Ggx);
        words.put_doubles([law.eta.get(), law.alpha.get()]);
        words
    }

    /// Facets drawn from a law of angles.
    pub fn of_normals<const N: usize>(normals: &Normals<f64, N>) -> Self {
        let law = normals.density.law();
        let mut words = Self::of(Kind::Normals);
        words.put(1, [u32::from(law.profile() == Profile::Cauchy)]);
        words.put_doubles([normals.eta.get(), law.delta(), law.n(), law.centre()]);
        words
    }

    /// A table with values of one byte, or of two.
    pub fn of_table(header: &Header, halves: bool) -> Self {
        let kind = if halves { Kind::TableOfHalves } else { Kind::TableOfBytes };
        let mut words = Self::of(kind);
        words.put(1, [u32::from(header.opaque)]);
        let ([air, inside], [dense_air, dense_inside]) = (header.fluxes, header.grazing);
        let numbers = [header.eta.get(), header.slope].map(f32::to_bits);
        words.put(TABLE, numbers);
        words.put(TABLE + 2, [u32::from(air), u32::from(inside)]);
        words.put(TABLE + 4, [dense_air, dense_inside].map(f32::to_bits));
        for (k, lobe) in header.lobes.iter().enumerate() {
            if let Some(lobe) = lobe {
                words.put(LOBES + LOBE * k, of_lobe(lobe));
            }
        }
        words
    }

    /// The words themselves.
    pub fn as_slice(&self) -> &[u32] {
        &self.0
    }

    /// What they describe.
    pub fn kind(&self) -> Kind {
        let known = |kind: &Kind| self.get(0) == *kind as u32;
        Kind::ALL.into_iter().find(known).unwrap_or(Kind::Empty)
    }

    /// The law of GGX facets, its parameters rounded once; `None` if they are none.
    pub fn ggx<T: Real>(&self) -> Option<Ggx<T>> {
        let [eta, alpha] = [0, 1].map(|k| self.double(k));
        Some(Ggx::new(Alpha::new(alpha).ok()?, RelativeIor::new(eta).ok()?))
    }

    /// The law of facets drawn from angles, its parameters rounded once; `None` if they are none.
    pub fn normals<T: Real, const N: usize>(&self) -> Option<Normals<T, N>> {
        let [eta, delta, n, centre] = [0, 1, 2, 3].map(|k| self.double(k));
        let profile = if self.get(1) == 0 { Profile::Gauss } else { Profile::Cauchy };
        let law = Law::new(profile, delta, n, centre).ok()?;
        Some(Normals::new(NormalDensity::new(law), RelativeIor::new(eta).ok()?))
    }

    /// The header of the table; `None` if it is none.
    pub fn table(&self) -> Option<Header> {
        let real = |at: usize| f32::from_bits(self.get(at));
        Some(Header {
            eta: RelativeIor::new(real(TABLE)).ok()?,
            opaque: self.get(1) != 0,
            slope: real(TABLE + 1),
            lobes: [0, 1, 2, 3].map(|k| self.lobe(LOBES + LOBE * k)),
            fluxes: [TABLE + 2, TABLE + 3].map(|at| self.get(at) as u16),
            grazing: [TABLE + 4, TABLE + 5].map(real),
        })
    }

    fn lobe(&self, at: usize) -> Option<LobeHeader> {
        let half = |k: usize| self.get(at + k) as u16;
        let shape =
            Shape { incidences: half(1), azimuths: half(2), radii: half(3), intervals: half(4) };
        let (form, fall) = (Form::of_number(half(5))?, Fall::of_number(half(6))?);
        let [scale, grazing, masking] = [7, 8, 9].map(|k| f32::from_bits(self.get(at + k)));
        (self.get(at) == 1).then_some(LobeHeader { shape, form, fall, scale, grazing, masking })
    }

    fn get(&self, at: usize) -> u32 {
        self.0.get(at).copied().unwrap_or(0)
    }

    fn double<T: Real>(&self, k: usize) -> T {
        let [low, high] = [0, 1].map(|half| u64::from(self.get(DOUBLES + 2 * k + half)));
        T::from_f64(f64::from_bits(high << 32 | low))
    }

    fn put<const N: usize>(&mut self, at: usize, words: [u32; N]) {
        for (to, word) in self.0.iter_mut().skip(at).zip(words) {
            *to = word;
        }
    }

    fn put_doubles<const N: usize>(&mut self, numbers: [f64; N]) {
        for (k, x) in numbers.into_iter().enumerate() {
            let bits = x.to_bits();
            self.put(DOUBLES + 2 * k, [bits as u32, (bits >> 32) as u32]);
        }
    }
}

fn of_lobe(lobe: &LobeHeader) -> [u32; LOBE] {
    let Shape { incidences, azimuths, radii, intervals } = lobe.shape;
    let [a, b, c, d] = [incidences, azimuths, radii, intervals].map(u32::from);
    let [form, fall] = [lobe.form.number(), lobe.fall.number()].map(u32::from);
    let [scale, grazing, masking] = [lobe.scale, lobe.grazing, lobe.masking].map(f32::to_bits);
    [1, a, b, c, d, form, fall, scale, grazing, masking]
}

#[cfg(test)]
mod tests {
    use super::{Kind, Slot, WORDS, Words};
    use crate::bsdf::{Ggx, Normals};
    use crate::ndf::law::{Law, Profile};
    use crate::ndf::normals::NormalDensity;
    use crate::quantity::{Alpha, RelativeIor};
    use crate::table::{Fall, Form, Header, LobeHeader, Shape};

    fn eta() -> RelativeIor<f64> {
        RelativeIor::new(1.49).unwrap()
    }

    #[test]
    fn a_law_comes_back_bit_by_bit() {
        let ggx = Ggx::new(Alpha::new(0.23).unwrap(), eta());
        let words = Words::of_ggx(&ggx);
        assert_eq!((words.kind(), words.ggx::<f64>()), (Kind::Ggx, Some(ggx)));
        let narrow = words.ggx::<f32>().unwrap();
        assert_eq!(narrow.alpha.get().to_bits(), 0.23_f32.to_bits());
        for profile in [Profile::Gauss, Profile::Cauchy] {
            let law = Law::new(profile, 0.1, 2.5, 0.02).unwrap();
            let normals: Normals<f64, 64> = Normals::new(NormalDensity::new(law), eta());
            let words = Words::of_normals(&normals);
            assert_eq!((words.kind(), words.normals()), (Kind::Normals, Some(normals)));
        }
    }

    #[test]
    fn the_header_of_a_table_comes_back() {
        let shape = Shape { incidences: 9, azimuths: 3, radii: 38, intervals: 8 };
        let (form, fall) = (Form::Drawn, Fall::Second);
        let lobe = LobeHeader { shape, form, fall, scale: 0.25, grazing: -0.5, masking: 0.125 };
        let header = Header {
            eta: RelativeIor::new(1.49).unwrap(),
            opaque: false,
            slope: 0.3,
            lobes: [Some(lobe), None, Some(LobeHeader { form: Form::Direct, ..lobe }), Some(lobe)],
            fluxes: [25, 65],
            grazing: [0.5, -0.25],
        };
        for (header, halves) in [(header, false), (Header { opaque: true, ..header }, true)] {
            let words = Words::of_table(&header, halves);
            let kind = if halves { Kind::TableOfHalves } else { Kind::TableOfBytes };
            assert_eq!((words.kind(), words.table()), (kind, Some(header)));
        }
    }

    #[test]
    fn an_empty_slot_and_wild_words_are_no_model() {
        assert_eq!(Slot::EMPTY.words.kind(), Kind::Empty);
        assert_eq!(Words([u32::MAX; WORDS]).kind(), Kind::Empty);
        let empty = Words([0; WORDS]);
        assert!(empty.ggx::<f64>().is_none() && empty.normals::<f32, 64>().is_none());
        assert!(empty.table().is_none());
    }
}
