//! Gaussian surfaces: coherent part and diffuse density of both engines against the closed form, which is first checked
//! against quadrature by an independent program, `golden/kirchhoff_gaussian.py`.
//!
//! A map is one sample, so densities are summed over a ring of a thousand orders or more about a row's momentum and
//! over all maps, and compared with the closed form summed over the same momenta. Rows are left out where the
//! grid cannot show them (neighbouring periods of the spectrum would add more than a thousandth) and where they
//! are below single precision (less than 1e-8 of the light in an order). Where phases are large, sums are freed of the
//! number of facets that maps happen to have ([`Slopes`]).

use std::f64::consts::{PI, TAU};

use asperity::kirchhoff::{Beam, Order};
use asperity::surface::{Edges, HeightMap};
use asperity_core::bsdf::{Bsdf, Lobe};
use asperity_core::direction::Direction;
use asperity_tests::oracle::fresnel;
use asperity_tests::{extensive, golden, tolerance};

use super::surfaces::{ETA, Gaussian, K, Ring, Slopes, all, beam, boundary, index, momentum};
use crate::common::Random;
use asperity_tests::kirchhoff::obliquity;

/// A row of a reference file.
#[derive(Clone, Debug)]
struct Row {
    name: String,
    surface: Gaussian,
    beam: Beam,
    wo: Direction<f64>,
    coherent: f64,
    density: f64,
}

fn rows() -> Vec<Row> {
    let text = golden::text("kirchhoff_gaussian.csv");
    let row = |line: &str| {
        let (geometry, rest) = line.split_once(',')?;
        let v: Vec<f64> = rest.split(',').filter_map(|x| x.parse().ok()).collect();
        let &[sigma_um, length_um, from, to, coherent, density] = v.as_slice() else {
            return None;
        };
        let (air, lobe) = match geometry {
            "refl_air" => (true, Lobe::Reflection),
            "trans_air_to_n" => (true, Lobe::Transmission),
            "trans_n_to_air" => (false, Lobe::Transmission),
            _ => return None,
        };
        let (s, c) = to.to_radians().sin_cos();
        let wo = Direction::from_unit(s, 0.0, if geometry == "trans_air_to_n" { -c } else { c });
        let name = format!("{geometry} sigma {sigma_um} L {length_um}, {from} to {to:.1} deg");
        let surface = Gaussian { sigma_um, length_um };
        Some(Row { name, surface, beam: beam(from, air, lobe), wo, coherent, density })
    };
    let rows: Vec<Row> = text.lines().filter(|l| !l.starts_with('#')).filter_map(row).collect();
    assert!(rows.len() == 441, "{}", rows.len());
    rows
}

/// `|q_z|` of the specular direction of a beam.
fn specular(beam: &Beam) -> f64 {
    let (x, cos, n_i) = (beam.wi.x(), beam.wi.z().abs(), index(beam.wi));
    match beam.lobe {
        Lobe::Reflection => 2.0 * K * n_i * cos,
        Lobe::Transmission => {
            let n_o = 1.0 + ETA - n_i;
            K * (n_o * (1.0 - (n_i * x / n_o).powi(2)).sqrt() - n_i * cos).abs()
        }
    }
}

#[test]
fn the_closed_form_is_that_of_quadrature() {
    let rows = rows();
    let (mut coherent, mut density) = (0.0_f64, 0.0_f64);
    for row in &rows {
        let expected = row.surface.coherent(specular(&row.beam));
        if row.coherent > 1e-30 {
            coherent = coherent.max((expected / row.coherent - 1.0).abs());
        }
        let [q, q_z] = momentum(row.beam.wi, row.wo);
        let expected = row.surface.density(q, q_z);
        // the file's own quadrature ends there
        if row.density > 1e-6 {
            let off = (expected / row.density - 1.0).abs();
            assert!(off < tolerance::KIRCHHOFF_SERIES.allowed, "{row:?} {expected}");
            density = density.max(off);
        }
    }
    println!("{} rows: coherent within {coherent:.1e}, D within {density:.1e}", rows.len());
    assert!(coherent < tolerance::KIRCHHOFF_SERIES.allowed, "{coherent}");
}

