//! Maps that alone are lit, where `q_z` goes to zero and elsewhere; and surfaces whose number of rows says nothing.

use asperity::kirchhoff::{Beam, BeamOrders, Tiling, orders};
use asperity::surface::{Crop, Edges, Fill, Form, HeightMap, Preparation, Purpose};
use asperity::watch::Watch;
use asperity_core::bsdf::Lobe;
use asperity_tests::kirchhoff::{intensity, lit_order, obliquity};
use asperity_tests::oracle::fresnel;
use asperity_tests::{data, tolerance};

use super::surfaces::{ETA, Gaussian, LOBES, WAVELENGTH_UM, all, beam, boundary};
use crate::common::ior;

fn lit(map: &HeightMap, beams: &[Beam]) -> Vec<BeamOrders> {
    orders(map, Tiling::Patch, ior(ETA), beams, Watch::nobody()).unwrap().unwrap()
}

fn both_sides(angles: &[f64]) -> Vec<Beam> {
    let sides = [true, false].into_iter();
    let pairs = sides.flat_map(|air| angles.iter().map(move |deg| (*deg, air)));
    pairs.flat_map(|(deg, air)| LOBES.map(|lobe| beam(deg, air, lobe))).collect()
}

/// Waves that do not fit into the map: height and slope.
fn waves(x: f64, y: f64) -> (f64, [f64; 2]) {
    let all = [[0.07, 1.3, 0.4, 0.3], [0.05, -0.7, 1.9, 1.1], [0.03, 2.6, -1.5, 2.0]];
    let (mut height, mut slope) = (0.0, [0.0; 2]);
    for [amplitude, along, across, phase] in all {
        let (s, c) = (along * x + across * y + phase).sin_cos();
        height += amplitude * s;
        slope = [slope[0] + amplitude * along * c, slope[1] + amplitude * across * c];
    }
    (height, slope)
}

#[test]
fn orders_of_a_patch_are_sums_over_tangent_planes() {
    let (nx, ny, pitch) = (96, 80, 0.04);
    let place = |k: usize| pitch * k as f64;
    let heights = (0..nx * ny).map(|k| waves(place(k % nx), place(k / nx)).0).collect();
    let map = HeightMap::new((nx, ny), (pitch, pitch), heights).unwrap();
    let edge = |column: usize| -> f64 {
        (0..ny).map(|row| waves(place(column), place(row)).0).sum::<f64>() / ny as f64
    };
    let slope = (edge(nx - 1) - edge(0)) / (nx as f64 * pitch);
    for found in lit(&map, &both_sides(&[0.0, 45.0, 70.0])) {
        let Beam { wi, lobe, .. } = *found.beam();
        let beyond = if wi.z() > 0.0 { ETA } else { 1.0 / ETA };
        let r = fresnel(wi.z().abs(), beyond).unpolarised();
        let specular = if lobe == Lobe::Reflection { r } else { 1.0 - r };
        let incident = 1.0 - slope * wi.x() / wi.z();
        // squares of differences and of values: of all orders and of those of little q_z
        let (mut off, mut size, mut count) = ([[0.0; 2]; 2], [[0.0; 2]; 2], 0);
        for order in found.iter().filter(|o| o.number[1].abs() <= 3) {
            let factor = obliquity(ETA, wi, order.wo);
            if factor <= 0.0 {
                continue;
            }
            let exact = lit_order(&map, |x, y| waves(x, y).1, ETA, WAVELENGTH_UM, (wi, order.wo));
            let facet = (factor / order.wo.z().abs()).sqrt();
            let square = |a: [f64; 2]| a[0] * a[0] + a[1] * a[1];
            let share = specular.sqrt() - facet * exact.upright;
            let whole = [0, 1].map(|k| exact.amplitude[k] * facet + exact.kept[k] * share);
            let wanted = [square(exact.amplitude) * 0.25, square(whole) * 0.25 / incident];
            // near the horizon power is a mean over a cell, which is wide here
            let values = [(order.intensity, true), (order.power, order.wo.z().abs() > 0.7)];
            // reflected light always has a q_z of its own
            let little = lobe == Lobe::Transmission && exact.upright < 0.1;
            for (k, (value, meant)) in values.into_iter().enumerate().filter(|(_, v)| v.1) {
                assert!(meant && value.is_finite());
                for kind in [0, 1].into_iter().filter(|kind| *kind == 0 || little) {
                    off[kind][k] += (value - wanted[k]).powi(2);
                    size[kind][k] += wanted[k].powi(2);
                }
            }
            count += 1;
        }
        let relative = [0, 1].map(|kind| {
            [0, 1].map(|k| {
                if size[kind][k] > 0.0 { (off[kind][k] / size[kind][k]).sqrt() } else { 0.0 }
            })
        });
        println!("{:.3} {lobe:?}: {count} orders, rms {relative:.4?}", wi.z());
        if count > 20 {
            for (errors, limit) in
                relative.iter().zip([tolerance::LIT_ORDERS, tolerance::LIT_LITTLE_Q_Z])
            {
                let worst = errors[0].max(errors[1]);
                assert!(worst < limit.allowed, "{wi:?} {lobe:?} {relative:?}");
            }
        }
    }
}

