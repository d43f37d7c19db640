//! The two laws in closed form, and what is asked of any law.

use asperity_core::bsdf::{Bsdf, Ggx, Normals, Scatter, Scattered};
use asperity_core::direction::Direction;
use asperity_core::math::Fast;
use asperity_core::ndf::law::{Law as Angles, LawError};
use asperity_core::ndf::normals::NormalDensity;
use asperity_core::quantity::{Alpha, RelativeIor};

use crate::options::{self, AsperityQuantity as Quantity, AsperityTier as Tier};
use crate::status::AsperityStatus as Status;

/// Nodes of the quantiles of a `Normals`.
const NODES: usize = 64;

/// A scattered ray.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AsperityRay {
    /// Direction, away from the surface, on either side; zeros for a lost ray.
    pub wo: [f32; 3],
    /// Flux it carries away for unit flux in; 0 for a lost ray.
    pub weight: f32,
}

impl AsperityRay {
    /// No ray.
    pub(crate) const LOST: Self = Self { wo: [0.0; 3], weight: 0.0 };
}

/// What the border asks of a law.
pub(crate) trait Law {
    fn value(&self, what: Quantity, wi: Direction<f32>, wo: Direction<f32>) -> f32;
    fn draw(&self, wi: Direction<f32>, uniform: &mut impl FnMut() -> f32) -> AsperityRay;
}

/// A direction from a vector of any length.
#[cfg_attr(target_arch = "arm", inline(never))]
#[cfg_attr(not(target_arch = "arm"), inline)]
pub(crate) fn direction([x, y, z]: [f32; 3]) -> Result<Direction<f32>, Status> {
    let finite = x.is_finite() && y.is_finite() && z.is_finite();
    Direction::new(x, y, z).ok_or(if finite { Status::ZeroVector } else { Status::NotFinite })
}

/// The value for a pair of vectors of any length.
#[inline(always)]
pub(crate) fn evaluate(
    law: &impl Law,
    what: Quantity,
    wi: [f32; 3],
    wo: [f32; 3],
) -> Result<f32, Status> {
    Ok(law.value(what, direction(wi)?, direction(wo)?))
}

/// Any BSDF of single precision.
#[inline(always)]
pub(crate) fn exact_value(
    bsdf: &impl Bsdf<f32>,
    what: Quantity,
    wi: Direction<f32>,
    wo: Direction<f32>,
) -> f32 {
    match what {
        Quantity::Eval => bsdf.eval(wi, wo),
        Quantity::Ars => bsdf.ars(wi, wo),
        Quantity::Pdf => bsdf.pdf(wi, wo),
    }
}

/// The same on the fast tier.
#[inline(always)]
pub(crate) fn fast_value(
    bsdf: &impl Bsdf<Fast<f32>>,
    what: Quantity,
    wi: Direction<f32>,
    wo: Direction<f32>,
) -> f32 {
    let (wi, wo) = (fast(wi), fast(wo));
    match what {
        Quantity::Eval => bsdf.eval(wi, wo),
        Quantity::Ars => bsdf.ars(wi, wo),
        Quantity::Pdf => bsdf.pdf(wi, wo),
    }
    .0
}

/// A ray of any law.
pub(crate) fn exact_ray(
    law: &impl Scatter<f32>,
    wi: Direction<f32>,
    uniform: &mut impl FnMut() -> f32,
) -> AsperityRay {
    law.sample(wi, uniform)
        .map_or(AsperityRay::LOST, |Scattered { wo, weight }| AsperityRay { wo: wo.xyz(), weight })
}

/// The same on the fast tier.
pub(crate) fn fast_ray(
    law: &impl Scatter<Fast<f32>>,
    wi: Direction<f32>,
    uniform: &mut impl FnMut() -> f32,
) -> AsperityRay {
    let ray = law.sample(fast(wi), &mut || Fast(uniform()));
    ray.map_or(AsperityRay::LOST, |Scattered { wo, weight }| AsperityRay {
        wo: wo.xyz().map(|x| x.0),
        weight: weight.0,
    })
}

#[inline(always)]
fn fast(w: Direction<f32>) -> Direction<Fast<f32>> {
    let [x, y, z] = w.xyz();
    Direction::from_unit(Fast(x), Fast(y), Fast(z))
}

/// GGX. Its values need no elementary function, so only samples differ between the tiers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GgxLaw {
    law: Ggx<f32>,
    tier: Tier,
}

impl GgxLaw {
    #[inline(always)]
    pub(crate) fn new(alpha: f32, eta: f32, tier: u32) -> Result<Self, Status> {
        let (alpha, tier) = (Alpha::new(alpha)?, options::tier(tier)?);
        // last, so that its numbers are not copied about, for which a device would need a `memcpy`
        Ok(Self { law: Ggx::new(alpha, RelativeIor::new(eta)?), tier })
    }
}

impl Law for GgxLaw {
    #[inline(always)]
    fn value(&self, what: Quantity, wi: Direction<f32>, wo: Direction<f32>) -> f32 {
        exact_value(&self.law, what, wi, wo)
    }

    fn draw(&self, wi: Direction<f32>, uniform: &mut impl FnMut() -> f32) -> AsperityRay {
        let Ggx { alpha, eta } = self.law;
        match (self.tier, Alpha::new(Fast(alpha.get()))) {
            (Tier::Fast, Ok(alpha)) => fast_ray(&Ggx::new(alpha, eta.cast()), wi, uniform),
            _ => exact_ray(&self.law, wi, uniform),
        }
    }
}

/// One facet at each hit, by a law of facet angles.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::large_enum_variant, reason = "both are of one size")]
pub(crate) enum NormalsLaw {
    Fast(Normals<Fast<f32>, NODES>),
    Exact(Normals<f32, NODES>),
}

impl NormalsLaw {
    pub(crate) fn new(
        profile: u32,
        [delta, n, theta0]: [f32; 3],
        eta: f32,
        tier: u32,
    ) -> Result<Self, Status> {
        let (profile, tier, eta) =
            (options::profile(profile)?, options::tier(tier)?, RelativeIor::new(eta)?);
        if !(delta.is_finite() && n.is_finite() && theta0.is_finite()) {
            return Err(Status::NotFinite);
        }
        let outside = |_: LawError| Status::OutOfDomain;
        Ok(match tier {
            Tier::Fast => {
                let law = Angles::new(profile, Fast(delta), Fast(n), Fast(theta0));
                let density = NormalDensity::new(law.map_err(outside)?);
                Self::Fast(Normals::new(density, eta.cast()))
            }
            Tier::Exact => {
                let law = Angles::new(profile, delta, n, theta0).map_err(outside)?;
                Self::Exact(Normals::new(NormalDensity::new(law), eta))
            }
        })
    }
}

impl Law for NormalsLaw {
    fn value(&self, what: Quantity, wi: Direction<f32>, wo: Direction<f32>) -> f32 {
        match self {
            Self::Fast(law) => fast_value(law, what, wi, wo),
            Self::Exact(law) => exact_value(law, what, wi, wo),
        }
    }

    fn draw(&self, wi: Direction<f32>, uniform: &mut impl FnMut() -> f32) -> AsperityRay {
        match self {
            Self::Fast(law) => fast_ray(law, wi, uniform),
            Self::Exact(law) => exact_ray(law, wi, uniform),
        }
    }
}
