//! How far a table is from its model: eq. (18) of a scan, and the flux.

use std::sync::atomic::AtomicBool;

use asperity_core::bsdf::{Bsdf, Lobe};
use asperity_core::direction::Side;
use asperity_core::gonio::Geometry;
use asperity_core::metric::rmsd_percent;
use asperity_core::plate::RoughSide;
use asperity_core::quantity::RelativeIor;
use asperity_core::table::{BsdfTableRef, Storage};

use super::balance;
use super::rays::Turning;
use crate::boundary::{Boundary, with_boundary};
use crate::embedded::{EmbeddedTable, with_view};
use crate::forward::{self, Effort, Incidence, Rays, Sample, Setup, monte_carlo, quadrature};
use crate::measurement::Quantity;

/// Incidences of the instrument, degrees.
const SIGMAS: [f64; 5] = [0.0, 15.0, 30.0, 45.0, 60.0];
const APERTURE_DEG: f64 = 0.6;

/// Eq. (18) between the readings of a scan of the table and of its model, percent, in transmission, or in reflection if
/// nothing of transmission was tabulated: diffuse light, observation every `step_deg`.
///
/// With all lobes the scan has its internal passes, else first hits are compared. Of a model that must be sampled two
/// independent simulations are taken, whose noise so drops out on average, of the model's mean over all azimuths; `None` for such a model without all lobes, and if
/// `stop` was set.
pub fn distance_percent(
    boundary: &Boundary,
    table: &EmbeddedTable,
    step_deg: f64,
    rays: Rays,
    stop: &AtomicBool,
) -> Option<f64> {
    let lobes = table.header().lobes;
    let full = lobes.iter().all(Option::is_some);
    let geometry = if lobes[1].is_some() { Geometry::Transmission } else { Geometry::Reflection };
    let sample = match boundary.eta() {
        Some(eta) => Sample::Plate {
            eta: RelativeIor::new(eta).ok()?,
            // without light from the air only the other face shows what there is
            rough_side: if lobes[0].is_some() || lobes[1].is_some() {
                RoughSide::Source
            } else {
                RoughSide::Detector
            },
        },
        None => Sample::Opaque,
    };
    let geometry = match (&sample, lobes[3].is_some()) {
        (Sample::Plate { rough_side: RoughSide::Detector, .. }, true) => Geometry::Transmission,
        _ => geometry,
    };
    let setup = Setup { sample, geometry, aperture_deg: APERTURE_DEG, quantity: Quantity::Flux };
    let count = (180.0 / step_deg).round() as u32;
    let thetas: Vec<f64> = (0..=count).map(|k| -90.0 + f64::from(k) * step_deg).collect();
    let plan = forward::Plan::product(&SIGMAS, &thetas);
    let effort = if full { Effort::Full } else { Effort::Draft };
    let of_table =
        with_view!(table, view => quadrature(&view, &setup, &plan, effort).values, else Vec::new());
    with_boundary!(boundary,
    b => rmsd_percent(&quadrature(b, &setup, &plan, effort).values, &of_table),
    traced t => {
        if !full {
            return None;
        }
        let t = &Turning(t);
        let scan = |seed| -> Option<Vec<f64>> {
            let mut values = Vec::new();
            for sigma_deg in SIGMAS {
                let angles = Incidence { sigma_deg, theta_deg: thetas.clone() };
                let rays = Rays { seed, ..rays };
                values.extend(monte_carlo(t, &setup, &angles, rays, stop, &|_| ())?.values);
            }
            Some(values)
        };
        let (a, b) = (scan(rays.seed + 101)?, scan(rays.seed + 102)?);
        let most = a.iter().zip(&b).map(|(a, b)| 0.5 * (a + b)).fold(0.0, f64::max);
        let sum: f64 =
            of_table.iter().zip(a.iter().zip(&b)).map(|(t, (a, b))| (a - t) * (b - t)).sum();
        Some(100.0 * (sum / of_table.len() as f64).max(0.0).sqrt() / most)
    })
}

/// Largest difference of the flux of a table's lobes and the model's, absolute, over incidences 0 to 80 degrees. A model that must be
/// sampled is counted with `rays` an incidence.
///
/// Incidences at which the model itself gives more than it receives, as waves may, are left out: no table follows it there.
/// `None` if there are no others.
pub fn energy_error(boundary: &Boundary, table: &EmbeddedTable, rays: Rays) -> Option<f64> {
    let mut worst: Option<f64> = None;
    for (k, side) in [Side::Air, Side::Dielectric].into_iter().enumerate() {
        for deg in [0.0_f64, 11.0, 25.0, 37.0, 45.0, 52.0, 60.0, 70.0, 80.0] {
            let cos = deg.to_radians().cos();
            let Some(model) = balance::model_fluxes(boundary, side, cos, rays) else { continue };
            for (j, lobe) in [Lobe::Reflection, Lobe::Transmission].into_iter().enumerate() {
                if table.header().lobes[2 * k + j].is_some() {
                    let off = (model[j] - summed(table, (side, lobe), cos)).abs();
                    worst = Some(worst.unwrap_or(0.0).max(off));
                }
            }
        }
    }
    worst
}

/// Flux of a lobe of the table itself: the mean weight of its samples over a lattice.
fn summed(table: &EmbeddedTable, (side, lobe): (Side, Lobe), cos: f64) -> f64 {
    const POINTS: u32 = 46_368;
    const STEP: u32 = 28_657;
    fn of<S: Storage>(view: &BsdfTableRef<'_, S>, (side, lobe): (Side, Lobe), cos: f64) -> f64 {
        let wi = balance::incident(side, cos);
        let coherent = view.coherent(wi).map_or(0.0, |c| match lobe {
            Lobe::Reflection => c.reflected.weight,
            Lobe::Transmission => c.transmitted.map_or(0.0, |t| t.weight),
        });
        let n = f64::from(POINTS);
        let weight = |k: u32| {
            let around = (u64::from(k) * u64::from(STEP) % u64::from(POINTS)) as f64 / n;
            let u = [around, (f64::from(k) + 0.5) / n];
            view.sample_lobe(wi, lobe, u).map_or(0.0, |ray| ray.weight)
        };
        (0..POINTS).map(weight).sum::<f64>() / n - coherent
    }
    with_view!(table, view => of(&view, (side, lobe), cos), else 0.0)
}
