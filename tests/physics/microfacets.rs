//! Anisotropic microfacets against figures of an independent closed form and of Mitsuba 3.

use asperity_core::bsdf::{Bsdf, Masking, Microfacet};
use asperity_core::direction::Direction;
use asperity_core::math::Real;
use asperity_core::ndf::stretched::Stretched;
use asperity_core::ndf::student::Student;
use asperity_core::quantity::{Alpha, RelativeIor};
use asperity_tests::data;

/// What a facet at grazing incidence loses of `f |cos|` where directions are rounded to single precision, 1/sr: one pair has one.
const GRAZING: f64 = 2e-7;

/// Relative errors of `f |cos|` with independent and with correlated masking, and of the density of samples.
fn errors<T: Real>(row: &[f64]) -> [f64; 3] {
    let &[x, y, psi_deg, n, ix, iy, iz, ox, oy, oz, _, pdf, separable, correlated] = row else {
        panic!("{row:?}");
    };
    let widths = [x, y].map(|a| Alpha::new(a).unwrap());
    let facets: Stretched<f64, Student<f64>> =
        Stretched::student(widths, 2.0, psi_deg.to_radians()).unwrap();
    let law = Microfacet::new(facets, RelativeIor::new(n).unwrap()).cast::<T>();
    let direction = |x: f64, y: f64, z: f64| {
        let [x, y, z] = Direction::new(x, y, z).unwrap().xyz().map(T::from_f64);
        Direction::from_unit(x, y, z)
    };
    let (wi, wo) = (direction(ix, iy, iz), direction(ox, oy, oz));
    let both = law.with_masking(Masking::Correlated);
    let pairs =
        [(law.ars(wi, wo), separable), (both.ars(wi, wo), correlated), (law.pdf(wi, wo), pdf)];
    pairs.map(|(got, want)| ((got.to_f64() - want).abs() - GRAZING).max(0.0) / want)
}

#[test]
fn anisotropic_ggx_agrees_with_an_independent_closed_form_and_mitsuba() {
    let Some(path) = data::find("reference/models/aniso_ggx_mitsuba.csv") else { return };
    let text = std::fs::read_to_string(path).unwrap();
    let numbers = text.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit()));
    let (mut rows, mut worst) = (0, [[0.0_f64; 3]; 2]);
    for line in numbers {
        let row: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        for (worst, found) in worst.iter_mut().zip([errors::<f64>(&row), errors::<f32>(&row)]) {
            for (worst, found) in worst.iter_mut().zip(found) {
                *worst = worst.max(found);
            }
        }
        rows += 1;
    }
    println!("{rows} rows of anisotropic GGX, double then single: {worst:?}");
    assert!(rows > 100);
    let [double, single] = worst;
    assert!(double[0] < 1.5e-4 && double[1] < 1.5e-4 && double[2] < 1e-3, "{double:?}");
    assert!(single[0] < 1.5e-4 && single[1] < 1.5e-4 && single[2] < 1e-3, "{single:?}");
}
