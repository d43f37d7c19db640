//! What is divided out, the scale of slopes, the numbers of nodes: those that err least.

use asperity_core::bsdf::Lobe;
use asperity_core::direction::{Direction, Side};
use asperity_core::table::{Fall, Form, GAIN_STEPS, LobeHeader, Shape, Storage, slope};

use crate::parallel;

use super::balance::incident;
use super::facet::{self, Beam};
use super::grid::LobeGrid;
use super::law::{Lattice, Law};

const FALLS: [Fall; 3] = [Fall::Fourth, Fall::Second, Fall::Flat];
/// Scales of slopes in units of the median slope.
const SCALES: [f64; 6] = [0.35, 0.6, 1.0, 1.7, 3.0, 5.0];
/// Widths of masking in units of the median slope; the last hides nothing that the others do not.
const MASKING: [f64; 6] = [0.0, 0.35, 0.7, 1.0, 2.0, 20.0];
/// Of shapes that serve alike the first is taken: samples of many incidences vary least in weight.
const INCIDENCES: [u16; 7] = [26, 20, 16, 12, 9, 7, 5];
const GRAZING: [f32; 4] = [0.0, -0.4, -0.7, 1.0];
const AZIMUTHS: [u16; 6] = [2, 3, 4, 5, 7, 9];
/// Incidences and azimuths with which kinds are compared: what is best with few azimuths need not be with many.
const START: [(u16, u16); 2] = [(9, 5), (16, 3)];
/// Error, over the peak, below which shapes serve alike.
const FINE: f64 = 3e-6;
/// Factors by which scale and masking are tried.
const STEPS: [f32; 4] = [1.3, 1.1, 1.03, 1.01];
/// Values beyond which a lobe need not use up its bytes.
const MANY: usize = 24_000;
/// Incidences at which errors are looked at, degrees: those of the instrument, between them, and on to grazing.
const ANGLES: [f64; 15] =
    [0.0, 8.0, 15.0, 22.0, 30.0, 37.0, 45.0, 52.0, 60.0, 66.0, 72.0, 78.0, 83.0, 86.5, 89.0];
/// Degrees from the critical angle at which they are looked at as well.
const CRITICAL: [f64; 5] = [-4.0, -1.0, 1.0, 8.0, 13.0];
/// Weight of an incidence beyond 60 degrees; 1 within the angles of the instrument.
const BEYOND: f64 = 0.5;
/// Flux of a lobe from which an incidence is judged by its own peak. With less flux the peak of the whole lobe takes over
/// gradually: beyond the critical angle peaks vanish.
const LIT: f64 = 5e-4;
/// What a place without light counts beside the peak.
const DIM: f64 = 0.1;
/// What the mean square of relative errors, by the light, counts beside that of errors over the peak: a sharp peak may hold little light.
const LIGHT: f64 = 0.006;
/// What the square of the relative error of the flux counts.
const FLUX: f64 = 0.02;
/// Facets along a line through the lobe.
const POINTS: u32 = 48;

/// A pair of directions, the value there, and what its error counts within its incidence.
struct Probe {
    wi: Direction<f64>,
    wo: Direction<f64>,
    ars: f64,
    /// Of the square of an error over the peak.
    weight: f64,
    /// Of an error in the flux, roughly, as a part of it.
    light: f64,
}

/// An incidence, of which the weights of probes are one together.
struct Incidence {
    probes: Vec<Probe>,
    counts: f64,
    peak: f64,
    /// Value of the light, spread over all slopes.
    mean: f64,
    /// Share of the light, roughly.
    flux: f64,
}

/// The shape with as many radii as fit.
pub(super) fn fitted<S: Storage>(incidences: u16, azimuths: u16, bytes: usize) -> Shape {
    let intervals = if bytes < 3000 { 8 } else { 16 };
    let gains = usize::from(GAIN_STEPS) * 4;
    let rest = usize::from(incidences) * (gains + 3 * usize::from(intervals) + 2);
    let each = usize::from(incidences) * usize::from(azimuths) * S::BYTES;
    let radii = (bytes.saturating_sub(rest) / each).clamp(2, 160) as u16;
    Shape { incidences, azimuths, radii, intervals }
}

/// A shape of given incidences and azimuths to compare kinds with.
fn coarse<S: Storage>((incidences, azimuths): (u16, u16), bytes: usize) -> Shape {
    let shape = fitted::<S>(incidences, azimuths, bytes);
    Shape { radii: 40.min(shape.radii.max(16)), ..shape }
}

