//! Work whose instructions `.ci/counts` counts under Valgrind: `asperity-counts NAME REPEATS` does a piece of work so many times. What one more time takes is the
//! cost; making the surface and the laws is not in it.
#![expect(clippy::unwrap_used, reason = "constant inputs")]
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program for a script")]

use std::hint::black_box;
use std::process::ExitCode;

use asperity::batch::{Directions, ggx_ars};
use asperity::boundary::Boundary;
use asperity::fit::{FitOptions, fit};
use asperity::forward::{Angles, Effort, Rays, Sample, Setup, quadrature, simulate};
use asperity::measurement::{Measurement, Metadata, Quantity, Reading};
use asperity::method::{Body, GgxMethod};
use asperity::raytrace::{Field, TracedBoundary};
use asperity::surface::{Edges, GaussianSurface};
use asperity::tabulate::{Budget, tabulate};
use asperity::watch::Watch;
use asperity_core::bsdf::{Bsdf, Ggx, LobeSet, Normals, Scatter};
use asperity_core::direction::Direction;
use asperity_core::gonio::Geometry;
use asperity_core::math::Real;
use asperity_core::ndf::law::{Law, Profile};
use asperity_core::ndf::normals::NormalDensity;
use asperity_core::plate::RoughSide;
use asperity_core::quantity::{Alpha, RelativeIor};
use asperity_fourier::{Ends, Fourier, RealFourier};
use num_complex::Complex;
use rand_pcg::Pcg64Mcg;

const IOR: f64 = 1.49;
const SURFACE: GaussianSurface = GaussianSurface {
    size: (256, 256),
    pitches_um: (0.5, 0.5),
    rq_um: 0.7,
    lengths_um: (8.0, 8.0),
    seed: 1,
};

/// A piece of work, made ready: each call does it once more.
type Work = Box<dyn FnMut()>;

