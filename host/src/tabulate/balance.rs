//! Flux: what the model has, what the table has, and never more than there is.

use asperity_core::direction::{Direction, Side};
use asperity_core::table::{Storage, incidence_cosine, incidence_place};
use rayon::prelude::*;

use super::grid::{LobeGrid, node};
use super::rays::Turning;
use crate::boundary::{Boundary, with_boundary};
use crate::energy::balance;
use crate::forward::{Rays, count_flux};
use crate::kirchhoff::CoherentFlux;

/// Places between two nodes of incidence where the flux is looked at.
const BETWEEN: usize = 10;
/// Rounds of lowering.
const ROUNDS: usize = 12;
/// What is left below 1 for the rounding of storage and sums.
const MARGIN: f64 = 5e-4;

/// What a law gives beyond what it receives by rounding and noise.
const ROUNDING: f64 = 1e-3;

/// Diffusely reflected and transmitted flux of a model at a cosine of incidence; `None` if it gives more than it receives.
pub(super) fn model_fluxes(
    boundary: &Boundary,
    side: Side,
    cos: f64,
    rays: Rays,
) -> Option<[f64; 2]> {
    let (reflected, transmitted) = with_boundary!(boundary, _law => {
        let flux = balance(boundary, side, cos.acos().to_degrees(), rays);
        (flux.reflected, flux.transmitted)
    }, traced t => {
        let flux = count_flux(&Turning(t), incident(side, cos), rays);
        (flux.reflected, flux.transmitted)
    });
    let coherent = match boundary {
        Boundary::Wave(wave) => wave.coherent(incident(side, cos)),
        _ => CoherentFlux::default(),
    };
    let [r, t] = [reflected - coherent.reflected, transmitted - coherent.transmitted];
    (reflected + transmitted <= 1.0 + ROUNDING).then_some([r.max(0.0), t.max(0.0)])
}

/// The direction that light comes from, at a cosine of incidence.
pub(super) fn incident(side: Side, cos: f64) -> Direction<f64> {
    let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
    Direction::from_unit(-sin, 0.0, if side == Side::Air { cos } else { -cos })
}

/// Coherent reflected and transmitted flux, and the shares of Fresnel's that they are.
pub(super) fn coherent(boundary: &Boundary, side: Side, cos: f64) -> [f64; 4] {
    let (Boundary::Wave(wave), Some(eta)) = (boundary, boundary.eta()) else { return [0.0; 4] };
    let flux = wave.coherent(incident(side, cos));
    let beyond = if side == Side::Air { eta } else { 1.0 / eta };
    let fresnel = asperity_core::fresnel::dielectric(cos, beyond);
    let share = |part: f64, of: f64| if of > 0.0 { (part / of).clamp(0.0, 1.0) } else { 0.0 };
    let shares =
        [share(flux.reflected, fresnel.reflected), share(flux.transmitted, fresnel.transmitted)];
    [flux.reflected, flux.transmitted, shares[0], shares[1]]
}

/// Linear in the cosine between known fluxes, in descending order of the cosine.
pub(super) fn between(known: &[(f64, f64)], cos: f64) -> f64 {
    let after = known.partition_point(|(c, _)| *c > cos).clamp(1, known.len() - 1);
    let ((a, f), (b, g)) = (known[after - 1], known[after]);
    let share = if a > b { ((a - cos) / (a - b)).clamp(0.0, 1.0) } else { 0.0 };
    f + share * (g - f)
}

/// Scales each incidence so that its flux is the model's, but by no more than `most`.
pub(super) fn to_model(
    grid: &mut LobeGrid,
    most: f64,
    model: impl Fn(f64, &LobeGrid) -> f64 + Sync,
) {
    let cosines: Vec<f64> =
        (0..usize::from(grid.header.shape.incidences)).map(|j| grid.cosine(j)).collect();
    let own = fluxes::<f32>(Some(grid), &cosines);
    for (j, (cos, own)) in cosines.iter().zip(own).enumerate() {
        let wanted = model(*cos, grid);
        if own > 0.0 {
            // at grazing incidence sums of either kind are rough: no more than a correction
            let factor = (wanted / own).clamp(1.0 / most, most).sqrt();
            grid.plane(j).iter_mut().for_each(|v| *v *= factor);
        }
    }
}

