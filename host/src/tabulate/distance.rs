//! The distance of a table from its model: eq. (18) of a scan, and the flux.

use asperity_core::bsdf::{Bsdf, Lobe, Scatter};
use asperity_core::direction::Side;
use asperity_core::gonio::{Geometry, gp200};
use asperity_core::metric::rmsd_percent;
use asperity_core::plate::RoughSide;
use asperity_core::quantity::RelativeIor;
use asperity_core::table::{BsdfTableRef, Storage};

use super::balance;
use super::law::Lattice;
use super::turned::{AZIMUTHS, At, Turning};
use crate::boundary::{AnyLaw, Boundary, with_boundary};
use crate::embedded::{EmbeddedTable, with_view};
use crate::forward::{self, Effort, Incidence, Rays, Sample, Setup, mix, monte_carlo, quadrature};
use crate::measurement::Quantity;
use crate::watch::Watch;

/// The distance of a table from its model: eq. (18) of a scan, percent of the largest reading.
///
/// Scans are in the plane of incidence at several azimuths of the surface, of which the first is that of a scan of the model. A law
/// has no azimuth: the last two say something of sampled models only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// From the model itself, over all azimuths.
    pub percent: f64,
    /// From the mean of the model over its azimuths, which is what a table holds.
    pub to_mean_percent: f64,
    /// Of the model at an azimuth from that mean: the grain of a map, or a direction of it.
    pub azimuths_percent: f64,
}

/// Eq. (18) between the readings of a scan of the table and of its model, in transmission, or in reflection if
/// nothing of transmission was tabulated: diffuse light, observation every `step_deg`.
///
/// With all lobes the scan has its internal passes, else first hits are compared. Of a model that must be sampled two
/// independent simulations are taken at every azimuth, whose noise so drops out on average. `None` for such a model without
/// all lobes, and if it was stopped. Speckle of waves is no part of a table: their model is its mean law.
pub fn distance(
    boundary: &Boundary,
    table: &EmbeddedTable,
    step_deg: f64,
    rays: Rays,
    watch: Watch<'_>,
) -> Option<Distance> {
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
    let setup = Setup {
        sample,
        geometry,
        aperture_deg: gp200::APERTURE_DEG,
        slit_height_deg: None,
        quantity: Quantity::Flux,
    };
    let count = (180.0 / step_deg).round() as u32;
    let thetas: Vec<f64> = (0..=count).map(|k| -90.0 + f64::from(k) * step_deg).collect();
    let angles = forward::Angles::product(&gp200::SIGMAS_DEG, &thetas);
    let effort = if full { Effort::Full } else { Effort::Draft };
    let of_table = with_view!(table, view => quadrature(&AnyLaw::of(&view), &setup, &angles, effort).values, else Vec::new());
    with_boundary!(boundary,
    b => {
        let percent = rmsd_percent(&quadrature(b, &setup, &angles, effort).values, &of_table)?;
        Some(Distance { percent, to_mean_percent: percent, azimuths_percent: 0.0 })
    },
    traced t => {
        if !full {
            return None;
        }
        let sampled = Sampled { setup: &setup, thetas: &thetas, rays, watch };
        let seed = |salt| rays.seed.wrapping_add(salt);
        let (a, b) = (sampled.scans(t, seed(101))?, sampled.scans(t, seed(102))?);
        let (mean_a, mean_b) = (sampled.mean(t, seed(103))?, sampled.mean(t, seed(104))?);
        Some(sampled_distance([&a, &b], [&mean_a, &mean_b], &of_table))
    })
}

/// A scan by rays.
struct Sampled<'a> {
    setup: &'a Setup,
    thetas: &'a [f64],
    rays: Rays,
    watch: Watch<'a>,
}

