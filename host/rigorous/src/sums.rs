//! Means over profiles of which some are solved rigorously and the rest by the approximations alone, and their noise.
//!
//! Few profiles scatter a speckled curve, and so do the same profiles in Kirchhoff's approximation: with n profiles solved and N of
//! either kind the rigorous mean is `mean_n(rigorous - b Kirchhoff) + b mean_N(Kirchhoff)`, a control variate, b by least squares over the profiles and
//! angles of a lobe. Without further profiles it is the plain mean. Noise is that of the jackknife, which leaves out one block of profiles after the
//! other: neighbours on a map know of each other. Blocks with solved profiles and those without are two strata.

use std::collections::BTreeMap;

use num_complex::Complex64;

/// What one profile sends into one lobe, by one method.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Record {
    /// Power per degree at each angle.
    pub(crate) curve: Vec<f64>,
    /// The curve of unit power in the specular order; empty for rays.
    pub(crate) cell: Vec<f64>,
    /// All of it.
    pub(crate) total: f64,
    /// Amplitude of the specular order, TE and TM.
    pub(crate) specular: [Complex64; 2],
}

/// One profile in one lobe.
#[derive(Clone, Debug)]
pub(crate) struct Sample {
    /// Which profiles it belongs with.
    pub(crate) block: usize,
    /// Of a profile that is solved.
    pub(crate) rigorous: Option<Record>,
    /// Kirchhoff, rays, facets.
    pub(crate) approximations: [Record; 3],
}

/// Means of one method.
#[derive(Clone, Debug)]
pub(crate) struct Means {
    pub(crate) curve: Vec<f64>,
    /// The curve without the coherent light.
    pub(crate) diffuse: Vec<f64>,
    pub(crate) total: f64,
    pub(crate) coherent: f64,
    specular: [Complex64; 2],
}

/// The rigorous means, and those of Kirchhoff, rays and facets.
#[derive(Clone, Debug)]
pub(crate) struct Estimate {
    pub(crate) rigorous: Means,
    pub(crate) approximations: [Means; 3],
}

/// Estimates from all profiles, and from all but one block.
#[derive(Debug)]
pub(crate) struct Estimates {
    pub(crate) all: Estimate,
    /// One block with solved profiles left out.
    but_solved: Vec<Estimate>,
    /// One of the other blocks left out.
    but_other: Vec<Estimate>,
}

impl Record {
    fn add(&mut self, other: &Self, times: f64) {
        let add = |a: &mut Vec<f64>, b: &[f64]| {
            a.resize(a.len().max(b.len()), 0.0);
            a.iter_mut().zip(b).for_each(|(a, b)| *a += times * b);
        };
        add(&mut self.curve, &other.curve);
        add(&mut self.cell, &other.cell);
        self.total += times * other.total;
        self.specular.iter_mut().zip(other.specular).for_each(|(a, b)| *a += times * b);
    }

    fn zero() -> Self {
        Self { curve: vec![], cell: vec![], total: 0.0, specular: [Complex64::ZERO; 2] }
    }
}

/// Sums over profiles.
#[derive(Clone, Debug)]
struct Sums {
    solved: f64,
    all: f64,
    rigorous: Record,
    /// Kirchhoff of the solved ones.
    variate: Record,
    approximations: [Record; 3],
}

impl Sums {
    fn of(samples: &[Sample]) -> Self {
        let zero = Record::zero;
        let mut sums = Self {
            solved: 0.0,
            all: 0.0,
            rigorous: zero(),
            variate: zero(),
            approximations: [zero(), zero(), zero()],
        };
        for sample in samples {
            sums.add(sample, 1.0);
        }
        sums
    }

    fn add(&mut self, sample: &Sample, times: f64) {
        self.all += times;
        for (sum, record) in self.approximations.iter_mut().zip(&sample.approximations) {
            sum.add(record, times);
        }
        if let Some(rigorous) = &sample.rigorous {
            self.solved += times;
            self.rigorous.add(rigorous, times);
            self.variate.add(&sample.approximations[0], times);
        }
    }

    fn but(&self, block: &[&Sample]) -> Self {
        let mut rest = self.clone();
        for sample in block {
            rest.add(sample, -1.0);
        }
        rest
    }

