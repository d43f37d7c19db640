//! Rays and waves on one map: equal to either where the other has nothing to do, and no worse than the better one
//! between.

use std::sync::Arc;

use asperity::boundary::Boundary;
use asperity::energy::{balance, balances};
use asperity::forward::{Angles, Effort, Rays, Readings, Sample, Setup, count_flux, simulate};
use asperity::hybrid::HybridBoundary;
use asperity::kirchhoff::{Shadowing, Speckle, WaveBoundary, WaveOptions, Wavelengths};
use asperity::measurement::Quantity;
use asperity::raytrace::{Field, TracedBoundary};
use asperity::surface::{Edges, GaussianSurface, HeightMap};
use asperity::watch::Watch;
use asperity_core::bsdf::Scatter;
use asperity_core::direction::{Direction, Side};
use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;
use asperity_tests::extensive;

use crate::common::{Random, ior};

const ETA: f64 = 1.49;
const EDGES: Edges = Edges::Periodic;

fn options() -> WaveOptions {
    let wavelengths = Wavelengths::single(550.0).unwrap();
    WaveOptions { wavelengths, speckle: Speckle::Averaged, shadowing: Shadowing::Off }
}

fn surface(points: usize, pitch_um: f64, rq_um: f64, length_um: f64) -> HeightMap {
    let (size, pitches_um) = ((points, points), (pitch_um, pitch_um));
    let lengths_um = (length_um, length_um);
    GaussianSurface { size, pitches_um, rq_um, lengths_um, seed: 1 }.map().unwrap()
}

fn ray(map: &HeightMap) -> TracedBoundary {
    TracedBoundary { field: Arc::new(Field::new(map, EDGES).unwrap()), eta: ior(ETA) }
}

fn wave(map: &HeightMap) -> WaveBoundary {
    WaveBoundary::of_map(map, EDGES, ior(ETA), &options()).unwrap()
}

fn hybrid(map: &HeightMap, cutoff_um: Option<f64>) -> HybridBoundary {
    HybridBoundary::with_cutoff(map, EDGES, ior(ETA), &options(), cutoff_um).unwrap()
}

fn scan(boundary: &Boundary, geometry: Geometry, sigmas_deg: &[f64], count: u64) -> Readings {
    let sample = Sample::Plate { eta: ior(ETA), rough_side: RoughSide::Source };
    let setup = Setup {
        sample,
        geometry,
        aperture_deg: 0.6,
        slit_height_deg: None,
        quantity: Quantity::Flux,
    };
    let angles: Vec<f64> = (0..361).map(|k| f64::from(k) * 0.5 - 90.0).collect();
    let (plan, rays) = (Angles::product(sigmas_deg, &angles), Rays { count, seed: 5 });
    simulate(boundary, &setup, &plan, Effort::Full, rays, Watch::nobody()).unwrap()
}

/// Eq. (18), %.
fn distance(a: &Readings, b: &Readings) -> f64 {
    let largest = b.values.iter().copied().fold(0.0, f64::max);
    let sum: f64 = a.values.iter().zip(&b.values).map(|(a, b)| (a - b) * (a - b)).sum();
    100.0 * (sum / a.values.len() as f64).sqrt() / largest
}

/// What the noise of its rays makes of it, %.
fn noise(a: &Readings) -> f64 {
    let largest = a.values.iter().copied().fold(0.0, f64::max);
    let errors = a.std_errors.as_ref().unwrap();
    let sum: f64 = errors.iter().map(|e| e * e).sum();
    100.0 * (sum / errors.len() as f64).sqrt() / largest
}

/// Where a ray goes with these random numbers, and its weight.
fn drawn<S: Scatter<f64>>(
    boundary: &S,
    wi: Direction<f64>,
    numbers: &[f64],
) -> Option<([f64; 3], f64)> {
    let mut next = numbers.iter().copied();
    boundary.sample(wi, &mut || next.next().unwrap()).map(|ray| (ray.wo.xyz(), ray.weight))
}

