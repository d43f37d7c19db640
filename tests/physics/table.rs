//! Tables of traced boundaries: against closed forms, against themselves, and at their edges.

use std::sync::Arc;

use asperity::binned::{Azimuth, Bin, BinnedBsdf, Binning, gather, to_disc};
use asperity::boundary::Boundary;
use asperity::energy::balance;
use asperity::forward::Rays;
use asperity::raytrace::{Field, TracedBoundary};
use asperity::surface::{Edges, HeightMap};
use asperity::watch::Watch;
use asperity_core::bsdf::{Bsdf, Lobe, Scatter, Scattered};
use asperity_core::direction::{Direction, Side};
use asperity_core::math::Real;
use asperity_tests::chi2::{Bins, sidak};
use asperity_tests::{count, extensive, tolerance};
use rand_pcg::Pcg64Mcg;

use crate::common::{Random, dir, ggx, incidence, ior, wide};

const SIDES: [Side; 2] = [Side::Air, Side::Dielectric];
const LOBES: [Lobe; 2] = [Lobe::Reflection, Lobe::Transmission];

fn plan(rays: usize, seed: u64, degrees: &[f64]) -> Binning {
    let mut plan = Binning::new(ior(1.49), Rays { count: rays as u64, seed });
    for side in SIDES {
        plan = plan.with_incidences(side, degrees).unwrap();
    }
    plan
}

fn traced<S: Scatter<f64> + Sync>(boundary: &S, plan: &Binning) -> BinnedBsdf {
    gather(boundary, plan, Watch::nobody()).unwrap()
}

fn from(deg: f64, side: Side) -> Direction<f64> {
    dir(incidence(deg, side == Side::Air))
}

/// The direction on a side of a point of the disc.
fn above([x, y]: [f64; 2], air: bool) -> Direction<f64> {
    let z = (1.0 - x * x - y * y).max(0.0).sqrt();
    Direction::from_unit(x, y, if air { z } else { -z })
}

/// Periodic random heights, smoothed over a few points: isotropic, slopes of about `slope`.
fn random_map(n: usize, slope: f64, seed: u128) -> HeightMap {
    let mut generator = Pcg64Mcg::new(seed);
    let mut heights: Vec<f64> = (0..n * n).map(|_| f64::uniform(&mut generator)).collect();
    for _ in 0..6 {
        let at = |x: usize, y: usize| heights[(y % n) * n + x % n];
        let mean = |k: usize| {
            let (x, y) = (k % n + n, k / n + n);
            let straight = at(x + 1, y) + at(x - 1, y) + at(x, y + 1) + at(x, y - 1);
            let across = at(x + 1, y + 1) + at(x - 1, y - 1) + at(x + 1, y - 1) + at(x - 1, y + 1);
            0.25 * at(x, y) + 0.125 * straight + 0.0625 * across
        };
        heights = (0..n * n).map(mean).collect();
    }
    let square = |k: usize| {
        let next = k / n * n + (k + 1) % n;
        (heights[next] - heights[k]).powi(2)
    };
    let rms = ((0..n * n).map(square).sum::<f64>() / (n * n) as f64).sqrt();
    let heights = heights.iter().map(|h| h * slope / rms).collect();
    HeightMap::new((n, n), (1.0, 1.0), heights).unwrap()
}

fn field(map: &HeightMap) -> TracedBoundary {
    let field = Arc::new(Field::new(map, Edges::Periodic).unwrap());
    TracedBoundary { field, eta: ior(1.49) }
}

