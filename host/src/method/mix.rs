//! Method `mix`: one law or two side by side, with what is specular and what is diffuse beside them.
//!
//! The surface is of areas larger than the relief, and a share of it follows each law: `f = s1 f1 + s2 f2 + lambert`. Parameters of the
//! second law have a 2 at the end of their names; its share is `share2`. On request a share of the surface is smooth (`specular`) and one
//! is diffuse (`lambert`); the first law has what is left. Laws about the specular direction, and those of an opaque body, have a
//! level of their own: there the levels add, and there is no `share2`.

mod blend;
mod names;

use std::borrow::Cow;

use asperity_core::bsdf::Lobe;

use super::kind::{Choice, Kind, Lack};
use super::{Body, Bounces, BuildError, Method, Parameter, Scale};
use crate::boundary::Boundary;
use blend::{Asked, Blend, blended};
use names::{second, together};

/// The share of the second law.
const SHARE2: Parameter = Parameter::new("share2", "", (0.0, 1.0), Scale::Linear, &[0.1, 0.5]);
const SPECULAR: Parameter =
    Parameter::new("specular", "", (1e-6, 1.0), Scale::Log, &[0.05]).or_zero();
const LAMBERT: Parameter =
    Parameter::new("lambert", "", (1e-6, 1.0), Scale::Log, &[0.05]).or_zero();

/// Its description and needs.
pub(super) const KIND: Kind = Kind {
    name: "mix",
    summary: "one closed form or two side by side, with what is specular and diffuse",
    takes_opaque: true,
    of_parts: true,
    optional: &["specular", "lambert"],
    make: |choice| MixMethod::new(choice).map(|mix| Box::new(mix) as Box<dyn Method>),
    ..Kind::CLOSED
};

/// The method.
pub struct MixMethod {
    /// Its names in files.
    of: Vec<String>,
    parts: Vec<Box<dyn Method>>,
    blend: Blend,
    ordered: bool,
    parameters: Vec<Parameter>,
}

impl std::fmt::Debug for MixMethod {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MixMethod").field("of", &self.of).finish_non_exhaustive()
    }
}

impl MixMethod {
    /// Of the methods and options of a choice.
    fn new(choice: &Choice<'_>) -> Result<Self, Lack> {
        if !(1..=2).contains(&choice.of.len()) {
            return Err(Lack::NoParts);
        }
        let kinds = Kind::with_parts(KIND.name, choice.of)?;
        let kinds = kinds.get(1..).unwrap_or_default();
        let blend = Blend::of(kinds, choice.body)?;
        let bounces = choice.bounces.map(Bounces::named).transpose()?.unwrap_or_default();
        if bounces == Bounces::Walk {
            let what = "it needs laws with values, and `walk` has none; take `all`";
            return Err(Lack::Mix(what.into()));
        }
        if bounces != Bounces::One && !kinds.iter().any(|kind| kind.has_bounces()) {
            return Err(Lack::NoBounces { those: Kind::names(Kind::has_bounces).join(", ") });
        }
        let make = |(k, name): (usize, &String)| {
            // a share of its own is the mix's where levels add
            let own = |name: &str| {
                let name = if k > 0 && name != SPECULAR.name { second(name) } else { name };
                (choice.asked)(name)
            };
            let has_bounces = kinds.get(k).is_some_and(|kind| kind.has_bounces());
            let bounces = choice.bounces.filter(|_| has_bounces && choice.body != Body::Opaque);
            Choice { name, asked: &own, bounces, of: &[], ..*choice }.method()
        };
        let parts = choice.of.iter().enumerate().map(make).collect::<Result<Vec<_>, _>>()?;
        let parameters = Self::parameters_of(&parts, blend, choice)?;
        Ok(Self { of: choice.of.to_vec(), parts, blend, ordered: choice.ordered, parameters })
    }

    /// Those of the first law, those of the second, and the shares.
    fn parameters_of(
        parts: &[Box<dyn Method>],
        blend: Blend,
        choice: &Choice<'_>,
    ) -> Result<Vec<Parameter>, Lack> {
        let alike = choice.of.windows(2).all(|pair| pair.first() == pair.last());
        let mut parameters = Vec::new();
        for (k, part) in parts.iter().enumerate() {
            for parameter in part.parameters().iter().filter(|p| blend.is_own(k, p.name)) {
                let mut parameter = parameter.clone();
                if parts.len() > 1 {
                    parameter.starts = apart(parameter.starts, k, alike);
                }
                parameters.push(match k {
                    0 => parameter,
                    _ => parameter.clone().named(second(parameter.name)),
                });
            }
        }
        let asked = |p: &Parameter| (choice.asked)(p.name);
        if blend == Blend::Shares && parts.len() > 1 {
            parameters.push(SHARE2);
        }
        if blend != Blend::Opaque {
            parameters.extend([SPECULAR, LAMBERT].into_iter().filter(asked));
        } else if asked(&SPECULAR) {
            let what = "an opaque body has levels, and no share of it is `specular`";
            return Err(Lack::Mix(what.into()));
        }
        Ok(parameters)
    }

