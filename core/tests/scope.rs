//! What a build answers, and what is off does not: runs with any features that have `f32`.
//!
//! ```text
//! cargo test -p asperity-core --test scope --no-default-features --features f32,ggx,air,transmission
//! ```
#![cfg(feature = "f32")]
#![allow(clippy::unwrap_used, reason = "tests may fail")]
// without a law there is nothing to ask
#![cfg_attr(
    not(any(feature = "ggx", feature = "normals", feature = "table")),
    allow(dead_code, unused_imports, reason = "a build without laws")
)]

use asperity_core::bsdf::{Bsdf, Lobe, Scatter};
use asperity_core::direction::Direction;
use asperity_core::quantity::RelativeIor;

const AIR: bool = cfg!(feature = "air");
const DIELECTRIC: bool = cfg!(feature = "dielectric");
const REFLECTION: bool = cfg!(feature = "reflection");
const TRANSMISSION: bool = cfg!(feature = "transmission");

/// Whether this build answers light from a side into a lobe.
fn answered(below: bool, mirrored: bool) -> bool {
    (if below { DIELECTRIC } else { AIR }) && if mirrored { REFLECTION } else { TRANSMISSION }
}

fn eta() -> RelativeIor<f32> {
    RelativeIor::new(1.49).unwrap()
}

/// Asks for every lobe from every side.
fn ask(law: &impl Bsdf<f32>, opaque: bool) {
    for below in [false, true] {
        let z = if below { -1.0 } else { 1.0 };
        let wi = Direction::new(-0.3, 0.0, z).unwrap();
        for mirrored in [false, true] {
            let wo = Direction::new(0.25, 0.0, if mirrored { z } else { -z }).unwrap();
            let there = answered(below, mirrored) && (!opaque || (mirrored && !below));
            let said = [law.eval(wi, wo), law.ars(wi, wo), law.pdf(wi, wo)];
            if there {
                assert!(
                    said.iter().all(|x| *x > 0.0),
                    "below {below}, mirrored {mirrored}: {said:?}"
                );
            } else {
                assert_eq!(said.map(f32::to_bits), [0; 3], "below {below}, mirrored {mirrored}");
            }
            let lobe = if mirrored { Lobe::Reflection } else { Lobe::Transmission };
            assert_eq!(law.sample_lobe(wi, lobe, [0.3, 0.4]).is_some(), there, "{below} {lobe:?}");
        }
        draw(law, wi, below, opaque);
    }
}

/// Rays go where this build sends them, and nowhere else.
fn draw(law: &impl Scatter<f32>, wi: Direction<f32>, below: bool, opaque: bool) {
    let mut word = 1_u32;
    let mut uniform = || {
        word = word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (word >> 8) as f32 / 16_777_216.0
    };
    let mut seen = [false; 2];
    for _ in 0..400 {
        if let Some(ray) = law.sample(wi, &mut uniform) {
            let mirrored = (ray.wo.z() < 0.0) == below;
            assert!(answered(below, mirrored), "a ray from below {below}, mirrored {mirrored}");
            seen[usize::from(mirrored)] = true;
        }
    }
    let dark = opaque && below;
    assert_eq!(seen[1], answered(below, true) && !dark, "reflected rays, below {below}");
    assert_eq!(seen[0], answered(below, false) && !opaque, "transmitted rays, below {below}");
}

#[cfg(feature = "ggx")]
#[test]
fn ggx_answers_what_it_is_built_for() {
    use asperity_core::bsdf::{Ggx, OpaqueGgx};
    use asperity_core::quantity::Alpha;

    let alpha = Alpha::new(0.3).unwrap();
    ask(&Ggx::new(alpha, eta()), false);
    ask(&OpaqueGgx::new(alpha, 0.9, 0.01).unwrap(), true);
    // matched media let light through, if anything is let through
    let none = Ggx::new(alpha, RelativeIor::new(1.0).unwrap());
    let wi = Direction::new(-0.3, 0.0, 1.0).unwrap();
    assert_eq!(
        none.sample_lobe(wi, Lobe::Transmission, [0.5; 2]).is_some(),
        answered(false, false)
    );
}