/// Integral of `f` over a bin, by halving until the rule of 3 x 3 points settles.
fn integral(f: &impl Fn([f64; 2]) -> f64, corner: [f64; 2], sides: [f64; 2], depth: u32) -> f64 {
    let rule = |corner: [f64; 2], sides: [f64; 2]| {
        let nodes = [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0)];
        let nodes = [nodes[0], nodes[1], (1.0 - nodes[0].0, nodes[0].1)];
        let mut sum = 0.0;
        for (a, wa) in nodes {
            for (b, wb) in nodes {
                sum += wa * wb * f(to_disc([corner[0] + a * sides[0], corner[1] + b * sides[1]]));
            }
        }
        sum * sides[0] * sides[1] * std::f64::consts::PI
    };
    let half = [0.5 * sides[0], 0.5 * sides[1]];
    let corners = [[0.0, 0.0], [half[0], 0.0], [0.0, half[1]], half]
        .map(|d| [corner[0] + d[0], corner[1] + d[1]]);
    let (coarse, fine) = (rule(corner, sides), corners.iter().map(|&c| rule(c, half)).sum::<f64>());
    if depth == 0 || (depth < 5 && (fine - coarse).abs() < 1e-3 * fine.abs() + 1e-9) {
        return fine;
    }
    corners.iter().map(|&c| integral(f, c, half, depth - 1)).sum()
}

/// Flux that a law sends into a bin.
fn expected(law: &impl Bsdf<f64>, wi: Direction<f64>, lobe: Lobe, bin: &Bin) -> f64 {
    let air = (wi.z() > 0.0) == (lobe == Lobe::Reflection);
    let f = |p: [f64; 2]| law.eval(wi, above(p, air));
    let halves = if bin.mirrored { 2.0 } else { 1.0 };
    halves * integral(&f, bin.corner, bin.sides, 7)
}

/// A law that does not use the evenly spread first two numbers of a ray.
struct Unspread<S>(S);

impl<S: Scatter<f64>> Scatter<f64> for Unspread<S> {
    fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        let _ = [uniform(), uniform()];
        self.0.sample(wi, uniform)
    }
}

/// Mean square of (found - exact) / error over bins with enough rays for normal errors, and their number.
fn mean_square(bins: impl Iterator<Item = Bin>, exact: impl Fn(&Bin) -> f64, n: f64) -> [f64; 2] {
    let (mut squares, mut count) = (0.0, 0.0);
    for bin in bins {
        let exact = exact(&bin);
        if exact * n > 20.0 {
            let z = (bin.flux.value - exact) / bin.flux.std_error;
            (squares, count) = (squares + z * z, count + 1.0);
        }
    }
    [squares / f64::max(count, 1.0), count]
}

#[test]
fn a_table_of_ggx_has_its_values_within_the_stated_errors() {
    let (degrees, n) = ([0.0, 40.0, 75.0], count(200_000));
    for a in [0.01, 0.7] {
        let law = ggx::<f64>(a, 1.49);
        let plan = plan(n, 3, &degrees);
        let (table, spread) = (traced(&Unspread(law), &plan), traced(&law, &plan));
        for side in SIDES {
            for (k, &deg) in degrees.iter().enumerate() {
                for lobe in LOBES {
                    let exact = |bin: &Bin| expected(&law, from(deg, side), lobe, bin);
                    let [mean, bins] = mean_square(table.bins(side, k, 0, lobe), exact, n as f64);
                    let [less, _] = mean_square(spread.bins(side, k, 0, lobe), exact, n as f64);
                    println!(
                        "alpha {a} {side:?} {deg} {lobe:?}: {bins} bins, mean z^2 {mean:.3}, of strata {less:.3}"
                    );
                    // the mean of z^2 has a standard deviation of sqrt(2 / bins)
                    let allowed = 0.1 + 4.0 * (2.0 / f64::max(bins, 1.0)).sqrt();
                    assert!(bins < 20.0 || (mean - 1.0).abs() < allowed, "{a} {side:?} {deg}");
                    // neighbours start in different places: errors are found too large, not too small
                    assert!(less < 1.0 + allowed, "{a} {side:?} {deg}");
                }
            }
        }
    }
}