    /// The values of the parts and of the shares.
    fn asked<'a>(&self, values: &'a [f64]) -> Result<Asked<'a>, BuildError> {
        if let Some(missing) = self.parameters.get(values.len()) {
            return Err(BuildError::Missing(missing.name));
        }
        let own = |k: usize| {
            let part = self.parts.get(k).map_or(&[][..], |part| part.parameters());
            part.iter().filter(|p| self.blend.is_own(k, p.name)).count()
        };
        let (first, rest) = values.split_at_checked(own(0)).unwrap_or((values, &[]));
        let (second, _) = rest.split_at_checked(own(1)).unwrap_or((rest, &[]));
        let share = |wanted: &Parameter| {
            let mut all = self.parameters.iter().zip(values);
            let value = all.find(|(p, _)| p.name == wanted.name).map_or(0.0, |(_, v)| *v);
            let (name, least, most) = (wanted.name, 0.0, 1.0);
            if (least..=most).contains(&value) {
                Ok(value)
            } else {
                Err(BuildError::OutOfDomain { name, value, least, most, unit: "" })
            }
        };
        // the floor of an opaque body is its first law's
        let lambert = if self.blend == Blend::Opaque { 0.0 } else { share(&LAMBERT)? };
        Ok(Asked {
            values: [first, second],
            second: share(&SHARE2)?,
            specular: share(&SPECULAR)?,
            lambert,
        })
    }
}

/// Where a search begins: of two laws the first is narrow and the second wide.
fn apart(starts: Cow<'static, [f64]>, k: usize, alike: bool) -> Cow<'static, [f64]> {
    let least = if alike { 3 } else { 4 };
    match (&*starts, k) {
        (all, _) if all.len() < least => starts,
        ([narrow @ .., _], 0) => Cow::Owned(narrow.to_vec()),
        ([_, wide @ ..], _) => Cow::Owned(wide.to_vec()),
        _ => starts,
    }
}

impl Method for MixMethod {
    fn name(&self) -> &'static str {
        KIND.name
    }

    fn references(&self) -> &'static [&'static str] {
        together(self.parts.iter().map(|part| part.references()))
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn boundary(&self, values: &[f64], body: Body) -> Result<Boundary, BuildError> {
        let mix = blended(&self.parts, self.blend, &self.asked(values)?, body)?;
        let alike = self.of.first() == self.of.last();
        if self.ordered && alike && blend::is_disordered(&mix) {
            return Err(BuildError::Order);
        }
        Ok(Boundary::Mix(Box::new(mix)))
    }

    fn profile(&self) -> Option<&'static str> {
        self.parts.iter().find_map(|part| part.profile())
    }

    fn lobe(&self) -> Option<Lobe> {
        self.parts.iter().find_map(|part| part.lobe())
    }

    fn wavelength_nm(&self) -> Option<f64> {
        self.parts.iter().find_map(|part| part.wavelength_nm())
    }

    fn of(&self) -> &[String] {
        &self.of
    }

    fn bounces(&self) -> Bounces {
        let mut all = self.parts.iter().map(|part| part.bounces());
        // its own name says it of ggx-ms
        let fixed = self.of.iter().any(|name| name == super::kind::GGX_MS);
        all.find(|bounces| *bounces != Bounces::One && !fixed).unwrap_or_default()
    }

    fn label(&self) -> String {
        let parts: Vec<String> = self.parts.iter().map(|part| part.label()).collect();
        format!("{} ({})", self.name(), parts.join(" + "))
    }
}

#[cfg(test)]
mod tests {
    use asperity_core::bsdf::Lobe;
    use asperity_core::direction::{Direction, Side};

    use super::super::{Body, Choice, Method};
    use crate::boundary::Boundary;
    use crate::energy::balance;
    use crate::forward::Rays;

    const CLEAR: Body = Body::Dielectric { ior: 1.49 };
    const SHEET: Body = Body::Sheet { ior: None };
    const ONE: Rays = Rays { count: 1, seed: 1 };

