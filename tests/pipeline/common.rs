//! Short spellings for the tests of this target: a virtual goniophotometer and fits of its scans.

use asperity::boundary::Boundary;
use asperity::fit::{Fit, FitError, FitOptions, cost_at, fit};
use asperity::forward::{
    Angles, Effort, Incidence, MonteCarlo, Rays, Readings, Sample, Setup, monte_carlo, simulate,
};
use asperity::measurement::{Measurement, Metadata, Quantity, Reading};
use asperity::method::{Body, GgxMethod, Method, NormalsMethod};
use asperity::watch::Watch;
use asperity_core::bsdf::Bsdf;
use asperity_core::gonio::{AngleGrid, Geometry};
use asperity_core::ndf::law::Profile;
use asperity_core::plate::RoughSide;

/// A surface in a setup.
#[derive(Clone, Debug)]
pub(crate) struct Virtual {
    pub(crate) boundary: Boundary,
    pub(crate) setup: Setup,
}

pub(crate) const GAUSS: NormalsMethod = NormalsMethod { profile: Profile::Gauss, centre: false };
pub(crate) const CAUCHY: NormalsMethod = NormalsMethod { profile: Profile::Cauchy, centre: false };

impl Virtual {
    /// A plate seen by the GP-200.
    pub(crate) fn plate(
        method: &dyn Method,
        values: &[f64],
        ior: f64,
        rough_side: RoughSide,
        geometry: Geometry,
    ) -> Self {
        let body = Body::Dielectric { ior };
        let sample = Sample::Plate { eta: body.eta().unwrap(), rough_side };
        let boundary = method.boundary(values, body).unwrap();
        let setup = Setup {
            sample,
            geometry,
            aperture_deg: 0.6,
            slit_height_deg: None,
            quantity: Quantity::Flux,
        };
        Self { boundary, setup }
    }

    /// A GGX plate, rough side to the source, transmitted light.
    pub(crate) fn ggx(alpha: f64, ior: f64) -> Self {
        let method = GgxMethod::new(Body::Dielectric { ior });
        Self::plate(&method, &[alpha], ior, RoughSide::Source, Geometry::Transmission)
    }

    /// An opaque body in relative flux.
    pub(crate) fn opaque(alpha: f64, gain: f64, lambert: f64) -> Self {
        let method = GgxMethod::new(Body::Opaque);
        let boundary = method.boundary(&[alpha, gain, lambert], Body::Opaque).unwrap();
        let setup = Setup {
            sample: Sample::Opaque,
            geometry: Geometry::Reflection,
            aperture_deg: 0.6,
            slit_height_deg: None,
            quantity: Quantity::Flux,
        };
        Self { boundary, setup }
    }

    pub(crate) fn with_sides(mut self, side: RoughSide, geometry: Geometry) -> Self {
        if let Sample::Plate { rough_side, .. } = &mut self.setup.sample {
            *rough_side = side;
        }
        self.setup.geometry = geometry;
        self
    }

    pub(crate) fn with_aperture(mut self, aperture_deg: f64) -> Self {
        self.setup.aperture_deg = aperture_deg;
        self
    }

    /// Typical slope of the facets.
    pub(crate) fn slope(&self) -> f64 {
        match &self.boundary {
            Boundary::Ggx(b) => b.slope(),
            Boundary::Microfacet(b) => b.slope(),
            Boundary::AllGgx(b) => b.slope(),
            Boundary::AllMicrofacet(b) => b.slope(),
            Boundary::Normals(b) => b.slope(),
            Boundary::Opaque(b) => b.slope(),
            Boundary::Tail(b) => b.slope(),
            Boundary::Mix(b) => b.slope(),
            Boundary::Wave(b) => b.slope(),
            Boundary::Table(b) => b.slope(),
            Boundary::Traced(_) | Boundary::Hybrid(_) | Boundary::Walk(_) => {
                panic!("a traced boundary has no closed form")
            }
        }
    }