#[test]
fn totals_are_the_balance_of_the_closed_form() {
    let degrees = [0.0, 30.0, 43.0, 60.0, 85.0];
    for a in [0.01, 0.7] {
        let law = ggx::<f64>(a, 1.49);
        let table = traced(&law, &plan(count(100_000), 5, &degrees));
        for side in SIDES {
            for deg in degrees {
                let exact = balance(&Boundary::Ggx(law), side, deg, Rays { count: 1, seed: 1 });
                let found = table.totals(from(deg, side));
                let pairs =
                    [(found.reflected, exact.reflected), (found.transmitted, exact.transmitted)];
                for (found, exact) in pairs {
                    // 1e-4 is the error of the lattice rule at a kink
                    let most = 4.0 * found.std_error + 1e-4;
                    assert!(
                        (found.value - exact).abs() < most,
                        "{a} {side:?} {deg}: {found:?} {exact}"
                    );
                    assert!(found.std_error < 2e-3);
                }
            }
            for deg in 0..900 {
                let t = table.totals(from(0.1 * f64::from(deg), side));
                let sum = t.reflected.value + t.transmitted.value;
                assert!((0.3..=1.0 + 1e-12).contains(&sum), "{side:?} {deg}: {t:?}");
            }
        }
    }
}

/// The default incidences follow the reflected share from inside through the critical angle.
#[test]
fn the_default_incidences_describe_the_critical_angle() {
    for a in [0.01, 0.05, 0.2] {
        let law = ggx::<f64>(a, 1.49);
        let plan = Binning::new(ior(1.49), Rays { count: 20_000, seed: 2 });
        let table = traced(&law, &plan.with_incidences(Side::Air, &[]).unwrap());
        let mut worst = [0.0_f64; 2];
        for tenth in 0..850 {
            let deg = 0.1 * f64::from(tenth);
            let exact =
                balance(&Boundary::Ggx(law), Side::Dielectric, deg, Rays { count: 1, seed: 1 });
            let found = table.totals(from(deg, Side::Dielectric));
            worst[0] = worst[0].max((found.reflected.value - exact.reflected).abs());
            worst[1] = worst[1].max((found.transmitted.value - exact.transmitted).abs());
        }
        println!("alpha {a}: totals between the default incidences off by {worst:?} at most");
        assert!(worst[0].max(worst[1]) < 0.02, "{a}: {worst:?}");
    }
    let table = traced(&ggx(0.1, 1.49), &plan(1000, 1, &[]));
    assert!(table.eval(from(10.0, Side::Air), from(5.0, Side::Air)).abs() <= 0.0);
    assert!(table.sample(from(10.0, Side::Air), &mut || 0.5).is_none());
}

#[test]
fn samples_of_a_table_follow_its_density() {
    let map = field(&random_map(64, 0.4, 8));
    let mut fits = Vec::new();
    for azimuth in [Azimuth::Isotropic, Azimuth::Fixed(vec![0.0, 90.0, 180.0, 270.0])] {
        let plan = plan(20_000, 7, &[0.0, 40.0, 50.0]).with_azimuth(azimuth.clone()).unwrap();
        let table = traced(&map, &plan);
        for (deg, phi, side) in
            [(0.0, 0.0, Side::Air), (44.0, 100.0_f64, Side::Dielectric), (70.0, -20.0, Side::Air)]
        {
            let (s, c) = phi.to_radians().sin_cos();
            let [x, _, z] = from(deg, side).xyz();
            let wi = Direction::from_unit(x * c, x * s, z);
            let mut random = Random::new(11);
            let mut draw = || table.sample(wi, &mut || random.next()).map(|r| wide(r.wo));
            let pilot: Vec<_> = (0..4000).filter_map(|_| draw()).collect();
            let bins = Bins::new(&pilot, 100);
            // steps of the density at the borders of its bins: brute force, not cubature
            let n = if extensive() { 2048 } else { 1024 };
            let mut expected = vec![0.0; bins.len()];
            for air in [true, false] {
                for k in 0..n * n {
                    let p = [k % n, k / n].map(|i| (f64::from(i) + 0.5) / f64::from(n));
                    let wo = above(to_disc(p), air);
                    let flux = std::f64::consts::PI / f64::from(n * n) * table.eval(wi, wo);
                    expected[bins.index(wide(wo))] += flux;
                }
            }
            let totals = table.totals(wi);
            let sum = totals.reflected.value + totals.transmitted.value;
            let found: f64 = expected.iter().sum();
            assert!((found - sum).abs() < 3e-3, "{azimuth:?} {deg}: {found} of {sum}");
            let fit = bins.test(&expected, count(20_000), draw);
            fits.push((format!("{azimuth:?} {deg} {side:?}"), fit));
        }
    }
    let least = sidak(tolerance::SIGNIFICANCE.allowed, fits.len());
    for (case, fit) in fits {
        println!("{case}: p {:.3}, {} bins", fit.p, fit.freedom + 1);
        assert!(fit.p > least, "{case}: {fit:?}");
    }
}

