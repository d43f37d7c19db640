//! Waves on a height map: the transform alone, the orders of several beams, the mean law, a whole scan.
//!
//! All cores that rayon is given (`RAYON_NUM_THREADS`).
#![expect(clippy::unwrap_used, reason = "constant inputs")]

use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

use asperity::kirchhoff::{
    Beam, Fourier, MeanSpectra, Shadowing, Speckle, WaveBoundary, WaveOptions, Wavelengths, orders,
};
use asperity::surface::{Edges, GaussianSurface, HeightMap};
use asperity::watch::Watch;
use asperity_core::bsdf::{Bsdf, Lobe};
use asperity_core::direction::Direction;
use asperity_core::quantity::RelativeIor;
use criterion::{BenchmarkId, Criterion};
use rustfft::num_complex::Complex;

/// Sample 5's figures.
fn map(size: usize) -> HeightMap {
    let surface = GaussianSurface {
        size: (size, size),
        pitches_um: (0.361, 0.361),
        rq_um: 1.47,
        lengths_um: (14.0, 14.0),
        seed: 5,
    };
    surface.map().unwrap()
}

fn transforms(c: &mut Criterion) {
    let mut group = c.benchmark_group("2-D transform, complex f64");
    for size in [1024_usize, 2048] {
        let field: Vec<Complex<f64>> =
            (0..size * size).map(|k| Complex::from_polar(1.0, (k * k % 1013) as f64)).collect();
        let fourier = Fourier::<f64>::new((size, size), Edges::Periodic);
        let mut room = fourier.room();
        group.bench_function(BenchmarkId::from_parameter(size), |b| {
            b.iter(|| {
                let row = |j: usize, out: &mut [Complex<f64>]| {
                    out.copy_from_slice(&field[j * size..(j + 1) * size]);
                };
                fourier.transform(row, &mut room);
            });
        });
    }
    group.finish();
}

fn beams() -> Vec<Beam> {
    let wi = |deg: f64| Direction::from_unit(-deg.to_radians().sin(), 0.0, deg.to_radians().cos());
    let both = [Lobe::Reflection, Lobe::Transmission];
    let of = |deg| both.map(|lobe| Beam { wi: wi(deg), lobe, wavelength_um: 0.55 });
    [0.0, 15.0, 30.0, 45.0, 60.0].into_iter().flat_map(of).collect()
}

fn engines(c: &mut Criterion) {
    let eta = RelativeIor::new(1.49).unwrap();
    let beams = beams();
    let mut group = c.benchmark_group("orders, 5 incidences, reflection and transmission");
    for size in [256, 512, 1024] {
        let map = map(size);
        group.bench_function(BenchmarkId::from_parameter(size), |b| {
            b.iter(|| orders(&map, Edges::Periodic, eta, &beams, Watch::nobody()));
        });
    }
    group.finish();
    let options = WaveOptions {
        wavelengths: Wavelengths::single(550.0).unwrap(),
        speckle: Speckle::Averaged,
        shadowing: Shadowing::Off,
    };
    let map = map(1024);
    c.bench_function("mean law of 1024 x 1024 points", |b| {
        b.iter(|| WaveBoundary::of_map(&map, Edges::Periodic, eta, &options));
    });
    let spectra = Arc::new(MeanSpectra::new(&map, Edges::Periodic).unwrap());
    let heights = Arc::new(map);
    let of_scale = |scale| {
        let spectra = (Arc::clone(&spectra), scale);
        WaveBoundary::new(Arc::clone(&heights), Edges::Periodic, spectra, eta, &options)
    };
    let law = of_scale(1.0);
    c.bench_function("another scale of the same map", |b| b.iter(|| of_scale(black_box(1.1))));
    let (wi, wo) = (beams[5].wi, Direction::from_unit(0.4, 0.01, -0.8398_f64.sqrt()));
    c.bench_function("one value of the mean law", |b| {
        b.iter(|| law.ars(black_box(wi), black_box(wo)));
    });
}

fn main() {
    let mut c = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(3))
        .configure_from_args();
    transforms(&mut c);
    engines(&mut c);
    c.final_summary();
}
