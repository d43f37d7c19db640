//! Rays and waves together on grooves, against rigorous curves: a redo of the hybrid in one dimension.
//!
//! `cargo run --release -p asperity --example hybrid_atlas -- ../shared/data/reference/rigorous/atlas [rays]`
//!
//! Lengths in vacuum wavelengths. The long profile is split off with the filter of `surface::split` and traced by the ray
//! engine; the short one scatters by Kirchhoff's law of its known autocorrelation, in the plane across the grooves.
//! Printed: eq. (18) in % of the peak against the rigorous curve for waves, rays (both of the atlas), the hybrid with one split
//! (`q_z` of transmission, as the library has it), and with a split by the `q_z` of each lobe.
#![expect(clippy::print_stdout, clippy::expect_used, reason = "a program for measurements")]

use std::f64::consts::{LN_2, PI, TAU};
use std::path::Path;

use asperity::forward::Rays;
use asperity::raytrace::{Facet, Field, Turned};
use asperity::surface::split::split;
use asperity::surface::{Edges, GaussianSurface, HeightMap};
use asperity_core::direction::Direction;
use asperity_core::fresnel;
use asperity_core::math::Real;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

const N: f64 = 1.49;
const CELLS: [(f64, f64); 4] = [(0.2, 0.2), (0.4, 0.5), (0.8, 0.3), (1.5, 0.5)];
/// As in `hybrid/scales.rs`.
const LOST: f64 = 10.0;
const DISTANCES: f64 = 3.0;
/// Columns of the profile, a correlation length of which has this many.
const POINTS: usize = 1 << 17;
const FINE: f64 = 12.0;

/// A vector in the plane across the grooves.
type Plane = [f64; 2];

/// A Gaussian profile.
#[derive(Clone, Copy)]
struct Profile {
    rq: f64,
    length: f64,
}

/// Kirchhoff's law of the short waves of a profile.
struct Law {
    /// Variance of the short heights.
    variance: f64,
    /// Density over `|q_x|` (step `dq`), by `q_z` (`ln` steps).
    density: Vec<Vec<f64>>,
    dq: f64,
    first: f64,
    step: f64,
    /// By side, half degree of incidence and lobe: flux, and its sum over quarter degrees of the outgoing angle.
    tables: Vec<(f64, Vec<f64>)>,
}

const OUT: usize = 720;
const IN: usize = 180;

fn dot(a: Plane, b: Plane) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

impl Law {
    /// Of all waves shorter than `cutoff`; of all without one.
    fn new(profile: Profile, cutoff: Option<f64>) -> Self {
        let Profile { rq, length } = profile;
        // spectrum, then autocorrelation
        let dk = 0.01 / length;
        let spectrum: Vec<f64> = (0..1500)
            .map(|k| {
                let kappa = (f64::from(k) + 0.5) * dk;
                let all = rq * rq * length * PI.sqrt() * (-0.25 * (kappa * length).powi(2)).exp();
                let wave = cutoff.map_or(f64::INFINITY, |c| (c * kappa / TAU).powi(4) * LN_2);
                all * -(-wave).exp_m1()
            })
            .collect();
        let dx = 0.02 * length;
        let correlation: Vec<f64> = (0..700)
            .map(|j| {
                let x = f64::from(j) * dx;
                let sum: f64 = spectrum
                    .iter()
                    .enumerate()
                    .map(|(k, s)| s * ((k as f64 + 0.5) * dk * x).cos())
                    .sum();
                sum * dk / PI
            })
            .collect();
        let variance = correlation[0];
        let (first, step) = (0.04 * TAU, 0.12);
        let dq = 0.01 * TAU;
        let density = (0..38)
            .into_par_iter()
            .map(|k| {
                let g = ((f64::from(k) * step).exp() * first).powi(2);
                let screen: Vec<f64> = correlation
                    .iter()
                    .map(|c| (-g * (variance - c)).exp() - (-g * variance).exp())
                    .collect();
                (0..420)
                    .map(|i| {
                        let q = f64::from(i) * dq;
                        let sum: f64 = screen
                            .iter()
                            .enumerate()
                            .map(
                                |(j, s)| {
                                    if j == 0 { 0.5 * s } else { s * (q * j as f64 * dx).cos() }
                                },
                            )
                            .sum();
                        (sum * dx / PI).max(0.0)
                    })
                    .collect()
            })
            .collect();
        let mut law = Self { variance, density, dq, first, step, tables: Vec::new() };
        law.tables = (0..4 * IN)
            .into_par_iter()
            .map(|at| {
                let (above, through) = (at / (2 * IN) == 0, (at / IN) % 2 == 1);
                let wi = incoming(((at % IN) as f64 + 0.5) * 0.5, above);
                let width = PI / OUT as f64;
                let mut sum = 0.0;
                let sums: Vec<f64> = (0..OUT)
                    .map(|k| {
                        sum += law.diffuse(
                            wi,
                            outgoing((k as f64 + 0.5) * width - 0.5 * PI, above != through),
                        ) * width;
                        sum
                    })
                    .collect();
                (sum, sums)
            })
            .collect();
        law
    }