#[test]
fn without_short_waves_it_is_the_ray_tracer_bit_for_bit() {
    let map = surface(128, 0.5, 2.0, 8.0);
    let (hybrid, ray) = (hybrid(&map, Some(1e-3)), ray(&map));
    assert!(hybrid.scales().short_um <= 0.0 && hybrid.scales().long_um > 1.9);
    let mut random = Random::new(3);
    for k in 0..2000 {
        let (s, c) = f64::from(k % 89).to_radians().sin_cos();
        let wi = Direction::from_unit(-s, 0.0, if k % 2 == 0 { c } else { -c });
        let numbers: Vec<f64> = (0..2000).map(|_| random.next()).collect();
        let (one, other) = (drawn(&hybrid, wi, &numbers), drawn(&ray, wi, &numbers));
        assert_eq!(one, other);
    }
}

#[test]
fn without_long_waves_it_scatters_as_waves_do() {
    let map = surface(256, 0.3, 0.15, 4.0);
    let exact = Boundary::Wave(Box::new(wave(&map)));
    // nothing long at all; and waves of 1 to 3 nm left to be traced, so that every facet has the law of the short ones
    let all = hybrid(&map, None);
    let (mut low, mut high) = (60.0, 200.0);
    let cutoff = loop {
        let middle: f64 = 0.5 * (low + high);
        match hybrid(&map, Some(middle)).scales().long_um {
            long if long >= 3e-3 => low = middle,
            long if long < 1e-3 => high = middle,
            _ => break middle,
        }
        assert!(high - low > 1e-3, "{low} {high}");
    };
    let both = hybrid(&map, Some(cutoff));
    assert!(all.scales().cutoff_um.is_none() && both.scales().cutoff_um.is_some());
    for hybrid in [all, both] {
        for (side, deg) in [(1.0, 0.0_f64), (1.0, 50.0), (-1.0, 30.0)] {
            let (s, c) = deg.to_radians().sin_cos();
            let wi = Direction::from_unit(-s, 0.0, side * c);
            let rays = Rays { count: 200_000, seed: 9 };
            let (a, b) = (count_flux(&hybrid, wi, rays), count_flux(&wave(&map), wi, rays));
            assert!((a.reflected - b.reflected).abs() < 3e-3, "{side} {deg} {a:?} {b:?}");
            assert!((a.transmitted - b.transmitted).abs() < 3e-3, "{side} {deg} {a:?} {b:?}");
        }
        let hybrid = Boundary::Hybrid(Box::new(hybrid));
        for geometry in [Geometry::Transmission, Geometry::Reflection] {
            let sigmas = [0.0, 45.0];
            let found = scan(&hybrid, geometry, &sigmas, 1_000_000);
            let expected = scan(&exact, geometry, &sigmas, 1);
            let (far, noise) = (distance(&found, &expected), noise(&found));
            // waves of 2 nm would take 0.5 % of the coherent light mirrored inside, rays do not know; the peak itself
            // is that of waves
            assert!(far < 0.15 + 1.5 * noise, "{geometry:?} {far} {noise}");
            let peak = found.values[180] / expected.values[180];
            let error = found.std_errors.as_ref().unwrap()[180] / expected.values[180];
            assert!((peak - 1.0).abs() < 0.005 + 4.0 * error, "{geometry:?} {peak} {error}");
        }
    }
}

#[test]
fn the_split_moves_steadily_from_all_waves_to_all_rays() {
    let one = surface(256, 0.5, 1.0, 6.0);
    let mut before: Option<f64> = None;
    let steps = if extensive() { 24 } else { 8 };
    for k in 0..=steps {
        let rq = 0.1 * (f64::from(k) * 4.8 / f64::from(steps)).exp();
        let map = asperity::surface::scaled(&one, rq).unwrap();
        let scales = *HybridBoundary::of_map(&map, EDGES, ior(ETA), &options()).unwrap().scales();
        let variance = scales.long_um.hypot(scales.short_um);
        assert!((variance / rq - 1.0).abs() < 1e-6, "{rq} {scales:?}");
        let share = scales.short_um / rq;
        assert!(share <= before.unwrap_or(1.0) + 1e-9, "{rq} {scales:?}");
        before = Some(share);
        assert!(rq > 0.3 || scales.cutoff_um.is_none(), "{rq} {scales:?}");
        assert!(rq < 5.0 || share < 0.05, "{rq} {scales:?}");
    }
}