/// Cosines at nodes of incidence and between them.
fn dense(grid: &LobeGrid) -> impl Iterator<Item = f64> + use<> {
    let count = usize::from(grid.header.shape.incidences);
    let k = f64::from(grid.header.grazing);
    let last = BETWEEN * (count - 1);
    (0..=last).map(move |n| incidence_cosine(n as f64 / last as f64, k).max(2e-3))
}

/// Fluxes of a lobe at cosines.
fn fluxes<S: Storage>(grid: Option<&LobeGrid>, cosines: &[f64]) -> Vec<f64> {
    let of = |grid: &LobeGrid| {
        grid.with_table::<S, _>(|table| {
            cosines.par_iter().map(|cos| grid.flux_of(table, *cos)).collect::<Vec<f64>>()
        })
    };
    grid.and_then(of).unwrap_or_else(|| vec![0.0; cosines.len()])
}

/// Lowers both lobes of a side about each incidence where together they give more than they receive.
pub(super) fn lower<'a, S: Storage>(
    mut reflection: Option<&'a mut LobeGrid>,
    mut transmission: Option<&'a mut LobeGrid>,
    coherent: &dyn Fn(f64) -> [f64; 4],
) {
    let mut cosines: Vec<f64> = Vec::new();
    for grid in [&reflection, &transmission].into_iter().flatten() {
        cosines.extend(dense(grid));
    }
    for _ in 0..ROUNDS {
        let r = fluxes::<S>(reflection.as_deref(), &cosines);
        let t = fluxes::<S>(transmission.as_deref(), &cosines);
        let mut lowered = false;
        let mut factors: [Vec<f64>; 2] = [&reflection, &transmission]
            .map(|g| vec![1.0; g.as_ref().map_or(0, |g| usize::from(g.header.shape.incidences))]);
        for ((cos, r), t) in cosines.iter().zip(&r).zip(&t) {
            let [cr, ct, ..] = coherent(*cos);
            let room = (1.0 - MARGIN - cr - ct).max(0.0);
            if r + t <= room {
                continue;
            }
            lowered = true;
            let factor = (room / (r + t)).sqrt() * (1.0 - 1e-6);
            for (grid, factors) in [&reflection, &transmission].into_iter().zip(&mut factors) {
                let Some(grid) = grid else { continue };
                let k = f64::from(grid.header.grazing);
                let last = usize::from(grid.header.shape.incidences) - 1;
                let y = incidence_place(((1.0 - cos) * (1.0 + cos)).sqrt(), *cos, k) * last as f64;
                for j in [y.floor(), y.ceil()] {
                    let j = (j as usize).min(last);
                    factors[j] = factors[j].min(factor);
                }
            }
        }
        if !lowered {
            return;
        }
        for (grid, factors) in [&mut reflection, &mut transmission].into_iter().zip(factors) {
            if let Some(grid) = grid {
                for (j, factor) in factors.into_iter().enumerate() {
                    grid.plane(j).iter_mut().for_each(|v| *v *= factor);
                }
            }
        }
    }
}

/// Rows of fluxes of a side.
pub(super) fn stored<S: Storage>(
    lobes: [Option<&LobeGrid>; 2],
    coherent: &dyn Fn(f64) -> [f64; 4],
    (count, grazing): (u16, f32),
) -> Vec<[u16; 4]> {
    let cosines: Vec<f64> = (0..usize::from(count))
        .map(|k| incidence_cosine(node(k, count), f64::from(grazing)).max(2e-3))
        .collect();
    let [r, t] = lobes.map(|grid| fluxes::<S>(grid, &cosines));
    let unit = |x: f64| (x.clamp(0.0, 1.0) * 65535.0) as u16;
    cosines
        .iter()
        .zip(r.iter().zip(&t))
        .map(|(cos, (r, t))| {
            let [.., cr, ct] = coherent(*cos);
            // never more than there is, also where the sums of the lobes err
            let scale = (1.0 / (r + t)).min(1.0);
            [unit(r * scale), unit(t * scale), unit(cr), unit(ct)]
        })
        .collect()
}
