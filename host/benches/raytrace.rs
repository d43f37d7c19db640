//! Rays on a height map: to the first hit, beside a hierarchy of boxes, and through a plate.
//!
//! One core, but for the plate.
#![expect(clippy::unwrap_used, reason = "constant inputs")]

use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

use asperity::forward::{Incidence, Rays, Sample, Setup, monte_carlo};
use asperity::measurement::Quantity;
use asperity::raytrace::{Fate, Field, Ray, TracedBoundary};
use asperity::surface::Edges;
use asperity::watch::Watch;
use asperity_core::gonio::Geometry;
use asperity_core::math::Real;
use asperity_core::plate::RoughSide;
use asperity_core::quantity::RelativeIor;
use criterion::{BenchmarkId, Criterion, Throughput};
use rand_pcg::Pcg64Mcg;

#[path = "surface/bvh.rs"]
mod bvh;
mod surface;

use bvh::Bvh;

const SIZE: usize = 1024;
const RAYS: usize = 1 << 14;

/// Rays that meet the surface well within the map, so that the peer needs no images of it.
fn rays(top: f64, degrees: f64) -> Vec<Ray> {
    let mut generator = Pcg64Mcg::new(7);
    let mut uniform = || f64::uniform(&mut generator);
    let inner = SIZE as f64 / 2.0;
    let shifted = |mut ray: Ray| {
        for c in &mut ray.origin[..2] {
            *c += (SIZE / 4) as f32;
        }
        ray
    };
    (0..RAYS).map(|_| shifted(surface::ray(top, [inner; 2], degrees, &mut uniform))).collect()
}

/// Every ray by both; how far apart they are at most, in pitches.
fn agree(field: &Field, peer: &Bvh, rays: &[Ray]) -> f32 {
    let apart = |ray: &Ray| {
        let Fate::Hits(hit) = field.follow(ray) else { return f32::INFINITY };
        let t = peer.nearest(ray);
        (hit.point[2] - ray.origin[2] - t * ray.direction[2]).abs()
    };
    rays.iter().map(apart).fold(0.0, f32::max)
}

fn main() {
    let mut criterion = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args();
    let map = surface::gaussian(SIZE, 10.0, 0.3, 1);
    let field = Arc::new(Field::new(&map, Edges::Periodic).unwrap());
    let peer = Bvh::new(&map);
    let mut group = criterion.benchmark_group("ray to a map of 1024 x 1024");
    group.throughput(Throughput::Elements(RAYS as u64));
    for degrees in [5.0, 45.0, 75.0, 85.0] {
        let rays = rays(surface::top(&map), degrees);
        let apart = agree(&field, &peer, &rays);
        assert!(apart < 1e-2, "{degrees} deg: {apart} pitches apart");
        group.bench_function(BenchmarkId::new("follow", degrees), |bencher| {
            bencher.iter(|| rays.iter().filter(|r| field.follow(r) == Fate::Escapes).count());
        });
        group.bench_function(BenchmarkId::new("boxes", degrees), |bencher| {
            bencher.iter(|| rays.iter().map(|r| peer.nearest(r)).fold(0.0, f32::max));
        });
    }
    group.finish();
    let mut criterion = criterion.sample_size(10);
    criterion.bench_function("field of 1024 x 1024", |bencher| {
        bencher.iter(|| Field::new(black_box(&map), Edges::Periodic).unwrap());
    });
    let eta = RelativeIor::new(1.49).unwrap();
    let boundary = TracedBoundary { field, eta };
    let setup = Setup {
        sample: Sample::Plate { eta, rough_side: RoughSide::Source },
        geometry: Geometry::Transmission,
        aperture_deg: 0.6,
        slit_height_deg: None,
        quantity: Quantity::Flux,
    };
    let theta_deg: Vec<f64> = (-900..=900).map(|k| f64::from(k) * 0.1).collect();
    let angles = Incidence::in_plane(30.0, theta_deg);
    let asked = Rays { count: 1 << 18, seed: 1 };
    let trace = || monte_carlo(&boundary, &setup, &angles, asked, Watch::nobody()).unwrap();
    let mut group = criterion.benchmark_group("photons through a plate, all cores");
    group.throughput(Throughput::Elements(trace().rays));
    group.bench_function("30 deg", |bencher| bencher.iter(|| trace().rays));
    group.finish();
    criterion.final_summary();
}
