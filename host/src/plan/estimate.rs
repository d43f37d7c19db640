//! A quantity of a scene by many paths, and how other laws would change it.
//!
//! Paths are drawn with the full law. Another law would have sent each of them with another weight: the product of the ratios of
//! the two laws over the hits of the path. So one set of paths tells the quantity of every law, and its error with next to none of
//! the noise of the paths. The light of a path is kept by the set of lobes it met, which tells the same of every choice of lobes.

use asperity_core::bsdf::LobeSet;

use crate::parallel;

use super::detect::{MOST_PARTS, Parts};
use super::numbers::Numbers;
use super::paths::{Pair, Setting, Sink};
use super::rough::{Rough, lobe_of};

/// Paths of a batch: a unit of work, and of the scatter that errors come from.
const BATCH: u64 = 64;
/// Classes of incidence of the weights: 5 degrees each.
pub(super) const CLASSES: usize = 18;

/// Which lobes light may meet: the number of a set of four.
pub(super) const SETS: usize = 16;

/// What paths tell of a law.
#[derive(Clone, Debug)]
pub(super) struct Told {
    /// Sums of the parts by the set of lobes that was met, per path.
    by_lobes: [Parts; SETS],
    /// Errors of the total, each part, standard deviations per path of the difference from the full law.
    variance: Parts,
}

/// What paths tell.
#[derive(Clone, Debug)]
pub(super) struct Estimate {
    /// Of the full law.
    pub(super) full: Parts,
    /// Of the others, in their order.
    others: Vec<Told>,
    /// The full law by lobes.
    own: [Parts; SETS],
    /// Share of the quantity whose light met a lobe in a class of incidence; a path that met it twice counts twice.
    pub(super) weights: [[f64; CLASSES]; 4],
}

/// Sums over paths.
#[derive(Clone, Debug)]
struct Sums {
    own: [Parts; SETS],
    others: Vec<[Parts; SETS]>,
    /// Squares of the batches of the differences from the full law.
    differences: Vec<Parts>,
    weights: [[f64; CLASSES]; 4],
}

/// Where one path adds up.
struct Adder<'a> {
    full: &'a dyn Rough,
    others: &'a [&'a dyn Rough],
    sums: &'a mut Sums,
    met: usize,
    ratios: Vec<f64>,
    classes: Vec<(usize, usize)>,
}

/// The number of a set.
pub(super) fn number(lobes: LobeSet) -> usize {
    let bit = |(k, (side, lobe))| usize::from(lobes.contains(LobeSet::of(side, lobe))) << k;
    LobeSet::ORDER.into_iter().enumerate().map(bit).sum()
}

/// The class of incidence of a direction.
fn class(w: asperity_core::direction::Direction<f64>) -> usize {
    let deg = w.z().abs().min(1.0).acos().to_degrees();
    ((deg / 5.0) as usize).min(CLASSES - 1)
}

impl Adder<'_> {
    fn ratio(&self, k: usize, (wi, wo): Pair, full: f64) -> f64 {
        let other = self.others[k].ars(wi, wo);
        if full > 0.0 && other.is_finite() { other / full } else { 1.0 }
    }
}

impl Sink for Adder<'_> {
    fn meet(&mut self, pair: Pair) {
        let full = self.full.ars(pair.0, pair.1);
        for k in 0..self.others.len() {
            self.ratios[k] *= self.ratio(k, pair, full);
        }
        let bits = number(lobe_of(pair.0, pair.1));
        self.met |= bits;
        if bits > 0 {
            self.classes.push((bits.trailing_zeros() as usize, class(pair.0)));
        }
    }

    fn count(&mut self, part: usize, light: f64, last: Option<Pair>) {
        let bits = last.map_or(0, |(wi, wo)| number(lobe_of(wi, wo)));
        let met = self.met | bits;
        self.sums.own[met][part] += light;
        let full = last.map_or(0.0, |(wi, wo)| self.full.ars(wi, wo));
        for k in 0..self.others.len() {
            let ratio = self.ratios[k] * last.map_or(1.0, |pair| self.ratio(k, pair, full));
            self.sums.others[k][met][part] += light * ratio;
        }
        let own =
            last.filter(|_| bits > 0).map(|(wi, _)| (bits.trailing_zeros() as usize, class(wi)));
        for (lobe, class) in self.classes.iter().copied().chain(own) {
            self.sums.weights[lobe][class] += light;
        }
    }
}