/// Distances of ray and hybrid to wave, of wave and hybrid to ray, and the noise.
fn study(rq_um: f64, points: usize, count: u64) -> ([f64; 2], [f64; 2], f64) {
    let length = (10.0 * rq_um).max(5.0);
    let map = surface(points, (length / 40.0).clamp(0.2, 0.8), rq_um, length);
    let sigmas = [0.0, 30.0];
    let of = |b: &Boundary| scan(b, Geometry::Transmission, &sigmas, count);
    let ray = of(&Boundary::Traced(ray(&map)));
    let wave = of(&Boundary::Wave(Box::new(wave(&map))));
    let hybrid = HybridBoundary::of_map(&map, EDGES, ior(ETA), &options()).unwrap();
    let hybrid = of(&Boundary::Hybrid(Box::new(hybrid)));
    let to_wave = [distance(&ray, &wave), distance(&hybrid, &wave)];
    let to_ray = [distance(&wave, &ray), distance(&hybrid, &ray)];
    (to_wave, to_ray, noise(&ray).hypot(noise(&hybrid)))
}

#[test]
fn it_is_no_worse_than_the_better_of_both() {
    let all: &[f64] = &[0.01, 0.03, 0.1, 0.2, 0.3, 0.45, 0.7, 1.1, 1.8, 3.0, 6.0, 13.0];
    let (heights, points, count) = if extensive() {
        (all, 1024, 4_000_000)
    } else {
        (&[0.03, 0.2, 0.7, 3.0][..], 512, 400_000)
    };
    for &rq_um in heights {
        let (to_wave, to_ray, noise) = study(rq_um, points, count);
        let g = (std::f64::consts::TAU / 0.55 * (ETA - 1.0) * rq_um).powi(2);
        let text = format!("Rq {rq_um}: to wave {to_wave:?}, to ray {to_ray:?}, noise {noise}");
        // Where heights are a part of a wave, waves are right; where they are many waves, rays are, and waves, blind
        // to the azimuths of a single map, miss its sample error. Between, it lies between.
        if g < 5.0 {
            assert!(to_wave[1] < 0.02 + 1.5 * noise && to_wave[1] < to_wave[0], "{text}");
        } else if g < 100.0 {
            assert!(to_wave[1] < to_wave[0] + noise && to_ray[1] < to_ray[0] + noise, "{text}");
        } else {
            assert!(to_ray[1] < 0.3 * to_ray[0] + 1.5 * noise, "{text}");
        }
    }
}

/// A beam from the air, or from inside, and the light that comes to a plane facet.
fn beam(inside: bool, deg: f64) -> Direction<f64> {
    let (s, c) = deg.to_radians().sin_cos();
    Direction::from_unit(-s, 0.0, if inside { -c } else { c })
}

/// Slope along x of 0.3, coherent nowhere: the whole map diffracts.
fn steep(seed: u64) -> HeightMap {
    let length = std::f64::consts::SQRT_2 * 0.44 / 0.3;
    let (size, pitches_um, lengths_um) = ((512, 512), (0.2, 0.2), (length, length));
    GaussianSurface { size, pitches_um, rq_um: 0.44, lengths_um, seed }.map().unwrap()
}

/// Mean and its standard error.
fn mean(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let square = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (square / n).sqrt())
}