#[test]
fn between_two_incidences_the_peak_stays_in_its_place() {
    let law = ggx::<f64>(0.05, 1.49);
    let table = traced(&law, &plan(count(1_000_000), 4, &[20.0, 25.0, 40.0, 45.0]));
    // from inside below the critical angle: beyond it more incidences are needed
    for (side, deg, far) in [(Side::Air, 42.5, 1.49), (Side::Dielectric, 22.5, 1.0 / 1.49)] {
        for lobe in LOBES {
            let wi = from(deg, side);
            let n = Direction::from_unit(0.0, 0.0, wi.z().signum());
            let specular = match lobe {
                Lobe::Reflection => wi.reflect(n),
                Lobe::Transmission => wi.refract(n, far).unwrap(),
            };
            // centre of the upper half of the lobe along the plane of incidence, and mean height about the mirror
            let (mut moment, mut mass) = (0.0, 0.0);
            let (mut height, mut exact) = (0.0, 0.0);
            let to = |theta: f64| {
                let (s, c) = theta.sin_cos();
                Direction::from_unit(s, 0.0, specular.z().signum() * c)
            };
            let centre = specular.x().asin();
            let steps = |half_deg: f64| {
                (-100..=100).map(move |k| (f64::from(k) / 100.0 * half_deg).to_radians())
            };
            let peak = steps(5.0).map(|d| table.ars(wi, to(centre + d))).fold(0.0, f64::max);
            for d in steps(5.0) {
                let value = table.ars(wi, to(centre + d));
                if value > 0.5 * peak {
                    (moment, mass) = (moment + value * d, mass + value);
                }
            }
            for d in steps(0.5) {
                height += table.ars(wi, to(centre + d));
                exact += law.ars(wi, to(centre + d));
            }
            let (off, ratio) = ((moment / mass).to_degrees(), height / exact);
            println!(
                "{side:?} {lobe:?}: peak {off:.3} deg from specular, height {ratio:.4} of the closed form"
            );
            assert!(
                off.abs() < 0.5 && (ratio - 1.0).abs() < 0.1,
                "{side:?} {lobe:?} {off} {ratio}"
            );
        }
    }
}

#[test]
fn a_flat_map_sends_all_light_into_one_smallest_bin() {
    let flat = field(&HeightMap::new((16, 16), (1.0, 1.0), vec![0.0; 256]).unwrap());
    let degrees = [20.0, 37.0, 70.0];
    let table = traced(&flat, &plan(20_000, 1, &degrees));
    for side in SIDES {
        for (k, &deg) in degrees.iter().enumerate() {
            let wi = from(deg, side);
            let far = if side == Side::Air { 1.49 } else { 1.0 / 1.49 };
            for (lobe, wo) in LOBES.into_iter().zip([
                Some(wi.reflect(Direction::normal())),
                wi.refract(
                    if side == Side::Air {
                        Direction::normal()
                    } else {
                        Direction::normal().opposite()
                    },
                    far,
                ),
            ]) {
                let full: Vec<Bin> =
                    table.bins(side, k, 0, lobe).filter(|b| b.flux.value > 0.0).collect();
                let Some(wo) = wo else {
                    assert!(full.is_empty());
                    continue;
                };
                let [bin] = full[..] else { panic!("{side:?} {deg} {lobe:?}: {full:?}") };
                assert!(bin.sides.iter().all(|s| *s <= 1.0 / 8192.0), "{bin:?}");
                let f = table.eval(wi, wo);
                assert!((f * bin.projected_sr - bin.flux.value).abs() < 1e-12, "{side:?} {deg}");
            }
        }
    }
}

