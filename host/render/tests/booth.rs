//! The light booth, with GGX facets, against an independent renderer, and spheres in uniform light against another.
#![allow(clippy::unwrap_used, reason = "a test may fail")]

mod facets;

use std::ops::ControlFlow;
use std::sync::Arc;

use asperity_needs::data;
use asperity_render::image::{Effort, Image, Share};
use asperity_render::path::Tracer;
use asperity_render::region::{Region, Until, region_means};
use asperity_render::scene::{Material, Scene};
use asperity_render::scene_file::Draft;
use facets::Facets;

fn scene(name: &str, alpha: f64) -> Scene {
    let rough = Material::Rough(Arc::new(Facets::new(alpha, 1.49)));
    Draft::built_in(name).unwrap().scene(&|_| rough.clone(), &|_| Err(String::new())).unwrap()
}

/// The rows of a table without its comments and head.
fn rows(text: &str) -> Vec<Vec<String>> {
    let lines = text.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit()));
    lines.map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

#[test]
fn regions_of_the_booth_are_those_of_the_other_renderer() {
    let Some(folder) = data("reference/models/booth.csv") else { return };
    let text = std::fs::read_to_string(folder).unwrap();
    let rows: Vec<_> = rows(&text).into_iter().filter(|row| row[0] == "0.2").collect();
    assert_eq!(rows.len(), 15);
    let number = |text: &String| text.parse::<f64>().unwrap();
    let regions: Vec<Region> = rows
        .iter()
        .map(|row| {
            let [x0, y0, x1, y1] = [2, 3, 4, 5].map(|k| number(&row[k]));
            Region { name: row[1].clone(), from: [x0, y0], to: [x1, y1] }
        })
        .collect();
    let scene = scene("booth", 0.2);
    let until = Until { relative: 0.004, most: 1 << 26, seed: 1 };
    let mut go_on = |_: f64| ControlFlow::Continue(());
    let means = region_means(&Tracer::new(&scene), &regions, until, &mut go_on);
    for ((row, region), found) in rows.iter().zip(&regions).zip(means) {
        let (mean, error) = (number(&row[6]), number(&row[7]).hypot(found.std_error));
        let z = (found.mean - mean) / error;
        assert!(z.abs() < 4.0, "{}: {found:?}, there {mean}: {z} errors", region.name);
        assert!(
            (found.mean / mean - 1.0).abs() < 0.015,
            "{}: {found:?}, there {mean}",
            region.name
        );
    }
}

#[test]
fn spheres_in_uniform_light_lose_what_their_law_loses() {
    let Some(folder) = data("reference/models/furnace_sphere.csv") else { return };
    let text = std::fs::read_to_string(folder).unwrap();
    let separable: Vec<_> = rows(&text).into_iter().filter(|row| row[1] == "separable").collect();
    assert_eq!(separable.len(), 4);
    for row in separable {
        let number = |k: usize| row[k].parse::<f64>().unwrap();
        let scene = scene("furnace", number(0));
        let mut image = Image::new(scene.camera.pixels());
        let effort = Effort { paths: 32, until: None, seed: 3 };
        let mut go_on = |_: f64| ControlFlow::Continue(());
        image.render(&Tracer::new(&scene), effort, Share::ALL, &mut go_on);
        let sphere = image.body(0);
        let (mean, error) = sphere.all().mean();
        assert!((mean - number(2)).abs() < 2e-3, "{row:?}: {mean} +- {error}");
        for (k, (from, to)) in
            [(0.0, 0.5), (0.5, 0.8), (0.8, 0.95), (0.95, 1.0)].into_iter().enumerate()
        {
            let (mean, error) = sphere.between(from, to).mean();
            let off = (mean - number(4 + k)).abs();
            assert!(off < 2e-3 + 4.0 * error, "{row:?}: {from}..{to} {mean} +- {error}");
        }
    }
}