    pub(crate) fn quadrature(&self, sigmas_deg: &[f64], grid: &AngleGrid<f64>) -> Readings {
        let plan = Angles::product(sigmas_deg, &angles(grid));
        let rays = Rays { count: 1, seed: 0 };
        simulate(&self.boundary, &self.setup, &plan, Effort::Full, rays, Watch::nobody()).unwrap()
    }

    pub(crate) fn monte_carlo(
        &self,
        sigma_deg: f64,
        grid: &AngleGrid<f64>,
        rays: Rays,
    ) -> MonteCarlo {
        let angles = Incidence::in_plane(sigma_deg, angles(grid));
        monte_carlo(&self.boundary, &self.setup, &angles, rays, Watch::nobody()).unwrap()
    }

    /// A scan by quadrature: free of noise.
    pub(crate) fn exact_scan(&self, sigmas_deg: &[f64], grid: &AngleGrid<f64>) -> Measurement {
        let values = self.quadrature(sigmas_deg, grid).values;
        measurement(sigmas_deg, grid, &values)
    }

    /// A scan by Monte Carlo, all readings times `gain`.
    pub(crate) fn noisy_scan(
        &self,
        sigmas_deg: &[f64],
        grid: &AngleGrid<f64>,
        rays: Rays,
        gain: f64,
    ) -> Measurement {
        let values: Vec<f64> = sigmas_deg
            .iter()
            .flat_map(|&sigma| self.monte_carlo(sigma, grid, rays).values)
            .map(|v| v * gain)
            .collect();
        measurement(sigmas_deg, grid, &values)
    }
}

/// From -90 to 90 degrees.
pub(crate) fn grid(steps_per_degree: u32) -> AngleGrid<f64> {
    AngleGrid {
        start_deg: -90.0,
        step_deg: 1.0 / f64::from(steps_per_degree),
        count: 180 * steps_per_degree as usize + 1,
    }
}

pub(crate) fn angles(grid: &AngleGrid<f64>) -> Vec<f64> {
    (0..grid.count).map(|k| grid.degrees(k)).collect()
}

pub(crate) fn measurement(
    sigmas_deg: &[f64],
    grid: &AngleGrid<f64>,
    values: &[f64],
) -> Measurement {
    let readings = sigmas_deg
        .iter()
        .flat_map(|&sigma_deg| angles(grid).into_iter().map(move |theta| (sigma_deg, theta)))
        .zip(values)
        .map(|((sigma_deg, theta_deg), &value)| Reading::in_plane(sigma_deg, theta_deg, value))
        .collect();
    Measurement::new(Metadata::default(), readings).unwrap()
}

/// The options of a plain fit.
pub(crate) fn options(body: Body) -> FitOptions {
    FitOptions { max_evaluations: 4000, ..FitOptions::new(body) }
}

/// A fit that nobody stops.
pub(crate) fn fitted(
    method: &dyn Method,
    scan: &Measurement,
    setup: &Setup,
    options: &FitOptions,
) -> Result<Fit, FitError> {
    fit(method, scan, setup, options, Watch::nobody())
}

/// A fitted value and its standard error.
pub(crate) fn value(fit: &Fit, name: &str) -> (f64, f64) {
    let found = fit.parameters.iter().find(|p| p.name == name).expect("a fitted parameter");
    (found.value, found.std_error.unwrap_or(f64::NAN))
}

/// Errors at three values of the only parameter, the middle one of equal ratios the truth, and where a parabola through their squares
/// is least, as a ratio to the truth. A fit would say the same after forty evaluations.
pub(crate) fn least(
    method: &dyn Method,
    scan: &Measurement,
    setup: &Setup,
    options: &FitOptions,
    truth: f64,
) -> ([f64; 3], f64) {
    let step = 1.12_f64;
    let cost = |value| cost_at(method, scan, setup, options, &[value], Watch::nobody()).unwrap();
    let errors = [truth / step, truth, truth * step].map(cost);
    let [a, b, c] = errors.map(|e| e * e);
    (errors, step.powf(0.5 * (a - c) / (a - 2.0 * b + c)))
}