#[test]
fn an_isotropic_map_is_the_same_by_fixed_azimuths() {
    let map = field(&random_map(512, 0.15, 5));
    let rays = count(60_000);
    let one = traced(&map, &plan(rays, 1, &[30.0]).with_rays_per_bin(10));
    let fixed = plan(rays, 2, &[30.0]).with_azimuth(Azimuth::directional()).unwrap();
    let fixed = fixed.with_rays_per_bin(10);
    let many = traced(&map, &fixed);
    assert_eq!((one.azimuth(), many.azimuth()), (&Azimuth::Isotropic, &Azimuth::directional()));
    for side in SIDES {
        for lobe in LOBES {
            let wi = from(30.0, side);
            let far = match (lobe, side) {
                (Lobe::Reflection, _) => 1.0,
                (_, Side::Air) => 1.0 / 1.49,
                _ => 1.49,
            };
            let air = (side == Side::Air) == (lobe == Lobe::Reflection);
            let (mut a, mut b) = (0.0, 0.0);
            // about the specular direction, at all azimuths of incidence
            for step in 0..12 {
                let (s, c) = (30.0 * f64::from(step)).to_radians().sin_cos();
                let turn = |[x, y]: [f64; 2]| [x * c - y * s, x * s + y * c];
                let [wx, wy] = turn([wi.x(), 0.0]);
                let from = Direction::from_unit(wx, wy, wi.z());
                for k in 0..400 {
                    let d = [k % 20, k / 20].map(|i| 0.02 * far * (f64::from(i) - 9.5));
                    let to = above(turn([0.5 * far + d[0], d[1]]), air);
                    a += one.eval(from, to);
                    b += many.eval(from, to);
                }
            }
            println!("{side:?} {lobe:?}: fixed over isotropic {:.4}", b / a);
            assert!((b / a - 1.0).abs() < 0.04, "{side:?} {lobe:?} {a} {b}");
        }
    }
}

#[test]
fn no_direction_gives_nan_and_none_in_the_surface_gives_light() {
    let map = field(&random_map(32, 0.8, 6));
    for azimuth in [Azimuth::Isotropic, Azimuth::Fixed(vec![20.0]), Azimuth::directional()] {
        let plan = plan(2000, 9, &[0.0, 40.0, 85.0]).with_azimuth(azimuth).unwrap();
        let table = traced(&map, &plan);
        assert!(table.slope() > 0.1 && table.slope() < 2.0, "{}", table.slope());
        let mut random = Random::new(2);
        for _ in 0..20_000 {
            let (wi, wo) = (dir::<f64>(random.direction()), dir::<f64>(random.direction()));
            for value in [table.eval(wi, wo), table.pdf(wi, wo), table.std_error(wi, wo)] {
                assert!(value.is_finite() && value >= 0.0, "{wi:?} {wo:?}");
            }
            if let Some(ray) = table.sample(wi, &mut || random.next()) {
                assert!(ray.wo.xyz().iter().all(|c| c.is_finite()));
                let (pdf, ars) = (table.pdf(wi, ray.wo), table.ars(wi, ray.wo));
                assert!((ars - pdf * ray.weight).abs() <= 1e-12 * ars);
            }
        }
        let (flat, up) = (Direction::from_unit(1.0, 0.0, 0.0), Direction::normal());
        let nan = Direction::from_unit(f64::NAN, 0.0, 1.0);
        for (wi, wo) in [(flat, up), (up, flat), (nan, up), (up, nan)] {
            assert!(table.eval(wi, wo).abs() <= 0.0 && table.std_error(wi, wo).abs() <= 0.0);
        }
        assert!(table.sample(flat, &mut || 0.3).is_none());
        // beyond the last incidence
        let totals = table.totals(from(89.9, Side::Air));
        assert!((0.0..=1.0).contains(&totals.reflected.value), "{totals:?}");
    }
}
