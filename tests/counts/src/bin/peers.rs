//! Work that is timed beside other programs: `peers FOLDER` writes the inputs there, so that they do the same work, and
//! prints what each piece takes. `docs/bench/run` runs both sides by turns.
#![expect(clippy::unwrap_used, reason = "constant inputs")]
#![expect(clippy::print_stdout, reason = "a program for a script")]

use std::fs;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use asperity::batch::{Directions, ggx_ars};
use asperity::forward::{Incidence, Rays, Sample, Setup, monte_carlo};
use asperity::measurement::Quantity;
use asperity::raytrace::{Fate, Field, Ray, TracedBoundary};
use asperity::surface::{Edges, GaussianSurface, HeightMap};
use asperity::watch::Watch;
use asperity_core::bsdf::{Bsdf, Ggx};
use asperity_core::direction::Direction;
use asperity_core::gonio::Geometry;
use asperity_core::math::Real;
use asperity_core::plate::RoughSide;
use asperity_core::quantity::{Alpha, RelativeIor};
use asperity_fourier::{Ends, Fourier};
use num_complex::Complex;
use rand_pcg::Pcg64Mcg;

const IOR: f64 = 1.49;
const ALPHA: f64 = 0.3;
const PAIRS: usize = 16384;
const RAYS: usize = 100_000;
/// Points a side of the map: slope 0.3 along each axis, 1/e lag of 10 pitches.
const SIDE: usize = 1024;
const SURFACE: GaussianSurface = GaussianSurface {
    size: (SIDE, SIDE),
    pitches_um: (1.0, 1.0),
    rq_um: 2.121_320_343_559_643,
    lengths_um: (10.0, 10.0),
    seed: 1,
};
/// Points a side of the transform.
const TRANSFORM: usize = 2048;

fn main() {
    let folder = std::env::args().nth(1).unwrap_or_else(|| ".".to_owned());
    let folder = Path::new(&folder);
    println!("work,ns");
    evaluations(folder);
    first_hits(folder);
    photons();
    transform();
}

/// The shortest of some runs, ns for each of `count`.
fn best(runs: u32, count: usize, mut work: impl FnMut()) -> f64 {
    work();
    let one = |_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    1e9 * (0..runs).map(one).fold(f64::INFINITY, f64::min) / count as f64
}

fn write(folder: &Path, name: &str, values: impl IntoIterator<Item = f32>) {
    let bytes: Vec<u8> = values.into_iter().flat_map(f32::to_le_bytes).collect();
    fs::write(folder.join(name), bytes).unwrap();
}

/// GGX on random pairs over the sphere, one thread: in a batch in single precision, one by one in double.
fn evaluations(folder: &Path) {
    let generator = &mut Pcg64Mcg::new(1);
    let mut direction = || {
        let z = 2.0 * f64::uniform(generator) - 1.0;
        let (s, c) = (std::f64::consts::TAU * f64::uniform(generator)).sin_cos();
        let r = (1.0 - z * z).sqrt();
        [r * c, r * s, z]
    };
    let sets: [Vec<[f64; 3]>; 2] = [(); 2].map(|()| (0..PAIRS).map(|_| direction()).collect());
    let part = |k: usize, c: usize| sets[k].iter().map(|d| d[c] as f32).collect::<Vec<f32>>();
    let parts = [0, 1].map(|k| [0, 1, 2].map(|c| part(k, c)));
    for (set, name) in parts.iter().zip(["wi.f32", "wo.f32"]) {
        write(folder, name, set.iter().flatten().copied());
    }
    let single = Ggx::new(Alpha::new(ALPHA as f32).unwrap(), RelativeIor::new(IOR as f32).unwrap());
    let mut out = vec![0.0_f32; PAIRS];
    let [wi, wo] = parts.each_ref().map(|[x, y, z]| Directions::new(x, y, z).unwrap());
    let ns = best(2000, PAIRS, || ggx_ars(&single, wi, wo, black_box(&mut out)).unwrap());
    println!("ggx batch f32,{ns:.3}");
    let double = Ggx::new(Alpha::new(ALPHA).unwrap(), RelativeIor::new(IOR).unwrap());
    let [wi, wo] = sets
        .map(|set| set.iter().map(|d| Direction::from_unit(d[0], d[1], d[2])).collect::<Vec<_>>());
    let ns = best(500, PAIRS, || {
        let sum: f64 = wi.iter().zip(&wo).map(|(i, o)| double.eval(*i, *o)).sum();
        black_box(sum);
    });
    println!("ggx scalar f64,{ns:.2}");
}