    fn estimate(&self, variate: &Variate) -> Estimate {
        let [mut rigorous, of_solved] =
            [&self.rigorous, &self.variate].map(|sum| scaled(sum, 1.0 / self.solved));
        let all = self.approximations.each_ref().map(|sum| scaled(sum, 1.0 / self.all));
        let mut change = all[0].clone();
        change.add(&of_solved, -1.0);
        let specular = rigorous.specular;
        rigorous.add(&change, variate.power);
        rigorous.cell = of_solved.cell;
        rigorous.specular = [0, 1].map(|p| specular[p] + variate.amplitude[p] * change.specular[p]);
        let means = |record: &Record, chance| {
            let coherent = variate.coherent(record.specular) - chance;
            let cell = record.cell.iter().copied().chain(std::iter::repeat(0.0));
            let diffuse = record.curve.iter().zip(cell).map(|(all, cell)| all - coherent * cell);
            Means {
                curve: record.curve.clone(),
                diffuse: diffuse.collect(),
                total: record.total,
                coherent,
                specular: record.specular,
            }
        };
        let [kirchhoff, rays, facets] = &all;
        Estimate {
            rigorous: means(&rigorous, variate.chance[0]),
            approximations: [
                means(kirchhoff, variate.chance[1]),
                means(rays, 0.0),
                means(facets, 0.0),
            ],
        }
    }
}

fn scaled(record: &Record, times: f64) -> Record {
    let mut scaled = Record::zero();
    scaled.add(record, times);
    scaled
}

/// How the rigorous light follows that of Kirchhoff from profile to profile.
#[derive(Debug)]
struct Variate {
    /// Of powers.
    power: f64,
    /// Of the amplitude of the specular order, TE and TM.
    amplitude: [Complex64; 2],
    /// Power that chance gives to mean amplitudes, rigorous and Kirchhoff.
    chance: [f64; 2],
    /// Shares of TE and TM.
    shares: [f64; 2],
}

impl Variate {
    fn coherent(&self, specular: [Complex64; 2]) -> f64 {
        specular.iter().zip(self.shares).map(|(a, share)| share * a.norm_sqr()).sum()
    }

    fn of(samples: &[Sample], sums: &Sums, shares: [f64; 2]) -> Self {
        let solved =
            || samples.iter().filter_map(|s| Some((s.rigorous.as_ref()?, &s.approximations[0])));
        let (mut both, mut square) = (0.0, 0.0);
        for (rigorous, kirchhoff) in solved() {
            for (angle, (x, k)) in rigorous.curve.iter().zip(&kirchhoff.curve).enumerate() {
                let k = k - sums.variate.curve[angle] / sums.solved;
                both += k * (x - sums.rigorous.curve[angle] / sums.solved);
                square += k * k;
            }
        }
        let power = if square > 0.0 { (both / square).clamp(0.0, 1.5) } else { 0.0 };
        let mut variate = Self { power, amplitude: [Complex64::ZERO; 2], chance: [0.0; 2], shares };
        for p in 0..2 {
            let mean = sums.rigorous.specular[p] / sums.solved;
            let of_solved = sums.variate.specular[p] / sums.solved;
            let (mut both, mut square) = (Complex64::ZERO, 0.0);
            for (x, k) in solved() {
                both += (k.specular[p] - of_solved).conj() * (x.specular[p] - mean);
                square += (k.specular[p] - of_solved).norm_sqr();
            }
            let c = if square > 0.0 { both / square } else { Complex64::ZERO };
            variate.amplitude[p] = c;
        }
        variate
    }
}

impl Estimates {
    /// Of profiles of which some are solved, in at least two blocks; `shares` of TE and TM.
    pub(crate) fn of(samples: &[Sample], shares: [f64; 2]) -> Self {
        let sums = Sums::of(samples);
        let mut blocks: BTreeMap<usize, Vec<&Sample>> = BTreeMap::new();
        for sample in samples {
            blocks.entry(sample.block).or_default().push(sample);
        }
        let mut variate = Variate::of(samples, &sums, shares);
        let estimates = |variate: &Variate| {
            let but = |is_solved: bool| {
                let blocks = blocks
                    .values()
                    .filter(|block| block.iter().any(|s| s.rigorous.is_some()) == is_solved);
                blocks.map(|block| sums.but(block).estimate(variate)).collect()
            };
            Self { all: sums.estimate(variate), but_solved: but(true), but_other: but(false) }
        };
        variate.chance = estimates(&variate).chance(shares);
        estimates(&variate)
    }

