//! Means of a law over pairs of patches.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use super::basis::{BASES, Known, Piece, pieces};
use super::{incidences, places};
use crate::error::CannotHold;
use crate::formats::window::Ring;
use crate::frame::{around, specular};
use crate::interpolation::Interpolation;
use crate::law::{Law, Options, Subject};
use crate::patches::{Seen, Span, full_width, mean};
use crate::sampled::{SampledBsdf, Symmetry};

pub(super) fn sample(
    known: &Known,
    law: &dyn Law,
    subject: &Subject,
    options: &Options,
) -> Result<SampledBsdf, CannotHold> {
    let rings = known.rings();
    let mut sampled = subject.empty(Interpolation::Nearest);
    if !options.accept {
        refuse_narrow(known, &rings, law, sampled.ratio())?;
    }
    let pieces = pieces(&rings);
    let means = Means::new(law, &pieces, subject.symmetry);
    sampled.incidences = incidences(&pieces, &pieces, &|i, o| means.of(i, o));
    Ok(sampled)
}

/// Refuses a lobe whose full width at half height is less than the ring that its ray falls into.
fn refuse_narrow(
    known: &Known,
    rings: &[Ring],
    law: &dyn Law,
    ratio: f64,
) -> Result<(), CannotHold> {
    for ring in rings.iter().filter(|r| r.edges[1] < 1.4) {
        let theta = f64::midpoint(ring.edges[0], ring.edges[1]);
        let Some(ray) = specular(theta, ratio) else { continue };
        let Some(hit) = rings.iter().find(|r| ray < r.edges[1]) else { continue };
        let width = full_width(law, [theta, 0.0], ratio);
        // the first ring is a cap
        let patch =
            if hit.edges[0] == 0.0 { 2.0 * hit.edges[1] } else { hit.edges[1] - hit.edges[0] };
        if width < patch {
            return Err(CannotHold {
                format: known.name,
                what: format!(
                    "a lobe of {:.2} degrees at {:.1} degrees of incidence, narrower than its patch of {:.0} degrees",
                    width.to_degrees(),
                    theta.to_degrees(),
                    patch.to_degrees()
                ),
                remedy: "use tensortree3, or write the means of patches all the same with --accept"
                    .into(),
            });
        }
    }
    Ok(())
}

/// Means of a law over pairs of patches; those that a turn or a mirror makes equal once.
struct Means<'a> {
    pieces: &'a [Piece],
    symmetry: Symmetry,
    found: HashMap<[usize; 3], f64>,
}

impl<'a> Means<'a> {
    fn new(law: &dyn Law, pieces: &'a [Piece], symmetry: Symmetry) -> Self {
        let mut means = Self { pieces, symmetry, found: HashMap::new() };
        let mut pairs: HashMap<[usize; 3], [usize; 2]> = HashMap::new();
        for i in 0..pieces.len() {
            for o in 0..pieces.len() {
                pairs.entry(means.key(i, o)).or_insert([i, o]);
            }
        }
        let pairs: Vec<_> = pairs.into_iter().collect();
        let of = |(key, [i, o]): &([usize; 3], [usize; 2])| {
            (*key, pair_mean(law, &pieces[*i], &pieces[*o]))
        };
        means.found = pairs.par_iter().map(of).collect();
        means
    }

    fn of(&self, i: usize, o: usize) -> f64 {
        self.found.get(&self.key(i, o)).copied().unwrap_or(0.0)
    }

    /// What pairs of equal means share: rings, and the difference of azimuths in parts of a turn.
    fn key(&self, i: usize, o: usize) -> [usize; 3] {
        let (a, b) = (&self.pieces[i], &self.pieces[o]);
        if self.symmetry == Symmetry::None {
            return [i, o, 0];
        }
        let turn = a.place[1] * b.place[1];
        let difference = (b.place[0] * a.place[1] + turn - a.place[0] * b.place[1]) % turn;
        let mirrored = self.symmetry == Symmetry::Isotropic;
        let least = if mirrored { difference.min(turn - difference) } else { difference };
        [a.ring, b.ring, least]
    }
}

/// Widest azimuth and polar angle of a box that is integrated at once, radians.
const WIDEST: [f64; 2] = [0.8, 0.2];

/// Mean of the BSDF over an incident and an outgoing patch, weighted with both cosines.
fn pair_mean(law: &dyn Law, from: &Piece, to: &Piece) -> f64 {
    // polar angles, for squares of sines have roots at the normal and the horizon
    let f = |[theta_i, phi_i, theta_o, phi_o]: [f64; 4]| {
        let incidence = [theta_i, around(phi_i + PI)];
        let value = law.value(incidence, [theta_o, around(phi_o - phi_i)]).max(0.0);
        value * (2.0 * theta_i).sin() * (2.0 * theta_o).sin()
    };
    let (into, out) = (parts(from), parts(to));
    let mut sum = 0.0;
    for [theta_i, phi_i] in &into {
        for [theta_o, phi_o] in &out {
            let low = [theta_i[0], phi_i[0], theta_o[0], phi_o[0]];
            let high = [theta_i[1], phi_i[1], theta_o[1], phi_o[1]];
            sum += mean(&f, Span { low, high });
        }
    }
    let weight = |piece: &Piece| {
        let [lower, upper] = piece.edges;
        (upper.sin().powi(2) - lower.sin().powi(2)) / (upper - lower)
    };
    sum / (into.len() * out.len()) as f64 / weight(from) / weight(to)
}

/// Parts of a patch: polar angles and azimuths.
fn parts(piece: &Piece) -> Vec<[[f64; 2]; 2]> {
    let width = TAU / piece.place[1] as f64;
    let count = |span: f64, most: f64| (span / most).ceil().max(1.0) as usize;
    let (n, m) = (count(piece.edges[1] - piece.edges[0], WIDEST[1]), count(width, WIDEST[0]));
    let share = |[a, b]: [f64; 2], k: usize, n: usize| {
        let step = (b - a) / n as f64;
        [a + step * k as f64, a + step * (k + 1) as f64]
    };
    let phi = [piece.azimuth - width / 2.0, piece.azimuth + width / 2.0];
    let row = |i: usize| (0..m).map(move |j| [share(piece.edges, i, n), share(phi, j, m)]);
    (0..n).flat_map(row).collect()
}

/// A law as the patches of a matrix see it; `None` if they are of no known basis.
pub(in crate::formats) fn seen(file: &SampledBsdf, law: &dyn Law) -> Option<Vec<Seen>> {
    let known = BASES.into_iter().find(|k| k.count() == file.incidences.len())?;
    if file.incidences.iter().any(|i| i.nodes.len() != known.count()) {
        return None;
    }
    let pieces = pieces(&known.rings());
    let places = places(file, &pieces)?;
    let means = Means::new(law, &pieces, file.symmetry);
    let of = |i: &usize| {
        let means: Vec<f64> = (0..pieces.len()).map(|o| means.of(*i, o)).collect();
        let flux = means.iter().zip(&pieces).map(|(v, p)| v * p.projected()).sum();
        Seen { means, flux }
    };
    Some(places.iter().map(of).collect())
}
