//! Klems matrices in the XML of WINDOW and Radiance.
//!
//! The hemisphere is shared out among patches in rings; a value is the mean of the BSDF over an incident and an outgoing patch, weighted with both
//! cosines, so that sums over outgoing patches are the scattered flux, the mean of an incident patch. Rings: Radiance `bsdf_m.c`. Sides and
//! directions: see `window.rs`.

mod basis;
mod means;
mod write;

use std::f64::consts::{PI, TAU};

use self::basis::{FULL_BASIS, HALF_BASIS, NAMED, Piece, QUARTER_BASIS, pieces};
use self::means::sample;
use self::write::encode;
use super::window::{self, Block, Document, Structure, fault};
use super::{Format, Source, Writer};
use crate::error::Fault;
use crate::frame::around;
use crate::interpolation::Interpolation;
use crate::sampled::{Incidence, Nodes, Patch, SampledBsdf, Symmetry};
use crate::text::excerpt;

pub(super) use self::means::seen;

/// Most patches of a basis.
const MOST: usize = 20_000;

const NOTES: &[&str] = &[
    "values are means over patches of 9 to 28 degrees: nothing narrower is seen",
    "Radiance derives a missing direction of transmission by reciprocity, which for a dielectric is wrong by n^2: give both sides",
];

pub(super) const FULL: Format = Format {
    name: "klems",
    title: "WINDOW/Radiance XML, Klems full basis",
    extensions: &["xml"],
    // what is of no other basis is read and its faults named here
    sniff: |source| window::is_window(&source.text) && other_basis(source).is_none(),
    read: Some(read),
    write: Some(Writer {
        sample: |law, subject, options| sample(&FULL_BASIS, law, subject, options),
        encode,
        notes: NOTES,
    }),
};

pub(super) const HALF: Format = Format {
    name: "klems-half",
    title: "WINDOW/Radiance XML, Klems half basis",
    extensions: &["xml"],
    sniff: |source| other_basis(source) == Some("klems-half"),
    read: Some(read),
    write: Some(Writer {
        sample: |law, subject, options| sample(&HALF_BASIS, law, subject, options),
        encode,
        notes: NOTES,
    }),
};

pub(super) const QUARTER: Format = Format {
    name: "klems-quarter",
    title: "WINDOW/Radiance XML, Klems quarter basis",
    extensions: &["xml"],
    sniff: |source| other_basis(source) == Some("klems-quarter"),
    read: Some(read),
    write: Some(Writer {
        sample: |law, subject, options| sample(&QUARTER_BASIS, law, subject, options),
        encode,
        notes: NOTES,
    }),
};

