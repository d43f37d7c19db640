//! Tables for microcontrollers against the models they are made of: readings, flux, samples, extremes.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, OnceLock};

use asperity::boundary::Boundary;
use asperity::embedded::EmbeddedTable;
use asperity::energy::balance;
use asperity::forward::Rays;
use asperity::kirchhoff::{
    MeanSpectra, Shadowing, Speckle, WaveBoundary, WaveOptions, Wavelengths,
};
use asperity::raytrace::{Field, TracedBoundary};
use asperity::surface::{Edges, HeightMap};
use asperity::tabulate::{Budget, distance, energy_error, tabulate};
use asperity::watch::Watch;
use asperity_core::bsdf::{Bsdf, LobeSet, Scatter};
use asperity_core::direction::Side;
use asperity_core::math::Fast;
use asperity_core::ndf::law::Profile;
use asperity_tests::chi2::{Bins, sidak};
use asperity_tests::{count, extensive, tolerance};

use crate::common::{Random, dir, ggx, incidence, ior, like_sample_5, normals, wide};

const RAYS: Rays = Rays { count: 1_000_000, seed: 5 };

fn table_of(boundary: &Boundary, bytes: usize) -> EmbeddedTable {
    table_of_rays(boundary, bytes, RAYS)
}

fn table_of_rays(boundary: &Boundary, bytes: usize, rays: Rays) -> EmbeddedTable {
    let plan = Budget { lobes: LobeSet::ALL, bytes, kept: None, rays };
    let table = tabulate(boundary, &plan, Watch::nobody()).unwrap();
    assert!(table.bytes() <= bytes, "{} bytes of {bytes}", table.bytes());
    table
}

/// The table of a closed form, which several tests look at: made once.
fn table_of_form(name: &str, boundary: &Boundary, bytes: usize) -> Arc<EmbeddedTable> {
    type Made = HashMap<(String, usize), Arc<OnceLock<Arc<EmbeddedTable>>>>;
    static MADE: LazyLock<Mutex<Made>> = LazyLock::new(Mutex::default);
    let place = MADE.lock().unwrap().entry((name.to_owned(), bytes)).or_default().clone();
    place.get_or_init(|| Arc::new(table_of(boundary, bytes))).clone()
}

fn closed_forms() -> Vec<(String, Boundary)> {
    let mut all = Vec::new();
    for a in [1e-3, 0.01, 0.2, 0.6, 2.0] {
        all.push((format!("ggx {a}"), Boundary::Ggx(ggx(a, 1.49))));
    }
    for (profile, delta, n) in
        [(Profile::Gauss, 0.12, 1.66), (Profile::Gauss, 0.17, 1.0), (Profile::Cauchy, 0.05, 2.5)]
    {
        let law = normals(profile, delta, n, 1.49);
        all.push((format!("normals {profile:?} {delta} {n}"), Boundary::Normals(Box::new(law))));
    }
    all
}

/// A rough surface without a preferred direction: a sum of waves that fit into the map.
fn traced(height: f64) -> Boundary {
    const SIDE: usize = 256;
    let mut random = Random::new(77);
    let waves: Vec<[f64; 3]> = (0..240)
        .map(|_| {
            let (k, a) = (random.between(4.0, 26.0), random.between(0.0, std::f64::consts::TAU));
            [
                (k * a.cos()).round(),
                (k * a.sin()).round(),
                random.between(0.0, std::f64::consts::TAU),
            ]
        })
        .collect();
    let at = |n: usize| {
        let (x, y) = ((n % SIDE) as f64 / SIDE as f64, (n / SIDE) as f64 / SIDE as f64);
        let wave = |[a, b, c]: &[f64; 3]| (std::f64::consts::TAU * (a * x + b * y) + c).sin();
        (height * waves.iter().map(wave).sum::<f64>()) as f32
    };
    let heights = (0..SIDE * SIDE).map(|n| at(n).into()).collect();
    let map = HeightMap::new((SIDE, SIDE), (1.0, 1.0), heights).unwrap();
    let field = Arc::new(Field::new(&map, Edges::Periodic).unwrap());
    Boundary::Traced(TracedBoundary { field, eta: ior(1.49) })
}

