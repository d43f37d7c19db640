//! Evaluators under hostile input: parameters and directions at their limits, beyond them, subnormal, huge,
//! infinite and NaN. What exists has to give finite results; the rest is a typed error.

use asperity_core::bsdf::tail::Shape;
use asperity_core::bsdf::{
    Bsdf, Ggx, Lobe, Masking, Microfacet, Normals, OpaqueGgx, ShiftInvariant, Smooth,
};
use asperity_core::direction::Direction;
use asperity_core::math::Real;
use asperity_core::ndf::beckmann::Beckmann;
use asperity_core::ndf::law::{Law, Profile};
use asperity_core::ndf::normals::NormalDensity;
use asperity_core::ndf::student::Student;
use asperity_core::quantity::{Alpha, RelativeIor};
use rand_core::Rng as _;
use rand_pcg::Pcg32;

use crate::digest::Digest;

/// What became of the cases.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// Checksum of all results.
    pub digest: Digest,
    /// Cases evaluated: a law, two directions, three uniforms.
    pub evaluated: u32,
    /// Parameters or directions that a constructor refused.
    pub refused: u32,
    /// Results that were NaN, infinite or negative.
    pub unsound: u32,
}

/// Numbers that arithmetic stumbles over.
const WILD: [f64; 16] = [
    0.0,
    -0.0,
    1e-45,
    1.2e-38,
    1e-30,
    1e-12,
    1e-7,
    1e-3,
    1.0,
    1.0 - 1e-7,
    1e3,
    1e18,
    3.4e38,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
];

/// Parameters at their limits, inside them, and beyond.
const WIDTHS: [f64; 10] = [1e-6, 1e-5, 1e-3, 0.05, 0.3, 2.0, 10.0, 100.0, 1e-7, 1e3];
/// Relative indices likewise.
const INDICES: [f64; 10] = [1.49, 1.0 / 1.49, 1.0 + 1e-7, 1.0, 0.1, 10.0, 1.0001, 4.0, 0.0, 1e9];

struct Source<T> {
    generator: Pcg32,
    outcome: Outcome,
    last: T,
}

impl<T: Real> Source<T> {
    fn uniform(&mut self) -> T {
        T::uniform(&mut self.generator)
    }

    fn pick<const N: usize>(&mut self, from: [f64; N]) -> T {
        let k = self.generator.next_u32() as usize % N;
        T::from_f64(from.get(k).copied().unwrap_or(1.0))
    }

    /// Half of them near the tangent plane or the normal, a quarter of wild components.
    fn direction(&mut self) -> Option<Direction<T>> {
        let (u, v) = (self.uniform(), self.uniform());
        let phi = T::TWO * T::PI * v;
        let small = T::from_f64(1e-4) * (u - T::HALF);
        let found = match self.generator.next_u32() % 8 {
            0 | 1 => {
                let wild = [self.pick(WILD), self.pick(WILD), self.pick(WILD)];
                let signed = wild.map(|x| if self.generator.next_u32() & 1 == 0 { x } else { -x });
                Direction::new(signed[0], signed[1], signed[2])
            }
            2 | 3 => Some(Direction::from_angles(T::PI * T::HALF + small, phi)),
            4 => Some(Direction::from_angles(small, phi)),
            5 => Some(Direction::from_angles(T::PI + small, phi)),
            _ => Some(Direction::from_angles(T::PI * u, phi)),
        };
        self.outcome.refused += u32::from(found.is_none());
        found
    }

    fn keep(&mut self, x: T) {
        self.outcome.digest.real(x);
        self.outcome.unsound += u32::from(!(x.is_finite() && x >= T::ZERO));
    }

    /// Every function of a law at one pair of directions.
    fn evaluate<B: Bsdf<T>>(&mut self, law: &B) {
        let (Some(wi), Some(wo)) = (self.direction(), self.direction()) else { return };
        self.outcome.evaluated += 1;
        for value in [law.eval(wi, wo), law.ars(wi, wo), law.pdf(wi, wo)] {
            self.keep(value);
        }
        let corners = [T::ZERO, T::ONE - T::EPSILON, T::HALF, self.uniform()];
        let first = self.generator.next_u32() as usize;
        let mut k = first;
        let sampled = law.sample(wi, &mut || {
            k = k.wrapping_add(1);
            // corners first, then anything: a law that draws again must find an end
            let corner = corners.get(k % 4).filter(|_| k.wrapping_sub(first) <= 3);
            corner.copied().unwrap_or_else(|| self.uniform())
        });
        if let Some(sampled) = sampled {
            self.outcome.digest.direction(Some(sampled.wo));
            self.keep(sampled.weight);
            for x in sampled.wo.xyz() {
                self.outcome.unsound += u32::from(!x.is_finite());
            }
        }
        self.last = self.uniform();
    }

    fn pick_index(&mut self) -> Option<RelativeIor<T>> {
        let index = self.pick(INDICES);
        self.refuse(RelativeIor::new(index))
    }

    fn refuse<R, E>(&mut self, made: Result<R, E>) -> Option<R> {
        self.outcome.refused += u32::from(made.is_err());
        made.ok()
    }
}

fn source<T: Real>(seed: u64) -> Source<T> {
    let outcome = Outcome { digest: Digest::new(), evaluated: 0, refused: 0, unsound: 0 };
    Source { generator: Pcg32::new(seed, 0x405), outcome, last: T::ZERO }
}

