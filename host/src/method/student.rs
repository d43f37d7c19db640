//! Method `student`: microfacets with Student-t slopes \[Ribardiere et al. 2017\].
//!
//! `sigma` is the width, `gamma` the tail: 2 is `ggx`, large values are `beckmann`. Between them lie most ground and
//! etched surfaces. Closed form. Optional are two widths, `sigma_x` and `sigma_y`, along axes turned by `orientation`.

use asperity_core::bsdf::Microfacet;
use asperity_core::ndf::any::AnyDensity;
use asperity_core::ndf::stretched::Stretched;
use asperity_core::ndf::student::Student;

use super::kind::Kind;
use super::oriented::{OF_SIGMA, ORIENTATION, Oriented, SIGMA_X, SIGMA_Y, is_asked};
use super::{Body, BuildError, Method, Parameter, Scale, alpha};
use crate::boundary::Boundary;

/// The method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StudentMethod {
    /// Whether it has two widths and an orientation.
    pub oriented: bool,
}

const GAMMA: Parameter = Parameter::new("gamma", "", (1.55, 100.0), Scale::Log, &[2.0, 6.0]);
static PARAMETERS: [Parameter; 2] =
    [Parameter::new("sigma", "", (1e-4, 5.0), Scale::Log, &[0.004, 0.02, 0.08, 0.25, 0.8]), GAMMA];
static ORIENTED: [Parameter; 4] = [SIGMA_X, SIGMA_Y, ORIENTATION, GAMMA];

/// Its description and needs.
pub(super) const KIND: Kind = Kind {
    name: "student",
    summary: "microfacets with a fitted tail between and beyond GGX and Beckmann, closed form",
    optional: OF_SIGMA,
    make: |choice| Ok(Box::new(StudentMethod { oriented: is_asked(OF_SIGMA, choice.asked) })),
    ..Kind::CLOSED
};

impl Method for StudentMethod {
    fn name(&self) -> &'static str {
        KIND.name
    }

    fn references(&self) -> &'static [&'static str] {
        &["Ribardiere et al. 2017", "Walter2007"]
    }

    fn parameters(&self) -> &[Parameter] {
        if self.oriented { &ORIENTED } else { &PARAMETERS }
    }

    fn boundary(&self, values: &[f64], body: Body) -> Result<Boundary, BuildError> {
        let value = |k: usize, name| values.get(k).copied().ok_or(BuildError::Missing(name));
        let refused = |gamma: f64| BuildError::OutOfDomain {
            name: "gamma",
            value: gamma,
            least: Student::<f64>::LEAST,
            most: Student::<f64>::MOST,
            unit: "",
        };
        let density = if self.oriented {
            let Oriented { widths, psi } = Oriented::of(&ORIENTED, values)?;
            let gamma = value(3, "gamma")?;
            let facets = Stretched::student(widths, gamma, psi).map_err(|_| refused(gamma))?;
            AnyDensity::StretchedStudent(facets)
        } else {
            let (sigma, gamma) = (value(0, "sigma")?, value(1, "gamma")?);
            let facets = Student::new(alpha("sigma", sigma)?, gamma).map_err(|_| refused(gamma))?;
            AnyDensity::Student(facets)
        };
        Ok(Boundary::Microfacet(Box::new(Microfacet::new(density, body.eta()?))))
    }
}

#[cfg(test)]
mod tests {
    use super::StudentMethod;
    use super::{Body, Method};
    use crate::boundary::Boundary;

    const PLAIN: StudentMethod = StudentMethod { oriented: false };

    #[test]
    fn values_outside_the_domain_are_refused_by_name() {
        let body = Body::Dielectric { ior: 1.49 };
        assert!(PLAIN.boundary(&[0.3, 3.0], body).is_ok());
        for (values, name) in [
            (vec![], "`sigma`"),
            (vec![0.3], "`gamma`"),
            (vec![-0.3, 3.0], "`sigma`"),
            (vec![0.3, 1.5], "`gamma`"),
            (vec![0.3, f64::NAN], "`gamma`"),
        ] {
            let text = PLAIN.boundary(&values, body).unwrap_err().to_string();
            assert!(text.contains(name), "{text}");
        }
        assert!(PLAIN.boundary(&[0.3, 3.0], Body::Opaque).is_err());
    }

    #[test]
    fn a_tail_of_two_is_ggx() {
        use asperity_core::direction::Direction;
        let body = Body::Dielectric { ior: 1.49 };
        let student = PLAIN.boundary(&[0.3, 2.0], body).unwrap();
        let ggx = super::super::GgxMethod::new(body).boundary(&[0.3], body).unwrap();
        let wi = Direction::from_angles(0.9, 0.0);
        for k in 0..30 {
            let wo = Direction::from_angles(0.1 * f64::from(k), 2.5);
            let of = |b: &Boundary| b.eval(wi, wo).unwrap();
            assert!((of(&student) - of(&ggx)).abs() <= 1e-11 * of(&ggx), "{k}");
        }
    }

    #[test]
    fn two_widths_are_parameters_of_their_own_and_equal_ones_are_the_plain_law() {
        use asperity_core::direction::Direction;
        let body = Body::Dielectric { ior: 1.49 };
        let oriented = StudentMethod { oriented: true };
        let two = oriented.boundary(&[0.3, 0.3, 20.0, 3.0], body).unwrap();
        let one = PLAIN.boundary(&[0.3, 3.0], body).unwrap();
        let (wi, wo) = (Direction::from_angles(0.9, 0.4), Direction::from_angles(2.5, 2.0));
        let of = |b: &Boundary| b.eval(wi, wo).unwrap();
        assert!((of(&two) - of(&one)).abs() <= 1e-12 * of(&one));
        for (values, name) in [
            (vec![0.3], "`orientation`"),
            (vec![0.3, -1.0, 0.0, 3.0], "`sigma_y`"),
            (vec![0.3, 0.1, f64::NAN, 3.0], "`orientation`"),
            (vec![0.3, 0.1, 0.0, 1.0], "`gamma`"),
            (vec![0.3, 0.1, 0.0], "`gamma`"),
        ] {
            let text = oriented.boundary(&values, body).unwrap_err().to_string();
            assert!(text.contains(name), "{text}");
        }
    }
}
