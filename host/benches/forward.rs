//! Batches of evaluations, the deterministic forward model and a fit: what a reconstruction waits for.
//!
//! Batches run on one core; the forward model and the fit use all of them.
#![expect(clippy::unwrap_used, reason = "constant inputs")]

use std::hint::black_box;
use std::time::Duration;

use asperity::batch::{Directions, Vectorised, ggx_ars};
use asperity::fit::{FitOptions, fit};
use asperity::forward::{Angles, Effort, Sample, Setup, quadrature};
use asperity::measurement::{Measurement, Metadata, Quantity, Reading};
use asperity::method::{Body, GgxMethod};
use asperity::watch::Watch;
use asperity_core::bsdf::{Bsdf, Ggx, Normals};
use asperity_core::direction::Direction;
use asperity_core::gonio::Geometry;
use asperity_core::math::Real;
use asperity_core::ndf::law::{Law, Profile};
use asperity_core::ndf::normals::NormalDensity;
use asperity_core::plate::RoughSide;
use asperity_core::quantity::{Alpha, RelativeIor};
use criterion::{BenchmarkId, Criterion, Throughput};
use rand_pcg::Pcg64Mcg;

const PAIRS: usize = 1 << 14;
const SIGMA_DEG: [f64; 5] = [0.0, 15.0, 30.0, 45.0, 60.0];
const IOR: f64 = 1.49;

fn ggx<T: Real>(alpha: f64) -> Ggx<T> {
    let alpha = Alpha::new(T::from_f64(alpha)).unwrap();
    Ggx::new(alpha, RelativeIor::new(T::from_f64(IOR)).unwrap())
}

/// Uniform over the sphere, component by component.
fn directions<T: Real>(generator: &mut Pcg64Mcg) -> [Vec<T>; 3] {
    let mut found = [const { Vec::new() }; 3];
    for _ in 0..PAIRS {
        let z = 2.0 * f64::uniform(generator) - 1.0;
        let r = (1.0 - z * z).sqrt();
        let (s, c) = (std::f64::consts::TAU * f64::uniform(generator)).sin_cos();
        for (component, value) in found.iter_mut().zip([r * c, r * s, z]) {
            component.push(T::from_f64(value));
        }
    }
    found
}

/// The loop that any user would write: compiled for the oldest processor of the kind.
#[inline(never)]
fn plain_loop<T: Real>(boundary: &Ggx<T>, wi: &[Vec<T>; 3], wo: &[Vec<T>; 3], out: &mut [T]) {
    let n = out.len();
    let [ix, iy, iz] = wi.each_ref().map(|c| &c[..n]);
    let [ox, oy, oz] = wo.each_ref().map(|c| &c[..n]);
    for k in 0..n {
        out[k] = boundary.ars(
            Direction::from_unit(ix[k], iy[k], iz[k]),
            Direction::from_unit(ox[k], oy[k], oz[k]),
        );
    }
}

fn batch<T: Vectorised>(c: &mut Criterion, scalar: &str) {
    let generator = &mut Pcg64Mcg::new(1);
    let (wi, wo) = (directions::<T>(generator), directions::<T>(generator));
    let boundary = ggx::<T>(0.3);
    let mut out = vec![T::ZERO; PAIRS];
    let mut group = c.benchmark_group("ggx batch of 16384 pairs");
    group.throughput(Throughput::Elements(PAIRS as u64));
    group.bench_function(BenchmarkId::new("multiversion", scalar), |bencher| {
        let [x, y, z] = &wi;
        let wi = Directions::new(x, y, z).unwrap();
        let [x, y, z] = &wo;
        let wo = Directions::new(x, y, z).unwrap();
        bencher.iter(|| ggx_ars(black_box(&boundary), wi, wo, black_box(&mut out)));
    });
    group.bench_function(BenchmarkId::new("plain loop", scalar), |bencher| {
        bencher.iter(|| plain_loop(black_box(&boundary), &wi, &wo, black_box(&mut out)));
    });
    group.finish();
}

/// 5 incidences, 1801 angles of observation each.
fn plan() -> Angles {
    let theta: Vec<f64> = (-900..=900).map(|k| f64::from(k) * 0.1).collect();
    Angles::product(&SIGMA_DEG, &theta)
}

fn setup(geometry: Geometry) -> Setup {
    let eta = RelativeIor::new(IOR).unwrap();
    Setup {
        sample: Sample::Plate { eta, rough_side: RoughSide::Source },
        geometry,
        aperture_deg: 0.6,
        slit_height_deg: None,
        quantity: Quantity::Flux,
    }
}

fn forward(c: &mut Criterion) {
    let law = Law::new(Profile::Gauss, 0.2, 2.0, 0.0).unwrap();
    let density = NormalDensity::new(law);
    let normals: Normals<f64> = Normals::new(density, RelativeIor::new(IOR).unwrap());
    let (ggx, plan) = (ggx::<f64>(0.2), plan());
    let mut group = c.benchmark_group("scan of 5 x 1801 readings by quadrature");
    for (seen, geometry) in
        [("transmission", Geometry::Transmission), ("reflection", Geometry::Reflection)]
    {
        let setup = setup(geometry);
        for effort in [Effort::Draft, Effort::Full] {
            let name = |method: &str| format!("{method}, {seen}, {effort:?}");
            group.bench_function(name("ggx"), |bencher| {
                bencher.iter(|| quadrature(&ggx, black_box(&setup), &plan, effort));
            });
            group.bench_function(name("normals"), |bencher| {
                bencher.iter(|| quadrature(&normals, black_box(&setup), &plan, effort));
            });
        }
    }
    group.finish();
}

fn fits(c: &mut Criterion) {
    let (plan, setup) = (plan(), setup(Geometry::Transmission));
    let values = quadrature(&ggx::<f64>(0.2), &setup, &plan, Effort::Full).values;
    let angles = plan.incidences.iter().flat_map(|i| i.theta_deg.iter().map(|t| (i.sigma_deg, *t)));
    let readings = angles
        .zip(values)
        .map(|((sigma_deg, theta_deg), value)| Reading::in_plane(sigma_deg, theta_deg, value))
        .collect();
    let scan = Measurement::new(Metadata::default(), readings).unwrap();
    let body = Body::Dielectric { ior: IOR };
    let options = FitOptions { max_evaluations: 5000, ..FitOptions::new(body) };
    let method = GgxMethod::new(body);
    c.bench_function("fit of 5 x 1801 readings, ggx", |bencher| {
        bencher
            .iter(|| fit(&method, &scan, &setup, &options, Watch::nobody()).unwrap().evaluations);
    });
}

fn main() {
    let mut criterion = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args();
    batch::<f32>(&mut criterion, "f32");
    batch::<f64>(&mut criterion, "f64");
    let mut criterion = criterion.sample_size(10);
    forward(&mut criterion);
    fits(&mut criterion);
    criterion.final_summary();
}
