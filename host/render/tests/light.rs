//! Light where closed forms or a direct sum say how much there is, and images that are the same however they are made.
#![allow(clippy::unwrap_used, reason = "a test may fail")]
#![allow(clippy::disallowed_methods, reason = "oracles use the platform's mathematics")]

mod facets;

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use asperity_render::image::{Effort, Image, Share};
use asperity_render::law::Law;
use asperity_render::path::Tracer;
use asperity_render::ray::Ray;
use asperity_render::scene::{Material, Scene};
use asperity_render::scene_file::Draft;
use facets::Facets;
use glam::DVec3;
use rand_pcg::Pcg64Mcg;

fn scene(text: &str) -> Scene {
    let rough = Material::Rough(Arc::new(Facets::new(0.3, 1.49)));
    let draft = Draft::parse(text, Path::new("test.toml")).unwrap();
    draft.scene(&|_| rough.clone(), &|_| Err(String::new())).unwrap()
}

fn mean(scene: &Scene, ray: Ray, paths: u32) -> (f64, f64) {
    let tracer = Tracer::new(scene);
    let mut numbers = Pcg64Mcg::new(0xcafe);
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..paths {
        let radiance = tracer.follow(ray, 0, &mut numbers).radiance;
        sum += radiance;
        squares += radiance * radiance;
    }
    let n = f64::from(paths);
    (sum / n, ((squares / n - (sum / n).powi(2)).max(0.0) / n).sqrt())
}

const CAMERA: &str = "[camera]\neye = [0, -5, 0]\nat = [0, 0, 0]\nwidth = 2\npixels = [40, 30]\n";

/// Reflected once, or refracted and reflected inside any number of times: each time the ray turns by a known angle.
#[test]
fn a_smooth_sphere_is_the_sum_over_its_internal_reflections() {
    let text = format!(
        "{CAMERA}[materials]\nglass = {{ kind = \"smooth\", ior = 1.49 }}\nlamp = {{ kind = \"lamp\", radiance = 3 }}\n\
         [[bodies]]\nname = \"sphere\"\nshape = \"sphere\"\ncentre = [0, 0, 0]\nradius = 1\nmaterial = \"glass\"\n\
         [[bodies]]\nname = \"wall\"\nshape = \"rectangle\"\nfrom = [-1e6, 2, 1e6]\nedges = [[0, 0, -2e6], [2e6, 0, 0]]\nmaterial = \"lamp\"\n"
    );
    let scene = scene(&text);
    for b in [0.05, 0.3, 0.6, 0.8, 0.97_f64] {
        let (ti, n) = (b.asin(), 1.49_f64);
        let tt = (b / n).asin();
        let (ci, ct) = (ti.cos(), tt.cos());
        let (s, p) = ((ci - n * ct) / (ci + n * ct), (n * ci - ct) / (n * ci + ct));
        // unpolarised at every facet anew, as rays are
        let r = 0.5 * (s * s + p * p);
        let shines = |turned: f64| if turned.cos() > 0.0 { 3.0 } else { 0.0 };
        let mut wanted = r * shines(PI - 2.0 * ti);
        let mut share = (1.0 - r) * (1.0 - r);
        for k in 0..60 {
            wanted += share * shines(2.0 * (ti - tt) + f64::from(k) * (PI - 2.0 * tt));
            share *= r;
        }
        let ray = Ray { origin: DVec3::new(b, -5.0, 0.0), direction: DVec3::Y };
        let (found, error) = mean(&scene, ray, 200_000);
        assert!((found - wanted).abs() < 4.0 * error + 1e-9, "{b}: {found} +- {error}, {wanted}");
    }
}

/// The light of a tube on a rough face, as a sum over the tube.
#[test]
fn a_flat_rough_face_is_the_integral_of_its_law() {
    let text = format!(
        "{CAMERA}[materials]\nrough = {{ kind = \"model\" }}\ntube = {{ kind = \"lamp\", radiance = 10 }}\n\
         [[bodies]]\nname = \"face\"\nshape = \"rectangle\"\nfrom = [-1, -1, 0]\nedges = [[2, 0, 0], [0, 2, 0]]\nmaterial = \"rough\"\n\
         [[bodies]]\nname = \"tube\"\nshape = \"cylinder\"\nfrom = [-0.35, 0.38, 0.5]\nto = [0.35, 0.38, 0.5]\nradius = 0.013\nclosed = false\nmaterial = \"tube\"\n"
    );
    let scene = scene(&text);
    let law = Facets::new(0.3, 1.49);
    for (from, at) in [
        (DVec3::new(0.0, -0.8, 0.32), DVec3::new(0.1, 0.1, 0.0)),
        (DVec3::new(0.4, -0.3, 0.9), DVec3::new(-0.3, 0.25, 0.0)),
    ] {
        let direction = (at - from).normalize();
        let local = |d: DVec3| asperity_core::direction::Direction::from_unit(d.x, d.y, d.z);
        let (along, around) = (400, 400);
        let mut wanted = 0.0;
        for i in 0..along {
            for j in 0..around {
                let x = -0.35 + 0.7 * (f64::from(i) + 0.5) / f64::from(along);
                let (s, c) = (TAU * (f64::from(j) + 0.5) / f64::from(around)).sin_cos();
                let normal = DVec3::new(0.0, c, s);
                let to = DVec3::new(x, 0.38, 0.5) + 0.013 * normal - at;
                let l = to.normalize();
                let cosine = -l.dot(normal);
                if cosine > 0.0 {
                    let area = 0.7 / f64::from(along) * 0.013 * TAU / f64::from(around);
                    let solid = area * cosine / to.length_squared();
                    // seen from the eye: by reciprocity the law from there
                    wanted += 10.0 * law.value(0, local(-direction), local(l)).unwrap().ars * solid;
                }
            }
        }
        let (found, error) = mean(&scene, Ray { origin: from, direction }, 200_000);
        assert!(error < 2e-3 * wanted, "{error}");
        assert!((found / wanted - 1.0).abs() < 5e-3, "{found} +- {error}, {wanted}");
    }
}

