//! Tensor trees in the XML of WINDOW and Radiance: reading, and the file of a tree.
//!
//! Layout: Radiance `bsdf_t.c`. A tree halves a cube of 3 or 4 coordinates until a value holds for a cell: of `TensorTree3` the first is `(1 - sin theta_i)/2`,
//! below 1/2, and two are the square of the outgoing direction turned so that the light goes to +x; of `TensorTree4` two are the square
//! of the direction the incident light goes to and two that of the outgoing direction, not turned. Squares keep areas: see `square.rs`.
//! Child k of a branch has the upper half of coordinate j where bit j of k is set; a list of 2^(n m) values is a grid whose last
//! coordinate is the fastest. Sides: see `window.rs`.
//!
//! A sampled lobe has an incidence for each part of the incident coordinates that no cell divides, and the cells there as patches.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fmt::Write as _;

use super::cells::{DEEPEST, Leaf, corner, slices};
use super::window::{self, Block, Document, Structure, fault};
use super::{Format, Source, Writer};
use crate::error::{CannotHold, Fault};
use crate::interpolation::Interpolation;
use crate::sampled::{Nodes, SampledBsdf, Symmetry};
use crate::square::{cosines_of, square_of};
use crate::text::excerpt;

const NOTES: &[&str] = &[
    "values are means over cells, with no interpolation between them: flanks are as steep as steps",
    "Radiance uses a tree in the direction of its block; give both sides where both are lit",
];

pub(super) const ISOTROPIC: Format = Format {
    name: "tensortree3",
    title: "WINDOW/Radiance XML, isotropic tensor tree",
    extensions: &["xml"],
    sniff: |source| is_tree(source, "tensortree3"),
    read: Some(read),
    write: Some(Writer { sample: super::tree_sample::isotropic, encode, notes: NOTES }),
};

pub(super) const ANISOTROPIC: Format = Format {
    name: "tensortree4",
    title: "WINDOW/Radiance XML, anisotropic tensor tree",
    extensions: &["xml"],
    sniff: |source| is_tree(source, "tensortree4"),
    read: Some(read),
    write: Some(Writer { sample: super::tree_sample::anisotropic, encode, notes: NOTES }),
};

fn is_tree(source: &Source<'_>, name: &str) -> bool {
    let structure = window::peek(&source.text, "IncidentDataStructure");
    structure.is_some_and(|structure| structure.eq_ignore_ascii_case(name))
}

fn read(source: &Source<'_>) -> Result<Vec<SampledBsdf>, Fault> {
    let document = window::parse(&source.text)?;
    let Structure::Tree(rank) = document.structure else {
        return Err(fault(1, "a matrix where a tensor tree is expected"));
    };
    document.blocks.iter().map(|block| lobe(&document, block, rank)).collect()
}

fn lobe(document: &Document, block: &Block, rank: usize) -> Result<SampledBsdf, Fault> {
    if !block.bases[0].eq_ignore_ascii_case("LBNL/Shirley-Chiu") {
        let what = format!("the angle basis '{}' of a tree", excerpt(&block.bases[0]));
        let remedy = "give LBNL/Shirley-Chiu";
        return Err(Fault::Unsupported { format: window::NAME, what, remedy });
    }
    let mut leaves = leaves(block, rank)?;
    let mut values: Vec<f64> = leaves.iter().map(|leaf| leaf.value).collect();
    let mut notes = document.notes.clone();
    notes.extend(window::without_noise(&mut values, block.line)?);
    leaves.iter_mut().zip(values).for_each(|(leaf, v)| leaf.value = v);
    let (incidences, is_whole) = slices(&leaves, rank);
    if !is_whole {
        notes.push("the tree is finer than the incidences taken from it".into());
    }
    let symmetry = if rank == 3 { Symmetry::Rotational } else { Symmetry::None };
    let mut sampled = SampledBsdf {
        side: block.side,
        lobe: block.lobe,
        index: document.said.index,
        symmetry: document.said.symmetry.unwrap_or(symmetry),
        bands: vec![document.band(block)],
        interpolation: Interpolation::Nearest,
        incidences,
        has_level: true,
        notes,
    };
    let flux = (0..sampled.incidences.len()).map(|k| sampled.flux(k, 0));
    let most = flux.fold(0.0, f64::max);
    if most > 1.01 {
        sampled.notes.push(format!("not physical: up to {most:.4} of the light is scattered"));
    }
    Ok(sampled)
}

