//! Makes the table of a boundary for a microcontroller.
//!
//! A law with values is evaluated at the nodes. `search` chooses the factors to divide out, the scale of slopes and the numbers of nodes
//! that give the smallest error. A boundary that can only be sampled sends rays: `pilot` sends some to make these choices, `rays` sends many to fill
//! the nodes. A table has no azimuth of the light, so `azimuths` refuses a surface with a direction. Finally `balance` gives the lobes the
//! flux of the model at each node of incidence; where the table would give more than it receives, as waves do at grazing incidence, it lowers both.
//!
//! ```
//! use asperity::{boundary::Boundary, forward::Rays, tabulate::{Budget, tabulate}};
//! use asperity::watch::Watch;
//! use asperity_core::bsdf::{Bsdf, Ggx, LobeSet};
//! use asperity_core::direction::Direction;
//! use asperity_core::quantity::{Alpha, RelativeIor};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let law = Ggx::new(Alpha::new(0.2)?, RelativeIor::new(1.49)?);
//! let rays = Rays { count: 0, seed: 1 }; // a closed form needs none
//! let budget = Budget { lobes: LobeSet::AIR_TRANSMISSION, bytes: 4096, kept: None, rays };
//! let table = tabulate(&Boundary::Ggx(law), &budget, Watch::nobody())?;
//! assert!(table.bytes() <= 4096);
//! let (wi, wo) = (Direction::from_angles(0.5, 0.0), Direction::from_angles(2.8, 3.1));
//! let (exact, looked_up): (f64, f64) = (law.eval(wi, wo), table.eval(wi, wo));
//! assert!((looked_up / exact - 1.0).abs() < 0.02, "{looked_up} {exact}");
//! # Ok(())
//! # }
//! ```

mod facet;
mod law;
mod grid;
mod fill;
mod samples;
mod turned;
mod rays;
mod pilot;
mod balance;
mod search;
mod bins;
mod azimuths;
mod distance;
mod lobes;

pub use distance::{Distance, distance, energy_error};
pub use lobes::{LobeDistance, lobe_distances};

use asperity_core::bsdf::{Bsdf, LobeSet};
use asperity_core::direction::Side;
use asperity_core::quantity::RelativeIor;
use asperity_core::table::{Header, Storage};

use crate::boundary::{Boundary, with_boundary};
use crate::embedded::{EmbeddedTable, Rest, Values};
use crate::forward::{Heeding, Rays};
use crate::parallel;
use crate::shard::Piece;
use crate::surface::spectrum::Anisotropy;
use crate::watch::{Progress, Watch};
use grid::LobeGrid;

/// The storage of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// 8 bits.
    U8,
    /// 16 bits.
    U16,
    /// Single precision.
    F32,
}

/// The content of a table, and its largest size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// The lobes that are wanted.
    pub lobes: LobeSet,
    /// Bytes of all arrays together, at most.
    pub bytes: usize,
    /// The storage of values; without it the number of bytes decides.
    pub kept: Option<Kept>,
    /// Rays per incidence, for a boundary that must be sampled.
    pub rays: Rays,
}

/// Bytes from which on values have 16 bits unless asked otherwise.
const WIDE: usize = 12 << 10;

/// Why there is no table.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoTable {
    /// Too few bytes for the smallest table.
    #[error("{0} bytes are too few; give at least {1}")]
    Small(usize, usize),
    /// No lobe is left that has light.
    #[error("there is no lobe to tabulate: an opaque body reflects light from the air only")]
    NoLobe,
    /// It is a table itself.
    #[error("it is a table already; give the model it was made of")]
    Table,
    /// The surface has a direction, and lobes depend on the azimuth of the light.
    #[error(
        "the surface has a direction (strength {strength:.2}, lay {lay_deg:.0} deg): its lobes differ by {percent:.1} % of their peak \
         from one azimuth of the light to another, and a table holds none; give `eval`, `check` and `scan` the model itself"
    )]
    Directional {
        /// Strength of the harmonic of its slopes, 0 to 1.
        strength: f64,
        /// Direction of its grooves, degrees from x to y.
        lay_deg: f64,
        /// Largest root mean square difference of a lobe from its mean over azimuths, % of its peak.
        percent: f64,
    },
    /// The same of waves, whose mean over azimuths no such surface scatters.
    #[error(
        "the surface has a direction (strength {strength:.2}, lay {lay_deg:.0} deg), and a table holds the mean of its waves over \
         all azimuths, which it does not scatter; give `eval`, `check` and `scan` the model itself"
    )]
    DirectionalWaves {
        /// As above.
        strength: f64,
        /// As above.
        lay_deg: f64,
    },
    /// The law has two widths.
    #[error(
        "the law has a direction, and its lobes depend on the azimuth of the light, of which a table holds none; give `eval`, `check` \
         and `scan` the model itself"
    )]
    Anisotropic,
    /// The media are alike: there is no boundary.
    #[error("the media are alike; there is nothing to tabulate")]
    Matched,
    /// A law about the specular direction.
    #[error(
        "a table has no place for what such a law leaves specular; its three parameters are smaller than any table: use the model"
    )]
    Specular,
    /// Values that are not finite, or too large.
    #[error("the model gives values that no table can hold")]
    Values,
    /// Interrupted.
    #[error("interrupted")]
    Stopped,
}