/// With walls that lose nothing, all of a closed room is as bright as its lamp.
#[test]
fn a_closed_white_room_is_as_bright_as_its_lamp() {
    let text = format!(
        "{CAMERA}[materials]\nwall = {{ kind = \"lambert\", reflectance = 1 }}\nglass = {{ kind = \"smooth\", ior = 1.49 }}\n\
         lamp = {{ kind = \"lamp\", radiance = 2 }}\n\
         [[bodies]]\nname = \"room\"\nshape = \"box\"\nfrom = [-2, -2, -2]\nto = [2, 2, 2]\nmaterial = \"wall\"\n\
         [[bodies]]\nname = \"lamp\"\nshape = \"sphere\"\ncentre = [0, 1, 1]\nradius = 0.9\nmaterial = \"lamp\"\n\
         [[bodies]]\nname = \"torus\"\nshape = \"torus\"\ncentre = [0, 0, -1]\naxis = [0, 1, 1]\nring = 0.5\ntube = 0.2\nmaterial = \"glass\"\n"
    );
    let scene = scene(&text);
    let places =
        [DVec3::new(0.3, 0.0, -1.0), DVec3::new(1.0, 0.0, 1.0), DVec3::new(0.0, -0.3, -1.3)];
    let (mut sum, mut variance) = (0.0, 0.0);
    for at in places {
        let origin = DVec3::new(0.0, -1.9, 0.0);
        let (found, error) =
            mean(&scene, Ray { origin, direction: (at - origin).normalize() }, 400_000);
        assert!((found - 2.0).abs() < 4.0 * error, "{at}: {found} +- {error}");
        sum += found / 3.0;
        variance += error * error / 9.0;
    }
    assert!((sum / 2.0 - 1.0).abs() < 1e-3, "{sum} +- {}", variance.sqrt());
}

#[test]
fn an_image_has_the_same_bits_however_it_is_made() {
    let scene = Draft::built_in("booth").unwrap();
    let rough = Material::Rough(Arc::new(Facets::new(0.2, 1.49)));
    let mut scene = scene.scene(&|_| rough.clone(), &|_| Err(String::new())).unwrap();
    scene.camera = scene.camera.with_pixels([70, 50]);
    let tracer = Tracer::new(&scene);
    let effort = Effort { paths: 32, until: Some(0.2), seed: 5 };
    let go_on = &mut |_: f64| ControlFlow::Continue(());
    let new = || Image::new([70, 50]);
    let mut whole = new();
    whole.render(&tracer, effort, Share::ALL, go_on);
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut alone = new();
    one_thread
        .install(|| alone.render(&tracer, effort, Share::ALL, &mut |_| ControlFlow::Continue(())));
    assert_eq!(whole, alone);
    // in shares of the tiles
    for of in [2, 3, 7] {
        let mut together = new();
        for part in 0..of {
            let mut image = new();
            image.render(&tracer, effort, Share { part, of }, go_on);
            for (k, tile) in image.tiles.into_iter().enumerate() {
                if k % of == part {
                    together.tiles[k] = tile;
                }
            }
        }
        assert_eq!(whole, together, "{of}");
    }
    // stopped after its first pass, kept as bytes, and continued
    let mut stopped = new();
    let mut calls = 0;
    stopped.render(&tracer, effort, Share::ALL, &mut |_| {
        calls += 1;
        if calls > 1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert_ne!(whole, stopped);
    let (mut again, key) = Image::of_bytes(&stopped.to_bytes("a key")).unwrap();
    assert_eq!((again.clone(), key.as_str()), (stopped, "a key"));
    again.render(&tracer, effort, Share::ALL, go_on);
    assert_eq!(whole, again);
    // cut off or longer, the bytes are refused
    let bytes = whole.to_bytes("k");
    assert!(
        Image::of_bytes(&bytes[..bytes.len() - 1]).is_err() && Image::of_bytes(b"PNG").is_err()
    );
    assert!(Image::of_bytes(&[bytes.clone(), vec![0]].concat()).is_err());
    assert!(whole.noise().unwrap() > 0.0);
}
