//! Cells of a tensor tree, and what lies over each part of the incident coordinates. Coordinates: see `tree.rs`.

use std::f64::consts::PI;

use crate::frame::around;
use crate::sampled::{Incidence, Nodes, Patch};
use crate::square::{angles_of, disc_of};

/// Most halvings of a tree.
pub(super) const DEEPEST: usize = 24;
/// Most values of all incidences of a lobe; a tree of more is taken at fewer incidences.
const MOST: usize = 4_000_000;

/// A cell: its lower corner, its width and its value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Leaf {
    pub(super) low: [f64; 4],
    pub(super) width: f64,
    pub(super) value: f64,
}

/// The lower corner of a child of width `width`.
pub(super) fn corner(low: [f64; 4], width: f64, child: usize, rank: usize) -> [f64; 4] {
    let mut low = low;
    for (k, x) in low.iter_mut().enumerate().take(rank) {
        *x += if child >> k & 1 == 1 { width } else { 0.0 };
    }
    low
}

/// A part of the incident coordinates that no cell divides, and the cells over it.
#[derive(Clone, Debug)]
pub(super) struct Slice {
    pub(super) low: [f64; 2],
    pub(super) width: f64,
    pub(super) inside: Vec<usize>,
}

/// The slices of a tree, fewer of one with too many values.
pub(super) fn slices_of(leaves: &[Leaf], rank: usize) -> Vec<Slice> {
    let all: Vec<usize> = (0..leaves.len()).collect();
    // fewer halvings of the incidence until the values are not too many
    let mut depth = DEEPEST;
    while depth > 0 && total(leaves, &all, [0.0; 2], 1.0, rank, depth) > MOST {
        depth = depth.min(13) - 1;
    }
    let mut found = Vec::new();
    visit(leaves, &all, [0.0; 2], 1.0, rank, depth, &mut |low, width, inside| {
        found.push(Slice { low, width, inside: inside.to_vec() });
    });
    found
}

/// The incidences of a tree, ascending by azimuth and polar angle, and whether they are all.
pub(super) fn slices(leaves: &[Leaf], rank: usize) -> (Vec<Incidence>, bool) {
    let slices = slices_of(leaves, rank);
    let is_whole =
        slices.iter().all(|slice| slice.inside.iter().all(|k| leaves[*k].width >= slice.width));
    let of = |slice: &Slice| incidence(leaves, slice, rank);
    let mut found: Vec<Incidence> = slices.iter().map(of).collect();
    let whole = |angle: f64| (angle * 1e9).round() as i64;
    found.sort_by_key(|i| (whole(i.phi), whole(i.theta)));
    (found, is_whole)
}

fn total(
    leaves: &[Leaf],
    inside: &[usize],
    low: [f64; 2],
    width: f64,
    rank: usize,
    depth: usize,
) -> usize {
    let mut sum = 0;
    visit(leaves, inside, low, width, rank, depth, &mut |_, _, inside| sum += inside.len());
    sum
}

/// Takes the corner and width of a part, and the cells over it.
type Take<'a> = dyn FnMut([f64; 2], f64, &[usize]) + 'a;

/// Calls `take` with every part of the incident coordinates that no cell divides, and the cells over it; parts that would be halved more
/// than `depth` times are taken at their middle.
fn visit(
    leaves: &[Leaf],
    inside: &[usize],
    low: [f64; 2],
    width: f64,
    rank: usize,
    depth: usize,
    take: &mut Take<'_>,
) {
    let axes = rank - 2;
    // the upper half of the first coordinate of an isotropic tree means nothing
    if rank == 3 && low[0] >= 0.5 {
        return;
    }
    let is_divided =
        inside.iter().any(|k| leaves[*k].width < width) || rank == 3 && low[0] + width > 0.5;
    if !is_divided {
        take(low, width, inside);
        return;
    }
    if depth == 0 {
        let middle = [low[0] + width / 2.0, low[1] + width / 2.0];
        let over = |k: &&usize| {
            let leaf = &leaves[**k];
            (0..axes).all(|j| (leaf.low[j]..leaf.low[j] + leaf.width).contains(&middle[j]))
        };
        let over: Vec<usize> = inside.iter().filter(over).copied().collect();
        take(low, width, &over);
        return;
    }
    let half = width / 2.0;
    for child in 0..1_usize << axes {
        let mut part = low;
        for (j, x) in part.iter_mut().enumerate().take(axes) {
            *x += if child >> j & 1 == 1 { half } else { 0.0 };
        }
        let meets = |k: &&usize| {
            let leaf = &leaves[**k];
            (0..axes).all(|j| leaf.low[j] < part[j] + half && part[j] < leaf.low[j] + leaf.width)
        };
        let inside: Vec<usize> = inside.iter().filter(meets).copied().collect();
        visit(leaves, &inside, part, half, rank, depth - 1, take);
    }
}

fn incidence(leaves: &[Leaf], slice: &Slice, rank: usize) -> Incidence {
    let Slice { low, width, inside } = slice;
    let middle = [low[0] + width / 2.0, low[1] + width / 2.0];
    let [theta, towards] =
        if rank == 3 { [(1.0 - 2.0 * middle[0]).asin(), 0.0] } else { angles_of(disc_of(middle)) };
    let turn = if rank == 3 { 0.0 } else { towards };
    let patch = |k: &usize| {
        let leaf = &leaves[*k];
        let half = leaf.width / 2.0;
        let square = [leaf.low[rank - 2] + half, leaf.low[rank - 1] + half];
        let [theta, phi] = angles_of(disc_of(square));
        Patch { centre: [theta, around(phi - turn)], projected: PI * leaf.width * leaf.width }
    };
    // an isotropic tree knows no azimuth of the source: it is 0
    let phi = if rank == 3 { 0.0 } else { around(towards + PI) };
    let nodes = Nodes::Patches(inside.iter().map(patch).collect());
    let values = inside.iter().map(|k| leaves[*k].value).collect();
    Incidence { theta, phi, nodes, values, stated: Vec::new() }
}