impl Sampled<'_> {
    /// Readings at every azimuth; all azimuths share the rays.
    fn scans<S: Scatter<f64> + Sync>(&self, boundary: &S, seed: u64) -> Option<Vec<Vec<f64>>> {
        let each = Rays { count: (self.rays.count / u64::from(AZIMUTHS)).max(1), seed };
        let one = |azimuth: u32| -> Option<Vec<f64>> {
            let rays = Rays { seed: mix(each.seed, u64::from(azimuth)), ..each };
            self.scan(&At::new(boundary, azimuth), rays)
        };
        (0..AZIMUTHS).map(one).collect()
    }

    /// Readings of the mean over all azimuths, one of chance for each ray.
    fn mean<S: Scatter<f64> + Sync>(&self, boundary: &S, seed: u64) -> Option<Vec<f64>> {
        self.scan(&Turning(boundary), Rays { seed, ..self.rays })
    }

    fn scan<S: Scatter<f64> + Sync>(&self, boundary: &S, rays: Rays) -> Option<Vec<f64>> {
        let mut values = Vec::new();
        for sigma_deg in gp200::SIGMAS_DEG {
            let angles = Incidence::in_plane(sigma_deg, self.thetas.to_vec());
            let read = monte_carlo(boundary, self.setup, &angles, rays, self.watch.quiet());
            values.extend(read?.values);
        }
        Some(values)
    }
}

/// From two independent sets of scans, and two of their mean over all azimuths.
fn sampled_distance(
    [a, b]: [&[Vec<f64>]; 2],
    [mean_a, mean_b]: [&[f64]; 2],
    of_table: &[f64],
) -> Distance {
    let product = |[a, b]: [&[f64]; 2], [x, y]: [&[f64]; 2]| {
        let terms = a.iter().zip(x).zip(b.iter().zip(y)).map(|((a, x), (b, y))| (a - x) * (b - y));
        terms.sum::<f64>() / of_table.len() as f64
    };
    let most = mean_a.iter().zip(mean_b).map(|(a, b)| 0.5 * (a + b)).fold(0.0, f64::max);
    let percent = |square: f64| 100.0 * square.max(0.0).sqrt() / most;
    let over = |[x, y]: [&[f64]; 2]| {
        let sum: f64 = a.iter().zip(b).map(|(a, b)| product([a, b], [x, y])).sum();
        sum / a.len() as f64
    };
    Distance {
        percent: percent(over([of_table, of_table])),
        to_mean_percent: percent(product([mean_a, mean_b], [of_table, of_table])),
        azimuths_percent: percent(over([mean_a, mean_b])),
    }
}

/// Largest difference of the flux of a table's lobes and the model's, absolute, over incidences 0 to 80 degrees. A model that must be
/// sampled is counted with `rays` per incidence.
///
/// Incidences at which the model itself gives more than it receives, as waves may, are left out: no table follows it there.
/// `None` if there are no others. Once it is stopped rays are lost, and the difference means nothing.
pub fn energy_error(
    boundary: &Boundary,
    table: &EmbeddedTable,
    rays: Rays,
    watch: Watch<'_>,
) -> Option<f64> {
    let mut worst: Option<f64> = None;
    for (k, side) in [Side::Air, Side::Dielectric].into_iter().enumerate() {
        for deg in [0.0_f64, 11.0, 25.0, 37.0, 45.0, 52.0, 60.0, 70.0, 80.0] {
            let cos = deg.to_radians().cos();
            let model = balance::model_fluxes(boundary, side, cos, (rays, watch));
            let Some(model) = model else { continue };
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

/// Flux of a lobe of the table itself, by its samples.
fn summed(table: &EmbeddedTable, (side, lobe): (Side, Lobe), cos: f64) -> f64 {
    fn of<S: Storage>(view: &BsdfTableRef<'_, S>, (side, lobe): (Side, Lobe), cos: f64) -> f64 {
        let wi = balance::incident(side, cos);
        let coherent = view.coherent(wi).map_or(0.0, |c| match lobe {
            Lobe::Reflection => c.reflected.weight,
            Lobe::Transmission => c.transmitted.map_or(0.0, |t| t.weight),
        });
        let rays = Lattice::FINE.rays(|u| view.sample_lobe(wi, lobe, u));
        Lattice::FINE.flux(&rays) - coherent
    }
    with_view!(table, view => of(&view, (side, lobe), cos), else 0.0)
}
