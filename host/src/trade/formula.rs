//! The laws in closed form, in any number type.

use asperity_core::bsdf::{AllBounces, Bsdf, Ggx, Microfacet, Normals, OpaqueGgx, ShiftInvariant};
use asperity_core::math::Real;
use asperity_core::ndf::any::AnyDensity;
use asperity_core::ndf::law::Law;
use asperity_core::ndf::normals::NormalDensity;
use asperity_core::quantity::{Alpha, RelativeIor};

/// Nodes of the tables inside `normals` that are measured: what a device has memory for. The model itself has 256.
const NODES: usize = 64;

/// A law that can be had in any number type.
pub(crate) trait Formula {
    /// The law in a number type.
    type In<T: Real>: Bsdf<T> + Sync;

    /// Its parameters rounded; `None` if they leave their domain by it.
    fn of<T: Real>(&self) -> Option<Self::In<T>>;
}

fn number<T: Real>(x: f64) -> T {
    T::from_f64(x)
}

impl Formula for Ggx<f64> {
    type In<T: Real> = Ggx<T>;

    fn of<T: Real>(&self) -> Option<Ggx<T>> {
        let alpha = Alpha::new(number(self.alpha.get())).ok()?;
        Some(Ggx::new(alpha, RelativeIor::new(number(self.eta.get())).ok()?))
    }
}

impl Formula for Normals<f64> {
    type In<T: Real> = Normals<T, NODES>;

    fn of<T: Real>(&self) -> Option<Normals<T, NODES>> {
        let law = self.density.law();
        let [delta, n, centre] = [law.delta(), law.n(), law.centre()].map(number);
        let law = Law::new(law.profile(), delta, n, centre).ok()?;
        Some(Normals::new(NormalDensity::new(law), RelativeIor::new(number(self.eta.get())).ok()?))
    }
}

impl Formula for OpaqueGgx<f64> {
    type In<T: Real> = OpaqueGgx<T>;

    fn of<T: Real>(&self) -> Option<OpaqueGgx<T>> {
        let alpha = Alpha::new(number(self.alpha.get())).ok()?;
        OpaqueGgx::new(alpha, number(self.gain), number(self.lambert))
    }
}

impl Formula for ShiftInvariant<f64> {
    type In<T: Real> = ShiftInvariant<T>;

    fn of<T: Real>(&self) -> Option<Self::In<T>> {
        Some(self.cast())
    }
}

impl Formula for Microfacet<f64, AnyDensity<f64>> {
    type In<T: Real> = Microfacet<T, AnyDensity<T>>;

    fn of<T: Real>(&self) -> Option<Self::In<T>> {
        Some(self.cast())
    }
}

impl Formula for AllBounces<f64, Ggx<f64>> {
    type In<T: Real> = AllBounces<T, Ggx<T>>;

    fn of<T: Real>(&self) -> Option<Self::In<T>> {
        Some(self.cast())
    }
}

impl Formula for AllBounces<f64, Microfacet<f64, AnyDensity<f64>>> {
    type In<T: Real> = AllBounces<T, Microfacet<T, AnyDensity<T>>>;

    fn of<T: Real>(&self) -> Option<Self::In<T>> {
        Some(self.cast())
    }
}
