//! How the value of a law of normals is computed from a half vector.

use super::edge::Edges;
use super::law::{Law, Profile};
use crate::math::Real;

/// The computation of a law from a half vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Form<T> {
    /// The normal law about 0: `2^-(halvings t^2)`.
    Normal { halvings: T },
    /// Another power of `t`, by way of `t^2 / delta^2`.
    Power { narrowness: T },
    /// From the angle.
    Angle,
    /// From the angle to an edge, where the law needs more digits than an angle has.
    Edges(Edges<T>),
}

impl<T: Real> Form<T> {
    /// That of a law.
    pub(super) fn of(law: &Law<f64>) -> Self {
        let narrowness = 1.0 / (law.delta() * law.delta());
        let normal = law.profile() == Profile::Gauss && law.n().total_cmp(&2.0).is_eq();
        match Edges::of(law) {
            Some(edges) => Self::Edges(edges),
            None if law.centre() > 0.0 => Self::Angle,
            None if normal => {
                Self::Normal { halvings: T::from_f64(0.5 * narrowness * core::f64::consts::LOG2_E) }
            }
            None => Self::Power { narrowness: T::from_f64(narrowness) },
        }
    }

    /// `F` of the direction of a half vector, from `h_x^2 + h_y^2` and `h_z^2`; where these are not enough, from
    /// the same with their rounding errors.
    #[inline(always)]
    pub(super) fn value(
        &self,
        law: &Law<T>,
        xy2: T,
        z2: T,
        in_two: impl FnOnce() -> [[T; 2]; 2],
    ) -> T {
        match self {
            Self::Normal { halvings } => (T::angle_squared(xy2, z2) * *halvings).halved(),
            Self::Power { narrowness } => {
                let power = T::HALF * law.n();
                law.falls((T::angle_squared(xy2, z2) * *narrowness).pow(power))
            }
            Self::Angle => law.value(xy2.sqrt().atan2(z2.sqrt())),
            Self::Edges(edges) => edges.value(law, in_two()),
        }
    }
}
