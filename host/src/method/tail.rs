//! Methods `abg`, `harvey`, `k-correlation` and `super-gauss`: scatter about the specular direction, as optical design
//! programs take it.
//!
//! Each describes one lobe by the distance from the specular direction in direction cosines, of the sheet as it is measured,
//! or with `--body plate` of the rough face inside. They follow what was measured and say nothing of why; of a sheet they
//! give no law from inside. What is not scattered stays specular; with the parameter `specular` that share is fitted.

use asperity_core::bsdf::tail::{Shape, ShapeError};
use asperity_core::bsdf::{Lobe, ShiftInvariant};

use super::kind::{Choice, Kind, Lack};
use super::{Body, BuildError, Method, Parameter, Scale};
use crate::boundary::Boundary;

/// Which of the four.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    Abg,
    Harvey,
    KCorrelation,
    SuperGauss,
}

/// One of the methods, for one lobe.
#[derive(Clone, Debug, PartialEq)]
pub struct TailMethod {
    form: Form,
    lobe: Lobe,
    /// Wavelength of the spectrum of roughness, nm.
    wavelength_nm: Option<f64>,
    parameters: Vec<Parameter>,
}

const fn level(name: &'static str, unit: &'static str, bounds: (f64, f64)) -> Parameter {
    Parameter::new(name, unit, bounds, Scale::Log, &[1e-3]).level()
}

const SPECULAR: Parameter =
    Parameter::new("specular", "", (1e-6, 1.0), Scale::Log, &[0.05]).or_zero().linear();

static OF_ABG: [Parameter; 3] = [
    level("A", "1/sr", (1e-12, 1e4)),
    Parameter::new("B", "", (1e-14, 10.0), Scale::Log, &[1e-5, 1e-3, 0.05]),
    Parameter::new("g", "", (0.2, 15.0), Scale::Linear, &[1.8, 4.0]),
];
/// Sharpness of the shoulder; 2 is none of its own.
const SHOULDER: Parameter =
    Parameter::new("m", "", (0.5, 60.0), Scale::Log, &[1.5, 8.0]).or_none(2.0);

static OF_HARVEY: [Parameter; 3] = [
    level("b0", "1/sr", (1e-9, 1e7)),
    Parameter::new("L", "", (1e-5, 10.0), Scale::Log, &[0.002, 0.02, 0.15]),
    Parameter::new("S", "", (-40.0, -0.1), Scale::Linear, &[-1.8, -6.0]),
];
static OF_SPECTRUM: [Parameter; 3] = [
    level("A", "um^4", (1e-12, 1e6)),
    Parameter::new("B", "um", (1e-2, 1e5), Scale::Log, &[3.0, 30.0, 300.0]),
    Parameter::new("C", "", (0.1, 20.0), Scale::Linear, &[1.8, 4.0]),
];
static OF_SUPER_GAUSS: [Parameter; 3] = [
    level("A", "1/sr", (1e-9, 1e7)),
    Parameter::new("w", "", (1e-5, 2.0), Scale::Log, &[0.003, 0.03, 0.2]),
    Parameter::new("p", "", (0.2, 60.0), Scale::Log, &[1.0, 3.0]),
];

impl Form {
    fn name(self) -> &'static str {
        match self {
            Self::Abg => ABG.name,
            Self::Harvey => HARVEY.name,
            Self::KCorrelation => K_CORRELATION.name,
            Self::SuperGauss => SUPER_GAUSS.name,
        }
    }

    fn parameters(self) -> &'static [Parameter; 3] {
        match self {
            Self::Abg => &OF_ABG,
            Self::Harvey => &OF_HARVEY,
            Self::KCorrelation => &OF_SPECTRUM,
            Self::SuperGauss => &OF_SUPER_GAUSS,
        }
    }

    fn method(self, choice: &Choice<'_>) -> Result<Box<dyn Method>, Lack> {
        let lobe = choice.need_lobe(Kind::named(self.name())?)?;
        let wavelength_nm = match self {
            Self::KCorrelation => Some(choice.wavelength_nm.ok_or(Lack::Wavelength(self.name()))?),
            _ => None,
        };
        let specular = (choice.asked)(SPECULAR.name).then_some(SPECULAR);
        let shoulder = (self == Self::Harvey && (choice.asked)(SHOULDER.name)).then_some(SHOULDER);
        let parameters =
            self.parameters().iter().cloned().chain(shoulder).chain(specular).collect();
        Ok(Box::new(TailMethod { form: self, lobe, wavelength_nm, parameters }))
    }
}

const TAIL: Kind =
    Kind { takes_opaque: true, describes_sheet: true, optional: &["specular"], ..Kind::CLOSED };

/// `A / (B + x^g)`.
pub(super) const ABG: Kind = Kind {
    name: "abg",
    summary: "A / (B + x^g) about the specular direction, of the sheet as measured",
    make: |choice| Form::Abg.method(choice),
    ..TAIL
};

/// `b0 (1 + (x / L)^m)^(S / m)`.
pub(super) const HARVEY: Kind = Kind {
    name: "harvey",
    summary: "Harvey's law, b0 (1 + (x / L)^m)^(S / m) with m = 2 or fitted, of the sheet as measured",
    make: |choice| Form::Harvey.method(choice),
    optional: &["m", "specular"],
    ..TAIL
};

/// A spectrum of roughness.
pub(super) const K_CORRELATION: Kind = Kind {
    name: "k-correlation",
    summary: "scatter of a slight roughness with the spectrum A / (1 + (B f)^2)^(C / 2), of the sheet as measured",
    make: |choice| Form::KCorrelation.method(choice),
    ..TAIL
};

