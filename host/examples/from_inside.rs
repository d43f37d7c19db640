//! Evaluates a rough face where no instrument can look, from inside the material:
//! `cargo run --release -p asperity --example from_inside`
#![allow(clippy::print_stdout, reason = "an example says what it found")]

use std::error::Error;

use asperity::{boundary::Boundary, energy, forward::Rays};
use asperity_core::bsdf::{Bsdf, Ggx};
use asperity_core::direction::{Direction, Side};
use asperity_core::quantity::{Alpha, RelativeIor};

fn from_inside() -> Result<(), Box<dyn Error>> {
    let rough_face = Ggx::new(Alpha::new(0.2)?, RelativeIor::new(1.49)?);
    // directions point away from the surface: light comes from `inside`, 30 degrees from the normal
    let inside = Direction::from_angles(150_f64.to_radians(), 0.0);
    for theta_deg in [130.0, 150.0, 170.0, 40.0, 50.0, 60.0_f64] {
        let wo = Direction::from_angles(theta_deg.to_radians(), std::f64::consts::PI);
        let goes = if theta_deg > 90.0 { "back inside" } else { "into the air" };
        println!("{theta_deg:5.0} deg, {goes:12}: f = {:.4} 1/sr", rough_face.eval(inside, wo));
    }
    let boundary = Boundary::Ggx(rough_face);
    let rays = Rays { count: 0, seed: 1 }; // a closed form needs none
    for incidence_deg in [0.0, 30.0, 42.2, 60.0] {
        let flux = energy::balance(&boundary, Side::Dielectric, incidence_deg, rays);
        println!(
            "from inside at {incidence_deg:4.1} deg: {:.3} reflected, {:.3} transmitted, {:.3} lost",
            flux.reflected, flux.transmitted, flux.lost
        );
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    from_inside()
}

#[test]
fn it_runs() {
    assert!(from_inside().is_ok());
}