#[test]
fn tables_of_closed_forms_give_the_readings_and_the_flux_of_their_models() {
    for (name, boundary) in closed_forms() {
        for (bytes, allowed) in
            [(8 << 10, tolerance::TABLE_8_KIB), (32 << 10, tolerance::TABLE_32_KIB)]
        {
            let table = table_of_form(&name, &boundary, bytes);
            let distance = distance(&boundary, &table, 0.5, RAYS, Watch::nobody()).unwrap().percent;
            let energy = energy_error(&boundary, &table, RAYS, Watch::nobody()).unwrap();
            println!("{name}, {bytes} bytes: {distance:.4} %, flux {:.3} %", 100.0 * energy);
            assert!(distance <= allowed.allowed, "{name} {bytes}: {distance} %");
            let flux =
                if bytes == 8 << 10 { tolerance::TABLE_FLUX_8 } else { tolerance::TABLE_FLUX };
            assert!(energy <= flux.allowed, "{name} {bytes}: flux {energy}");
        }
    }
}

/// Slopes of 0.12 and 0.32: the light of the first meets one facet mostly, that of the other several. About the specular direction
/// the second shows the grain of its few thousand facets, which takes more rays to know.
#[test]
fn a_table_of_a_traced_map_gives_the_readings_and_the_flux_of_the_map() {
    let cases = [
        (0.03, 8 << 10, 1, tolerance::TABLE_8_KIB),
        (0.03, 32 << 10, 1, tolerance::TABLE_32_KIB),
        (0.08, 8 << 10, 1, tolerance::TABLE_8_KIB),
        (0.08, 32 << 10, 4, tolerance::TABLE_32_KIB),
    ];
    // one of each size, and of each roughness, unless there is time: it is 400 million rays for all
    let cases = if extensive() { &cases[..] } else { &cases[1..3] };
    let mut bad = Vec::new();
    for &(height, bytes, times, allowed) in cases {
        let rays = Rays { count: times * RAYS.count, ..RAYS };
        let boundary = traced(height);
        let table = table_of_rays(&boundary, bytes, rays);
        let found = distance(&boundary, &table, 0.5, rays, Watch::nobody()).unwrap();
        // what a table can hold; its few facets make the map itself another at each azimuth
        let distance = found.to_mean_percent;
        let energy =
            energy_error(&boundary, &table, Rays { count: 300_000, seed: 6 }, Watch::nobody())
                .unwrap();
        println!("{found:?}");
        println!("traced {height}, {bytes} bytes: {distance:.4} %, flux {:.3} %", 100.0 * energy);
        let small = bytes == 8 << 10;
        let flux = if small { tolerance::TABLE_FLUX_8 } else { tolerance::TABLE_FLUX };
        let fine = distance <= allowed.allowed && energy <= flux.allowed;
        if !fine {
            bad.push((height, bytes, distance, energy));
        }
    }
    assert!(bad.is_empty(), "{bad:?}");
}