/// The lobe of a law that errs least within a number of bytes.
pub(super) fn best<S: Storage>(
    law: &dyn Law,
    eta: f64,
    which: (Side, Lobe),
    bytes: usize,
) -> LobeGrid {
    let median = median_slope(law, (eta, Form::Masked), which);
    let moved = median_slope(law, (eta, Form::Direct), which);
    let probes = probes(law, eta, which, median);
    let start = LobeHeader {
        shape: coarse::<S>(START[0], bytes),
        form: Form::Masked,
        fall: Fall::Fourth,
        scale: median as f32,
        grazing: 0.0,
        masking: median as f32,
    };
    let judged = |header: LobeHeader| {
        let mut grid = LobeGrid::new(eta, which, header);
        grid.fill(law);
        (error::<S>(&grid, &probes), header)
    };
    let least_above = |candidates: Vec<LobeHeader>, floor: f64| {
        let judged = parallel::map_slice(&candidates, &|header| judged(*header));
        let errors = judged.into_iter().map(|(error, header)| (error.max(floor), header));
        errors.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(start, |best| best.1)
    };
    let least = |candidates| least_above(candidates, 0.0);
    let mut kinds = Vec::new();
    for fall in FALLS {
        for factor in SCALES {
            let scaled = LobeHeader { fall, scale: (median * factor) as f32, ..start };
            kinds.push(LobeHeader { form: Form::Drawn, ..scaled });
            kinds.extend(MASKING.map(|a| LobeHeader { masking: (median * a) as f32, ..scaled }));
            let scale = (moved * factor) as f32;
            kinds.extend(MASKING.map(|a| {
                let masking = (median * a) as f32;
                LobeHeader { form: Form::Direct, scale, masking, ..scaled }
            }));
        }
    }
    // GGX itself, of which one `v` is all: the median, far off where steep facets reflect totally, need not lead there
    let own = law.slope() as f32;
    kinds.push(LobeHeader { scale: own, masking: own, ..start });
    let kinds = START.map(|counts| {
        let shape = coarse::<S>(counts, bytes);
        let shaped = kinds.iter().map(|kind| LobeHeader { shape, ..*kind });
        refined(least(shaped.collect()), &least)
    });
    let mut shapes = Vec::new();
    for incidences in INCIDENCES {
        for azimuths in AZIMUTHS {
            let shape = fitted::<S>(incidences, azimuths, bytes);
            let used = shape.values() * S::BYTES;
            if shape.radii >= 12 && (2 * used > bytes || shape.values() >= MANY) {
                for grazing in GRAZING {
                    shapes.extend(kinds.map(|kind| LobeHeader { shape, grazing, ..kind }));
                }
            }
        }
    }
    if shapes.is_empty() {
        // too few bytes for any of them
        let shape = fitted::<S>(5, 2, bytes);
        shapes.extend(kinds.map(|kind| LobeHeader { shape, ..kind }));
    }
    let mut grid = LobeGrid::new(eta, which, refined(least_above(shapes, FINE), &least));
    grid.fill(law);
    grid
}

/// Scale and masking, one after the other, in ever smaller steps.
fn refined(mut best: LobeHeader, least: &impl Fn(Vec<LobeHeader>) -> LobeHeader) -> LobeHeader {
    for step in STEPS {
        for _ in 0..2 {
            let scales = [1.0, step, 1.0 / step];
            best = least(scales.map(|f| LobeHeader { scale: best.scale * f, ..best }).into());
            if best.form != Form::Drawn {
                best =
                    least(scales.map(|f| LobeHeader { masking: best.masking * f, ..best }).into());
            }
        }
    }
    best
}

/// Errors of each incidence, over its peak and of its light, of which the mean of fourth powers is taken: the worst leads.
fn error<S: Storage>(grid: &LobeGrid, incidences: &[Incidence]) -> f64 {
    let sum = grid.with_table::<S, _>(|table| {
        let fourth = |of: &Incidence| {
            let (mut of_peak, mut of_light, mut of_flux) = (0.0, 0.0, 0.0);
            for probe in &of.probes {
                let off = table.ars(probe.wi, probe.wo) - probe.ars;
                of_peak += off * off * probe.weight;
                of_light += off * off * probe.light / (probe.ars + of.mean);
                of_flux += off * probe.light;
            }
            let mean = of_peak + LIGHT * of_light + FLUX * of_flux * of_flux;
            of.counts * mean * mean
        };
        let counted: f64 = incidences.iter().map(|of| of.counts).sum();
        incidences.iter().map(fourth).sum::<f64>() / counted
    });
    sum.filter(|s| s.is_finite()).map_or(f64::INFINITY, |sum| sum.sqrt().sqrt())
}

