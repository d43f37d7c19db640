//! What single precision and the fast tier lose: every evaluator against double precision on the same numbers.
//!
//! The law is a function of the six components as they are given, rounded to single precision and therefore not
//! quite unit vectors: both precisions take the same ones, so that the conditioning of the input is no excuse. What is
//! drawn is where the value matters and where formulas cancel: the lobe at all scales of its width, facets seen at
//! grazing incidence and at the critical angle, the plane of incidence, indices near 1.

use std::fmt::Write as _;

use asperity_tests::oracle::{Vec3, combine, cross, dot, spherical, unit};
use asperity_tests::{count, tolerance};
use rayon::prelude::*;

use crate::common::Random;
use crate::tiers::{Subject, closed_form, normals, single};

/// Directions of one incidence.
const BATCH: usize = 64;
/// `cos 89.9 deg`.
const GRAZING: f64 = 1.745_328_4e-3;
/// Single and fast single against double; fast double against double.
const TIERS: [&str; 3] = ["f32", "fast f32", "fast f64"];

/// Where light comes from: near the normal, oblique, grazing, at the critical angle; either side; a third in the
/// plane x-z.
fn incidence(random: &mut Random, subject: &Subject) -> Vec3 {
    let critical = subject.index.min(1.0 / subject.index);
    let theta = match random.next::<f64>() {
        x if x < 0.05 => 0.0,
        x if x < 0.25 => random.log(1e-4, 0.3),
        x if x < 0.5 => random.between(0.3, 1.4),
        x if x < 0.85 => std::f64::consts::FRAC_PI_2 - random.log(1.75e-3, 0.175),
        _ => critical.asin() + random.between(-1.0, 1.0) * random.log(1e-5, 0.1),
    };
    let phi = random.between(0.0, std::f64::consts::TAU);
    let phi = if random.next::<f64>() < 0.33 { 0.0 } else { phi };
    let up = random.next::<f64>() < 0.5 || subject.name == "opaque";
    let [x, y, z] = spherical(theta.min(1.569_05), phi);
    [x, y, if up { z } else { -z }].map(single)
}

/// A facet: in the lobe at all scales; or one that `wi` meets at a special angle.
fn facet(random: &mut Random, subject: &Subject, wi: Vec3) -> Vec3 {
    let special = random.next::<f64>();
    if special < 0.6 {
        let offset = subject.width * random.log(1e-3, 1e3);
        let sign = if random.next::<f64>() < 0.5 { -1.0 } else { 1.0 };
        let edge = if random.next::<f64>() < 0.3 { subject.width } else { 0.0 };
        let theta = (subject.centre + edge + sign * offset).abs();
        let phi = random.between(0.0, std::f64::consts::TAU);
        return spherical(theta.atan(), if random.next::<f64>() < 0.3 { 0.0 } else { phi });
    }
    let towards = if wi[2] > 0.0 { wi } else { wi.map(|x| -x) };
    let critical = (1.0 - subject.index.min(1.0 / subject.index).powi(2)).max(0.0).sqrt();
    let cos = if special < 0.8 {
        random.log(1e-5, 0.3)
    } else {
        (critical + random.between(-1.0, 1.0) * random.log(1e-8, 0.1)).clamp(1e-6, 1.0)
    };
    // the facet of that cosine nearest to the mean normal, turned about wi a little or by any angle
    let rise = combine(1.0, [0.0, 0.0, 1.0], -towards[2], towards);
    let rise = if dot(rise, rise) > 1e-12 { unit(rise) } else { [1.0, 0.0, 0.0] };
    let (s, c) = (random.between(-1.0, 1.0) * random.log(1e-4, 3.0)).sin_cos();
    let tangent = combine(c, rise, s, cross(towards, rise));
    combine(cos, towards, (1.0 - cos * cos).sqrt(), tangent)
}