/// Makes the table of a boundary. `watch` is told the steps done; a part of the work ends as if it were stopped.
///
/// # Errors
/// [`NoTable`] if there is none.
pub fn tabulate(
    boundary: &Boundary,
    plan: &Budget,
    watch: Watch<'_>,
) -> Result<EmbeddedTable, NoTable> {
    if matches!(boundary, Boundary::Table(_)) {
        return Err(NoTable::Table);
    }
    if boundary.lobe().is_some() {
        return Err(NoTable::Specular);
    }
    let mut wanted = plan.lobes;
    if boundary.eta().is_none() {
        wanted = wanted & LobeSet::AIR_REFLECTION;
    }
    let count = wanted.len();
    if count == 0 {
        return Err(NoTable::NoLobe);
    }
    let eta = boundary.eta().unwrap_or(f64::from(Header::STAND_IN));
    let index = RelativeIor::new(eta as f32).map_err(|_| NoTable::Values)?;
    if index.is_matched() {
        return Err(NoTable::Matched);
    }
    let kept = plan.kept.unwrap_or(if plan.bytes < WIDE { Kept::U8 } else { Kept::U16 });
    let least = 1400 * count * if kept == Kept::U8 { 1 } else { 2 };
    if plan.bytes < least {
        return Err(NoTable::Small(plan.bytes, least));
    }
    if boundary.is_anisotropic() {
        return Err(NoTable::Anisotropic);
    }
    let directional = azimuths::directional(boundary, wanted, plan.rays, watch);
    if watch.is_stopped() {
        return Err(NoTable::Stopped);
    }
    if let Some(found) = directional {
        let Anisotropy { strength, lay_deg, .. } = found.anisotropy;
        return Err(match found.percent {
            Some(percent) => NoTable::Directional { strength, lay_deg, percent },
            None => NoTable::DirectionalWaves { strength, lay_deg },
        });
    }
    let made = match kept {
        Kept::U8 => of_storage::<u8>(boundary, plan, (eta, wanted), watch),
        Kept::U16 => of_storage::<u16>(boundary, plan, (eta, wanted), watch),
        Kept::F32 => of_storage::<f32>(boundary, plan, (eta, wanted), watch),
    };
    let (lobes, slope) = made?;
    let fluxes = flux_nodes(plan.bytes);
    let done = match kept {
        Kept::U8 => finish::<u8>(boundary, lobes, (index, slope, fluxes), Values::U8),
        Kept::U16 => finish::<u16>(boundary, lobes, (index, slope, fluxes), Values::U16),
        Kept::F32 => finish::<f32>(boundary, lobes, (index, slope, fluxes), Values::F32),
    };
    done.ok_or(NoTable::Values)
}

/// Incidences of the fluxes of each side.
fn flux_nodes(bytes: usize) -> u16 {
    if bytes < WIDE { 25 } else { 65 }
}

/// Lobes with the flux of the model at their nodes.
type Lobes = [Option<LobeGrid>; 4];

fn of_storage<S: Storage>(
    boundary: &Boundary,
    plan: &Budget,
    (eta, wanted): (f64, LobeSet),
    watch: Watch<'_>,
) -> Result<(Lobes, f64), NoTable> {
    let count = wanted.len();
    let budget = (plan.bytes - 16 * usize::from(flux_nodes(plan.bytes))) / count;
    with_boundary!(boundary,
    b => {
        let mut lobes: Lobes = [const { None }; 4];
        let mut done = 0;
        let each = LobeSet::ORDER.into_iter().enumerate();
        for (k, which) in each.filter(|(_, (side, lobe))| wanted.contains(LobeSet::of(*side, *lobe))) {
            if watch.is_stopped() {
                return Err(NoTable::Stopped);
            }
            let mut grid = search::best::<S>(b, eta, which, budget);
            let model = parallel::map_slice(&grid.cosines(), &|cos| grid.flux_of(b, *cos));
            balance::to_model(&mut grid, &model);
            lobes[k] = Some(grid);
            done += 1;
            watch.done(done, count);
        }
        Ok((lobes, b.slope()))
    },
    traced t => of_rays::<_, S>(t, plan, (eta, wanted), budget, watch))
}