    fn at(&self, q: f64, q_z: f64) -> f64 {
        let (x, y) = (q / self.dq, ((q_z / self.first).ln() / self.step).clamp(0.0, 36.99));
        let (i, k) = (x as usize, y as usize);
        if i + 1 >= self.density[0].len() {
            return 0.0;
        }
        let (s, t) = (x - i as f64, y - k as f64);
        let along = |row: &[f64]| row[i] + s * (row[i + 1] - row[i]);
        // weak phases: in proportion to the square of q_z
        let below = (q_z / self.first).min(1.0).powi(2);
        below * (along(&self.density[k]) * (1.0 - t) + along(&self.density[k + 1]) * t)
    }

    /// Obliquity times Fresnel's share, `h_z`, and `h_x`; `None` where no facet leads.
    fn factor(wi: Plane, wo: Plane) -> Option<(f64, Plane)> {
        let index = |w: Plane| if w[1] > 0.0 { 1.0 } else { N };
        let (ni, no) = (index(wi), index(wo));
        let h = [ni * wi[0] + no * wo[0], ni * wi[1] + no * wo[1]];
        let (ih, oh) = (dot(wi, h), dot(wo, h));
        let reflected = (wi[1] > 0.0) == (wo[1] > 0.0);
        let front = 1.0_f64.copysign(wi[1]) * 1.0_f64.copysign(h[1]);
        let seen = if reflected { ih > 0.0 } else { front * ih > 0.0 && front * oh < 0.0 };
        let below = h[1] * h[1] * wi[1].abs();
        if !seen || below <= 0.0 {
            return None;
        }
        let beyond = if wi[1] > 0.0 { N } else { 1.0 / N };
        let cos = (ih.abs() / dot(h, h).sqrt()).min(1.0);
        let f = fresnel::dielectric(cos, beyond);
        let share = if reflected { f.reflected } else { f.transmitted };
        Some((share * ih.abs() * oh.abs() / below, h))
    }

    /// Diffuse flux per radian.
    fn diffuse(&self, wi: Plane, wo: Plane) -> f64 {
        let Some((factor, h)) = Self::factor(wi, wo) else { return 0.0 };
        let no = if wo[1] > 0.0 { 1.0 } else { N };
        TAU * no * self.at((TAU * h[0]).abs(), (TAU * h[1]).abs()) * factor
    }

    /// Where a level facet sends coherent light, and its flux.
    fn coherent(&self, wi: Plane, through: bool) -> Option<(Plane, f64)> {
        let above = wi[1] > 0.0;
        let (ni, no) = match (above, through) {
            (true, true) => (1.0, N),
            (false, true) => (N, 1.0),
            _ => (1.0, 1.0),
        };
        let x = -wi[0] * ni / no;
        let z = (1.0 - x * x).max(0.0).sqrt();
        if z <= 0.0 {
            return None;
        }
        let wo = [x, if above == through { -z } else { z }];
        let (share, h) = Self::factor(wi, wo).map(|_| {
            let beyond = if above { N } else { 1.0 / N };
            let f = fresnel::dielectric(wi[1].abs(), beyond);
            let index = |w: Plane| if w[1] > 0.0 { 1.0 } else { N };
            (
                if through { f.transmitted } else { f.reflected },
                index(wi) * wi[1] + index(wo) * wo[1],
            )
        })?;
        Some((wo, share * (-(TAU * h).powi(2) * self.variance).exp()))
    }