/// A piece of work by its name.
type Named = (&'static str, fn() -> Work);

/// All of them.
const WORK: [Named; 11] = [
    ("sample_map", light_on_a_map),
    ("sample_ggx", light_on_facets),
    ("single", single),
    ("batch_f32", batch),
    ("scan_ggx", scan_of_ggx),
    ("scan_normals", scan_of_normals),
    ("scan_traced", scan_of_map),
    ("fit_ggx", fit_of_ggx),
    ("fft_f32", complex_fft),
    ("fft_real", real_fft),
    ("tabulate", table),
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let known = |name: &String| WORK.iter().find(|(known, _)| known == name);
    match arguments.as_slice() {
        [] => {
            for (name, _) in WORK {
                println!("{name}");
            }
            ExitCode::SUCCESS
        }
        [name, repeats] if known(name).is_some() && repeats.parse::<u32>().is_ok() => {
            let mut work = known(name).map(|(_, make)| make()).unwrap();
            (0..repeats.parse::<u32>().unwrap()).for_each(|_| work());
            ExitCode::SUCCESS
        }
        _ => {
            eprintln!("give a name, as without arguments, and a number");
            ExitCode::from(2)
        }
    }
}

fn eta() -> RelativeIor<f64> {
    RelativeIor::new(IOR).unwrap()
}

fn ggx<T: Real>(alpha: f64) -> Ggx<T> {
    let alpha = Alpha::new(T::from_f64(alpha)).unwrap();
    Ggx::new(alpha, RelativeIor::new(T::from_f64(IOR)).unwrap())
}

fn traced() -> TracedBoundary {
    let field = Field::new(&SURFACE.map().unwrap(), Edges::Periodic).unwrap();
    TracedBoundary { field: field.into(), eta: eta() }
}

fn setup() -> Setup {
    Setup {
        sample: Sample::Plate { eta: eta(), rough_side: RoughSide::Source },
        geometry: Geometry::Transmission,
        aperture_deg: 0.6,
        slit_height_deg: None,
        quantity: Quantity::Flux,
    }
}

fn angles(step_deg: f64) -> Angles {
    let count = (90.0 / step_deg) as i32;
    let theta: Vec<f64> = (-count..=count).map(|k| f64::from(k) * step_deg).collect();
    Angles::product(&[0.0, 30.0, 60.0], &theta)
}

/// Light on a map at 45 degrees, with all its bounces: 1000 rays.
fn light_on_a_map() -> Work {
    let boundary = traced();
    let mut generator = Pcg64Mcg::new(7);
    let wi = Direction::from_angles(0.785, 0.3);
    Box::new(move || {
        for _ in 0..1000 {
            black_box(boundary.sample(wi, &mut || f64::uniform(&mut generator)));
        }
    })
}

/// The same on facets in closed form.
fn light_on_facets() -> Work {
    let boundary = ggx::<f64>(0.2);
    let mut generator = Pcg64Mcg::new(7);
    let wi = Direction::from_angles(0.5, 0.3);
    Box::new(move || {
        for _ in 0..1000 {
            black_box(boundary.sample(wi, &mut || f64::uniform(&mut generator)));
        }
    })
}

/// Directions over the sphere.
fn directions<T: Real>(count: usize, generator: &mut Pcg64Mcg) -> [Vec<T>; 3] {
    let mut found = [const { Vec::new() }; 3];
    for _ in 0..count {
        let z = 2.0 * f64::uniform(generator) - 1.0;
        let r = (1.0 - z * z).sqrt();
        let (s, c) = (std::f64::consts::TAU * f64::uniform(generator)).sin_cos();
        for (component, value) in found.iter_mut().zip([r * c, r * s, z]) {
            component.push(T::from_f64(value));
        }
    }
    found
}

/// Single values of GGX: 4096 pairs.
fn single() -> Work {
    let generator = &mut Pcg64Mcg::new(1);
    let (wi, wo) = (directions::<f64>(4096, generator), directions::<f64>(4096, generator));
    let boundary = ggx::<f64>(0.3);
    let at = |w: &[Vec<f64>; 3], k: usize| Direction::from_unit(w[0][k], w[1][k], w[2][k]);
    Box::new(move || {
        for k in 0..4096 {
            black_box(boundary.eval(at(&wi, k), at(&wo, k)));
        }
    })
}

/// The same in a batch in single precision: 16384 pairs.
fn batch() -> Work {
    let generator = &mut Pcg64Mcg::new(1);
    let (wi, wo) = (directions::<f32>(16384, generator), directions::<f32>(16384, generator));
    let boundary = ggx::<f32>(0.3);
    let mut out = vec![0.0_f32; 16384];
    Box::new(move || {
        let [x, y, z] = &wi;
        let wi = Directions::new(x, y, z).unwrap();
        let [x, y, z] = &wo;
        let wo = Directions::new(x, y, z).unwrap();
        ggx_ars(&boundary, wi, wo, &mut out).unwrap();
        black_box(&mut out);
    })
}

/// A scan by quadrature, with internal passes.
fn scan_of_ggx() -> Work {
    let (law, setup, angles) = (ggx::<f64>(0.2), setup(), angles(1.0));
    Box::new(move || {
        black_box(quadrature(&law, &setup, &angles, Effort::Full));
    })
}

fn scan_of_normals() -> Work {
    let density = NormalDensity::new(Law::new(Profile::Gauss, 0.2, 2.0, 0.0).unwrap());
    let law: Normals<f64> = Normals::new(density, eta());
    let (setup, angles) = (setup(), angles(1.0));
    Box::new(move || {
        black_box(quadrature(&law, &setup, &angles, Effort::Full));
    })
}

/// A scan of a traced map: the sum over its facets, and rays for the rest.
fn scan_of_map() -> Work {
    let boundary = Boundary::Traced(traced());
    let (setup, angles) = (setup(), angles(1.0));
    let rays = Rays { count: 4096, seed: 1 };
    Box::new(move || {
        let watch = Watch::nobody();
        black_box(simulate(&boundary, &setup, &angles, Effort::Full, rays, watch));
    })
}

fn fit_of_ggx() -> Work {
    let (setup, angles) = (setup(), angles(2.0));
    let values = quadrature(&ggx::<f64>(0.2), &setup, &angles, Effort::Full).values;
    let places =
        angles.incidences.iter().flat_map(|i| i.theta_deg.iter().map(|t| (i.sigma_deg, t)));
    let reading =
        |((sigma, theta), value): ((f64, &f64), f64)| Reading::in_plane(sigma, *theta, value);
    let readings = places.zip(values).map(reading).collect();
    let scan = Measurement::new(Metadata::default(), readings).unwrap();
    let body = Body::Dielectric { ior: IOR };
    let options = FitOptions::new(body);
    Box::new(move || {
        let method = GgxMethod::new(body);
        black_box(fit(&method, &scan, &setup, &options, Watch::nobody()).unwrap().evaluations);
    })
}

/// A complex transform of 256 x 256 points in single precision.
fn complex_fft() -> Work {
    let fourier = Fourier::<f32>::new((256, 256), Ends::Periodic);
    let mut room = fourier.room();
    Box::new(move || {
        let fill = |row: usize, values: &mut [Complex<f32>]| {
            for (k, value) in values.iter_mut().enumerate() {
                *value = Complex::new((row * k % 17) as f32, k as f32);
            }
        };
        fourier.transform(fill, &mut room);
        black_box(&room);
    })
}

/// A real one there.
fn real_fft() -> Work {
    let fourier = RealFourier::new((256, 256), Ends::Periodic);
    let grid: Vec<f64> = (0..256 * 256).map(|k| f64::from(k * 31 % 101)).collect();
    Box::new(move || {
        black_box(fourier.forward(grid.clone()));
    })
}

/// A table of 4 KiB.
fn table() -> Work {
    let law = Boundary::Ggx(ggx::<f64>(0.2));
    let rays = Rays { count: 0, seed: 1 };
    let plan = Budget { lobes: LobeSet::AIR_TRANSMISSION, bytes: 4096, kept: None, rays };
    Box::new(move || {
        black_box(tabulate(&law, &plan, Watch::nobody()).unwrap().bytes());
    })
}