/// A surface as rough as sample 5, whose light is all scattered, and a tenth of its heights, of whose light much stays coherent. Kirchhoff's integral
/// gives up to twice what it receives where light grazes the surface: there the table gives what it receives.
#[test]
fn a_table_of_waves_gives_the_readings_and_the_flux_of_the_mean_law() {
    let (map, edges) = (like_sample_5(), Edges::Periodic);
    let wavelengths = Wavelengths::single(550.0).unwrap();
    let options =
        WaveOptions { wavelengths, speckle: Speckle::Averaged, shadowing: Shadowing::Off };
    let spectra = Arc::new(MeanSpectra::new(&map, edges).unwrap());
    for scale in [1.0, 0.1] {
        let scaled = Arc::new(map.clone().map(|_, _, h| scale * h));
        let spectra = (Arc::clone(&spectra), scale);
        let wave = WaveBoundary::new(scaled, edges, spectra, ior(1.49), &options);
        let boundary = Boundary::Wave(Box::new(wave));
        let table = table_of(&boundary, 32 << 10);
        let distance = distance(&boundary, &table, 0.5, RAYS, Watch::nobody()).unwrap().percent;
        let energy = energy_error(&boundary, &table, RAYS, Watch::nobody()).unwrap();
        println!("waves, heights times {scale}: {distance:.4} %, flux {:.3} %", 100.0 * energy);
        assert!(distance <= tolerance::TABLE_32_KIB.allowed, "{scale}: {distance} %");
        assert!(energy <= tolerance::TABLE_FLUX.allowed, "{scale}: flux {energy}");
        let table = Boundary::Table(Box::new(table));
        for side in [Side::Air, Side::Dielectric] {
            for deg in [0.0, 30.0, 45.0, 60.0, 75.0, 80.0, 84.0, 87.0] {
                let [model, found] =
                    [&boundary, &table].map(|of| 1.0 - balance(of, side, deg, RAYS).lost);
                println!("  {side:?} {deg}: R + T {model:.4}, of the table {found:.4}");
                assert!(found <= 1.0 + tolerance::TABLE_GAIN.allowed, "{side:?} {deg}: {found}");
                let lowered = (found - model.min(1.0)).abs();
                assert!(lowered <= 2.0 * tolerance::TABLE_FLUX.allowed, "{side:?} {deg}: {found}");
            }
        }
    }
}

/// Flux of all light at dense incidences, by the samples' own weights.
#[test]
fn a_table_never_gives_more_than_it_receives() {
    let mut all = closed_forms();
    all.truncate(6);
    for (name, boundary) in all {
        let table = table_of_form(&name, &boundary, 8 << 10);
        let asperity::embedded::Values::U8(values) = table.values() else { panic!("8 bits") };
        let view = table.view(values).unwrap();
        for air in [true, false] {
            for k in 0..30 {
                let wi = dir(incidence(3.0 * f64::from(k) + 0.37, air));
                let n = 46_368_u32;
                let mut sum = 0.0;
                for k in 0..n {
                    let u = [
                        f64::from((u64::from(k) * 28_657 % u64::from(n)) as u32),
                        f64::from(k) + 0.5,
                    ]
                    .map(|u| u / f64::from(n));
                    for lobe in [
                        asperity_core::bsdf::Lobe::Reflection,
                        asperity_core::bsdf::Lobe::Transmission,
                    ] {
                        sum += view.sample_lobe(wi, lobe, u).map_or(0.0, |ray| ray.weight);
                    }
                }
                let flux = sum / f64::from(n);
                assert!(
                    flux <= 1.0 + tolerance::TABLE_GAIN.allowed,
                    "{name} air {air} {k}: {flux}"
                );
            }
        }
    }
}

#[test]
fn samples_of_a_table_follow_their_density_and_weigh_ars_over_pdf() {
    let mut fits = Vec::new();
    for (name, boundary) in
        closed_forms().into_iter().filter(|(n, _)| n == "ggx 0.2" || n.contains("1.66"))
    {
        let table = table_of_form(&name, &boundary, 8 << 10);
        for (deg, air) in [(50.0, true), (20.0, false)] {
            let wi = incidence(deg, air);
            let mut random = Random::new(fits.len() as u128);
            let mut sample = || table.sample(dir(wi), &mut || random.next());
            for _ in 0..300 {
                let Some(s) = sample() else { continue };
                let (ars, pdf) = (table.ars(dir(wi), s.wo), table.pdf(dir(wi), s.wo));
                if pdf > 1e-7 {
                    let error = (ars / pdf - s.weight).abs() / s.weight.max(1e-3);
                    assert!(error < 1e-3, "{name} {deg} {air}: {s:?} {ars} {pdf} {error:e}");
                }
            }
            let pilot: Vec<_> =
                (0..100_000).filter_map(|_| sample()).map(|s| wide(s.wo)).take(10_000).collect();
            let bins = Bins::new(&pilot, 80);
            let integrals = bins.integrals(&|o| table.pdf(dir(wi), dir(o)), 2e-5);
            let fit = bins.test(&integrals, count(20_000), || sample().map(|s| wide(s.wo)));
            fits.push((format!("{name} {deg} deg air {air}"), fit));
        }
    }
    let each = sidak(tolerance::SIGNIFICANCE.allowed, fits.len());
    for (case, f) in &fits {
        assert!(f.freedom >= 15 && f.p > each, "{case}: {f:?}");
    }
}

