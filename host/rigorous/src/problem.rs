//! What is to be solved, and what is refused.

use thiserror::Error;

use crate::profile::Profile;

/// Where light comes from, or goes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// Above the surface.
    Air,
    /// Below the surface.
    Dielectric,
}

impl Side {
    /// The medium on the other side of the surface.
    pub fn other(self) -> Self {
        match self {
            Self::Air => Self::Dielectric,
            Self::Dielectric => Self::Air,
        }
    }
}

/// Light on a periodic surface: its order's tangential wavenumber is `2 pi order / period`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Incidence {
    /// The medium that the light comes from.
    pub side: Side,
    /// Positive: the light travels towards +x.
    pub order: i32,
}

/// A dielectric with grooves below air.
#[derive(Clone, Debug)]
pub struct Problem {
    profile: Profile,
    index: f64,
    wavelength_um: f64,
}

/// Why there is no solution.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum RigorousError {
    /// An index that is not that of a denser dielectric.
    #[error("the index of the dielectric is from 1.0001 to 10, not {0}")]
    Index(f64),
    /// No wavelength.
    #[error("the wavelength in vacuum is a finite length above 0 um, not {0}")]
    Wavelength(f64),
    /// An order leaves along the surface, where the periodic Green's function has a pole.
    #[error(
        "an order of the {period_um} um period grazes the surface in {} at {wavelength_um} um; \
         use a wavelength of {usable_wavelength_um:.6} um or a period of {usable_period_um:.5} um",
        match .side { Side::Air => "air", Side::Dielectric => "the dielectric" }
    )]
    Grazing {
        /// Where it grazes.
        side: Side,
        /// The period asked for, um.
        period_um: f64,
        /// The wavelength asked for, um.
        wavelength_um: f64,
        /// The nearest wavelength that is well off, at the same period.
        usable_wavelength_um: f64,
        /// The nearest period that is well off, at the same wavelength.
        usable_period_um: f64,
    },
    /// An incidence beyond 90 degrees.
    #[error("incidence of order {order} does not travel: the last order of this side is {last}")]
    Incidence {
        /// The order asked for.
        order: i32,
        /// The highest order that travels.
        last: i32,
    },
    /// More nodes than can be afforded.
    #[error(
        "{nodes} nodes would be needed, above the limit of {limit}; take a shorter period or a smoother profile"
    )]
    TooManyNodes {
        /// Nodes needed.
        nodes: usize,
        /// Nodes allowed.
        limit: usize,
    },
    /// More nodes did not help.
    #[error(
        "with {nodes} nodes the balance of energy is still off by {energy_error:.1e}, where {tolerance:.1e} is asked for; the profile is too rough or too steep"
    )]
    Unsettled {
        /// Nodes of the last attempt.
        nodes: usize,
        /// Its error of the balance of energy.
        energy_error: f64,
        /// What was asked for.
        tolerance: f64,
    },
    /// Profiles of an ensemble that scatter into different directions.
    #[error(
        "profile {at} of the ensemble has a period of {period_um} um, the first one {first_um} um; all have to agree"
    )]
    Periods {
        /// Which profile, from 0.
        at: usize,
        /// Its period, um.
        period_um: f64,
        /// The period of the first profile, um.
        first_um: f64,
    },
    /// An ensemble of less than two.
    #[error("an ensemble needs at least two profiles that are solved, in two blocks")]
    NoEnsemble,
    /// The watcher ended the work.
    #[error("the solution was stopped before its end")]
    Stopped,
}

/// How far, in orders, the horizon must be from the nearest order.
const OFF: f64 = 1e-3;
/// How far it is after the correction that an error proposes.
const WELL_OFF: f64 = 2e-2;

