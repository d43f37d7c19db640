//! Readings in any order as lobes: grids where they form one, single directions elsewhere.

use std::f64::consts::PI;

use crate::frame::{Frame, around};
use crate::interpolation::Interpolation;
use crate::sampled::{Band, Grid, Incidence, Lobe, Nodes, SampledBsdf, Side, Symmetry};

/// One value of a list.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// The side the light comes from.
    pub side: Side,
    /// What becomes of it.
    pub lobe: Lobe,
    /// The light.
    pub band: Band,
    /// Polar angle and azimuth of the source.
    pub incidence: [f64; 2],
    /// Absolute polar angle and relative azimuth of the outgoing direction.
    pub out: [f64; 2],
    /// BSDF, 1/sr.
    pub f: f64,
}

/// Angles nearer than this are the same: 1e-7 degrees, which no file means.
const SAME: f64 = 2e-9;

/// An incidence and its directions and values.
type Group = ([f64; 2], Vec<([f64; 2], f64)>);

/// Sorts readings into lobes. `isotropic` says that azimuths from 0 to pi are mirrored.
///
/// Bands of an incidence must have the same directions; those with other directions become lobes of their own.
pub fn collect(readings: Vec<Reading>, isotropic: bool) -> Vec<SampledBsdf> {
    let mut lobes: Vec<(Reading, Vec<Reading>)> = Vec::new();
    for reading in readings {
        let of = |(first, _): &&mut (Reading, Vec<Reading>)| {
            first.side == reading.side && first.lobe == reading.lobe && first.band == reading.band
        };
        match lobes.iter_mut().find(of) {
            Some((_, all)) => all.push(reading),
            None => lobes.push((reading.clone(), vec![reading])),
        }
    }
    let mut done: Vec<SampledBsdf> = Vec::new();
    for (first, all) in lobes {
        let lobe = of_one(&first, all, isotropic);
        // a further band of a lobe with the same directions
        let same = |other: &&mut SampledBsdf| {
            other.side == lobe.side
                && other.lobe == lobe.lobe
                && other.incidences.len() == lobe.incidences.len()
                && other.incidences.iter().zip(&lobe.incidences).all(|(a, b)| {
                    a.theta.to_bits() == b.theta.to_bits()
                        && a.phi.to_bits() == b.phi.to_bits()
                        && a.nodes == b.nodes
                })
        };
        match done.iter_mut().find(same) {
            Some(other) => {
                other.bands.extend(lobe.bands);
                let pairs = other.incidences.iter_mut().zip(lobe.incidences);
                pairs.for_each(|(to, from)| to.values.extend(from.values));
            }
            None => done.push(lobe),
        }
    }
    done
}

fn of_one(first: &Reading, all: Vec<Reading>, isotropic: bool) -> SampledBsdf {
    let mut groups: Vec<Group> = Vec::new();
    for reading in all {
        let near = |(at, _): &Group| {
            (at[0] - reading.incidence[0]).abs() < SAME
                && (at[1] - reading.incidence[1]).abs() < SAME
        };
        // files run through the directions of an incidence: it is mostly the last one
        let at = groups.iter().rposition(near).unwrap_or_else(|| {
            groups.push((reading.incidence, Vec::new()));
            groups.len() - 1
        });
        groups[at].1.push((reading.out, reading.f));
    }
    groups.sort_by(|a, b| a.0[1].total_cmp(&b.0[1]).then(a.0[0].total_cmp(&b.0[0])));
    let turned = groups.iter().any(|g| (g.0[1] - groups[0].0[1]).abs() > SAME);
    let incidences: Vec<Incidence> = groups
        .into_iter()
        .map(|([theta, phi], list)| {
            let (nodes, values) = nodes(list, isotropic);
            Incidence { theta, phi, nodes, values, stated: Vec::new() }
        })
        .collect();
    let mirrored = |i: &Incidence| matches!(&i.nodes, Nodes::Grid(g) if g.mirrored);
    let symmetry = if turned {
        Symmetry::None
    } else if isotropic || incidences.iter().all(mirrored) {
        Symmetry::Isotropic
    } else {
        Symmetry::Rotational
    };
    SampledBsdf {
        side: first.side,
        lobe: first.lobe,
        index: None,
        symmetry,
        bands: vec![first.band.clone()],
        interpolation: Interpolation::Linear,
        incidences,
        has_level: true,
        notes: Vec::new(),
    }
}

/// A product grid of absolute angles if the directions are all of one, each once; else single directions as they came.
pub fn nodes(list: Vec<([f64; 2], f64)>, isotropic: bool) -> (Nodes, Vec<f64>) {
    let plain = |list: Vec<([f64; 2], f64)>| {
        let (points, values) = list.into_iter().unzip();
        (Nodes::Points(points), values)
    };
    let thetas = axis(list.iter().map(|(at, _)| at[0]));
    let phis = axis(list.iter().map(|(at, _)| around(at[1])));
    let n = thetas.len() * phis.len();
    if n != list.len() || thetas.len() < 2 || phis.len() < 3 {
        return plain(list);
    }
    let mut values = vec![f64::NAN; n];
    for (at, value) in &list {
        let (i, j) = (nearest(&thetas, at[0]), nearest(&phis, around(at[1])));
        let place = &mut values[j * thetas.len() + i];
        if !place.is_nan() {
            return plain(list);
        }
        *place = *value;
    }
    let half = phis.first().is_some_and(|p| *p < SAME)
        && phis.last().is_some_and(|p| (p - PI).abs() < SAME);
    let mirrored = half || isotropic && phis.last().is_some_and(|p| *p <= PI + SAME);
    (Nodes::Grid(Grid { frame: Frame::Absolute, radii: thetas, azimuths: phis, mirrored }), values)
}

/// The different numbers of a list, ascending.
fn axis(all: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut list: Vec<f64> = all.collect();
    list.sort_by(f64::total_cmp);
    list.dedup_by(|a, b| (*a - *b).abs() < SAME);
    list
}

fn nearest(axis: &[f64], at: f64) -> usize {
    let high = axis.partition_point(|x| *x < at).min(axis.len() - 1);
    let low = high.saturating_sub(1);
    if (axis[low] - at).abs() <= (axis[high] - at).abs() { low } else { high }
}
