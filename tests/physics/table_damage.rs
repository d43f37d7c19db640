//! Damaged tables: no bit of a file may be another, and what passes for a table gives no light that was never there.

use std::path::{Path, PathBuf};

use asperity::embedded::{EmbeddedTable, Rest, Values, of_bytes, read};
use asperity_core::bsdf::{Bsdf, Scatter};
use asperity_core::table::{Arrays, Header};

use crate::common::{Random, dir, incidence};

/// Largest weight of a sample whatever the numbers of a table, `core/src/table/sample.rs`.
const MOST_WEIGHT: f64 = 1e4;

fn example() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .with_file_name("host")
        .join("capi/examples/bsdf_example.bsdft")
}

#[test]
fn every_flipped_bit_of_a_file_is_refused() {
    let path = example();
    let bytes = std::fs::read(&path).unwrap();
    assert!(of_bytes(&path, &bytes).is_ok());
    let mut bad = bytes.clone();
    for bit in 0..8 * bytes.len() {
        bad[bit / 8] ^= 1 << (bit % 8);
        let found = of_bytes(&path, &bad);
        let Err(why) = found else { panic!("bit {} of byte {} is not seen", bit % 8, bit / 8) };
        if bit % 97 == 0 {
            assert!(why.to_string().lines().count() == 1, "{why}");
        }
        bad[bit / 8] ^= 1 << (bit % 8);
    }
    // two bits, and a byte of chance: the sum sees any burst of up to 32 bits
    let mut random = Random::new(8);
    for _ in 0..2000 {
        let at = random.between(0.0, bytes.len() as f64 - 4.0) as usize;
        let mut bad = bytes.clone();
        for byte in &mut bad[at..at + 4] {
            *byte = random.between(0.0, 256.0) as u8;
        }
        assert!(bad == bytes || of_bytes(&path, &bad).is_err(), "four bytes from {at}");
    }
}

/// The numbers and arrays of a table.
struct Parts {
    header: Header,
    values: Vec<u16>,
    rest: Rest,
}

impl Parts {
    fn of(table: &EmbeddedTable) -> Self {
        let Values::U16(values) = table.values().clone() else { panic!("16 bits") };
        let view = table.view(&values).unwrap();
        let mut rest = Rest::default();
        for side in
            [asperity_core::direction::Side::Air, asperity_core::direction::Side::Dielectric]
        {
            let side = view.side(side);
            for lobe in side.reflection.iter().chain(&side.transmission) {
                rest.gains.extend(lobe.gains);
                rest.quantiles.extend(lobe.quantiles);
                rest.leans.extend(lobe.leans);
            }
            rest.fluxes.extend(side.fluxes);
        }
        Self { header: *table.header(), values, rest }
    }

    /// Turns a bit of an array; `false` beyond the last.
    fn flip(&mut self, array: usize, bit: usize) -> bool {
        let turned: Option<()> = (|| {
            match array {
                0 => {
                    let gain = self.rest.gains.get_mut(bit / 32)?;
                    *gain = f32::from_bits(gain.to_bits() ^ (1 << (bit % 32)));
                }
                1 => *self.values.get_mut(bit / 16)? ^= 1 << (bit % 16),
                2 => *self.rest.quantiles.get_mut(bit / 16)? ^= 1 << (bit % 16),
                3 => {
                    let lean = self.rest.leans.get_mut(bit / 8)?;
                    *lean = (lean.cast_unsigned() ^ (1 << (bit % 8))).cast_signed();
                }
                4 => *self.rest.fluxes.get_mut(bit / 64)?.get_mut(bit / 16 % 4)? ^= 1 << (bit % 16),
                5 => {
                    let lobe = self.header.lobes.iter_mut().flatten().next()?;
                    let numbers = [&mut lobe.scale, &mut lobe.grazing, &mut lobe.masking];
                    let number = numbers.into_iter().nth(bit / 32)?;
                    *number = f32::from_bits(number.to_bits() ^ (1 << (bit % 32)));
                }
                _ => return None,
            }
            Some(())
        })();
        turned.is_some()
    }

    fn arrays(&self) -> Arrays<'_, u16> {
        let Rest { gains, quantiles, leans, fluxes } = &self.rest;
        Arrays { gains, values: &self.values, quantiles, leans, fluxes }
    }
}

/// Numbers that are damaged but have the checksum of what they are, or none: refused, or weights within a bound.
#[test]
fn flipped_bits_with_a_sum_of_their_own_give_no_huge_weight() {
    let (table, _) = read(&example()).unwrap();
    let mut parts = Parts::of(&table);
    let sound = table.checksum();
    let (mut taken, mut refused, mut most) = (0, 0, 0.0_f64);
    let mut random = Random::new(5);
    for array in 0..6 {
        // every bit of the few numbers, of the many some
        let step = if array == 1 { 23 } else { 5 };
        for bit in (0..).step_by(if array == 5 { 1 } else { step }) {
            if !parts.flip(array, bit) {
                break;
            }
            let arrays = parts.arrays();
            let sum = parts.header.checksum(&arrays);
            assert!(sum != sound, "array {array} bit {bit}");
            assert!(parts.header.verified(arrays, sound).is_err());
            match parts.header.verified(arrays, sum) {
                Err(_) => refused += 1,
                Ok(view) => {
                    taken += 1;
                    for deg in [0.0, 33.0, 71.0, 89.0] {
                        let wi = dir::<f32>(incidence(deg, true));
                        for _ in 0..8 {
                            let weight =
                                view.sample(wi, &mut || random.next()).map_or(0.0, |s| s.weight);
                            let value =
                                Bsdf::<f32>::ars(&view, wi, dir(incidence(180.0 + deg, true)));
                            assert!(weight >= 0.0 && value.is_finite(), "{array} {bit}");
                            most = most.max(f64::from(weight));
                        }
                    }
                }
            }
            parts.flip(array, bit);
        }
    }
    println!("{taken} taken, {refused} refused, largest weight {most:.1}");
    assert!(most <= MOST_WEIGHT && taken > 500 && refused > 100, "{most} {taken} {refused}");
}
