//! Follows rays to a seeded surface, for counting instructions: `follow_rays COUNT DEGREES`.
#![expect(clippy::print_stdout, clippy::unwrap_used, reason = "a program for measurements")]

use asperity::raytrace::{Fate, Field, Ray};
use asperity::surface::{Edges, HeightMap};
use asperity_core::math::Real;
use rand_pcg::Pcg64Mcg;

#[path = "../benches/surface/mod.rs"]
mod surface;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let count: usize = arguments.next().and_then(|a| a.parse().ok()).unwrap_or(1000);
    let degrees: f64 = arguments.next().and_then(|a| a.parse().ok()).unwrap_or(45.0);
    let map: HeightMap = surface::gaussian(512, 10.0, 0.3, 1);
    let field = Field::new(&map, Edges::Periodic).unwrap();
    let mut generator = Pcg64Mcg::new(1);
    let mut uniform = || f64::uniform(&mut generator);
    let (top, extent) = (surface::top(&map), [map.nx() as f64, map.ny() as f64]);
    let mut hits = 0;
    for _ in 0..count {
        let ray: Ray = surface::ray(top, extent, degrees, &mut uniform);
        hits += usize::from(matches!(field.follow(&ray), Fate::Hits(_)));
    }
    println!("{hits} of {count} rays hit at {degrees} deg");
}