/// The cells of a block.
fn leaves(block: &Block, rank: usize) -> Result<Vec<Leaf>, Fault> {
    let mut words = window::words(&block.data, block.line).peekable();
    let mut leaves = Vec::new();
    // of each open brace: the corner, the width, and the children that are done
    let mut open: Vec<([f64; 4], f64, usize)> = Vec::new();
    let mut is_done = false;
    let mut last = block.line;
    while let Some((word, line)) = words.next() {
        last = line;
        if is_done {
            return Err(fault(line, format!("'{}' after the end of the tree", excerpt(word))));
        }
        match word {
            "{" => {
                let (low, width) = match open.last() {
                    None => ([0.0; 4], 1.0),
                    Some((_, _, children)) if *children >= 1 << rank => {
                        return Err(fault(line, "a branch with too many children"));
                    }
                    Some((low, width, children)) => {
                        (corner(*low, width / 2.0, *children, rank), width / 2.0)
                    }
                };
                if open.len() > DEEPEST {
                    return Err(fault(line, format!("a tree deeper than {DEEPEST} halvings")));
                }
                let is_branch = words.peek().is_some_and(|(next, _)| *next == "{");
                open.push((low, width, 0));
                if !is_branch {
                    let mut values = Vec::new();
                    while let Some((word, line)) = words.next_if(|(w, _)| *w != "{" && *w != "}") {
                        values.push(window::value_of(word, line)?);
                        last = line;
                    }
                    grid(low, width, &values, rank, &mut leaves).map_err(|e| fault(last, e))?;
                    if let Some(of) = open.last_mut() {
                        of.2 = 1 << rank;
                    }
                    if words.peek().is_some_and(|(next, _)| *next == "{") {
                        return Err(fault(last, "a branch among values"));
                    }
                }
            }
            "}" => {
                match open.pop() {
                    Some((_, _, children)) if children == 1 << rank => {}
                    Some((_, _, children)) => {
                        let what = format!("a branch of {children} children, not {}", 1 << rank);
                        return Err(fault(line, what));
                    }
                    None => return Err(fault(line, "a '}' without its '{'")),
                }
                match open.last_mut() {
                    Some((_, _, children)) => *children += 1,
                    None => is_done = true,
                }
            }
            _ => {
                return Err(fault(line, format!("'{}' where a '{{' is expected", excerpt(word))));
            }
        }
    }
    if is_done { Ok(leaves) } else { Err(fault(last, "the tree ends early")) }
}

/// Adds the cells of a list of values.
fn grid(
    low: [f64; 4],
    width: f64,
    values: &[f64],
    rank: usize,
    leaves: &mut Vec<Leaf>,
) -> Result<(), String> {
    let halvings = (0..=DEEPEST).find(|m| {
        u32::try_from(rank * m).ok().and_then(|bits| 1_usize.checked_shl(bits))
            == Some(values.len())
    });
    let Some(halvings) = halvings else {
        return Err(format!("{} values in a cell: not a power of {}", values.len(), 1 << rank));
    };
    let n = 1_usize << halvings;
    let width = width / n as f64;
    for (place, value) in values.iter().enumerate() {
        let mut low = low;
        let mut rest = place;
        for x in low.iter_mut().take(rank).rev() {
            *x += (rest % n) as f64 * width;
            rest /= n;
        }
        leaves.push(Leaf { low, width, value: *value });
    }
    Ok(())
}