#[test]
fn a_flat_patch_keeps_fresnels_flux() {
    let map = HeightMap::new((160, 120), (0.5, 0.6), vec![1.0; 160 * 120]).unwrap();
    for found in lit(&map, &both_sides(&[0.0, 30.0, 50.0, 75.0])) {
        let Beam { wi, lobe, .. } = *found.beam();
        let beyond = if wi.z() > 0.0 { ETA } else { 1.0 / ETA };
        let r = fresnel(wi.z().abs(), beyond).unpolarised();
        let exact = if lobe == Lobe::Reflection { r } else { 1.0 - r };
        let (flux, coherent) = found.totals();
        println!("{:.3} {lobe:?}: {flux:.5}, {coherent:.5} of {exact:.5}", wi.z());
        // what is diffracted beyond the horizon is lost
        let grazes = wi.z().abs() < 0.3;
        let lost = if grazes { tolerance::LIT_GRAZING } else { tolerance::LIT_FLAT };
        let off = exact - flux;
        assert!(off > -1e-4 && off < lost.allowed, "{wi:?} {lobe:?} {flux} {exact}");
        assert!((coherent - exact).abs() < tolerance::FLAT_WAVE.allowed, "{coherent} {exact}");
    }
}

/// Sums of both lobes of a patch beside those of the mean law, an integral that knows no single orders.
fn balance(name: &str, map: &HeightMap, edges: Edges, angles: &[f64]) {
    let beams = both_sides(angles);
    let law = boundary(map, edges);
    for (both, beam) in lit(map, &beams).chunks(2).zip(beams.chunks(2)) {
        let wi = beam[0].wi;
        let found: f64 = both.iter().map(|o| o.totals().0).sum();
        let coherent = law.coherent(wi);
        let diffuse: f64 = LOBES.map(|lobe| law.diffuse_flux(wi, lobe)).iter().sum();
        let mean = coherent.reflected + coherent.transmitted + diffuse;
        println!("{name} {:.3}: R + T {found:.4}, mean law {mean:.4}", wi.z());
        let off = (found - mean).abs();
        assert!(off < tolerance::LIT_ENERGY.allowed, "{name} {wi:?} {found} {mean}");
        assert!(found < 1.0 + tolerance::WAVE_ENERGY.allowed, "{name} {wi:?} {found}");
    }
}

#[test]
fn a_patch_scatters_as_much_light_as_falls_on_it() {
    let map = &Gaussian { sigma_um: 0.25, length_um: 7.0 }.maps(160, 0.44, 1, 21)[0];
    balance("Gaussian", map, Edges::Periodic, &[0.0, 45.0, 60.0, 75.0]);
    // a part of it has a rim that does not meet itself
    let part = Crop::new(10..130, 30..150).unwrap().of(map).unwrap();
    let part = Form::Plane.removed(&part);
    assert_eq!(Edges::of(&part), Edges::Mirrored);
    balance("part", &part, Edges::Mirrored, &[0.0, 30.0, 60.0]);
}

#[test]
fn a_measured_patch_scatters_as_much_light_as_falls_on_it() {
    let files =
        [("al3d-1.al3d", &[0.0, 15.0, 30.0, 45.0, 60.0, 75.0][..]), ("opd-1.opd", &[45.0, 75.0])];
    for (name, angles) in files {
        let path = format!("topography/SurfaceTopography/{name}");
        let Some(path) = data::find(&path) else { return };
        let filled = Preparation { fill: Some(Fill::Harmonic), ..Preparation::default() };
        let map = filled.load(&path, Purpose::Light).unwrap().map;
        balance(name, &map, Edges::Mirrored, angles);
    }
}

/// A corrugated surface, `rows` times the same line.
fn corrugated(rows: usize) -> HeightMap {
    let line: Vec<f64> = (0..128)
        .map(|k| {
            let x = std::f64::consts::TAU * f64::from(k) / 128.0;
            0.25 * (3.0 * x).sin() + 0.2 * (7.0 * x + 1.0).sin() + 0.1 * (11.0 * x + 2.0).sin()
        })
        .collect();
    let heights = line.repeat(rows);
    HeightMap::new((128, rows), (0.25, 0.25), heights).unwrap()
}

#[test]
fn a_corrugated_surface_does_not_know_its_rows() {
    for edges in [Edges::Periodic, Edges::Mirrored] {
        let beams = both_sides(&[0.0, 40.0, 70.0]);
        let of = |rows| -> Vec<f64> {
            all(&corrugated(rows), edges, &beams).iter().map(|o| o.totals().0).collect()
        };
        let few = of(8);
        for rows in [64, 512] {
            for ((many, few), beam) in of(rows).iter().zip(&few).zip(&beams) {
                let off = (many / few - 1.0).abs();
                assert!(
                    off < tolerance::ROWS.allowed || (many - few).abs() < 1e-9,
                    "{edges:?} {rows} {beam:?} {few} {many}"
                );
            }
        }
        // and is the plain sum over its orders
        let map = corrugated(8);
        for (found, flux) in all(&map, edges, &beams).iter().zip(&few) {
            let Beam { wi, lobe, .. } = *found.beam();
            let plain: f64 = found
                .iter()
                .filter(|o| o.number[1] == 0)
                .map(|o| {
                    let pair = (wi, o.wo);
                    let a2 = intensity(&map, edges, ETA, WAVELENGTH_UM, pair);
                    a2 * obliquity(ETA, wi, o.wo) / o.wo.z().abs()
                })
                .sum();
            println!("{edges:?} {:.3} {lobe:?}: {flux:.6}, plain sum {plain:.6}", wi.z());
            assert!((flux - plain).abs() < tolerance::PLAIN_SUM.allowed * plain.max(0.01));
        }
    }
}
