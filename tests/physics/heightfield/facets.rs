//! Where facets are met once the scatter of a traced map is that of single facets.
//!
//! The reference is a BSDF in 1/sr without cosine, of flux (no `eta^2` of radiance), angles in their own
//! medium: our convention, so nothing is converted. Its slope law `exp(-t^2 / s^2) / (pi s^2)` has `s`
//! as the rms of the whole slope: `s / sqrt 2` along each axis. A detector is a cone, so the closed form, checked
//! against the file at the cone's axis, is averaged over the cone.

use std::f64::consts::PI;

use asperity::forward::Rays;
use asperity::surface::Edges;
use asperity_core::bsdf::Scatter;
use asperity_tests::oracle::{Vec3, combine, cross, dot, fresnel, unit};
use asperity_tests::{count, golden, tolerance};

use super::maps::{ETA, boundary, gaussian, stream};
use crate::common::{dir, incidence};

const SLOPE: f64 = 0.1;

/// Single facets of a Gaussian slope law without shadowing.
fn closed_form(wi: Vec3, wo: Vec3) -> f64 {
    let index = |w: Vec3| if w[2] > 0.0 { 1.0 } else { ETA };
    let (ni, no) = (index(wi), index(wo));
    let reflected = wi[2] * wo[2] > 0.0;
    let half = if reflected { combine(1.0, wi, 1.0, wo) } else { combine(ni, wi, no, wo) };
    let m = unit(half);
    let m = if m[2] < 0.0 { m.map(|x| -x) } else { m };
    let (i, o) = (dot(wi, m), dot(wo, m));
    if (i * wi[2] <= 0.0) || (o * wo[2] <= 0.0) {
        return 0.0;
    }
    let tan2 = (m[0] * m[0] + m[1] * m[1]) / (m[2] * m[2]);
    let d = (-tan2 / (SLOPE * SLOPE)).exp() / (PI * SLOPE * SLOPE * m[2].powi(4));
    let relative = if wi[2] > 0.0 { ETA } else { 1.0 / ETA };
    let f = fresnel(i.abs(), relative).unpolarised();
    let cosines = (wi[2] * wo[2]).abs();
    if reflected {
        f * d / (4.0 * cosines)
    } else {
        (i * o).abs() * no * no * (1.0 - f) * d / (cosines * (ni * i + no * o).powi(2))
    }
}

/// One detector, and what it got from each map.
struct Detector {
    axis: Vec3,
    /// Cosine of half its cone.
    cosine: f64,
    expected: f64,
    counts: Vec<f64>,
    name: String,
}

/// Mean of the closed form times the cosine over a cone, times its solid angle.
fn over_cone(wi: Vec3, axis: Vec3, half: f64) -> f64 {
    let u = unit(cross(axis, [0.0, 1.0, 0.0]));
    let v = [0.0, 1.0, 0.0];
    let (rings, spokes) = (12, 24);
    let mut sum = 0.0;
    for r in 0..rings {
        // equal steps of 1 - cos are equal solid angles
        let down = (1.0 - half.cos()) * (f64::from(r) + 0.5) / f64::from(rings);
        let (c, s) = (1.0 - down, (down * (2.0 - down)).sqrt());
        for k in 0..spokes {
            let (sin, cos) = (2.0 * PI * f64::from(k) / f64::from(spokes)).sin_cos();
            let wo = combine(c, axis, s, combine(cos, u, sin, v));
            sum += closed_form(wi, wo) * wo[2].abs();
        }
    }
    sum / f64::from(rings * spokes) * 2.0 * PI * (1.0 - half.cos())
}

