//! Kirchhoff's integral, rays and facets on grooves against the project's engines on the same profile as a map.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails where its data do, and shows what it measures"
)]

use std::f64::consts::TAU;

use asperity_rigorous::{
    Incidence, Kind, Order, Problem, Profile, RayOptions, Response, Side, facets, kirchhoff, trace,
};

const PERIOD: f64 = 30.1 * 0.55;
/// Number, amplitude in um, phase.
const WAVES: [(f64, f64, f64); 6] = [
    (1.0, 0.05, 0.3),
    (2.0, 0.06, 1.1),
    (3.0, 0.04, 2.5),
    (5.0, 0.03, 4.0),
    (8.0, 0.02, 0.7),
    (11.0, 0.008, 5.1),
];

fn problem(scale: f64) -> Problem {
    let height = |i: u32| -> f64 {
        let x = TAU * f64::from(i) / 64.0;
        WAVES.iter().map(|(k, a, phase)| scale * a * (k * x + phase).cos()).sum()
    };
    let profile = Profile::new((0..64).map(height).collect(), PERIOD).unwrap();
    Problem::new(profile, 1.49, 0.55).unwrap()
}

/// What `asperity check --map ... --edges periodic --engine wave --speckle kept --shadowing off` prints for the map of 2048 x 4 points of
/// that profile, and `--engine ray --rays 3e6` in the last two columns.
struct Row {
    scale: f64,
    side: Side,
    order: i32,
    /// Reflected and transmitted, then their coherent parts.
    waves: [f64; 4],
    rays: [f64; 2],
}

const AIR: Side = Side::Air;
const INSIDE: Side = Side::Dielectric;

#[rustfmt::skip]
const ROWS: [Row; 12] = [
    Row { scale: 1.0, side: AIR, order: 0, waves: [0.0387314952, 0.9612367427, 0.0076489927, 0.8346208534], rays: [0.0385278, 0.9614722] },
    Row { scale: 1.0, side: AIR, order: 15, waves: [0.0404467233, 0.9595638423, 0.0097627367, 0.8100642110], rays: [0.0402891, 0.9597109] },
    Row { scale: 1.0, side: AIR, order: 26, waves: [0.0849563619, 0.9125057945, 0.0483021430, 0.6805886562], rays: [0.0878688, 0.9121312] },
    Row { scale: 1.0, side: INSIDE, order: 0, waves: [0.0387408751, 0.9610507026, 0.0040188699, 0.8346208534], rays: [0.0387570, 0.9612430] },
    Row { scale: 1.0, side: INSIDE, order: 22, waves: [0.0711445706, 0.9338662853, 0.0075258403, 0.7595186066], rays: [0.0713320, 0.9286680] },
    Row { scale: 1.0, side: INSIDE, order: 39, waves: [0.9866091882, 0.0033075227, 0.3227645431, 0.0], rays: [1.0, 0.0] },
    Row { scale: 6.0, side: AIR, order: 0, waves: [0.0367428174, 0.9588853998, 0.0006432431, 0.1046997106], rays: [0.0373071, 0.9626929] },
    Row { scale: 6.0, side: AIR, order: 15, waves: [0.0477513537, 0.9523268146, 0.0011240570, 0.0686834077], rays: [0.0414725, 0.9585275] },
    Row { scale: 6.0, side: AIR, order: 26, waves: [0.0968926867, 0.9356677702, 0.0003560585, 0.0130880350], rays: [0.0529888, 0.9470112] },
    Row { scale: 6.0, side: INSIDE, order: 0, waves: [0.0457642411, 0.8864034742, 0.0006977090, 0.1046997106], rays: [0.1073316, 0.8926684] },
    Row { scale: 6.0, side: INSIDE, order: 22, waves: [0.1646410371, 0.7216208726, 0.0005061945, 0.0215090517], rays: [0.2279140, 0.7720861] },
    Row { scale: 6.0, side: INSIDE, order: 39, waves: [0.6576791165, 0.2025499002, 0.0095196517, 0.0], rays: [0.7064464, 0.2935536] },
];

fn unpolarised(response: &Response, is_of: impl Fn(&Order) -> bool) -> f64 {
    let pairs = response.te.iter().zip(&response.tm).filter(|pair| is_of(pair.0));
    pairs.map(|(te, tm)| 0.5 * (te.efficiency() + tm.efficiency())).sum()
}

#[test]
fn waves_are_those_of_the_engine_on_the_same_map() {
    let mut worst = 0.0f64;
    for row in ROWS {
        let incidence = Incidence { side: row.side, order: row.order };
        let response = &kirchhoff(&problem(row.scale), &[incidence]).unwrap()[0];
        let of = |kind| unpolarised(response, |order| order.kind == kind);
        let coherent = |kind| unpolarised(response, |o| o.kind == kind && o.m == row.order);
        let found = [
            of(Kind::Reflected),
            of(Kind::Transmitted),
            coherent(Kind::Reflected),
            coherent(Kind::Transmitted),
        ];
        for (found, engine) in found.iter().zip(row.waves) {
            worst = worst.max((found - engine).abs());
        }
    }
    println!("Kirchhoff: off by {worst:.1e} from the engine");
    assert!(worst < 5e-6, "{worst:e}"); // the engine interpolates to 1e-5 of the field
}