/// The cells of a lobe, by level and place; `None` if its patches are not those of a tree.
fn cells(lobe: &SampledBsdf, rank: usize) -> Option<BTreeMap<(usize, [u32; 4]), f64>> {
    let mut cells = BTreeMap::new();
    for incidence in &lobe.incidences {
        let Nodes::Patches(patches) = &incidence.nodes else { return None };
        let towards = incidence.phi - PI;
        let from = if rank == 3 {
            [(1.0 - incidence.theta.sin()) / 2.0, 0.0]
        } else {
            square_of(cosines_of([incidence.theta, towards]))
        };
        let turn = if rank == 3 { 0.0 } else { towards };
        for (patch, value) in patches.iter().zip(&incidence.values) {
            let width = (patch.projected / PI).sqrt();
            let level = -width.log2();
            if (level - level.round()).abs() > 1e-6 || level > DEEPEST as f64 {
                return None;
            }
            let out = square_of(cosines_of([patch.centre[0], patch.centre[1] + turn]));
            let at = if rank == 3 {
                [from[0], out[0], out[1], 0.0]
            } else {
                [from[0], from[1], out[0], out[1]]
            };
            let place = at.map(|x| (x / width).floor() as u32);
            cells.insert((level.round() as usize, place), *value);
        }
    }
    Some(cells)
}

fn encode(lobes: &[SampledBsdf]) -> Result<Vec<u8>, CannotHold> {
    let refuse = || CannotHold {
        format: window::NAME,
        what: "directions that are not the cells of a tree".into(),
        remedy: "sample it anew".into(),
    };
    // the source of an isotropic tree is always at azimuth 0
    let rank_of = |lobe: &SampledBsdf| {
        let phi = lobe.incidences.first().map_or(0.0, |i| i.phi);
        let is_one = lobe.incidences.iter().all(|i| (i.phi - phi).abs() < 1e-9);
        if is_one { 3 } else { 4 }
    };
    let rank = lobes.first().map(rank_of).ok_or_else(refuse)?;
    let mut data = Vec::new();
    for lobe in lobes {
        if rank_of(lobe) != rank || lobe.bands.len() != 1 {
            return Err(refuse());
        }
        let cells = cells(lobe, rank).ok_or_else(refuse)?;
        let mut text = String::new();
        write(&cells, rank, 0, [0; 4], &mut text).ok_or_else(refuse)?;
        data.push(text);
    }
    let definition =
        format!("\t\t<IncidentDataStructure>TensorTree{rank}</IncidentDataStructure>\n");
    Ok(window::text(
        lobes,
        &definition,
        "\t\t\t<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>\n",
        &data,
    ))
}

/// Writes the part of a tree at a level and place; `None` where a cell is missing.
fn write(
    cells: &BTreeMap<(usize, [u32; 4]), f64>,
    rank: usize,
    level: usize,
    place: [u32; 4],
    out: &mut String,
) -> Option<()> {
    if let Some(value) = cells.get(&(level, place)) {
        let _ = writeln!(out, "{{ {value:.6e} }}");
        return Some(());
    }
    if rank == 3 && level > 0 && place[0] >= 1 << (level - 1) {
        out.push_str("{ 0 }\n");
        return Some(());
    }
    if level >= DEEPEST {
        return None;
    }
    let child = |k: usize| {
        let mut place = place;
        for (j, x) in place.iter_mut().enumerate().take(rank) {
            *x = *x * 2 + u32::from(k >> j & 1 == 1);
        }
        place
    };
    // children that are all cells are a grid, whose last coordinate is the fastest
    let flipped = |k: usize| (0..rank).fold(0, |to, j| to | (k >> j & 1) << (rank - 1 - j));
    let values: Option<Vec<f64>> =
        (0..1_usize << rank).map(|k| cells.get(&(level + 1, child(flipped(k)))).copied()).collect();
    out.push_str("{\n");
    if let Some(values) = values {
        for value in values {
            let _ = write!(out, "{value:.6e} ");
        }
    } else {
        for k in 0..1_usize << rank {
            write(cells, rank, level + 1, child(k), out)?;
        }
    }
    out.push_str("}\n");
    Some(())
}