/// Half of the light of a lobe, at a middle incidence, meets facets below this slope.
fn median_slope(law: &dyn Law, of: (f64, Form), (side, lobe): (Side, Lobe)) -> f64 {
    let wi = incident(side, 0.9);
    let mut slopes: Vec<(f64, f64)> = Vec::new();
    for ray in Lattice::COARSE.rays(|u| law.sample_lobe(wi, lobe, u)) {
        let place = facet::between(of, [1.0, 0.0], wi, ray.wo);
        if let Some((s, _)) = place.filter(|f| f.0 > 1e-7) {
            slopes.push((s, ray.weight));
        }
    }
    slopes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * slopes.iter().map(|s| s.1).sum::<f64>();
    let mut sum = 0.0;
    let median = slopes.iter().find(|(_, weight)| {
        sum += weight;
        sum >= half
    });
    median.map_or(law.slope(), |m| m.0).clamp(1e-6, 10.0)
}

/// Lines through the lobe in the plane of incidence and across.
fn probes(law: &dyn Law, eta: f64, which: (Side, Lobe), median: f64) -> Vec<Incidence> {
    let lines = LobeGrid::new(
        eta,
        which,
        LobeHeader {
            shape: Shape { incidences: 2, azimuths: 2, radii: 2, intervals: 1 },
            form: Form::Masked,
            fall: Fall::Flat,
            scale: 1.0,
            grazing: 0.0,
            masking: 0.0,
        },
    );
    let angles = ANGLES.into_iter().chain(critical(eta, which.0));
    let mut incidences: Vec<Incidence> =
        angles.filter_map(|deg| incidence(law, &lines, deg, median)).collect();
    // each by its own peak, or those of high peaks would have all nodes
    let highest = incidences.iter().map(|of| of.peak).fold(0.0, f64::max);
    for Incidence { probes, peak, flux, .. } in &mut incidences {
        let own = (*flux / LIT).min(1.0);
        let scale = peak.powf(own) * highest.powf(1.0 - own);
        for probe in probes {
            probe.weight /= scale * scale;
            probe.light *= own;
        }
    }
    incidences
}

/// Incidences about the critical angle of a side, if it has one.
fn critical(eta: f64, side: Side) -> impl Iterator<Item = f64> {
    let beyond = if side == Side::Air { eta } else { 1.0 / eta };
    let angle = (beyond < 1.0).then(|| beyond.asin().to_degrees());
    let near = CRITICAL.into_iter().filter_map(move |off| angle.map(|angle| angle + off));
    near.filter(|deg| (0.0..90.0).contains(deg))
}

/// The probes of one incidence; `None` without light.
fn incidence(law: &dyn Law, lines: &LobeGrid, deg: f64, median: f64) -> Option<Incidence> {
    let beam = lines.beam(deg.to_radians().cos());
    let mut probes = Vec::new();
    for p in [1.0, -1.0, 0.02] {
        for k in 0..POINTS {
            let r = (f64::from(k) + 0.5) / f64::from(POINTS);
            let s = slope(r, median);
            let Some(turned) = beam.turn(s, p) else { continue };
            let weight = 1.0 / ((1.0 - r) * (1.0 - r)) / (1.0 + s * s);
            let ars = law.ars(beam.wi, turned.wo);
            if ars.is_finite() {
                probes.push(Probe { wi: beam.wi, wo: turned.wo, ars, weight, light: s * weight });
            }
        }
    }
    let peak = probes.iter().map(|probe| probe.ars).fold(0.0, f64::max);
    if peak <= 0.0 {
        return None;
    }
    // bright places have the largest weight within an incidence
    for probe in &mut probes {
        probe.weight *= probe.ars / peak + DIM;
    }
    let all: f64 = probes.iter().map(|probe| probe.weight).sum();
    let area: f64 = probes.iter().map(|probe| probe.light).sum();
    let light: f64 = probes.iter().map(|probe| probe.ars * probe.light).sum();
    for probe in &mut probes {
        probe.weight /= all;
        probe.light /= light;
    }
    let counts = if deg > 60.0 { BEYOND } else { 1.0 };
    Some(Incidence { probes, counts, peak, mean: light / area, flux: flux(law, &beam, lines.lobe) })
}

/// Flux of a lobe, roughly.
fn flux(law: &dyn Law, beam: &Beam, lobe: Lobe) -> f64 {
    Lattice::MIDDLE.flux(&Lattice::MIDDLE.rays(|u| law.sample_lobe(beam.wi, lobe, u)))
}