/// Quantiles of the normal law by bisection of its distribution, in no order.
fn normal_heights(size: usize, sigma_um: f64) -> HeightMap {
    let count = size * size;
    // integral of the density by Simpson's rule is inverted on a fine grid
    let (steps, reach) = (200_000, 6.5);
    let dx = 2.0 * reach / f64::from(steps);
    let density = |x: f64| (-0.5 * x * x).exp() / TAU.sqrt();
    let mut heights = Vec::with_capacity(count);
    let mut below = 0.0;
    for k in 0..steps {
        let x = -reach + f64::from(k) * dx;
        let share = dx / 6.0 * (density(x) + 4.0 * density(x + 0.5 * dx) + density(x + dx));
        while heights.len() < count {
            let target = (heights.len() as f64 + 0.5) / count as f64;
            if target > below + share {
                break;
            }
            heights.push(sigma_um * (x + dx * (target - below) / share));
        }
        below += share;
    }
    assert!(heights.len() == count);
    let mut random = Random::new(5);
    for k in (1..count).rev() {
        heights.swap(k, random.between(0.0, k as f64 + 1.0) as usize);
    }
    HeightMap::new((size, size), (1.0, 1.0), heights).unwrap()
}

/// The mean field depends on the law of the heights alone, so a map of normal quantiles has no noise to speak of.
#[test]
fn the_coherent_part_is_that_of_normal_heights() {
    let rows = rows();
    let (mut worst, mut dark, mut count) = ([0.0_f64; 2], [0.0_f64; 2], [0, 0]);
    let mut done: Option<(Gaussian, HeightMap)> = None;
    // one row of each beam
    for rows in rows.chunks(7) {
        let Row { surface, beam, coherent, name, .. } = &rows[0];
        let known = done.take().filter(|(s, _)| s == surface);
        let (_, map) =
            done.insert(known.unwrap_or_else(|| (*surface, normal_heights(96, surface.sigma_um))));
        let exact = boundary(map, Edges::Periodic).coherent(beam.wi);
        let relative = if beam.wi.z() > 0.0 { ETA } else { 1.0 / ETA };
        let reflected = fresnel(beam.wi.z().abs(), relative).unpolarised();
        let by_law = match beam.lobe {
            Lobe::Reflection => exact.reflected / reflected,
            Lobe::Transmission => exact.transmitted / (1.0 - reflected),
        };
        let found = all(map, Edges::Periodic, &[*beam]);
        let order = found[0].iter().find(Order::is_specular).unwrap();
        for (k, found) in [order.intensity, by_law].into_iter().enumerate() {
            if *coherent > 1e-3 {
                let off = (found / coherent - 1.0).abs();
                worst[k] = worst[k].max(off);
                assert!(off < tolerance::COHERENT.allowed, "{name}: {found} {coherent}");
            } else {
                dark[k] = dark[k].max((found - coherent).abs());
                assert!((found - coherent).abs() < tolerance::COHERENT_DARK.allowed, "{name}");
            }
        }
        count[usize::from(*coherent <= 1e-3)] += 1;
    }
    println!(
        "coherent: {} beams within {:.1e} (orders), {:.1e} (mean law); {} below 1e-3 within {:.1e}, {:.1e}",
        count[0], worst[0], worst[1], count[1], dark[0], dark[1]
    );
}

/// Maps of a surface: points, pitch in um, how many.
#[derive(Clone, Copy, Debug)]
struct Case {
    surface: Gaussian,
    size: usize,
    pitch: f64,
    maps: usize,
}

/// The maps of each surface. The two roughest are usually seen in transmission alone: reflection needs finer maps, and
/// those of as many facets more time.
fn all_cases() -> Vec<Case> {
    let usual = [
        (0.01, 2.0, 128, 0.5, 16),
        (0.05, 5.0, 192, 0.6, 16),
        (0.1, 5.0, 256, 0.5, 16),
        (0.25, 5.0, 256, 0.4, 32),
        (0.5, 10.0, 256, 0.4, 40),
        (1.0, 15.0, 256, 1.2, 48),
        (2.5, 30.0, 256, 1.2, 32),
    ];
    usual
        .into_iter()
        .map(|(sigma_um, length_um, size, pitch, maps)| {
            let surface = Gaussian { sigma_um, length_um };
            let finer = extensive() && sigma_um > 0.9;
            let (size, pitch) = if finer { (512, 0.36) } else { (size, pitch) };
            Case { surface, size, pitch, maps: if extensive() { 4 * maps } else { maps } }
        })
        .collect()
}

