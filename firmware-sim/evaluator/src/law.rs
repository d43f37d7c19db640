//! The law this firmware evaluates, as a function of two vectors.

#[cfg(feature = "ggx")]
pub(crate) use ggx::law;
#[cfg(all(feature = "normals", not(feature = "ggx")))]
pub(crate) use normals::law;
#[cfg(all(feature = "table", not(any(feature = "ggx", feature = "normals"))))]
pub(crate) use table::law;

#[cfg(feature = "ggx")]
mod ggx {
    use asperity_core::bsdf::{Bsdf as _, Ggx};
    use asperity_core::direction::Direction;
    use asperity_core::quantity::{Alpha, RelativeIor};

    pub(crate) fn law() -> Option<impl Fn([f32; 3], [f32; 3]) -> Option<f32>> {
        let law = Ggx::new(Alpha::new(0.25).ok()?, RelativeIor::constant(1.49)?);
        let w = |[x, y, z]: [f32; 3]| Direction::new(x, y, z);
        Some(move |wi, wo| Some(law.eval(w(wi)?, w(wo)?)))
    }
}

#[cfg(all(feature = "normals", not(feature = "ggx")))]
mod normals {
    use asperity_core::bsdf::{Bsdf as _, Normals};
    use asperity_core::direction::Direction;
    use asperity_core::math::Fast;
    use asperity_core::ndf::law::{Law, Profile};
    use asperity_core::ndf::normals::NormalDensity;
    use asperity_core::quantity::RelativeIor;

    pub(crate) fn law() -> Option<impl Fn([f32; 3], [f32; 3]) -> Option<f32>> {
        let angles = Law::new(Profile::Gauss, Fast(0.2_f32), Fast(2.0), Fast(0.0)).ok()?;
        let eta = RelativeIor::constant(1.49)?.cast();
        let law: Normals<Fast<f32>, 64> = Normals::new(NormalDensity::new(angles), eta);
        let w = |[x, y, z]: [f32; 3]| Direction::new(Fast(x), Fast(y), Fast(z));
        Some(move |wi, wo| Some(law.eval(w(wi)?, w(wo)?).0))
    }
}

#[cfg(all(feature = "table", not(any(feature = "ggx", feature = "normals"))))]
mod table {
    use asperity_core::bsdf::Bsdf as _;
    use asperity_core::direction::Direction;

    use crate::example::TABLE;

    #[expect(clippy::unnecessary_wraps, reason = "as the laws that are made at start-up")]
    pub(crate) fn law() -> Option<impl Fn([f32; 3], [f32; 3]) -> Option<f32>> {
        let w = |[x, y, z]: [f32; 3]| Direction::new(x, y, z);
        Some(move |wi, wo| Some(TABLE.eval(w(wi)?, w(wo)?)))
    }
}