    /// The power that noise gives to mean amplitudes, rigorous and Kirchhoff.
    fn chance(&self, shares: [f64; 2]) -> [f64; 2] {
        let of = |amplitude: &dyn Fn(&Estimate) -> [Complex64; 2]| {
            let of = |p: usize| {
                self.variance(|e| amplitude(e)[p].re) + self.variance(|e| amplitude(e)[p].im)
            };
            shares[0] * of(0) + shares[1] * of(1)
        };
        [of(&|e| e.rigorous.specular), of(&|e| e.approximations[0].specular)]
    }

    /// The variance of a figure.
    pub(crate) fn variance(&self, figure: impl Fn(&Estimate) -> f64) -> f64 {
        let of = |left_out: &[Estimate]| jackknife(left_out.iter().map(&figure));
        of(&self.but_solved) + of(&self.but_other)
    }

    /// The mean square over the angles of a difference of curves: without its noise, the noise, and the standard
    /// error of the former.
    pub(crate) fn mean_square(&self, difference: impl Fn(&Estimate) -> Vec<f64>) -> [f64; 3] {
        let all = difference(&self.all);
        let raw = |curve: &[f64]| curve.iter().map(|d| d * d).sum::<f64>() / curve.len() as f64;
        let mut noise = vec![0.0; all.len()];
        let mut variance = 0.0;
        for left_out in [&self.but_solved, &self.but_other] {
            let curves: Vec<Vec<f64>> = left_out.iter().map(&difference).collect();
            for (i, noise) in noise.iter_mut().enumerate() {
                *noise += jackknife(curves.iter().map(|curve| curve[i]));
            }
            variance += jackknife(curves.iter().map(|curve| raw(curve)));
        }
        let noise = noise.iter().sum::<f64>() / noise.len() as f64;
        [raw(&all) - noise, noise, variance.sqrt()]
    }
}

/// The variance of a figure from its values without each of the profiles.
fn jackknife(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count() as f64;
    if count < 2.0 {
        return 0.0;
    }
    let mean = values.clone().sum::<f64>() / count;
    values.map(|x| (x - mean).powi(2)).sum::<f64>() * (count - 1.0) / count
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::{Estimates, Record, Sample};

    fn record(power: f64) -> Record {
        let specular = [Complex64::new(power, 0.0); 2];
        Record { curve: vec![power; 4], cell: vec![0.0; 4], total: power, specular }
    }

    /// What the rigorous light shares with Kirchhoff's is known from all profiles.
    #[test]
    fn the_variate_takes_the_common_noise_away() {
        let sample = |at: usize| {
            let common = ((at * 7919 % 97) as f64 / 97.0 - 0.5) * 0.4;
            let own = ((at * 104729 % 89) as f64 / 89.0 - 0.5) * 0.002;
            let zero = || record(0.0);
            Sample {
                block: at,
                rigorous: (at < 10).then(|| record(1.0 + common + own)),
                approximations: [record(0.8 + common), zero(), zero()],
            }
        };
        let samples: Vec<Sample> = (0..300).map(sample).collect();
        let estimates = Estimates::of(&samples, [0.5, 0.5]);
        let plain = Estimates::of(&samples[..10], [0.5, 0.5]);
        let error = |e: &Estimates| e.variance(|e| e.rigorous.total).sqrt();
        assert!(error(&estimates) < 0.3 * error(&plain));
        assert!((estimates.all.rigorous.total - 1.0).abs() < 0.02);
        let off = |e: &super::Estimate| {
            let pairs = e.rigorous.curve.iter().zip(&e.approximations[0].curve);
            pairs.map(|(a, b)| a - b).collect()
        };
        let [square, noise, error] = estimates.mean_square(off);
        assert!((square.sqrt() - 0.2).abs() < 0.002 && noise < 1e-5 && error < 1e-2);
    }
}