/// Usually one surface of each kind: first order, some orders, many, and facets. Those between, and rougher ones, show nothing else.
fn cases() -> Vec<Case> {
    let kinds = [0.01, 0.1, 0.25, 1.0];
    let is = |case: &Case| kinds.iter().any(|sigma| (case.surface.sigma_um - sigma).abs() < 1e-9);
    all_cases().into_iter().filter(|case| extensive() || is(case)).collect()
}

/// Orders in a ring.
const ORDERS: f64 = 1500.0;

/// Sums over a row's ring of orders.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    found: f64,
    expected: f64,
    /// Facets of the law and of the maps, where phases are large.
    facets: [f64; 2],
    count: u32,
}

impl Sums {
    fn deviation(&self) -> f64 {
        let [law, maps] = self.facets;
        let ratio = if maps > 0.0 { law / maps } else { 1.0 };
        self.found / self.expected * ratio - 1.0
    }

    fn add(&mut self, density: f64, expected: f64, slopes: &Slopes, momentum: [f64; 2]) {
        self.found += density;
        self.expected += expected;
        self.count += 1;
        if slopes.surface().g(momentum[1]) > FACETS_ABOVE {
            let [law, map] = slopes.at(momentum);
            self.facets[0] += law;
            self.facets[1] += map;
        }
    }
}

/// Mean square phase above which light goes where facets are.
const FACETS_ABOVE: f64 = 20.0;

/// Prints what was found, and judges it: the bright rows, those below a hundredth of the peak, and those below a
/// thousandth, which are shown only.
fn judge(engine: &str, rows: &[(&Row, Ring)], sums: &[Sums], left_out: [usize; 2]) {
    let (mut squares, mut worst, mut count) = ([0.0; 3], [0.0_f64; 3], [0; 3]);
    for ((row, _), s) in rows.iter().zip(sums) {
        let off = s.deviation();
        let (name, d) = (&row.name, row.density);
        println!("{engine} {name}: D {d:.3e}, {:+.2} %, {} momenta", 100.0 * off, s.count);
        let share = row.density / row.surface.density(0.0, specular(&row.beam));
        let class = usize::from(share < 1e-2) + usize::from(share < 1e-3);
        squares[class] += off * off;
        worst[class] = worst[class].max(off.abs());
        count[class] += 1;
    }
    let percent = |k: usize| {
        let rms = (squares[k] / f64::from(count[k].max(1))).sqrt();
        format!("{} (rms {:.2} %, worst {:.2} %)", count[k], 100.0 * rms, 100.0 * worst[k])
    };
    println!(
        "{engine}: {} bright rows, {} below 1e-2, {} below 1e-3; left out: {} beyond the grid, {} too dark",
        percent(0),
        percent(1),
        percent(2),
        left_out[0],
        left_out[1]
    );
    assert!(worst[0] < tolerance::DIFFUSE_DENSITY.allowed, "{engine}: {worst:?}");
    assert!(worst[1] < tolerance::DIFFUSE_TAIL.allowed, "{engine}: {worst:?}");
}

/// The rows of a surface that its maps show, with their rings, and how many they do not.
fn shown(rows: &[Row], Case { surface, size, pitch, .. }: Case) -> (Vec<(&Row, Ring)>, [usize; 2]) {
    let step = TAU / (size as f64 * pitch);
    let mut left_out = [0, 0];
    let mut seen = Vec::new();
    // usually from 0 and 30 degrees alone
    let middle = f64::to_radians(15.0).sin();
    let wanted = |r: &&Row| {
        r.surface == surface && (extensive() || (r.beam.wi.x().abs() - middle).abs() > 0.1)
    };
    for row in rows.iter().filter(wanted) {
        let [q, q_z] = momentum(row.beam.wi, row.wo);
        let exact = surface.density(q, q_z);
        if exact * step * step < 1e-8 {
            left_out[1] += 1;
        } else if q > 0.9 * PI / pitch || surface.sampled(q, q_z, pitch) > 1.001 * exact {
            left_out[0] += 1;
        } else {
            seen.push((row, Ring::new(q, ORDERS, step)));
        }
    }
    (seen, left_out)
}