#[test]
fn beyond_the_critical_angle_it_transmits_what_the_orders_of_maps_do() {
    // 42.2 degrees: of a smooth face nothing would pass
    const SEEDS: u64 = 6;
    let rays = Rays { count: 40_000, seed: 1 };
    let places = [45.0, 60.0, 75.0].map(|deg| (Side::Dielectric, deg));
    let (mut of_hybrid, mut of_law, mut of_orders) =
        ([const { vec![] }; 3], [[0.0; 2]; 3], [const { vec![] }; 3]);
    for seed in 1..=SEEDS {
        let map = steep(seed);
        let hybrid = hybrid(&map, None);
        let options = WaveOptions { speckle: Speckle::Kept, ..options() };
        let kept = WaveBoundary::of_map(&map, EDGES, ior(ETA), &options).unwrap();
        let kept = Boundary::Wave(Box::new(kept));
        let found = balances(&kept, &places, rays, Watch::nobody()).unwrap();
        let mean_law = Boundary::Wave(Box::new(wave(&map)));
        for (k, (_, deg)) in places.into_iter().enumerate() {
            let flux = count_flux(&hybrid, beam(true, deg), Rays { seed, ..rays });
            of_hybrid[k].push(flux.transmitted);
            of_orders[k].push(found[k].transmitted);
            let law = balance(&mean_law, places[k].0, deg, rays);
            of_law[k][0] += law.reflected / SEEDS as f64;
            of_law[k][1] += law.transmitted / SEEDS as f64;
        }
    }
    for (k, (_, deg)) in places.into_iter().enumerate() {
        let (hybrid, orders) = (mean(&of_hybrid[k]), mean(&of_orders[k]));
        let [r, t] = of_law[k];
        println!("{deg} deg: hybrid {hybrid:.4?}, orders {orders:.4?}, law {r:.4} {t:.4}");
        // a facet gives no more than it receives
        let right = t / (r + t).max(1.0);
        assert!((hybrid.0 / right - 1.0).abs() < 0.01, "{deg} {hybrid:?} {right}");
        assert!(
            (t - orders.0).abs() < 3.0 * orders.1 && orders.1 < 0.15 * t,
            "{deg} {orders:?} {t}"
        );
        // an independent sum over a map like the first gives 0.143
        let first = of_hybrid[k][0];
        assert!((deg - 60.0).abs() > 1.0 || (first - 0.143).abs() < 0.006, "{first}");
    }
}

#[test]
fn a_plate_at_60_degrees_reads_what_waves_read() {
    let map = steep(1);
    let sigmas = [60.0];
    let exact = scan(&Boundary::Wave(Box::new(wave(&map))), Geometry::Transmission, &sigmas, 1);
    let hybrid = Boundary::Hybrid(Box::new(hybrid(&map, None)));
    let found = scan(&hybrid, Geometry::Transmission, &sigmas, 2_000_000);
    let sum = |readings: &Readings| readings.values.iter().sum::<f64>();
    let ratio = sum(&found) / sum(&exact);
    let (far, noise) = (distance(&found, &exact), noise(&found));
    println!("{ratio:.4}, eq. (18) {far:.3} %, noise {noise:.3} %");
    assert!((ratio - 1.0).abs() < 0.03, "{ratio}");
    assert!(far < 1.0 + 1.5 * noise && noise < 2.0, "{far} {noise}");
}

#[test]
fn it_gives_no_more_than_it_receives() {
    for (rq, slope) in [(0.1, 0.1), (0.44, 0.3), (0.9, 0.2), (1.5, 0.3)] {
        let length = std::f64::consts::SQRT_2 * rq / slope;
        let map = surface(256, length / 8.0, rq, length);
        let hybrid = HybridBoundary::of_map(&map, EDGES, ior(ETA), &options()).unwrap();
        for inside in [false, true] {
            for deg in [0.0, 20.0, 40.0, 50.0, 60.0, 70.0, 80.0, 85.0] {
                let rays = Rays { count: 20_000, seed: 3 };
                let again = Rays { seed: 4, ..rays };
                let of = |rays| count_flux(&hybrid, beam(inside, deg), rays);
                let (a, b) = (of(rays), of(again));
                let sum = a.reflected + a.transmitted;
                println!(
                    "{rq} {slope} {inside} {deg}: R {:.4} T {:.4}",
                    a.reflected, a.transmitted
                );
                assert!(sum < 1.02, "Rq {rq}, slope {slope}, inside {inside}, {deg} deg: {a:?}");
                assert!((a.transmitted - b.transmitted).abs() < 0.03, "{a:?} {b:?}");
                // what is lost is evanescent, or sent along the surface
                assert!(sum > 0.8, "Rq {rq}, slope {slope}, inside {inside}, {deg} deg: {a:?}");
            }
        }
    }
}