    fn method(of: &[&str], body: Body, asked: &[&str]) -> Result<Box<dyn Method>, String> {
        let of: Vec<String> = of.iter().map(|name| (*name).to_owned()).collect();
        let asked = |name: &str| asked.contains(&name);
        let lobe = Some(Lobe::Transmission);
        let choice = Choice { of: &of, asked: &asked, lobe, ..Choice::new("mix", body) };
        choice.method().map_err(|lack| lack.to_string())
    }

    fn names(of: &[&str], body: Body, asked: &[&str]) -> Vec<&'static str> {
        method(of, body, asked).unwrap().parameters().iter().map(|p| p.name).collect()
    }

    fn made(of: &[&str], body: Body, asked: &[&str], values: &[f64]) -> Result<Boundary, String> {
        method(of, body, asked)?.boundary(values, body).map_err(|e| e.to_string())
    }

    #[test]
    fn parameters_are_those_of_both_laws_and_the_shares() {
        let both = ["specular", "lambert"];
        assert_eq!(names(&["ggx", "ggx"], CLEAR, &[]), ["alpha", "alpha2", "share2"]);
        assert_eq!(names(&["ggx"], CLEAR, &both), ["alpha", "specular", "lambert"]);
        let of_student = ["alpha", "sigma2", "gamma2", "share2", "lambert"];
        assert_eq!(names(&["ggx", "student"], CLEAR, &["lambert"]), of_student);
        let tails = ["A", "w", "p", "A2", "B2", "g2"];
        assert_eq!(names(&["super-gauss", "abg"], SHEET, &[]), tails);
        let harvey = ["b0", "L", "S", "b02", "L2", "S2", "m2", "specular", "lambert"];
        assert_eq!(names(&["harvey", "harvey"], SHEET, &["m2", "specular", "lambert"]), harvey);
        let opaque = ["alpha", "gain", "lambert", "alpha2", "gain2"];
        assert_eq!(names(&["ggx", "ggx"], Body::Opaque, &[]), opaque);
        let turned = ["alpha", "alpha_x2", "alpha_y2", "orientation2", "share2"];
        assert_eq!(names(&["ggx", "ggx"], CLEAR, &["alpha_x2"]), turned);
    }

    #[test]
    fn levels_of_laws_about_the_specular_direction_add() {
        let law = |name: &str, values: &[f64]| {
            let choice = Choice { lobe: Some(Lobe::Transmission), ..Choice::new(name, SHEET) };
            choice.method().unwrap().boundary(values, SHEET).unwrap()
        };
        let (first, second) = ([4.0, 0.15, 4.0], [0.01, 0.05, 2.5]);
        let (a, b) = (law("super-gauss", &first), law("abg", &second));
        let both = [first, second].concat();
        let mix = made(&["super-gauss", "abg"], SHEET, &[], &both).unwrap();
        let wi = Direction::from_angles(0.3, 0.0);
        for k in 0..20 {
            let wo = Direction::from_angles(3.1 - 0.07 * f64::from(k), 1.0);
            let of = |b: &Boundary| b.eval(wi, wo).unwrap();
            assert!((of(&mix) / (of(&a) + of(&b)) - 1.0).abs() < 1e-12, "{k}");
        }
        // what neither scatters goes straight on
        let of = |b: &Boundary| balance(b, Side::Air, 0.0, ONE);
        let kept = of(&a).coherent_transmitted + of(&b).coherent_transmitted - 1.0;
        let balance = of(&mix);
        assert!((balance.coherent_transmitted - kept).abs() < 1e-9, "{balance:?}");
        assert!(balance.lost.abs() < 1e-9 && mix.is_sheet() && mix.keeps_direction());
        // a specular share is the part of the light that it says, and what is diffuse goes where the rest goes
        let asked = ["specular", "lambert"];
        let values = [&both[..], &[0.2, 0.1]].concat();
        let shared = made(&["super-gauss", "abg"], SHEET, &asked, &values).unwrap();
        let e = of(&shared);
        assert!((e.coherent_transmitted - 0.2).abs() < 1e-9, "{e:?}");
        assert!((e.transmitted - (1.0 - kept + 0.3)).abs() < 1e-6, "{e:?}");
    }

    #[test]
    fn balances_are_those_of_the_parts() {
        let asked = ["specular", "lambert"];
        let mix = made(&["ggx", "beckmann"], CLEAR, &asked, &[0.1, 0.4, 0.3, 0.2, 0.1]).unwrap();
        let part = |name: &str, alpha: f64| {
            Choice::new(name, CLEAR).method().unwrap().boundary(&[alpha], CLEAR).unwrap()
        };
        for (side, deg) in [(Side::Air, 30.0), (Side::Dielectric, 70.0)] {
            let of = |b: &Boundary| balance(b, side, deg, ONE);
            let lost = 0.4 * of(&part("ggx", 0.1)).lost + 0.3 * of(&part("beckmann", 0.4)).lost;
            assert!((of(&mix).lost - lost).abs() < 1e-9, "{side:?}: {:?} {lost}", of(&mix));
        }
        assert!(mix.eta().is_some_and(|n| (n - 1.49).abs() < 1e-15) && !mix.is_sheet());
    }

    #[test]
    fn opaque_levels_add_and_the_floor_is_one() {
        let values = [0.05, 0.3, 0.02, 0.3, 0.2];
        let mix = made(&["ggx", "ggx"], Body::Opaque, &[], &values).unwrap();
        let one = |alpha: f64, gain: f64, floor: f64| {
            let method = Choice::new("ggx", Body::Opaque).method().unwrap();
            method.boundary(&[alpha, gain, floor], Body::Opaque).unwrap()
        };
        let (a, b) = (one(0.05, 0.3, 0.02), one(0.3, 0.2, 0.0));
        let (wi, wo) = (Direction::from_angles(0.3, 0.0), Direction::from_angles(0.4, 3.0));
        let of = |b: &Boundary| b.eval(wi, wo).unwrap();
        assert!((of(&mix) / (of(&a) + of(&b)) - 1.0).abs() < 1e-12);
        assert!(mix.eta().is_none());
    }

    #[test]
    fn a_law_with_a_direction_turns_with_the_mix() {
        let values = [0.1, 0.05, 0.4, 20.0, 0.3];
        let made = |values: &[f64]| made(&["ggx", "ggx"], CLEAR, &["alpha_x2"], values).unwrap();
        let (mix, turned) = (made(&values), made(&[0.1, 0.05, 0.4, 50.0, 0.3]));
        assert!(mix.is_anisotropic());
        let (wi, wo) = (Direction::from_angles(0.3, 0.5), Direction::from_angles(2.8, 3.0));
        let there = mix.turned(30.0);
        let of = |b: &Boundary| b.eval(wi, wo).unwrap();
        assert!((of(&there) / of(&turned) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn what_does_not_mix_is_refused_by_name() {
        for (of, body, asked, words) in [
            (&[][..], CLEAR, &[][..], "needs the laws"),
            (&["ggx"; 3], CLEAR, &[], "needs the laws"),
            (&["ggx", "phong"], CLEAR, &[], "`phong` is unknown"),
            (&["ggx", "heights"], CLEAR, &[], "heights is no closed form"),
            (&["ggx", "mix"], CLEAR, &[], "mix is no closed form"),
            (&["ggx", "abg"], CLEAR, &[], "do not mix"),
            (&["ggx", "ggx"], SHEET, &[], "not a sheet"),
            (&["ggx", "ggx"], Body::Opaque, &["specular"], "opaque"),
        ] {
            let Err(what) = method(of, body, asked) else { panic!("{of:?} was made") };
            assert!(what.contains(words), "{of:?}: {what}");
        }
        let asked = ["specular", "lambert"];
        for (values, words) in [
            (vec![0.1, 0.4, 0.5, 0.3, 0.3], "more than 1"),
            (vec![0.1, 0.4, 1.5, 0.0, 0.0], "`share2`"),
            (vec![0.1, 0.4, 0.5, -0.1, 0.0], "`specular`"),
            (vec![0.1, -0.4, 0.5, 0.0, 0.0], "`alpha2`"),
            (vec![0.1, 0.4, f64::NAN, 0.0, 0.0], "`share2`"),
            (vec![0.1, 0.4], "`share2`"),
        ] {
            let what = made(&["ggx", "ggx"], CLEAR, &asked, &values).unwrap_err();
            assert!(what.contains(words), "{values:?}: {what}");
        }
        let bright = [&[10.0, 0.15, 4.0][..], &[0.3, 0.05, 2.5]].concat();
        let what = made(&["super-gauss", "abg"], SHEET, &[], &bright).unwrap_err();
        assert!(what.contains("more than all"), "{what}");
        let of = ["ggx".to_owned()];
        let other = Choice { of: &of, ..Choice::new("ggx", CLEAR) };
        assert!(other.method().is_err());
    }

    #[test]
    fn a_fit_takes_the_narrower_law_first() {
        let of = vec!["ggx".to_owned(); 2];
        let choice = Choice { of: &of, ordered: true, ..Choice::new("mix", CLEAR) };
        let method = choice.method().unwrap();
        assert!(method.boundary(&[0.1, 0.4, 0.3], CLEAR).is_ok());
        assert!(method.boundary(&[0.4, 0.1, 0.3], CLEAR).is_err());
        assert_eq!(method.label(), "mix (ggx + ggx)");
    }
}