/// Where a facet sends light, in either lobe; or any direction.
fn observation(random: &mut Random, subject: &Subject, wi: Vec3) -> Option<Vec3> {
    let which = random.next::<f64>();
    if which < 0.1 {
        return Some(random.direction().map(single));
    }
    let m = facet(random, subject, wi);
    let c = dot(wi, m);
    let wo = if which < 0.5 || subject.name == "opaque" {
        combine(2.0 * c, m, -1.0, wi)
    } else {
        let n = if wi[2] > 0.0 { subject.index } else { 1.0 / subject.index };
        let g2 = n * n - 1.0 + c * c;
        if g2 < 0.0 {
            return None;
        }
        combine((c - g2.sqrt().copysign(c)) / n, m, -1.0 / n, wi)
    };
    Some(unit(wo).map(single))
}

const REGIONS: [&str; 3] = ["peak", "flank", "tail"];
const ANGLES: [&str; 3] = ["normal", "oblique", "grazing"];

/// The worst of a row: pairs, then errors of the tiers in `eval`, `ars`, `pdf`, and of the weights, with where.
#[derive(Clone, Default)]
struct Row {
    pairs: usize,
    worst: [[f64; 4]; 3],
    place: [String; 3],
}

impl Row {
    fn most(&self, tier: usize) -> f64 {
        self.worst[tier].iter().fold(0.0, |a, &b| a.max(b))
    }
    fn take(&mut self, tier: usize, what: usize, error: f64, place: impl FnOnce() -> String) {
        if error > self.most(tier) {
            self.place[tier] = place();
        }
        self.worst[tier][what] = self.worst[tier][what].max(error);
    }
    fn merge(&mut self, other: &Self) {
        self.pairs += other.pairs;
        for tier in 0..3 {
            for what in 0..4 {
                let error = other.worst[tier][what];
                self.take(tier, what, error, || other.place[tier].clone());
            }
        }
    }
}

/// Rows by a label that sorts; every pair counts in several.
type Table = std::collections::BTreeMap<String, Row>;

/// The rows a pair belongs to.
fn labels(subject: &Subject, wi: Vec3, wo: Vec3) -> [String; 2] {
    let lobe = if wi[2] * wo[2] > 0.0 { "reflection" } else { "transmission" };
    let side = if wi[2] > 0.0 { "air" } else { "dielectric" };
    let (a, b) = if wi[2] > 0.0 { (wi, wo) } else { (wo, wi) };
    let h = combine(1.0, a, if lobe == "reflection" { 1.0 } else { subject.index }, b);
    let theta = h[0].hypot(h[1]).atan2(h[2].abs());
    let far = (theta - subject.centre).abs() / subject.width;
    let region = REGIONS[usize::from(far > 0.3) + usize::from(far > 3.0)];
    let steep = wi[2].abs().min(wo[2].abs());
    let angle = ANGLES[usize::from(steep < 0.94) + usize::from(steep < 0.173_65)];
    let (name, decade) = (subject.name, (subject.width.log10() + 3.0).clamp(0.0, 3.0) as usize);
    let decade = ["1e-3", "1e-2", "0.1", "1"][decade];
    [
        format!("{name:8} {lobe:12} {side:10} {angle:8} {region:5}"),
        format!("{name:8} {lobe:12} width {decade} and above"),
    ]
}