/// The engine draws random rays, three millions of them: up to 3e-4 of the flux for one standard error.
#[test]
fn rays_are_those_of_the_engine_on_the_same_map() {
    let options = RayOptions { starts: 20_000, seed: 5 };
    let mut worst = 0.0f64;
    for row in ROWS {
        let incidence = Incidence { side: row.side, order: row.order };
        let traced = trace(&problem(row.scale), incidence, options).unwrap();
        let [.., light] = &traced.gathered;
        let found = [light.reflected.total(), light.transmitted.total()];
        assert!((found[0] + found[1] + traced.lost[2] - 1.0).abs() < 1e-9);
        assert!(traced.lost[2] < 1e-4, "{:?}", traced.lost);
        for (found, engine) in found.iter().zip(row.rays) {
            worst = worst.max((found - engine).abs());
        }
    }
    println!("rays: off by {worst:.1e} from the engine");
    assert!(worst < 1.2e-3, "{worst:e}");
}

/// Without slopes all are Fresnel's, in the direction of the mirror and of Snell's law.
#[test]
fn a_flat_surface_is_fresnels() {
    let flat = Problem::new(Profile::new(vec![0.0; 8], PERIOD).unwrap(), 1.49, 0.55).unwrap();
    let incidence = Incidence { side: Side::Air, order: 15 };
    let sine = flat.sine(Side::Air, 15);
    let (cos, inner) = ((1.0 - sine * sine).sqrt(), (1.0 - (sine / 1.49).powi(2)).sqrt());
    let exact = [
        ((cos - 1.49 * inner) / (cos + 1.49 * inner)).powi(2),
        ((1.49 * cos - inner) / (1.49 * cos + inner)).powi(2),
    ];
    let response = &kirchhoff(&flat, &[incidence]).unwrap()[0];
    let options = RayOptions { starts: 100, seed: 1 };
    let rays = trace(&flat, incidence, options).unwrap().gathered;
    let single = facets(&flat, incidence).unwrap();
    for (at, orders) in [&response.te, &response.tm].into_iter().enumerate() {
        let mirrored = orders.iter().find(|o| o.kind == Kind::Reflected && o.m == 15).unwrap();
        assert!((mirrored.efficiency() - exact[at]).abs() < 1e-12);
        let angle = sine.asin().to_degrees();
        for light in [&rays[at], &single[at]] {
            let near = light.reflected.between(angle - 0.5, angle + 0.5);
            assert!((near - exact[at]).abs() < 1e-9);
            let angle = (sine / 1.49).asin().to_degrees();
            let near = light.transmitted.between(angle - 0.5, angle + 0.5);
            assert!((near + exact[at] - 1.0).abs() < 1e-9);
        }
    }
}

/// Facets of a Gaussian density of slopes by quadrature over that density: rms slope 0.2, reflected and transmitted.
#[test]
fn facets_are_the_integral_over_slopes() {
    // sampled quantiles of slopes, sorted into a profile that rises and falls: only its slopes matter
    let slopes: Vec<f64> = (0..2048).map(|i| 0.6 * (TAU * f64::from(i) / 2048.0).cos()).collect();
    let wavelength = 0.55;
    let height = |i: u32| 0.6 * PERIOD / TAU * (TAU * f64::from(i) / 64.0).sin();
    let profile = Profile::new((0..64).map(height).collect(), PERIOD).unwrap();
    let problem = Problem::new(profile, 1.49, wavelength).unwrap();
    let incidence = Incidence { side: Side::Dielectric, order: 39 };
    let sine = problem.sine(Side::Dielectric, 39);
    let cos_i = (1.0 - sine * sine).sqrt();
    let mut exact = [0.0; 2];
    for slope in slopes {
        let scale = slope.hypot(1.0);
        let [x, z] = [-slope / scale, 1.0 / scale];
        let cos = sine * x + cos_i * z;
        if cos <= 0.0 {
            continue;
        }
        let share = cos / (z * cos_i) / 2048.0;
        let g2 = 1.0 / 1.49f64.powi(2) - 1.0 + cos * cos;
        let reflected = if g2 > 0.0 {
            let g = g2.sqrt();
            let te = (cos - g) / (cos + g);
            let tm = (cos / 1.49f64.powi(2) - g) / (cos / 1.49f64.powi(2) + g);
            let up = (cos_i + (g - cos) * z) * 1.49;
            exact[1] += if up > 0.0 { share * (1.0 - 0.5 * (te * te + tm * tm)) } else { 0.0 };
            0.5 * (te * te + tm * tm)
        } else {
            1.0
        };
        exact[0] += if cos_i - 2.0 * cos * z < 0.0 { share * reflected } else { 0.0 };
    }
    let [.., light] = facets(&problem, incidence).unwrap();
    println!("{exact:?} {} {}", light.reflected.total(), light.transmitted.total());
    assert!((light.reflected.total() - exact[0]).abs() < 2e-3);
    assert!((light.transmitted.total() - exact[1]).abs() < 2e-3);
}