/// Rays from above that meet a map well within its ends, azimuths at random: to the first hit, one thread.
fn first_hits(folder: &Path) {
    let map: HeightMap = SURFACE.map().unwrap();
    let heights: Vec<f64> = map.points().map(|p| p.2).collect();
    let (low, high) =
        heights.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (a.min(*h), b.max(*h)));
    write(folder, "map.f32", heights.iter().map(|h| (h - 0.5 * (low + high)) as f32));
    let top = 0.5 * (high - low);
    let field = Field::new(&map, Edges::Periodic).unwrap();
    for degrees in [5.0_f64, 45.0, 75.0, 85.0] {
        let generator = &mut Pcg64Mcg::new(7);
        let (s, c) = degrees.to_radians().sin_cos();
        let side = SIDE as f64;
        let one = |_| {
            let (sin, cos) = (std::f64::consts::TAU * f64::uniform(generator)).sin_cos();
            let [x, y] = [(); 2].map(|()| side * (0.25 + 0.5 * f64::uniform(generator)));
            Ray {
                origin: [x as f32, y as f32, top as f32],
                direction: [(s * cos) as f32, (s * sin) as f32, -c as f32],
                above: true,
                from: None,
            }
        };
        let rays: Vec<Ray> = (0..RAYS).map(one).collect();
        let numbers = rays.iter().flat_map(|r| r.origin.into_iter().chain(r.direction));
        write(folder, &format!("rays{degrees}.f32"), numbers);
        let length = |ray: &Ray| match field.follow(ray) {
            Fate::Hits(hit) => (hit.point[2] - ray.origin[2]) / ray.direction[2],
            Fate::Escapes => f32::INFINITY,
            Fate::Lost => f32::NAN,
        };
        write(folder, &format!("hits{degrees}.f32"), rays.iter().map(length));
        let ns = best(15, RAYS, || {
            black_box(rays.iter().filter(|r| field.follow(r) == Fate::Escapes).count());
        });
        println!("first hit {degrees},{ns:.1}");
    }
}

/// Photons through a rough plate at 30 degrees, all bounces and passes, read at 1801 angles, all cores.
fn photons() {
    let eta = RelativeIor::new(IOR).unwrap();
    let field = Field::new(&SURFACE.map().unwrap(), Edges::Periodic).unwrap();
    let boundary = TracedBoundary { field: field.into(), eta };
    let setup = Setup {
        sample: Sample::Plate { eta, rough_side: RoughSide::Source },
        geometry: Geometry::Transmission,
        aperture_deg: 0.6,
        slit_height_deg: None,
        quantity: Quantity::Flux,
    };
    let theta_deg = (-900..=900).map(|k| f64::from(k) * 0.1).collect();
    let angles = Incidence::in_plane(30.0, theta_deg);
    let rays = Rays { count: 1 << 20, seed: 1 };
    let mut traced = 0;
    let ns = best(5, 1, || {
        traced = monte_carlo(&boundary, &setup, &angles, rays, Watch::nobody()).unwrap().rays;
    });
    println!("photon,{:.2}", ns / traced as f64);
}

/// A complex transform in double precision, all cores.
fn transform() {
    let fourier = Fourier::<f64>::new((TRANSFORM, TRANSFORM), Ends::Periodic);
    let mut room = fourier.room();
    let values: Vec<Complex<f64>> = (0..TRANSFORM * TRANSFORM)
        .map(|k| Complex::new((k % 17) as f64, (k % 101) as f64))
        .collect();
    let ns = best(15, 1, || {
        let fill = |row: usize, line: &mut [Complex<f64>]| {
            line.copy_from_slice(&values[row * TRANSFORM..][..TRANSFORM]);
        };
        fourier.transform(fill, &mut room);
        black_box(&room);
    });
    println!("transform,{ns:.0}");
}