/// One incidence on one evaluator.
fn batch(subject: &Subject, random: &mut Random, table: &mut Table) {
    let wi = incidence(random, subject);
    let all: Vec<Vec3> = (0..BATCH)
        .filter_map(|_| observation(random, subject, wi))
        .filter(|wo| wo[2].abs() > GRAZING && (wo[2] > 0.0 || subject.name != "opaque"))
        .collect();
    let want: Vec<[f64; 3]> = all.iter().map(|&wo| subject.double.values(wi, wo)).collect();
    // the peak of a lobe: what "where the value matters" is measured by
    let mut peak = [[0.0_f64; 3]; 2];
    for (wo, values) in all.iter().zip(&want) {
        let of_lobe = &mut peak[usize::from(wi[2] * wo[2] > 0.0)];
        for what in 0..3 {
            of_lobe[what] = of_lobe[what].max(values[what]);
        }
    }
    // a lobe that no facet sends light to has no peak
    let both: [f64; 3] = [0, 1, 2].map(|what| peak[0][what].max(peak[1][what]));
    for (&wo, want) in all.iter().zip(&want) {
        let of_lobe = peak[usize::from(wi[2] * wo[2] > 0.0)];
        let peak = [0, 1, 2].map(|what| of_lobe[what].max(1e-4 * both[what]).max(1e-24));
        let rows = labels(subject, wi, wo);
        let got = subject.tiers.each_ref().map(|tier| tier.values(wi, wo));
        for label in rows {
            let row = table.entry(label).or_default();
            row.pairs += 1;
            for (tier, got) in got.iter().enumerate() {
                for what in 0..3 {
                    let floor = tolerance::MATTERS.allowed * peak[what];
                    // below the floor only that it stays there
                    let both = want[what].max(got[what]);
                    if both > floor && both > 0.0 {
                        let error = (got[what] - want[what]).abs() / want[what].max(floor);
                        row.take(tier, what, error, || {
                            format!("{} {wi:?} {wo:?} {} {}", subject.text, want[what], got[what])
                        });
                    }
                }
            }
        }
    }
    let u = [(); 4].map(|()| f64::from(random.next::<f32>()));
    for (tier, law) in subject.tiers.iter().enumerate() {
        let Some((wo, weight)) = law.sample(wi, u) else { continue };
        let [_, ars, pdf] = subject.double.values(wi, wo);
        if wo[2].abs() > GRAZING && pdf > 0.0 {
            let row = table.entry(labels(subject, wi, wo)[0].clone()).or_default();
            row.take(tier, 3, (weight * pdf / ars - 1.0).abs(), || {
                format!("{} {wi:?} {wo:?} weight", subject.text)
            });
        }
    }
}

/// Many incidences, whatever the number of threads in the same order.
fn survey(subjects: usize, batches: usize, make: fn(&mut Random) -> Subject) -> Table {
    let tables: Vec<Table> = (0..subjects)
        .into_par_iter()
        .map(|k| {
            let mut random = Random::new(0x9e37 + 7919 * k as u128);
            let (subject, mut table) = (make(&mut random), Table::new());
            (0..batches).for_each(|_| batch(&subject, &mut random, &mut table));
            table
        })
        .collect();
    let mut all = Table::new();
    for (label, row) in tables.iter().flatten() {
        all.entry(label.clone()).or_default().merge(row);
    }
    all
}

fn show(table: &Table) {
    println!(
        "worst relative error above 1e-6 of the peak: f32 | fast f32 | fast f64 (eval ars pdf weight)"
    );
    for (label, row) in table {
        let mut line = format!("  {label:52} {:9}", row.pairs);
        for errors in row.worst {
            let _ = write!(line, " |");
            for error in errors {
                let _ = write!(line, " {error:7.1e}");
            }
        }
        println!("{line}");
    }
    for (tier, name) in TIERS.iter().enumerate() {
        let most = table.values().max_by(|a, b| a.most(tier).total_cmp(&b.most(tier)));
        if let Some(r) = most {
            println!("  worst {name}: {:.2e} {}", r.most(tier), r.place[tier]);
        }
    }
}

fn check(table: &Table) {
    show(table);
    let limits = [tolerance::PRECISION, tolerance::PRECISION, tolerance::PRECISION_F64];
    for (label, row) in table {
        for (tier, limit) in limits.iter().enumerate() {
            let (worst, name) = (row.most(tier), TIERS[tier]);
            assert!(worst <= limit.allowed, "{label} {name}: {worst:e} {}", row.place[tier]);
        }
    }
}

#[test]
fn single_precision_keeps_ggx_where_it_matters() {
    check(&survey(count(1000), 12, closed_form));
}

#[test]
fn single_precision_keeps_normals_where_it_matters() {
    check(&survey(count(300), 24, normals));
}
