//! Flux: what the model has, what the table has, and never more than there is.

use asperity_core::direction::{Direction, Side};
use asperity_core::table::{Storage, incidence_cosine, incidence_place};
use rayon::prelude::*;

use super::grid::{LobeGrid, node};
use super::rays::Turning;
use crate::boundary::{Boundary, with_boundary};
use crate::energy::balance;
use crate::forward::{Rays, count_flux};

/// Factor by which the flux may change a gain.
const MOST: f64 = 2.0;
/// Places from one gain to the next where the flux is looked at.
const BETWEEN: u32 = 2;
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
    let coherent = boundary.coherent(incident(side, cos));
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

/// Changes the gains so that the flux at each is the model's, but none by more than a factor of [`MOST`].
pub(super) fn to_model(grid: &mut LobeGrid, model: &[f64]) {
    let own = fluxes::<f32>(Some(grid), &grid.cosines());
    for (trim, (own, wanted)) in grid.trim.iter_mut().zip(own.iter().zip(model)) {
        if *own > 0.0 {
            // where there is hardly any light sums of either kind are rough
            *trim *= (wanted / own).clamp(1.0 / MOST, MOST);
        }
    }
}

/// Cosines of the gains and between them.
fn dense(grid: &LobeGrid) -> Vec<f64> {
    let nodes = grid.cosines();
    let between = |ends: &[f64]| {
        (0..BETWEEN)
            .map(|k| {
                let share = f64::from(k) / f64::from(BETWEEN);
                ends[0] + share * (ends[1] - ends[0])
            })
            .collect::<Vec<f64>>()
    };
    nodes.windows(2).flat_map(between).chain(nodes.last().copied()).collect()
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
        let mut factors = [&reflection, &transmission]
            .map(|g| vec![1.0_f64; g.as_ref().map_or(0, |g| g.trim.len())]);
        for ((cos, r), t) in cosines.iter().zip(&r).zip(&t) {
            let [cr, ct, ..] = coherent(*cos);
            let room = (1.0 - MARGIN - cr - ct).max(0.0);
            if r + t <= room {
                continue;
            }
            lowered = true;
            let factor = room / (r + t) * (1.0 - 1e-6);
            for (grid, factors) in [&reflection, &transmission].into_iter().zip(&mut factors) {
                let Some(grid) = grid else { continue };
                let k = f64::from(grid.header.grazing);
                let last = grid.trim.len() - 1;
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
                grid.trim.iter_mut().zip(factors).for_each(|(trim, factor)| *trim *= factor);
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