/// GGX, opaque GGX and the smooth face: `cases` of them.
pub fn closed_forms<T: Real>(cases: u32) -> Outcome {
    let mut source = source::<T>(1);
    for k in 0..cases {
        let (width, index) = (source.pick(WIDTHS), source.pick(INDICES));
        let Some(alpha) = source.refuse(Alpha::new(width)) else { continue };
        let Some(eta) = source.refuse(RelativeIor::new(index)) else { continue };
        if k % 4 < 3 {
            source.evaluate(&Ggx::new(alpha, eta));
        } else if let Some(metal) = OpaqueGgx::new(alpha, T::from_f64(0.8), T::from_f64(0.05)) {
            source.evaluate(&metal);
            smooth(&mut source, eta);
        }
    }
    source.outcome
}

/// The smooth face has no values: its fluxes and its rays.
fn smooth<T: Real>(source: &mut Source<T>, eta: RelativeIor<T>) {
    let Some(wi) = source.direction() else { return };
    let face = Smooth { eta };
    let fluxes = face.fresnel(wi);
    source.keep(fluxes.reflected);
    source.keep(fluxes.transmitted);
    source.outcome.digest.direction(face.refract(wi));
}

/// Normals, whose tables take long to make: `laws` of them, `cases` of each.
pub fn normals<T: Real>(laws: u32, cases: u32) -> Outcome {
    let mut source = source::<T>(2);
    for k in 0..laws {
        let profile = if k % 2 == 0 { Profile::Gauss } else { Profile::Cauchy };
        let (delta, index) = (source.pick(WIDTHS), source.pick(INDICES));
        let n = source.pick([0.1, 0.5, 1.0, 2.0, 3.7, 64.0, 100.0, 0.0]);
        let law = source.refuse(Law::new(profile, delta, n, T::ZERO));
        let eta = source.refuse(RelativeIor::new(index));
        if let (Some(law), Some(eta)) = (law, eta) {
            let law: Normals<T, 64> = Normals::new(NormalDensity::new(law), eta);
            for _ in 0..cases {
                source.evaluate(&law);
            }
        }
    }
    source.outcome
}

/// Microfacets of Student's and Beckmann's densities: `cases` of them.
pub fn microfacets<T: Real>(cases: u32) -> Outcome {
    let mut source = source::<T>(3);
    for k in 0..cases {
        let (width, index) = (source.pick(WIDTHS), source.pick(INDICES));
        let gamma = source.pick([1.51, 1.6, 2.0, 3.0, 30.0, 500.0, 1.5, 1e9]);
        let alpha = source.refuse(Alpha::new(width));
        let eta = source.refuse(RelativeIor::new(index));
        let (Some(alpha), Some(eta)) = (alpha, eta) else { continue };
        let masking = if k % 2 == 0 { Masking::Separable } else { Masking::Correlated };
        if k % 3 == 0 {
            source.evaluate(&Microfacet::new(Beckmann::new(alpha), eta).with_masking(masking));
        } else if let Some(student) = source.refuse(Student::new(alpha, gamma)) {
            source.evaluate(&Microfacet::new(student, eta).with_masking(masking));
        }
    }
    source.outcome
}

/// Scatter about the specular direction, of sheets and of faces: `cases` of them.
pub fn about_specular<T: Real>(cases: u32) -> Outcome {
    let mut source = source::<T>(4);
    for k in 0..cases {
        let level = source.pick([1e-9, 1e-4, 0.01, 0.3, 1e6, f64::NAN, 0.0, 1e-2]);
        let width = source.pick([1e-6, 1e-3, 0.05, 0.5, 3.0, 1e-12, 0.0, 0.2]);
        let power = source.pick([0.2, 1.0, 2.0, 3.7, 15.0, 60.0, 1e4, -1.0]);
        let shape = match k % 4 {
            0 => Shape::Abg { a: level, b: width, g: power },
            1 => Shape::Harvey { b0: level, l: width, s: T::ZERO - power, m: power },
            2 => Shape::SuperGauss { a: level, w: width, p: power },
            _ => Shape::KCorrelation { b0: level, l: width, s: T::ZERO - power },
        };
        let Some(eta) = source.pick_index() else { continue };
        let lobe = if k % 3 == 0 { Lobe::Reflection } else { Lobe::Transmission };
        let specular = (k % 5 == 0).then(|| T::from_f64(0.1));
        if let Some(law) = source.refuse(ShiftInvariant::new(shape, lobe, eta, specular)) {
            source.evaluate(&law);
        }
    }
    source.outcome
}

#[cfg(test)]
mod tests {
    use super::{Outcome, about_specular, closed_forms, microfacets, normals};
    use asperity_core::math::{Fast, Real};

    fn sound(what: &str, outcome: Outcome, least: u32) {
        assert_eq!(outcome.unsound, 0, "{what}: {outcome:?}");
        // neither all refused nor all accepted
        assert!(outcome.evaluated > least && outcome.refused > least / 4, "{what}: {outcome:?}");
    }

    fn both<T: Real>(what: &str) {
        sound(what, closed_forms::<T>(400_000), 100_000);
        sound(what, normals::<T>(300, 300), 20_000);
        sound(what, microfacets::<T>(20_000), 5_000);
        sound(what, about_specular::<T>(20_000), 2_000);
    }

    #[test]
    fn nothing_unsound_in_either_precision_and_either_tier() {
        both::<f32>("f32");
        both::<f64>("f64");
        both::<Fast<f32>>("fast f32");
        both::<Fast<f64>>("fast f64");
    }
}
