//! Scans of height maps that scatter waves: a smooth plate, a scan made by direct sums, and fits of the virtual
//! samples that a ray tracer made.

use std::f64::consts::TAU;

use asperity::boundary::Boundary;
use asperity::fit::{Fit, FitOptions, FitRays, cost_at};
use asperity::forward::{Angles, Effort, Sample, Setup, wave};
use asperity::kirchhoff::{Shadowing, Speckle, WaveBoundary, WaveOptions, Wavelengths};
use asperity::measurement::{Measurement, Metadata, Quantity, Reading};
use asperity::method::{Body, Choice, Method};
use asperity::surface::{Crop, Edges, Form, GaussianSurface, HeightMap, Prepared};
use asperity::watch::Watch;
use asperity_core::direction::Direction;
use asperity_core::gonio::{Geometry, incidence};
use asperity_core::plate::RoughSide;
use asperity_tests::extensive;
use asperity_tests::kirchhoff::{intensity, obliquity};
use asperity_tests::oracle::fresnel;
use asperity_tests::tolerance::{DIRECT_SUM_SCAN, SCALE_OF_MAP};

use crate::common::{fitted, least, options};
use crate::traced_samples::sample;

const IOR: f64 = 1.49;
const CLEAR: Body = Body::Dielectric { ior: IOR };
const WAVELENGTH_UM: f64 = 0.55;

fn light(speckle: Speckle) -> WaveOptions {
    let wavelengths = Wavelengths::single(1000.0 * WAVELENGTH_UM).unwrap();
    WaveOptions { wavelengths, speckle, shadowing: Shadowing::Off }
}

fn setup(rough_side: RoughSide, geometry: Geometry) -> Setup {
    let sample = Sample::Plate { eta: CLEAR.eta().unwrap(), rough_side };
    Setup { sample, geometry, aperture_deg: 0.6, slit_height_deg: None, quantity: Quantity::Flux }
}

fn readings(boundary: &WaveBoundary, setup: &Setup, plan: &Angles) -> Vec<f64> {
    wave(boundary, setup, plan, Effort::Full, Watch::nobody()).unwrap().values
}

#[test]
fn a_flat_map_is_a_smooth_plate() {
    let flat = HeightMap::new((24, 20), (0.5, 0.5), vec![3.0; 480]).unwrap();
    for speckle in [Speckle::Averaged, Speckle::Kept] {
        let eta = CLEAR.eta().unwrap();
        let boundary = WaveBoundary::of_map(&flat, Edges::Mirrored, eta, &light(speckle)).unwrap();
        for rough_side in [RoughSide::Source, RoughSide::Detector] {
            for geometry in [Geometry::Transmission, Geometry::Reflection] {
                for sigma in [0.0, 30.0, 60.0, 80.0] {
                    let plan = Angles::product(&[sigma], &[sigma - 0.4, sigma, sigma + 0.2]);
                    let found = readings(&boundary, &setup(rough_side, geometry), &plan);
                    let r = fresnel(sigma.to_radians().cos(), IOR).unpolarised();
                    // the series of all reflections between the faces
                    let exact = match geometry {
                        Geometry::Transmission => (1.0 - r) / (1.0 + r),
                        Geometry::Reflection => 2.0 * r / (1.0 + r),
                    };
                    assert!(found[0] < 1e-12, "{found:?}");
                    for value in &found[1..] {
                        assert!(
                            (value - exact).abs() < 3e-6,
                            "{speckle:?} {rough_side:?} {geometry:?} {sigma}: {value} {exact}"
                        );
                    }
                }
            }
        }
    }
}

/// What a detector of a full angle of 0.6 degrees reads of the orders of a mirrored map, transmitted through a plate whose
/// rough face looks to the source; every order by a sum over all points, internal passes left out.
fn direct_sum_scan(map: &HeightMap, sigmas_deg: &[f64], thetas_deg: &[f64]) -> Vec<Reading> {
    let half = 0.3_f64.to_radians();
    let k = TAU / WAVELENGTH_UM;
    let [lx, ly] =
        [(map.nx(), map.dx_um()), (map.ny(), map.dy_um())].map(|(n, d)| 2.0 * n as f64 * d);
    let [sx, sy] = [lx, ly].map(|l| WAVELENGTH_UM / l);
    let mut readings = Vec::new();
    for &sigma_deg in sigmas_deg {
        let wi = incidence(sigma_deg.to_radians());
        let mut values = vec![0.0; thetas_deg.len()];
        // tangential part of the light outside is that of the beam plus a multiple of wavelength over period
        let rows = (half.sin() / sy).ceil() as i32;
        let columns = map.nx() as i32;
        for m in 1 - columns..columns {
            for n in -rows..=rows {
                let (x, y) = (-wi.x() + f64::from(m) * sx, f64::from(n) * sy);
                let cos2 = 1.0 - x * x - y * y;
                if cos2 <= 0.0 || y.abs() > half.sin() {
                    continue;
                }
                let (xi, yi) = (x / IOR, y / IOR);
                let wo = Direction::from_unit(xi, yi, -(1.0 - xi * xi - yi * yi).sqrt());
                let a2 = intensity(map, Edges::Mirrored, IOR, WAVELENGTH_UM, (wi, wo));
                let through = fresnel(cos2.sqrt(), IOR).through();
                let flux = a2 * obliquity(IOR, wi, wo) / wo.z().abs() * through;
                for (value, theta) in values.iter_mut().zip(thetas_deg) {
                    let (s, c) = theta.to_radians().sin_cos();
                    if x * s + cos2.sqrt() * c >= half.cos() {
                        *value += flux;
                    }
                }
            }
        }
        let reading =
            |(theta_deg, value): (&f64, f64)| Reading::in_plane(sigma_deg, *theta_deg, value);
        readings.extend(thetas_deg.iter().zip(values).map(reading));
    }
    assert!((k * lx) > 0.0);
    readings
}