impl Sums {
    fn empty(others: usize) -> Self {
        Self {
            own: [[0.0; MOST_PARTS]; SETS],
            others: vec![[[0.0; MOST_PARTS]; SETS]; others],
            differences: vec![[0.0; MOST_PARTS]; others],
            weights: [[0.0; CLASSES]; 4],
        }
    }

    /// The squares of a batch of so many paths.
    fn closed(mut self, count: f64) -> Self {
        let own = total(&self.own, SETS - 1);
        for (others, squares) in self.others.iter().zip(&mut self.differences) {
            let other = total(others, SETS - 1);
            for ((square, a), b) in squares.iter_mut().zip(own).zip(other) {
                *square = (b - a) * (b - a) / count;
            }
        }
        self
    }

    fn add(&mut self, more: &Self) {
        let sum = |to: &mut [f64], from: &[f64]| to.iter_mut().zip(from).for_each(|(a, b)| *a += b);
        let tables = std::iter::once((&mut self.own, &more.own));
        for (to, from) in tables.chain(self.others.iter_mut().zip(&more.others)) {
            to.iter_mut().zip(from).for_each(|(a, b)| sum(a, b));
        }
        self.differences.iter_mut().zip(&more.differences).for_each(|(a, b)| sum(a, b));
        self.weights.iter_mut().zip(&more.weights).for_each(|(a, b)| sum(a, b));
    }
}

/// Sums over the sets within a set of lobes.
fn total(by_lobes: &[Parts; SETS], kept: usize) -> Parts {
    let mut sums = [0.0; MOST_PARTS];
    for (set, parts) in by_lobes.iter().enumerate() {
        if set & !kept == 0 {
            sums.iter_mut().zip(parts).for_each(|(a, b)| *a += b);
        }
    }
    sums
}

/// Follows paths with the full law, and weighs them for others. The same for any number of threads.
pub(super) fn estimate(
    setting: &Setting,
    full: &dyn Rough,
    others: &[&dyn Rough],
    (paths, seed): (u64, u64),
) -> Estimate {
    let batches = paths.div_ceil(BATCH).max(2);
    let batch = |number: usize| {
        let number = number as u64;
        let mut sums = Sums::empty(others.len());
        for path in number * BATCH..(number + 1) * BATCH {
            let ratios = vec![1.0; others.len()];
            let mut adder =
                Adder { full, others, sums: &mut sums, met: 0, ratios, classes: Vec::new() };
            setting.follow(full, Numbers::of(path, seed), &mut adder);
        }
        sums.closed(BATCH as f64)
    };
    let all = parallel::map(batches as usize, &batch);
    let mut sums = Sums::empty(others.len());
    for one in &all {
        sums.add(one);
    }
    let count = (batches * BATCH) as f64;
    let scaled = |by: &[Parts; SETS]| by.map(|parts| parts.map(|x| x / count));
    let variance = |squares: &Parts, total: Parts| {
        let mut of = [0.0; MOST_PARTS];
        for ((v, square), mean) in of.iter_mut().zip(squares).zip(total) {
            *v = ((square / count - mean * mean).max(0.0) / count).sqrt();
        }
        of
    };
    let own = scaled(&sums.own);
    let full = total(&own, SETS - 1);
    let told = sums.others.iter().zip(&sums.differences).map(|(other, squares)| {
        let by_lobes = scaled(other);
        let mut off = total(&by_lobes, SETS - 1);
        off.iter_mut().zip(full).for_each(|(a, b)| *a -= b);
        Told { by_lobes, variance: variance(squares, off) }
    });
    let all_light: f64 = full.iter().sum::<f64>() * count;
    Estimate {
        full,
        others: told.collect(),
        own,
        weights: sums
            .weights
            .map(|lobe| lobe.map(|x| if all_light > 0.0 { x / all_light } else { 0.0 })),
    }
}

impl Estimate {
    /// The quantity's sums with another law, or with the full one (`None`), if only some lobes are kept.
    pub(super) fn sums(&self, law: Option<usize>, kept: LobeSet) -> Parts {
        match law {
            None => total(&self.own, number(kept)),
            Some(k) => total(&self.others[k].by_lobes, number(kept)),
        }
    }

    /// Standard error of the first part's difference of another law from the full one.
    pub(super) fn spread(&self, law: usize) -> f64 {
        self.others[law].variance[0]
    }
}