#[test]
fn orders_have_the_density_of_the_closed_form() {
    let rows = rows();
    for case in cases() {
        let Case { surface, size, pitch, maps } = case;
        let (seen, left_out) = shown(&rows, case);
        let mut beams: Vec<Beam> = seen.iter().map(|(row, _)| row.beam).collect();
        beams.dedup();
        let mut sums = vec![Sums::default(); seen.len()];
        let per_order = (size as f64 * pitch / TAU).powi(2);
        for map in surface.maps(size, pitch, maps, 1) {
            let slopes = Slopes::new(surface, &map);
            for found in all(&map, Edges::Periodic, &beams) {
                let mine: Vec<usize> =
                    (0..seen.len()).filter(|k| seen[*k].0.beam == *found.beam()).collect();
                for order in found.iter().filter(|o| !o.is_specular()) {
                    let q = momentum(found.beam().wi, order.wo);
                    let mut exact = None;
                    for &k in mine.iter().filter(|k| seen[**k].1.holds(q[0])) {
                        let exact = *exact.get_or_insert_with(|| surface.density(q[0], q[1]));
                        sums[k].add(order.intensity * per_order, exact, &slopes, q);
                    }
                }
            }
        }
        judge("orders", &seen, &sums, left_out);
    }
}

#[test]
fn the_mean_law_has_the_density_of_the_closed_form() {
    let rows = rows();
    for case in cases() {
        let Case { surface, size, pitch, maps } = case;
        let (seen, left_out) = shown(&rows, case);
        let mut sums = vec![Sums::default(); seen.len()];
        for map in surface.maps(size, pitch, maps, 2) {
            let law = boundary(&map, Edges::Periodic);
            let slopes = Slopes::new(surface, &map);
            for ((row, ring), sum) in seen.iter().zip(&mut sums) {
                let wi = row.beam.wi;
                for wo in ring.directions(wi, row.wo.z() > 0.0) {
                    let q = momentum(wi, wo);
                    let factor = obliquity(ETA, wi, wo) * (K * index(wo)).powi(2);
                    // facets that turn away from the light lead nowhere
                    if factor > 0.0 {
                        let density = law.ars(wi, wo) / factor;
                        sum.add(density, surface.density(q[0], q[1]), &slopes, q);
                    }
                }
            }
        }
        judge("mean law", &seen, &sums, left_out);
    }
}

/// Light from `(a, b, c)` that goes to `(a, -b, c)`: q = 2 k a while `q_z` stays 2 k c.
#[test]
fn what_is_not_coherent_is_diffuse() {
    let cos = 0.7_f64;
    for Case { surface, size, pitch, .. } in all_cases().into_iter().take(4).skip(1) {
        let map = &surface.maps(size, pitch, 1, 3)[0];
        let law = boundary(map, Edges::Periodic);
        let sine = (1.0 - cos * cos).sqrt();
        let steps = 4000;
        let mut diffuse = 0.0;
        for k in 0..steps {
            let a = sine * (f64::from(k) + 0.5) / f64::from(steps);
            let b = (sine * sine - a * a).sqrt();
            let [wi, wo] = [b, -b].map(|b| Direction::from_unit(a, b, cos));
            let density = law.ars(wi, wo) / (obliquity(ETA, wi, wo) * K * K);
            diffuse += density * TAU * (2.0 * K * a) * 2.0 * K * sine / f64::from(steps);
        }
        let straight = Direction::from_unit(-sine, 0.0, cos);
        let reflected = fresnel(cos, ETA).unpolarised();
        let coherent = law.coherent(straight).reflected / reflected;
        println!("{surface:?}: diffuse {diffuse:.4}, coherent {coherent:.4}");
        let off = (diffuse + coherent - 1.0).abs();
        assert!(off < tolerance::DIFFUSE_POWER.allowed, "{surface:?} {off}");
        let exact = surface.coherent(2.0 * K * cos);
        assert!((coherent - exact).abs() < 0.02, "{surface:?} {coherent} {exact}");
    }
}
