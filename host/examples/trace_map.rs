//! Traces light on a height map: `cargo run --release -p asperity --example trace_map [MAP.x3p]`
#![allow(clippy::print_stdout, reason = "an example says what it found")]

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use asperity::raytrace::{Field, TracedBoundary};
use asperity::surface::{Edges, GaussianSurface, Preparation, Purpose, Roughness};
use asperity::{boundary::Boundary, energy, forward::Rays};
use asperity_core::{direction::Side, quantity::RelativeIor};

fn trace_map(path: Option<String>) -> Result<(), Box<dyn Error>> {
    let (map, edges) = if let Some(path) = path {
        let made = Preparation::default().load(Path::new(&path), Purpose::Light)?;
        (made.map, made.edges)
    } else {
        let (size, pitches_um, lengths_um) = ((256, 256), (0.5, 0.5), (8.0, 8.0));
        let made = GaussianSurface { size, pitches_um, rq_um: 1.0, lengths_um, seed: 7 };
        (made.map().ok_or("no surface")?, Edges::Periodic)
    };
    println!("Rq = {:.3} um", Roughness::of(&map).rq_um);
    let field = Arc::new(Field::new(&map, edges)?);
    let boundary = Boundary::Traced(TracedBoundary { field, eta: RelativeIor::new(1.49)? });
    for (side, incidence_deg) in [(Side::Air, 0.0), (Side::Air, 60.0), (Side::Dielectric, 30.0)] {
        let rays = Rays { count: 100_000, seed: 1 };
        let flux = energy::balance(&boundary, side, incidence_deg, rays);
        println!(
            "from {} at {incidence_deg:2} deg: {:.3} reflected, {:.3} transmitted",
            flux.side, flux.reflected, flux.transmitted
        );
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    trace_map(std::env::args().nth(1))
}

#[test]
fn it_runs() {
    assert!(trace_map(None).is_ok());
}