/// A part of a Gaussian surface whose rms height, correlation length and pitch are those of the measured `al3d-1.al3d`.
fn like_a_measured_one(side: usize) -> HeightMap {
    let surface = GaussianSurface {
        size: (256, 256),
        pitches_um: (0.438, 0.438),
        rq_um: 0.27,
        lengths_um: (6.6, 6.6),
        seed: 4,
    };
    let crop = Crop::new(20..20 + side, 30..30 + side).unwrap();
    Form::Plane.removed(&crop.of(&surface.map().unwrap()).unwrap())
}

#[test]
fn a_scan_made_by_direct_sums_is_known_as_that_of_the_map() {
    let side = if extensive() { 128 } else { 64 };
    let map = like_a_measured_one(side);
    assert_eq!(Edges::of(&map), Edges::Mirrored);
    let thetas: Vec<f64> = (0..901).map(|n| -90.0 + 0.2 * f64::from(n)).collect();
    let readings = direct_sum_scan(&map, &[0.0, 30.0, 60.0], &thetas);
    let meta = Metadata { ior: Some(IOR), aperture_deg: Some(0.6), ..Metadata::default() };
    let scan = Measurement::new(meta, readings).unwrap();
    let setup = setup(RoughSide::Source, Geometry::Transmission);
    let of = |name, speckle: Option<Speckle>| {
        let wave = speckle.map(light);
        let choice = Choice {
            map: Some((&map, Edges::Mirrored)),
            wave: wave.as_ref(),
            ..Choice::new(name, CLEAR)
        };
        let fit = fitted(&*choice.method().unwrap(), &scan, &setup, &options(CLEAR)).unwrap();
        println!("{name} {speckle:?}: {:.3} %, {:?}", fit.rmsd_percent, fit.parameters);
        fit
    };
    let kept = of("measured-wave", Some(Speckle::Kept));
    assert!(kept.rmsd_percent < DIRECT_SUM_SCAN.allowed, "{}", kept.rmsd_percent);
    assert!((kept.parameters[0].value - 1.0).abs() < SCALE_OF_MAP.allowed);
    let averaged = of("measured-wave", Some(Speckle::Averaged));
    // heights of half a wave: rays and waves together are waves
    let wave = light(Speckle::Averaged);
    let choice = Choice {
        map: Some((&map, Edges::Mirrored)),
        wave: Some(&wave),
        ..Choice::new("measured-hybrid", CLEAR)
    };
    let rays = FitRays { draft: 10_000, fit: Some(50_000), last: Some(200_000), seed: 3 };
    let options_of_rays = FitOptions { rays, ..options(CLEAR) };
    let hybrid = choice.method().unwrap();
    let (errors, at) = least(&*hybrid, &scan, &setup, &options_of_rays, 1.0);
    println!("measured-hybrid: errors {errors:.3?} %, least at {at:.4} of the heights");
    assert!((at - averaged.parameters[0].value).abs() < SCALE_OF_MAP.allowed, "{at}");
    assert!(errors[1] < errors[0].min(errors[2]), "{errors:?}");
    let traced = of("measured-ray", None);
    assert!(traced.rmsd_percent > 2.0 * kept.rmsd_percent.max(DIRECT_SUM_SCAN.allowed));
    assert!(averaged.rmsd_percent < traced.rmsd_percent);
}

fn wave_fit(number: u32, pixel_um: f64) -> Option<(Measurement, Prepared, Fit, f64)> {
    let (scan, prepared) = sample(number, pixel_um)?;
    let options = options(CLEAR);
    let setup = setup(RoughSide::Source, Geometry::Transmission);
    let method = |speckle| -> Box<dyn Method> {
        let wave = light(speckle);
        let choice = Choice {
            map: Some((&prepared.map, prepared.edges)),
            wave: Some(&wave),
            ..Choice::new("measured-wave", CLEAR)
        };
        choice.method().unwrap()
    };
    let fit = fitted(&*method(Speckle::Averaged), &scan, &setup, &options).unwrap();
    let values: Vec<f64> = fit.parameters.iter().map(|p| p.value).collect();
    // the ray tracer's scan does not show the speckle of the map
    let kept = cost_at(&*method(Speckle::Kept), &scan, &setup, &options, &values, Watch::nobody())
        .unwrap();
    println!("sample {number}: {:.3} %, speckle kept {kept:.3} %", fit.rmsd_percent);
    Some((scan, prepared, fit, kept))
}

#[test]
fn waves_describe_sample_5_better_than_ggx() {
    let Some((_, _, fit, kept)) = wave_fit(5, 0.361) else { return };
    assert!(fit.rmsd_percent < 1.53 && kept > 1.2 * fit.rmsd_percent, "{}", fit.rmsd_percent);
    assert!((fit.parameters[0].value - 1.0).abs() < SCALE_OF_MAP.allowed);
}

#[test]
fn on_sample_8_waves_fail_and_say_so() {
    let Some((_, prepared, fit, _)) = wave_fit(8, 1.42) else { return };
    assert!(fit.rmsd_percent > 10.0 && fit.refusal(15.0).is_some(), "{}", fit.rmsd_percent);
    let eta = CLEAR.eta().unwrap();
    let wave = WaveBoundary::of_map(&prepared.map, prepared.edges, eta, &light(Speckle::Averaged))
        .unwrap();
    let warnings = Boundary::Wave(Box::new(wave)).warnings(&[0.0, 30.0, 60.0]).join("\n");
    for word in ["horizon", "beyond the critical", "pixel", "phase"] {
        assert!(warnings.contains(word), "{word}: {warnings}");
    }
}
