//! Klems matrices in the XML of WINDOW and Radiance.
//!
//! The hemisphere is shared out among patches in rings; a value is the mean of the BSDF over an incident and an outgoing patch, weighted with both
//! cosines, so that sums over outgoing patches are the scattered flux, the mean of an incident patch. Rings: Radiance `bsdf_m.c`. Sides and
//! directions: see `window.rs`.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;

use rayon::prelude::*;

use super::window::{self, Block, Document, Ring, Structure, fault};
use super::{Format, Source, Writer};
use crate::error::{CannotHold, Fault};
use crate::frame::{around, specular};
use crate::interpolation::Interpolation;
use crate::law::{Law, Options, Subject};
use crate::patches::{Seen, Span, full_width, mean, projected};
use crate::sampled::{Incidence, Nodes, Patch, SampledBsdf, Symmetry};
use crate::text::excerpt;

/// One of the three bases of the format.
struct Known {
    name: &'static str,
    /// Upper edge of each ring, degrees, and its patches.
    rings: &'static [(f64, usize)],
}

static FULL_BASIS: Known = Known {
    name: "LBNL/Klems Full",
    rings: &[
        (5.0, 1),
        (15.0, 8),
        (25.0, 16),
        (35.0, 20),
        (45.0, 24),
        (55.0, 24),
        (65.0, 24),
        (75.0, 16),
        (90.0, 12),
    ],
};
/// Named unlike the built-in one of Radiance, which has 73 patches in versions up to 2021 and 77 in later ones: this name is read by the
/// definition in the file.
static HALF_BASIS: Known = Known {
    name: "LBNL/Klems Half 73",
    rings: &[(6.5, 1), (19.5, 8), (32.5, 12), (46.5, 16), (61.5, 20), (76.5, 12), (90.0, 4)],
};
/// The name without a definition, as Radiance of 2021 has it.
static OLD_HALF: Known = Known { name: "LBNL/Klems Half", rings: HALF_BASIS.rings };
/// The same of later versions (table of pyradiance 1.3.1).
static NEW_HALF: Known = Known {
    name: "LBNL/Klems Half",
    rings: &[(6.5, 1), (19.5, 8), (32.5, 12), (45.5, 16), (58.5, 20), (71.5, 12), (90.0, 8)],
};
/// Named unlike the built-in one of Radiance, whose rings end at 46 and 66 degrees in versions up to 2021 and at 45 and 63 in later ones.
static QUARTER_BASIS: Known = Known {
    name: "LBNL/Klems Quarter 41",
    rings: &[(9.0, 1), (27.0, 8), (46.0, 12), (66.0, 12), (90.0, 8)],
};
static NEW_QUARTER: Known = Known {
    name: "LBNL/Klems Quarter",
    rings: &[(9.0, 1), (27.0, 8), (45.0, 12), (63.0, 12), (90.0, 8)],
};
static BASES: [&Known; 3] = [&FULL_BASIS, &HALF_BASIS, &QUARTER_BASIS];
/// What names mean without a definition.
static NAMED: [&Known; 4] = [&FULL_BASIS, &OLD_HALF, &NEW_HALF, &NEW_QUARTER];

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

/// A patch of a basis: polar angles of its edges, azimuth of its centre, and its width.
#[derive(Clone, Copy, Debug)]
struct Piece {
    ring: usize,
    edges: [f64; 2],
    azimuth: f64,
    /// Place in its ring and number of patches there.
    place: [usize; 2],
}

impl Piece {
    /// Polar angle of the centre.
    fn theta(self) -> f64 {
        if self.place[1] == 1 && self.edges[0] == 0.0 {
            0.0
        } else {
            f64::midpoint(self.edges[0], self.edges[1])
        }
    }

    fn projected(self) -> f64 {
        projected(self.edges) / self.place[1] as f64
    }
}

/// A part of a full turn; the same number from whichever ring it comes.
fn turn(k: usize, count: usize) -> f64 {
    let (mut a, mut b) = (k, count);
    while b > 0 {
        (a, b) = (b, a % b);
    }
    TAU * (k / a.max(1)) as f64 / (count / a.max(1)) as f64
}