    /// Draws light, with its weight.
    fn sample(&self, wi: Plane, uniform: &mut impl FnMut() -> f64) -> Option<(Plane, f64)> {
        let above = wi[1] > 0.0;
        let deg = wi[0].abs().atan2(wi[1].abs()).to_degrees();
        let bin = ((2.0 * deg) as usize).min(IN - 1);
        let row = |through: bool| usize::from(!above) * 2 * IN + usize::from(through) * IN + bin;
        let coherent = [false, true].map(|t| self.coherent(wi, t));
        let parts = [
            coherent[0].map_or(0.0, |c| c.1),
            coherent[1].map_or(0.0, |c| c.1),
            self.tables[row(false)].0,
            self.tables[row(true)].0,
        ];
        let all: f64 = parts.iter().sum();
        let shares = parts.map(|p| if p > 0.0 { p / all } else { 0.0 });
        let scale = 1.0 / all.max(1.0);
        let mut u = uniform();
        let part = shares.iter().position(|s| {
            u -= s;
            u < 0.0
        })?;
        if part < 2 {
            return coherent[part].map(|(wo, flux)| (wo, scale * flux / shares[part]));
        }
        let through = part == 3;
        let (sum, sums) = &self.tables[row(through)];
        let width = PI / OUT as f64;
        let (v, w) = (uniform(), uniform());
        let cell = if v < 0.1 {
            (v * 10.0 * OUT as f64) as usize
        } else {
            sums.partition_point(|s| *s <= (v - 0.1) / 0.9 * sum)
        }
        .min(OUT - 1);
        let angle = (cell as f64 + w) * width - 0.5 * PI;
        let mass = (sums[cell] - if cell > 0 { sums[cell - 1] } else { 0.0 }) / sum;
        let drawn = 0.9 * mass / width + 0.1 / PI;
        // the tables hold one sign of the incidence
        let wo = outgoing(if wi[0] > 0.0 { -angle } else { angle }, above != through);
        Some((wo, scale * self.diffuse(wi, wo) / (drawn * shares[part])))
    }
}

/// Light that comes at an angle.
fn incoming(deg: f64, above: bool) -> Plane {
    let (s, c) = deg.to_radians().sin_cos();
    [-s, if above { c } else { -c }]
}

fn outgoing(angle: f64, above: bool) -> Plane {
    let (s, c) = angle.sin_cos();
    [s, if above { c } else { -c }]
}

struct Grooved<'a>(&'a Law);

impl Facet for Grooved<'_> {
    fn turn(
        &self,
        from: Direction<f32>,
        m: Direction<f32>,
        above: bool,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Turned> {
        let ([fx, _, fz], [mx, _, mz]) = (from.xyz().map(f64::from), m.xyz().map(f64::from));
        let wi = [fx * mz - fz * mx, fx * mx + fz * mz];
        if (wi[1] > 0.0) != above || wi[1].abs() <= 0.0 {
            return None;
        }
        let (wo, weight) = self.0.sample(wi, uniform)?;
        let to = Direction::new(
            (wo[0] * mz + wo[1] * mx) as f32,
            0.0,
            (wo[1] * mz - wo[0] * mx) as f32,
        )?;
        (weight > 0.0 && weight.is_finite()).then_some(Turned { to, above: wo[1] > 0.0, weight })
    }
}

/// Flux in each degree from -89 to 89, mean over two degrees: reflected and transmitted.
type Curves = [Vec<f64>; 2];

fn hybrid(
    profile: Profile,
    q_z: f64,
    beams: &[(bool, f64)],
    rays: Rays,
) -> (Option<f64>, Vec<Curves>) {
    let Profile { rq, length } = profile;
    // D = 2 Rq^2 (1 - exp(-(r / l)^2)) reaches 2 LOST / q_z^2
    let left = 1.0 - LOST / (q_z * rq).powi(2);
    let cutoff = (left > 0.0).then(|| DISTANCES * length * (-left.ln()).sqrt());
    let law = Law::new(profile, cutoff);
    let field = cutoff.map(|cutoff| {
        let pitch = length / FINE;
        let surface = GaussianSurface {
            size: (POINTS, 1),
            pitches_um: (pitch, pitch),
            rq_um: rq,
            lengths_um: (length, length),
            seed: 7,
        };
        let line = surface.map().expect("a profile");
        let (long, _) = split(&line, Edges::Periodic, cutoff).expect("complete");
        let row = long.complete().expect("complete");
        let rows = (0..4).flat_map(|_| row.iter().copied()).collect();
        let map = HeightMap::new((POINTS, 4), (pitch, pitch), rows).expect("a map");
        Field::new(&map, Edges::Periodic).expect("a field")
    });
    let curves = beams.iter().map(|&(above, deg)| {
        let [x, z] = incoming(deg, above);
        let blocks: Vec<Curves> = (0..64_u64)
            .into_par_iter()
            .map(|block| {
                let generator = &mut Pcg64Mcg::new(u128::from(rays.seed * 1000 + block) * 7919 + 1);
                let mut found: Curves = [vec![0.0; 179], vec![0.0; 179]];
                for _ in 0..rays.count / 64 {
                    let mut uniform = || f64::uniform(generator);
                    let ray = match &field {
                        Some(field) => {
                            let wi = Direction::from_unit(x, 0.0, z);
                            let ray = field.scatter(wi, &Grooved(&law), &mut uniform);
                            ray.map(|ray| ([ray.wo.x(), ray.wo.z()], ray.weight))
                        }
                        None => law.sample([x, z], &mut uniform),
                    };
                    let Some((wo, weight)) = ray else { continue };
                    let out = wo[0].atan2(wo[1].abs()).to_degrees();
                    let lobe = usize::from((wo[1] > 0.0) != above);
                    for (k, flux) in found[lobe].iter_mut().enumerate() {
                        if (out - (k as f64 - 89.0)).abs() <= 1.0 {
                            *flux += 0.5 * weight / rays.count as f64;
                        }
                    }
                }
                found
            })
            .collect();
        let mut sum: Curves = [vec![0.0; 179], vec![0.0; 179]];
        for block in &blocks {
            for (all, part) in sum.iter_mut().zip(block) {
                all.iter_mut().zip(part).for_each(|(a, b)| *a += b);
            }
        }
        sum
    });
    (cutoff, curves.collect())
}