#[cfg(all(feature = "ggx", feature = "microfacet"))]
#[test]
fn all_bounces_answer_what_they_are_built_for() {
    use asperity_core::bsdf::{AllBounces, Ggx, Walk};
    use asperity_core::ndf::ggx_facets::GgxFacets;
    use asperity_core::quantity::Alpha;

    let alpha = Alpha::new(0.3).unwrap();
    ask(&AllBounces::new(Ggx::new(alpha, eta())), false);
    let walk = Walk::new(GgxFacets::new(alpha), eta());
    for below in [false, true] {
        let z = if below { -1.0 } else { 1.0 };
        draw(&walk, Direction::new(-0.3, 0.0, z).unwrap(), below, false);
    }
}

#[cfg(all(feature = "ggx", feature = "normals"))]
#[test]
fn a_mix_answers_what_it_is_built_for() {
    use asperity_core::bsdf::{Backing, Ggx, Lambert, Mix, MixShares};
    use asperity_core::quantity::Alpha;

    let law = |a| Ggx::new(Alpha::new(a).unwrap(), eta());
    let shares = MixShares { second: 0.3, specular: 0.2, lambert: 0.1 };
    let backing = Backing::Dielectric(eta());
    ask(&Mix::new(backing, law(0.1), Some(law(0.4)), shares).unwrap(), false);
    ask(&Lambert::new(backing), false);
    ask(&Lambert::<f32>::new(Backing::Opaque), true);
}

#[cfg(feature = "normals")]
#[test]
fn normals_answers_what_it_is_built_for() {
    use asperity_core::bsdf::Normals;
    use asperity_core::ndf::law::{Law, Profile};
    use asperity_core::ndf::normals::NormalDensity;

    let law = Law::new(Profile::Gauss, 0.2, 2.0, 0.0).unwrap();
    ask(&Normals::<f32, 64>::new(NormalDensity::new(law), eta()), false);
}

#[cfg(feature = "table")]
#[test]
fn a_table_answers_what_it_is_built_for() {
    use asperity_core::direction::Side;
    use asperity_core::table::{Arrays, Fall, Form, Header, LobeHeader, Shape};

    const SHAPE: Shape = Shape { incidences: 2, azimuths: 2, radii: 2, intervals: 1 };
    let lobe = LobeHeader {
        shape: SHAPE,
        form: Form::Masked,
        fall: Fall::Fourth,
        scale: 0.3,
        grazing: 1.0,
        masking: 0.3,
    };
    let header = Header {
        eta: eta(),
        opaque: false,
        slope: 0.3,
        lobes: [Some(lobe); 4],
        fluxes: [2; 2],
        grazing: [1.0; 2],
    };
    let table = header.table(Arrays {
        gains: &[1e-4; 4 * SHAPE.gains()],
        values: &[100_u8; 4 * SHAPE.values()],
        quantiles: &[
            0, 60_000, 0, 60_000, 0, 60_000, 0, 60_000, 0, 60_000, 0, 60_000, 0, 60_000, 0, 60_000,
        ],
        leans: &[0; 4 * SHAPE.leans()],
        fluxes: &[[20_000, 30_000, 0, 0]; 4],
    });
    let table = table.unwrap();
    ask(&table, false);
    for (side, below) in [(Side::Air, false), (Side::Dielectric, true)] {
        let fluxes = [table.reflectance(0.9_f32, side), table.transmittance(0.9, side)];
        assert_eq!(fluxes.map(|f| f > 0.0), [answered(below, true), answered(below, false)]);
        for (lobe, mirrored) in [(Lobe::Reflection, true), (Lobe::Transmission, false)] {
            assert_eq!(table.lobe(side, lobe).is_some(), answered(below, mirrored));
        }
    }
}