/// The detectors of one incidence: cones that see at least a twentieth of the brightest, not near the horizon.
fn detectors(rows: &[Vec<f64>], kind: f64, degrees: f64, wi: Vec3) -> Vec<Detector> {
    // half cones a quarter to a half of the lobe's rms width
    let (half, every) = [(2.5, 5), (0.5, 1), (2.5, 5), (0.75, 2)][kind as usize];
    let (from_air, through) = (kind < 2.0, kind as i32 % 2 == 1);
    let mut found = Vec::new();
    for row in rows {
        let &[k, i, o, want] = row.as_slice() else { panic!("{row:?}") };
        if (k - kind).abs() + (i - degrees).abs() > 1e-9 || o > 70.0 || o as i32 % every != 0 {
            continue;
        }
        let at = |o: f64| {
            let (s, c) = o.to_radians().sin_cos();
            [s, 0.0, if from_air == through { -c } else { c }]
        };
        // the file's directions are 1e-3 degrees further on than it says
        let exact = closed_form(wi, at(o + 1e-3));
        if want > 1e-6 {
            assert!(
                (exact / want - 1.0).abs() < tolerance::FACET_REFERENCE.allowed,
                "{row:?} {exact}"
            );
        }
        let half = f64::to_radians(half);
        found.push(Detector {
            axis: at(o),
            cosine: half.cos(),
            expected: over_cone(wi, at(o), half),
            counts: Vec::new(),
            name: format!("type {kind} from {degrees} to {o} deg"),
        });
    }
    let most = found.iter().map(|d| d.expected).fold(0.0, f64::max);
    found.retain(|d| d.expected > 0.05 * most);
    found
}

#[test]
fn a_gentle_surface_scatters_as_its_single_facets() {
    let rows = golden::numbers("facets.csv");
    let mut beams = Vec::new();
    for (air, kinds, incidences) in [
        (true, [0.0, 1.0], &[0.0, 15.0, 30.0, 45.0, 60.0][..]),
        (false, [2.0, 3.0], &[0.0, 15.0, 30.0]),
    ] {
        for &degrees in incidences {
            let wi = incidence(degrees, air);
            let seen = kinds.map(|kind| detectors(&rows, kind, degrees, wi));
            beams.push((wi, seen.into_iter().flatten().collect::<Vec<_>>()));
        }
    }
    let (maps, rays) = (8, Rays { count: count(150_000) as u64, seed: 0 });
    for seed in 0..maps {
        let boundary = boundary(&gaussian(1024, 20.0, SLOPE, seed), Edges::Periodic);
        for (wi, detectors) in &mut beams {
            let mut random = stream(1000 + seed);
            let mut counts = vec![0.0; detectors.len()];
            for _ in 0..rays.count {
                let out = boundary.sample(dir(*wi), &mut || random.next()).unwrap();
                let wo = out.wo.xyz();
                if wo[1].abs() > 0.05 {
                    continue;
                }
                for (n, d) in counts.iter_mut().zip(detectors.iter()) {
                    *n += f64::from(u8::from(dot(wo, d.axis) >= d.cosine));
                }
            }
            for (n, d) in counts.into_iter().zip(detectors.iter_mut()) {
                d.counts.push(n / rays.count as f64);
            }
        }
    }
    judge(&beams.into_iter().flat_map(|b| b.1).collect::<Vec<_>>(), rays.count as f64);
}

/// Each detector within some standard errors, and all together nearer.
fn judge(detectors: &[Detector], rays: f64) {
    let (mut squares, mut off, mut weight) = (0.0, 0.0, 0.0);
    for d in detectors {
        let n = d.counts.len() as f64;
        let mean = d.counts.iter().sum::<f64>() / n;
        let scatter = d.counts.iter().map(|c| (c - mean).powi(2)).sum::<f64>() / (n - 1.0) / n;
        // few maps may happen to agree better than counts can
        let counting = d.expected / (rays * n);
        let error = scatter.max(counting).sqrt();
        let z = (mean - d.expected) / error;
        println!(
            "{}: {:.3e}, expected {:.3e}, off {:+.1} %, {z:+.1} errors",
            d.name,
            mean,
            d.expected,
            100.0 * (mean / d.expected - 1.0)
        );
        assert!(z.abs() < tolerance::FACETS_TRACED.allowed, "{}: {z}", d.name);
        squares += z * z;
        let w = (d.expected / error).powi(2);
        off += w * (mean / d.expected - 1.0);
        weight += w;
    }
    let count = detectors.len() as f64;
    let (rms, mean) = ((squares / count).sqrt(), off / weight);
    println!("{count} detectors: rms {rms:.2} errors, mean deviation {:+.2} %", 100.0 * mean);
    assert!(count > 60.0 && rms < 1.7, "{count} {rms}");
    assert!(mean.abs() < tolerance::FACETS_TRACED_MEAN.allowed, "{mean}");
}