/// Lobes of a boundary that is sampled: one choice of nodes for all.
fn of_rays<B: asperity_core::bsdf::Scatter<f64> + Sync, S: Storage>(
    boundary: &B,
    plan: &Budget,
    (eta, wanted): (f64, LobeSet),
    budget: usize,
    watch: Watch<'_>,
) -> Result<(Lobes, f64), NoTable> {
    let boundary = &Heeding { boundary, watch };
    let mut lobes: Lobes = [const { None }; 4];
    let sides = [Side::Air, Side::Dielectric];
    let of_side = [LobeSet::AIR, LobeSet::DIELECTRIC];
    let used = of_side.into_iter().filter(|side| !(wanted & *side).is_empty()).count();
    let (mut done, mut slope) = (0, None);
    for (at, side) in sides.into_iter().enumerate() {
        // from inside much changes about the critical angle
        let incidences = match (budget < 4096, side) {
            (true, Side::Air) => 9,
            (true, Side::Dielectric) => 12,
            (false, Side::Air) => 14,
            (false, Side::Dielectric) => 20,
        };
        let fitted = |azimuths| search::fitted::<S>(incidences, azimuths, budget);
        let chosen = pilot::chosen(boundary, (eta, side), incidences, fitted, plan.rays);
        slope = slope.or(Some(chosen[0].1));
        let made = [0, 1].map(|k| {
            let (side, lobe) = LobeSet::ORDER[2 * at + k];
            let grid = || LobeGrid::new(eta, (side, lobe), chosen[k].0);
            wanted.contains(LobeSet::of(side, lobe)).then(grid)
        });
        if made.iter().all(Option::is_none) {
            continue;
        }
        let [mut reflection, mut transmission] = made;
        let step = std::sync::atomic::AtomicUsize::new(done);
        let all = used * usize::from(incidences);
        let tick = |_: Progress<'_>| {
            watch.done(step.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1, all);
        };
        let both = [reflection.as_mut(), transmission.as_mut()];
        let fluxes = rays::fill(boundary, both, plan.rays, watch.telling(&tick));
        if watch.is_part_of(Piece::TableRays) && !watch.is_stopped() {
            done += usize::from(incidences);
            continue;
        }
        // the last incidence may have been cut short
        let fluxes = fluxes.filter(|_| !watch.is_stopped());
        let fluxes = fluxes.ok_or(NoTable::Stopped)?;
        done += usize::from(incidences);
        for (k, grid) in [reflection, transmission].into_iter().enumerate() {
            if let Some(mut grid) = grid {
                let model: Vec<f64> = fluxes.iter().map(|flux| flux[k]).collect();
                balance::to_model(&mut grid, &model);
                lobes[2 * at + k] = Some(grid);
            }
        }
    }
    if watch.is_part_of(Piece::TableRays) {
        Err(NoTable::Stopped)
    } else {
        Ok((lobes, slope.unwrap_or(0.1)))
    }
}

/// Stores everything.
fn finish<S: Storage>(
    boundary: &Boundary,
    mut lobes: Lobes,
    (eta, slope, fluxes): (RelativeIor<f32>, f64, u16),
    kept: impl Fn(Vec<S>) -> Values,
) -> Option<EmbeddedTable> {
    // fluxes need no crowding
    const GRAZING: f32 = 0.0;
    let mut rest = Rest::default();
    let mut rows = [0; 2];
    for (k, side) in [Side::Air, Side::Dielectric].into_iter().enumerate() {
        let [reflection, transmission] = lobes.get_disjoint_mut([2 * k, 2 * k + 1]).ok()?;
        let coherent = |cos| balance::coherent(boundary, side, cos);
        let beyond = f64::from(if side == Side::Air { eta.get() } else { eta.inverse() });
        let between = balance::coherent_between(&coherent, beyond, (fluxes, GRAZING));
        balance::lower::<S>(reflection.as_mut(), transmission.as_mut(), &between);
        if reflection.is_some() || transmission.is_some() {
            rows[k] = fluxes;
            let both = [reflection.as_ref(), transmission.as_ref()];
            rest.fluxes.extend(balance::stored::<S>(both, &coherent, (fluxes, GRAZING)));
        }
    }
    let mut values = Vec::new();
    for grid in lobes.iter().flatten() {
        let (gains, own) = grid.stored::<S>();
        let (quantiles, leans) = grid.with_table::<S, _>(|table| samples::samples(grid, table))?;
        rest.gains.extend(gains);
        values.extend(own);
        rest.quantiles.extend(quantiles);
        rest.leans.extend(leans);
    }
    let header = Header {
        eta,
        opaque: boundary.eta().is_none(),
        slope: slope as f32,
        lobes: lobes.map(|grid| grid.map(|g| g.header)),
        fluxes: rows,
        grazing: [GRAZING; 2],
    };
    EmbeddedTable::new(header, kept(values), rest).ok()
}