/// Columns of a table of curves by name.
struct Table {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).expect("the curves of the atlas");
        let mut lines = text.lines().filter(|l| !l.starts_with('#'));
        let names = lines.next().expect("a header").split(',').map(str::to_owned).collect();
        let number = |f: &str| f.trim().parse().expect("a number");
        Self { names, rows: lines.map(|l| l.split(',').map(number).collect()).collect() }
    }

    /// The sum of columns.
    fn sum(&self, names: &[String]) -> Vec<f64> {
        let at: Vec<usize> = names
            .iter()
            .map(|n| self.names.iter().position(|m| m == n).expect("a column"))
            .collect();
        self.rows.iter().map(|row| at.iter().map(|k| row[*k]).sum()).collect()
    }
}

/// `q_z` of the middle of a lobe.
fn momentum(above: bool, deg: f64, through: bool) -> f64 {
    let (s, c) = deg.to_radians().sin_cos();
    let (ni, no) = if above { (1.0, N) } else { (N, 1.0) };
    let z = (1.0 - (ni * s / no).powi(2)).max(0.0).sqrt();
    TAU * if through { (no * z - ni * c).abs() } else { 2.0 * ni * c }
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().expect("the folder of the atlas");
    let count = arguments.next().and_then(|a| a.parse().ok()).unwrap_or(1_000_000);
    println!(
        "| Rq | slope | lobe | total | waves | rays | one split | its total | a split a lobe | its total | L, L of the lobe |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for (rq, slope) in CELLS {
        let table = Table::read(&Path::new(&folder).join(format!("curves_{rq}_{slope}.csv")));
        let profile = Profile { rq, length: std::f64::consts::SQRT_2 * rq / slope };
        let mut beams: Vec<(String, bool, f64)> = Vec::new();
        for name in table.names.iter().filter_map(|n| n.strip_suffix("_R_rig")) {
            let above = name.starts_with("air");
            let deg = name.trim_start_matches("air").trim_start_matches("in");
            beams.push((name.to_owned(), above, deg.parse().expect("an angle")));
        }
        let all: Vec<(bool, f64)> = beams.iter().map(|b| (b.1, b.2)).collect();
        let one_q = TAU * (N - 1.0).min(1.0);
        let (cutoff, one) = hybrid(profile, one_q, &all, Rays { count, seed: 1 });
        let text = |c: Option<f64>| c.map_or("all short".into(), |c| format!("{c:.2}"));
        for (k, (name, above, deg)) in beams.iter().enumerate() {
            for (lobe, letter) in ["R", "T"].iter().enumerate() {
                let named = |what: &str| format!("{name}_{letter}_{what}");
                let rigorous = table.sum(&[named("rig"), named("coh")]);
                let waves = table.sum(&[named("kir"), named("kircoh")]);
                let traced = table.sum(&[named("ray")]);
                let own_q = momentum(*above, *deg, lobe == 1).max(0.05);
                let (own_cutoff, own) =
                    hybrid(profile, own_q, &[(*above, *deg)], Rays { count, seed: 2 });
                let peak = rigorous.iter().copied().fold(0.0, f64::max);
                let rms = |found: &[f64]| {
                    let sum: f64 =
                        found.iter().zip(&rigorous).map(|(a, b)| (a - b) * (a - b)).sum();
                    100.0 * (sum / rigorous.len() as f64).sqrt() / peak
                };
                let total = |found: &[f64]| found.iter().sum::<f64>();
                println!(
                    "| {rq} | {slope} | {name} {letter} | {:.4} | {:.2} | {:.2} | {:.2} | {:.4} | {:.2} | {:.4} | {}, {} |",
                    total(&rigorous),
                    rms(&waves),
                    rms(&traced),
                    rms(&one[k][lobe]),
                    total(&one[k][lobe]),
                    rms(&own[0][lobe]),
                    total(&own[0][lobe]),
                    text(cutoff),
                    text(own_cutoff),
                );
            }
        }
    }
}