/// `A exp(-(x / w)^p)`.
pub(super) const SUPER_GAUSS: Kind = Kind {
    name: "super-gauss",
    summary: "A exp(-(x / w)^p) about the specular direction, flat-topped for large p, of the sheet as measured",
    make: |choice| Form::SuperGauss.method(choice),
    ..TAIL
};

impl TailMethod {
    fn shape(&self, values: &[f64], body: Body) -> Result<Shape<f64>, BuildError> {
        let value = |k: usize| {
            let parameter = self.parameters.get(k).map_or("", |p| p.name);
            values.get(k).copied().ok_or(BuildError::Missing(parameter))
        };
        let [a, b, c] = [value(0)?, value(1)?, value(2)?];
        Ok(match self.form {
            Form::Abg => Shape::Abg { a, b, g: c },
            Form::Harvey => {
                Shape::Harvey { b0: a, l: b, s: c, m: self.named("m", values).unwrap_or(2.0) }
            }
            Form::SuperGauss => Shape::SuperGauss { a, w: b, p: c },
            Form::KCorrelation => {
                let wavelength_um =
                    1e-3 * self.wavelength_nm.ok_or(BuildError::Missing("wavelength_nm"))?;
                Shape::k_correlation([a, b, c], wavelength_um, self.contrast(body)?)
            }
        })
    }

    /// The value of an optional parameter, if it is there.
    fn named(&self, name: &str, values: &[f64]) -> Option<f64> {
        self.parameters.iter().zip(values).find(|(p, _)| p.name == name).map(|(_, value)| *value)
    }

    /// The phase that a height of one wavelength makes, over `2 pi`: 2 for a mirror, the difference of the indices in
    /// transmission.
    fn contrast(&self, body: Body) -> Result<f64, BuildError> {
        match (self.lobe, body) {
            (Lobe::Reflection, _) => Ok(2.0),
            (_, Body::Dielectric { ior } | Body::Sheet { ior: Some(ior) }) => Ok((ior - 1.0).abs()),
            (_, Body::Sheet { ior: None } | Body::Opaque) => Err(BuildError::Ior(
                "a spectrum of roughness seen in transmission needs the refractive index".into(),
            )),
        }
    }
}

impl Method for TailMethod {
    fn name(&self) -> &'static str {
        self.form.name()
    }

    fn references(&self) -> &'static [&'static str] {
        match self.form {
            Form::Abg => &["Pfisterer 2011"],
            Form::Harvey => &["Harvey 1976", "Pfisterer 2011"],
            Form::KCorrelation => &["Church and Takacs 1986", "Stover 2012"],
            Form::SuperGauss => &[],
        }
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn boundary(&self, values: &[f64], body: Body) -> Result<Boundary, BuildError> {
        let specular = self.named(SPECULAR.name, values);
        // an opaque body is a sheet that only reflects
        let eta = match body {
            Body::Opaque => Body::Sheet { ior: None }.eta()?,
            body => body.eta()?,
        };
        ShiftInvariant::new(self.shape(values, body)?, self.lobe, eta, specular)
            .map(Boundary::Tail)
            .map_err(|e| match e {
                ShapeError::TooMuch { scattered } => BuildError::TooBright { scattered },
                ShapeError::OutOfDomain { name, value, least, most } => {
                    BuildError::OutOfDomain { name, value, least, most, unit: "" }
                }
            })
    }

    fn lobe(&self) -> Option<Lobe> {
        Some(self.lobe)
    }

    fn wavelength_nm(&self) -> Option<f64> {
        self.wavelength_nm
    }
}

#[cfg(test)]
mod tests {
    use asperity_core::bsdf::Lobe;
    use asperity_core::direction::Direction;

    use super::super::{Body, Choice};
    use crate::boundary::Boundary;

    fn law(name: &str, values: &[f64]) -> Result<Boundary, String> {
        let body = Body::Sheet { ior: Some(1.49) };
        let choice = Choice {
            lobe: Some(Lobe::Transmission),
            wavelength_nm: Some(550.0),
            asked: &|_| values.len() > 3,
            ..Choice::new(name, body)
        };
        choice.method().unwrap().boundary(values, body).map_err(|e| e.to_string())
    }

    #[test]
    fn values_are_those_of_independent_programs() {
        let wi = Direction::normal();
        for (name, values, x, wanted) in [
            ("abg", [0.0025, 0.001, 1.8], 0.5, 0.008_675_296_496),
            ("harvey", [0.1, 0.01, -1.5], 0.3, 0.000_608_073_961_5),
            ("k-correlation", [0.0003, 20.0, 3.0], 0.1, 0.000_576_430_22),
            ("super-gauss", [31.830_988_61, 0.1, 2.0], 0.03, 29.091_333_16),
        ] {
            let wo = Direction::from_unit(x, 0.0, -f64::sqrt(1.0 - x * x));
            let got = law(name, &values).unwrap().eval(wi, wo).unwrap();
            assert!((got / wanted - 1.0).abs() < 1e-8, "{name}: {got}");
        }
    }

    #[test]
    fn what_cannot_be_is_refused_by_name() {
        for (values, words) in [
            (vec![1.0, 0.01, 2.0], "more than all"),
            (vec![0.1, 0.0, 2.0], "`B`"),
            (vec![0.1, 0.1], "`g`"),
            (vec![0.3, 0.1, 2.0, 0.2], "more than all"),
            (vec![0.1, 0.1, 2.0, -0.2], "`specular`"),
        ] {
            let text = law("abg", &values).unwrap_err();
            assert!(text.contains(words), "{values:?}: {text}");
        }
    }
}