impl Problem {
    /// A profile above which there is air; `index` of the dielectric below, wavelength in vacuum in um.
    ///
    /// # Errors
    /// An index or a wavelength out of range, or an order that grazes the surface: `period / wavelength` or `index period /
    /// wavelength` within 0.001 of an integer.
    pub fn new(profile: Profile, index: f64, wavelength_um: f64) -> Result<Self, RigorousError> {
        if !(1.0001..=10.0).contains(&index) {
            return Err(RigorousError::Index(index));
        }
        if !(wavelength_um.is_finite() && wavelength_um > 0.0) {
            return Err(RigorousError::Wavelength(wavelength_um));
        }
        let problem = Self { profile, index, wavelength_um };
        match [Side::Air, Side::Dielectric].into_iter().find(|side| problem.off(*side) < OFF) {
            None => Ok(problem),
            Some(side) => Err(problem.grazing(side)),
        }
    }

    /// The profile.
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// The index of the dielectric.
    pub fn index(&self) -> f64 {
        self.index
    }

    /// The wavelength in vacuum, um.
    pub fn wavelength_um(&self) -> f64 {
        self.wavelength_um
    }

    /// The index of the medium of a side.
    pub fn index_of(&self, side: Side) -> f64 {
        match side {
            Side::Air => 1.0,
            Side::Dielectric => self.index,
        }
    }

    /// The highest order that travels in the medium of a side.
    pub fn last_order(&self, side: Side) -> i32 {
        self.horizon(side).floor() as i32
    }

    /// The sine of the angle of an order from the normal, in the medium of a side.
    pub fn sine(&self, side: Side, order: i32) -> f64 {
        f64::from(order) / self.horizon(side)
    }

    /// The order, not an integer, that would leave along the surface.
    fn horizon(&self, side: Side) -> f64 {
        self.index_of(side) * self.profile.period_um() / self.wavelength_um
    }

    /// The distance of the horizon from the nearest order.
    fn off(&self, side: Side) -> f64 {
        let horizon = self.horizon(side);
        (horizon - horizon.round()).abs()
    }

    fn grazing(&self, side: Side) -> RigorousError {
        let period_um = self.profile.period_um();
        let ratio = period_um / self.wavelength_um;
        let well = |ratio: f64| {
            [1.0, self.index].iter().all(|n| (n * ratio - (n * ratio).round()).abs() >= WELL_OFF)
        };
        let usable = (1..10_000)
            .flat_map(|step| [1.0, -1.0].map(|sign| ratio + sign * 1e-3 * f64::from(step)))
            .find(|ratio| *ratio > 0.0 && well(*ratio))
            .unwrap_or(ratio);
        RigorousError::Grazing {
            side,
            period_um,
            wavelength_um: self.wavelength_um,
            usable_wavelength_um: period_um / usable,
            usable_period_um: usable * self.wavelength_um,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Problem, RigorousError, Side};
    use crate::profile::Profile;

    #[test]
    fn a_grazing_order_is_refused_with_a_way_out() {
        let profile = |period| Profile::new(vec![0.0; 8], period).unwrap();
        let error = Problem::new(profile(5.5), 1.49, 0.55).unwrap_err();
        let RigorousError::Grazing { side, usable_period_um, usable_wavelength_um, .. } = error
        else {
            panic!("{error}");
        };
        assert_eq!(side, Side::Air);
        assert!(Problem::new(profile(usable_period_um), 1.49, 0.55).is_ok());
        assert!(Problem::new(profile(5.5), 1.49, usable_wavelength_um).is_ok());
        assert!((usable_period_um / 5.5 - 1.0).abs() < 0.03);
        let period = 0.55 * 15.0 / 1.49;
        let error = Problem::new(profile(period), 1.49, 0.55).unwrap_err();
        assert!(matches!(error, RigorousError::Grazing { side: Side::Dielectric, .. }));
    }

    #[test]
    fn a_problem_without_light_is_refused() {
        let profile = Profile::new(vec![0.0; 8], 1.0).unwrap();
        assert!(matches!(Problem::new(profile.clone(), 1.0, 0.55), Err(RigorousError::Index(_))));
        assert!(matches!(Problem::new(profile, 1.5, 0.0), Err(RigorousError::Wavelength(_))));
    }
}