fn pieces(rings: &[Ring]) -> Vec<Piece> {
    let of_ring = |(ring, r): (usize, &Ring)| {
        let r = *r;
        (0..r.count).map(move |k| Piece {
            ring,
            edges: r.edges,
            azimuth: turn(k, r.count),
            place: [k, r.count],
        })
    };
    rings.iter().enumerate().flat_map(of_ring).collect()
}

impl Known {
    fn rings(&self) -> Vec<Ring> {
        let mut lower = 0.0;
        let ring = |(upper, count): &(f64, usize)| {
            let edges = [lower, upper.to_radians()];
            lower = edges[1];
            Ring { edges, count: *count }
        };
        self.rings.iter().map(ring).collect()
    }

    fn count(&self) -> usize {
        self.rings.iter().map(|r| r.1).sum()
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

fn sample(
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
pub(super) fn seen(file: &SampledBsdf, law: &dyn Law) -> Option<Vec<Seen>> {
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

fn encode(lobes: &[SampledBsdf]) -> Result<Vec<u8>, CannotHold> {
    let refuse = || CannotHold {
        format: "WINDOW XML",
        what: "directions that are not the patches of a Klems basis".into(),
        remedy: "sample it anew".into(),
    };
    let first = lobes.first().ok_or_else(refuse)?;
    let known = BASES.into_iter().find(|k| k.count() == first.incidences.len());
    let known = known.ok_or_else(refuse)?;
    let pieces = pieces(&known.rings());
    let data: Option<Vec<String>> = lobes.iter().map(|lobe| matrix(lobe, &pieces)).collect();
    let data = data.ok_or_else(refuse)?;
    let basis = format!(
        "\t\t\t<ColumnAngleBasis>{0}</ColumnAngleBasis>\n\t\t\t<RowAngleBasis>{0}</RowAngleBasis>\n",
        known.name
    );
    Ok(window::text(lobes, &definition(known), &basis, &data))
}

/// The numbers of a lobe: a line for each outgoing patch.
fn matrix(lobe: &SampledBsdf, pieces: &[Piece]) -> Option<String> {
    let places = places(lobe, pieces)?;
    let is_whole = |i: &Incidence| i.values.len() == pieces.len();
    if lobe.bands.len() != 1 || !lobe.incidences.iter().all(is_whole) {
        return None;
    }
    let mut of_patch = vec![0; pieces.len()];
    places.iter().enumerate().for_each(|(k, i)| of_patch[*i] = k);
    let mut out = String::new();
    for o in 0..pieces.len() {
        for k in &of_patch {
            let _ = write!(out, "{:.7e}, ", lobe.incidences[*k].values[o]);
        }
        out.push('\n');
    }
    Some(out)
}

/// The definition of a basis.
fn definition(known: &Known) -> String {
    let mut out = format!(
        "\t\t<IncidentDataStructure>Columns</IncidentDataStructure>\n\t\t<AngleBasis>\n\
         \t\t\t<AngleBasisName>{}</AngleBasisName>\n",
        known.name
    );
    let mut lower = 0.0;
    for &(upper, count) in known.rings {
        let theta = if lower == 0.0 { 0.0 } else { f64::midpoint(lower, upper) };
        let _ = write!(
            out,
            "\t\t\t<AngleBasisBlock>\n\t\t\t\t<Theta>{theta}</Theta>\n\t\t\t\t<nPhis>{count}</nPhis>\n\
             \t\t\t\t<ThetaBounds>\n\t\t\t\t\t<LowerTheta>{lower}</LowerTheta>\n\
             \t\t\t\t\t<UpperTheta>{upper}</UpperTheta>\n\t\t\t\t</ThetaBounds>\n\t\t\t</AngleBasisBlock>\n"
        );
        lower = upper;
    }
    out.push_str("\t\t</AngleBasis>\n");
    out
}
