//! Flux of the model and of the table; a table never gives more than it receives.

use asperity_core::direction::{Direction, Side};
use asperity_core::table::{Place, Storage, cells, incidence_cosine, incidence_place};

use super::grid::{LobeGrid, node};
use super::turned::Turning;
use crate::boundary::{Boundary, with_boundary};
use crate::energy::balance;
use crate::forward::{Rays, count_flux_until};
use crate::parallel;
use crate::watch::Watch;

/// Factor by which the flux may change a gain where the table has next to none, and what that is.
const MOST: f64 = 2.0;
const DIM: f64 = 1e-3;
/// Places from one gain to the next where the flux is looked at.
const BETWEEN: usize = 2;
/// Rounds of lowering.
const ROUNDS: usize = 12;
/// What is left below 1 for the rounding of storage and sums.
const MARGIN: f64 = 5e-4;

/// The excess of a law by rounding and noise.
const ROUNDING: f64 = 1e-3;

/// Diffusely reflected and transmitted flux of a model at a cosine of incidence; `None` if it gives more than it receives.
/// Once it is stopped rays are lost, and the flux means nothing.
pub(super) fn model_fluxes(
    boundary: &Boundary,
    side: Side,
    cos: f64,
    (rays, watch): (Rays, Watch<'_>),
) -> Option<[f64; 2]> {
    let (reflected, transmitted) = with_boundary!(boundary, _law => {
        let flux = balance(boundary, side, cos.acos().to_degrees(), rays);
        (flux.reflected, flux.transmitted)
    }, traced t => {
        let flux = count_flux_until(&Turning(t), incident(side, cos), rays, watch);
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
    let Some(eta) = boundary.eta() else { return [0.0; 4] };
    let flux = boundary.coherent(incident(side, cos));
    let beyond = if side == Side::Air { eta } else { 1.0 / eta };
    let fresnel = asperity_core::fresnel::dielectric(cos, beyond);
    let share = |part: f64, of: f64| if of > 0.0 { (part / of).clamp(0.0, 1.0) } else { 0.0 };
    let shares =
        [share(flux.reflected, fresnel.reflected), share(flux.transmitted, fresnel.transmitted)];
    [flux.reflected, flux.transmitted, shares[0], shares[1]]
}

/// The same as a table gives them: the shares are linear between its rows of fluxes. At grazing incidence, where all light becomes
/// coherent, that may be some percent more.
pub(super) fn coherent_between(
    coherent: &dyn Fn(f64) -> [f64; 4],
    beyond: f64,
    (count, grazing): (u16, f32),
) -> impl Fn(f64) -> [f64; 4] + use<> {
    let k = f64::from(grazing);
    let rows = row_cosines(count, grazing).into_iter().map(coherent).map(|[.., r, t]| [r, t]);
    let rows: Vec<[f64; 2]> = rows.collect();
    move |cos| {
        let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
        let place: Place<f64> = Place::of(incidence_place(sin, cos, k), cells(count));
        let low = place.cell.min(rows.len() - 2);
        let [r, t] = [0, 1].map(|lobe| place.mix(rows[low][lobe], rows[low + 1][lobe]));
        let fresnel = asperity_core::fresnel::dielectric(cos, beyond);
        [r * fresnel.reflected, t * fresnel.transmitted, r, t]
    }
}

/// Changes the gains so that the flux at each is the model's; where there is hardly any light by no more than a factor of
/// [`MOST`].
pub(super) fn to_model(grid: &mut LobeGrid, model: &[f64]) {
    let own = fluxes::<f32>(Some(grid), &grid.cosines());
    for (trim, (own, wanted)) in grid.trim.iter_mut().zip(own.iter().zip(model)) {
        if *own > 0.0 {
            // where there is hardly any light sums of either kind are rough
            let most = if *own < DIM { MOST } else { f64::INFINITY };
            *trim *= (wanted / own).clamp(1.0 / most, most);
        }
    }
}

/// Cosines of the gains and between them: every [`BETWEEN`]th is that of a gain.
fn dense(grid: &LobeGrid) -> Vec<f64> {
    let nodes = grid.cosines();
    let between = |ends: &[f64]| {
        (0..BETWEEN)
            .map(|k| {
                let share = k as f64 / BETWEEN as f64;
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
            parallel::map_slice(cosines, &|cos| grid.flux_of(table, *cos))
        })
    };
    grid.and_then(of).unwrap_or_else(|| vec![0.0; cosines.len()])
}

/// A lobe while its gains are lowered, with its flux at each cosine of incidence. The flux is proportional to the gain there, so
/// new gains need no new sums over facets.
struct Lowered<'a> {
    grid: &'a mut LobeGrid,
    fluxes: Vec<f64>,
    /// By what the gains were lowered.
    trim: Vec<f64>,
}

impl<'a> Lowered<'a> {
    fn new<S: Storage>(grid: &'a mut LobeGrid, cosines: &[f64]) -> Self {
        let fluxes = fluxes::<S>(Some(grid), cosines);
        let trim = vec![1.0; grid.trim.len()];
        Self { grid, fluxes, trim }
    }

    /// The gain below a cosine, and how far towards the next it lies.
    fn place(&self, cos: f64) -> (usize, f64) {
        let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
        let cells = self.trim.len() - 1;
        let y = incidence_place(sin, cos, f64::from(self.grid.header.grazing)) * cells as f64;
        let low = (y.floor() as usize).min(cells - 1);
        (low, y - low as f64)
    }

    /// The flux at each cosine with the gains as they are now.
    fn now(&self, cosines: &[f64]) -> Vec<f64> {
        let gains = self.grid.gains();
        let mixed = |values: &dyn Fn(usize) -> f64, (low, share): (usize, f64)| {
            values(low) * (1.0 - share) + values(low + 1) * share
        };
        let of = |(cos, flux): (&f64, &f64)| {
            let place = self.place(*cos);
            let before = mixed(&|n| gains[n], place);
            let after = mixed(&|n| gains[n] * self.trim[n], place);
            if before > 0.0 { flux * after / before } else { *flux }
        };
        cosines.iter().zip(&self.fluxes).map(of).collect()
    }

    /// Lowers each gain by the least of the factors about it.
    fn lower(&mut self, cosines: &[f64], needed: &[f64]) {
        let mut factors = vec![1.0_f64; self.trim.len()];
        for (cos, needed) in cosines.iter().zip(needed) {
            let (low, share) = self.place(*cos);
            for n in [low + usize::from(share >= 1.0), low + usize::from(share > 0.0)] {
                factors[n] = factors[n].min(*needed);
            }
        }
        self.by(&factors);
    }

    fn by(&mut self, factors: &[f64]) {
        self.trim.iter_mut().zip(factors).for_each(|(trim, factor)| *trim *= factor);
    }
}

/// Lowers both lobes of a side where together they give more than they receive, each by the same factor
/// `F = (1 - coherent) / (R + T)`.
///
/// First every gain by the `F` of its own incidence, so that `R + T` is what is received at those incidences and the lobes share it
/// as they did; then, round by round, the gains about each incidence between them at which too much is left. Without the first
/// step the greater need of one incidence would lower those beside it: where `R + T` runs away as `1 / cos`, as that of waves does at
/// grazing incidence, the table would end far below 1.
pub(super) fn lower<'a, S: Storage>(
    reflection: Option<&'a mut LobeGrid>,
    transmission: Option<&'a mut LobeGrid>,
    coherent: &dyn Fn(f64) -> [f64; 4],
) {
    let grids: Vec<&mut LobeGrid> = [reflection, transmission].into_iter().flatten().collect();
    let own: Vec<Vec<f64>> = grids.iter().map(|grid| dense(grid)).collect();
    let cosines = own.concat();
    let received = |cos: &f64| {
        let [cr, ct, ..] = coherent(*cos);
        (1.0 - MARGIN - cr - ct).max(0.0)
    };
    let room: Vec<f64> = cosines.iter().map(received).collect();
    let mut lobes: Vec<Lowered<'_>> =
        grids.into_iter().map(|grid| Lowered::new::<S>(grid, &cosines)).collect();
    let factors = |lobes: &[Lowered<'_>]| -> Vec<f64> {
        let mut all = vec![0.0; cosines.len()];
        for lobe in lobes {
            all.iter_mut().zip(lobe.now(&cosines)).for_each(|(all, flux)| *all += flux);
        }
        let factor = |(all, room): (&f64, &f64)| {
            if all <= room { 1.0 } else { room / all * (1.0 - 1e-6) }
        };
        all.iter().zip(&room).map(factor).collect()
    };
    let needed = factors(&lobes);
    let mut rest = needed.as_slice();
    for (lobe, own) in lobes.iter_mut().zip(&own) {
        let (of_own, others) = rest.split_at(own.len());
        lobe.by(&of_own.iter().copied().step_by(BETWEEN).collect::<Vec<f64>>());
        rest = others;
    }
    for _ in 0..ROUNDS {
        let needed = factors(&lobes);
        if needed.iter().all(|factor| *factor >= 1.0) {
            break;
        }
        for lobe in &mut lobes {
            lobe.lower(&cosines, &needed);
        }
    }
    for Lowered { grid, trim, .. } in lobes {
        grid.trim.iter_mut().zip(trim).for_each(|(own, factor)| *own *= factor);
    }
}

/// Cosines of incidence of the rows of fluxes.
fn row_cosines(count: u16, grazing: f32) -> Vec<f64> {
    let cosine = |k| incidence_cosine(node(k, count), f64::from(grazing)).max(2e-3);
    (0..usize::from(count)).map(cosine).collect()
}

/// Rows of fluxes of a side.
pub(super) fn stored<S: Storage>(
    lobes: [Option<&LobeGrid>; 2],
    coherent: &dyn Fn(f64) -> [f64; 4],
    (count, grazing): (u16, f32),
) -> Vec<[u16; 4]> {
    let cosines = row_cosines(count, grazing);
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