/// What a file of the XML is if not a Klems full matrix.
fn other_basis(source: &Source<'_>) -> Option<&'static str> {
    let structure = window::peek(&source.text, "IncidentDataStructure").unwrap_or("");
    if structure.to_ascii_lowercase().starts_with("tensortree") {
        return Some("tree");
    }
    let basis = window::peek(&source.text, "ColumnAngleBasis").unwrap_or("");
    if basis.to_ascii_lowercase().starts_with("lbnl/klems half") {
        Some("klems-half")
    } else if basis.to_ascii_lowercase().starts_with("lbnl/klems quarter") {
        Some("klems-quarter")
    } else {
        None
    }
}

fn read(source: &Source<'_>) -> Result<Vec<SampledBsdf>, Fault> {
    let document = window::parse(&source.text)?;
    if let Structure::Tree(_) = document.structure {
        return Err(fault(1, "a tensor tree where a matrix is expected"));
    }
    let mut lobes: Vec<SampledBsdf> = Vec::new();
    for block in &document.blocks {
        let lobe = lobe(&document, block)?;
        // a further band of a lobe with the same patches
        let same = |other: &&mut SampledBsdf| {
            other.side == lobe.side
                && other.lobe == lobe.lobe
                && other.bands.iter().all(|band| *band != block.band)
                && other.incidences.len() == lobe.incidences.len()
                && other.incidences.iter().zip(&lobe.incidences).all(|(a, b)| a.nodes == b.nodes)
        };
        match lobes.iter_mut().find(same) {
            Some(other) => {
                other.bands.extend(lobe.bands);
                let pairs = other.incidences.iter_mut().zip(lobe.incidences);
                pairs.for_each(|(to, from)| to.values.extend(from.values));
            }
            None => lobes.push(lobe),
        }
    }
    Ok(lobes)
}

fn lobe(document: &Document, block: &Block) -> Result<SampledBsdf, Fault> {
    let mut values = Vec::new();
    let mut last = block.line;
    for (word, line) in window::words(&block.data, block.line) {
        values.push(window::value_of(word, line)?);
        last = line;
    }
    let [into, out] = [&block.bases[0], &block.bases[1]]
        .map(|name| basis(document, name, block.line, values.len()));
    let (mut into, mut out) = (into?, out?);
    let mut notes = document.notes.clone();
    if values.len() != into.len() * out.len() {
        let side = values.len().isqrt();
        let is_part = side * side == values.len()
            && (2..into.len().min(out.len())).contains(&side)
            && document
                .blocks
                .iter()
                .all(|b| window::words(&b.data, 0).take(values.len() + 1).count() == values.len());
        if !is_part {
            let what = format!(
                "{} values where the bases have {} x {}",
                values.len(),
                into.len(),
                out.len()
            );
            return Err(fault(last, what));
        }
        notes.push(format!(
            "{side} x {side} of {} x {} values: those of the first patches, the others are missing",
            into.len(),
            out.len()
        ));
        into.truncate(side);
        out.truncate(side);
    }
    notes.extend(window::without_noise(&mut values, last)?);
    let incidences = incidences(&into, &out, &|i, o| {
        let at = match document.structure {
            Structure::Rows => i * out.len() + o,
            _ => o * into.len() + i,
        };
        values.get(at).copied().unwrap_or(0.0)
    });
    let most = incidences.iter().map(flux).fold(0.0, f64::max);
    if most > 1.01 {
        notes.push(format!("not physical: up to {most:.4} of the light is scattered"));
    }
    Ok(SampledBsdf {
        side: block.side,
        lobe: block.lobe,
        index: document.said.index,
        symmetry: document.said.symmetry.unwrap_or(Symmetry::None),
        bands: vec![document.band(block)],
        interpolation: Interpolation::Nearest,
        incidences,
        has_level: true,
        notes,
    })
}

fn flux(incidence: &Incidence) -> f64 {
    let Nodes::Patches(patches) = &incidence.nodes else { return 0.0 };
    patches.iter().zip(&incidence.values).map(|(p, v)| p.projected * v).sum()
}

/// The patches of a name: as the file defines them, else as they are known; of two with a name that which `count` values are for.
fn basis(document: &Document, name: &str, line: usize, count: usize) -> Result<Vec<Piece>, Fault> {
    let defined = document.bases.iter().find(|b| b.name.eq_ignore_ascii_case(name));
    let named = || NAMED.iter().filter(|k| k.name.eq_ignore_ascii_case(name));
    let known = named().find(|k| k.count() * k.count() == count).or_else(|| named().next());
    let rings = match (defined, known) {
        (Some(basis), _) if !basis.rings.is_empty() => basis.rings.clone(),
        (_, Some(known)) => known.rings(),
        _ => return Err(fault(line, format!("the basis '{}' is not defined", excerpt(name)))),
    };
    let mut lower = 0.0;
    for ring in &rings {
        if (ring.edges[0] - lower).abs() > 1e-6 {
            return Err(fault(
                line,
                format!("the rings of '{}' do not follow each other", excerpt(name)),
            ));
        }
        lower = ring.edges[1];
    }
    if rings.iter().map(|r| r.count).sum::<usize>() > MOST {
        return Err(fault(line, format!("'{}' has too many patches", excerpt(name))));
    }
    Ok(pieces(&rings))
}

/// Incidences of all incident patches, ascending by azimuth and then by polar angle.
fn incidences(
    into: &[Piece],
    out: &[Piece],
    value: &dyn Fn(usize, usize) -> f64,
) -> Vec<Incidence> {
    let mut order: Vec<usize> = (0..into.len()).collect();
    let key = |i: &usize| {
        into.get(*i).map_or((0, 0), |p| {
            let whole = |angle: f64| (angle * 1e9).round() as i64;
            (whole(around(p.azimuth + PI)), whole(p.theta()))
        })
    };
    order.sort_by_key(key);
    let incidence = |i: usize| {
        let from = *into.get(i)?;
        let patch = |o: &Piece| Patch {
            centre: [o.theta(), around(o.azimuth - from.azimuth)],
            projected: o.projected(),
        };
        Some(Incidence {
            theta: from.theta(),
            phi: around(from.azimuth + PI),
            nodes: Nodes::Patches(out.iter().map(patch).collect()),
            values: (0..out.len()).map(|o| value(i, o)).collect(),
            stated: Vec::new(),
        })
    };
    order.into_iter().filter_map(incidence).collect()
}

/// The incident patch of each incidence; `None` if they are not just those of a basis.
fn places(sampled: &SampledBsdf, pieces: &[Piece]) -> Option<Vec<usize>> {
    let of = |incidence: &Incidence| {
        pieces.iter().position(|p| {
            let turned = around(p.azimuth + PI - incidence.phi);
            (p.theta() - incidence.theta).abs() < 1e-6 && turned.min(TAU - turned) < 1e-6
        })
    };
    let places: Vec<usize> = sampled.incidences.iter().map(of).collect::<Option<_>>()?;
    let mut once = places.clone();
    once.sort_unstable();
    once.dedup();
    (once.len() == pieces.len() && places.len() == pieces.len()).then_some(places)
}
