//! The registry of methods.
//!
//! A new method is a file with a [`Kind`], and a line in [`KINDS`]; names, errors, the flags of the command line and
//! the methods of comparisons come from here.

use super::bouncing::Bouncing;
use super::kind::{Choice, GGX_MS, Kind, Lack, Origin};
use super::{
    Body, Bounces, Method, beckmann, ggx, heights, measured_hybrid, measured_ray, measured_wave,
    mix, normals, slopes, smith_normals, student, tail,
};

/// All methods, in the order of tables.
pub const KINDS: [Kind; 15] = [
    ggx::KIND,
    normals::KIND,
    heights::KIND,
    measured_ray::KIND,
    measured_wave::KIND,
    measured_hybrid::KIND,
    beckmann::KIND,
    student::KIND,
    smith_normals::KIND,
    slopes::KIND,
    tail::ABG,
    tail::HARVEY,
    tail::K_CORRELATION,
    tail::SUPER_GAUSS,
    mix::KIND,
];

impl Kind {
    /// The method of a name.
    ///
    /// # Errors
    /// [`Lack::Method`], which lists the names.
    pub fn named(name: &str) -> Result<&'static Self, Lack> {
        static ALL: [Kind; KINDS.len()] = KINDS;
        let unknown =
            || Lack::Method { name: name.into(), known: Self::names(|_| true).join(", ") };
        let name = if name == GGX_MS { ggx::KIND.name } else { name };
        ALL.iter().find(|kind| kind.name == name).ok_or_else(unknown)
    }

    /// A method, and those that it is made of.
    ///
    /// # Errors
    /// [`Lack::Method`], which lists the names.
    pub fn with_parts(name: &str, of: &[String]) -> Result<Vec<&'static Self>, Lack> {
        let names = std::iter::once(name).chain(of.iter().map(String::as_str));
        names.map(Self::named).collect()
    }

    /// The names of all methods that satisfy a condition.
    pub fn names(of: impl Fn(&Self) -> bool) -> Vec<&'static str> {
        KINDS.iter().filter(|kind| of(kind)).map(|kind| kind.name).collect()
    }

    /// The five methods of the paper.
    pub fn of_paper() -> Vec<&'static str> {
        Self::names(|kind| kind.origin == Origin::Paper)
    }
}

impl Choice<'_> {
    /// The method.
    ///
    /// # Errors
    /// What the method lacks.
    pub fn method(&self) -> Result<Box<dyn Method>, Lack> {
        let kind = Kind::named(self.name)?;
        self.profile()?;
        if kind.of_parts {
            return (kind.make)(self);
        }
        if !self.of.is_empty() {
            return Err(Lack::NotMixed(kind.name));
        }
        if self.body == Body::Opaque && !kind.takes_opaque {
            let others = in_words(&Kind::names(|kind| kind.takes_opaque));
            return Err(Lack::Index { method: kind.name, others });
        }
        if matches!(self.body, Body::Sheet { .. }) && !kind.describes_sheet {
            let others = in_words(&Kind::names(|kind| kind.describes_sheet));
            return Err(Lack::Sheet { method: kind.name, others });
        }
        match self.bounces(kind)? {
            Bounces::One => (kind.make)(self),
            bounces => Ok(Box::new(Bouncing { of: (kind.make)(self)?, bounces })),
        }
    }
}

/// Names as a list in a sentence: `a`, `a and b`, `a, b and c`.
pub fn in_words(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [one] => (*one).into(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use asperity_core::bsdf::Lobe;

    use super::{Body, Choice, KINDS, Kind, in_words};

    #[test]
    fn what_is_made_has_the_name_and_the_optional_parameters_of_its_kind() {
        let clear = Body::Dielectric { ior: 1.49 };
        for kind in &KINDS {
            let asked = |name: &str| kind.optional.contains(&name);
            let of = if kind.of_parts { vec!["ggx".to_owned(); 2] } else { Vec::new() };
            let choice = Choice {
                of: &of,
                asked: &asked,
                lobe: Some(Lobe::Transmission),
                wavelength_nm: Some(550.0),
                ..Choice::new(kind.name, clear)
            };
            match choice.method() {
                Ok(method) => {
                    assert_eq!(method.name(), kind.name);
                    let names: Vec<&str> = method.parameters().iter().map(|p| p.name).collect();
                    assert!(kind.optional.iter().all(|o| names.contains(o)), "{names:?}");
                    assert_eq!(method.profile().is_some(), kind.has_profile);
                    assert_eq!(method.is_traced(), kind.traced);
                }
                Err(lack) => assert!(kind.needs_map, "{}: {lack}", kind.name),
            }
        }
        assert_eq!(Kind::of_paper().len(), 5);
    }

    #[test]
    fn names_stand_in_a_sentence() {
        assert_eq!(in_words(&["a"]), "a");
        assert_eq!(in_words(&["a", "b", "c"]), "a, b and c");
    }
}