#[test]
fn a_table_of_a_reciprocal_law_is_nearly_reciprocal() {
    let boundary = Boundary::Ggx(ggx(0.3, 1.49));
    let table = table_of(&boundary, 32 << 10);
    let (mut sum, mut all) = (0.0, 0.0);
    let mut random = Random::new(3);
    for _ in 0..4000 {
        let (deg, air) = (random.between(1.0, 70.0), random.next::<f64>() < 0.5);
        let wi = dir(incidence(deg, air));
        let Some(s) = table.sample(wi, &mut || random.next()) else { continue };
        let index2 = |z: f64| if z > 0.0 { 1.0 } else { 1.49 * 1.49 };
        let a = table.eval(wi, s.wo) / index2(s.wo.z());
        let b = table.eval(s.wo, wi) / index2(wi.z());
        sum += (a - b).abs();
        all += 0.5 * (a + b);
    }
    println!("reciprocity: mean difference {:.4} of the mean", sum / all);
    assert!(sum / all < tolerance::TABLE_RECIPROCITY.allowed, "{}", sum / all);
}

#[test]
fn single_precision_and_extremes_are_finite() {
    for (name, boundary) in closed_forms() {
        let table = table_of_form(&name, &boundary, 8 << 10);
        let asperity::embedded::Values::U8(values) = table.values() else { panic!("8 bits") };
        let view = table.view(values).unwrap();
        let mut random = Random::new(4);
        for k in 0..4000 {
            let (mut i, o) = (random.direction(), random.direction());
            match k % 8 {
                0 => i[2] = 0.0,
                1 => i[0] = f64::NAN,
                2 => i[2] = 1e-30,
                3 => i = [0.0, 0.0, if k % 16 < 8 { 1.0 } else { -1.0 }],
                _ => (),
            }
            let (wi, wo) = (dir::<Fast<f32>>(i), dir::<Fast<f32>>(o));
            for x in [view.eval(wi, wo), view.ars(wi, wo), view.pdf(wi, wo)] {
                assert!(x.0.is_finite() && x.0 >= 0.0, "{name} {i:?} {o:?}: {x:?}");
            }
            if let Some(s) = view.sample(wi, &mut || random.next()) {
                assert!(s.weight.0.is_finite() && s.weight.0 >= 0.0, "{name} {i:?}: {s:?}");
            }
            let (f, exact) = (f64::from(view.ars(wi, wo).0), table.ars(dir(i), dir(o)));
            let error = (f - exact).abs() / exact.max(1e-3);
            assert!(error < 2e-2 || k % 8 < 4, "{name} {i:?} {o:?}: {f} {exact}");
        }
    }
}

#[test]
fn a_table_file_comes_back_as_it_was_and_damage_is_refused() {
    use asperity::embedded::{read, write};
    use asperity::output::AtomicFile;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.bsdft");
    let table = table_of_form("ggx 0.2", &Boundary::Ggx(ggx(0.2, 1.49)), 8 << 10);
    write(AtomicFile::create(&path).unwrap(), &table, "ggx", Some(0.1)).unwrap();
    let (again, record) = read(&path).unwrap();
    assert_eq!((&again, &*record.method), (&*table, "ggx"));
    let bytes = std::fs::read(&path).unwrap();
    let refused = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        read(&path).unwrap_err().to_string()
    };
    assert!(refused(&bytes[..bytes.len() - 1]).contains("cut or damaged"));
    assert!(refused(b"{}").contains("is no table") && refused(b"").contains("is no table"));
    let huge = String::from_utf8_lossy(&bytes[..bytes.iter().position(|b| *b == b'\n').unwrap()])
        .replacen("\"radii\":", "\"radii\":6", 1);
    assert!(!refused(format!("{huge}\n").as_bytes()).is_empty());
}
