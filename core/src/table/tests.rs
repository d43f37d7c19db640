//! A table whose values are one constant is GGX, exactly.

use core::f32::consts::FRAC_1_PI;

use super::{
    Arrays, BsdfTable, BsdfTableRef, Fall, Form, Header, LobeHeader, Shape, SideTable, Storage,
    TableError,
};
use crate::bsdf::{Bsdf, Ggx, Lobe, Scatter};
use crate::direction::{Direction, Side};
use crate::math::{Fast, Real};
use crate::quantity::{Alpha, RelativeIor};

const ALPHA: f32 = 0.25;
const SHAPE: Shape = Shape { incidences: 3, azimuths: 2, radii: 4, intervals: 2 };
const VALUES: usize = 4 * SHAPE.values();
const QUANTILES: usize = 4 * SHAPE.quantiles();
const GAINS: usize = 4 * SHAPE.gains();
type Table<S> = BsdfTable<S, VALUES, QUANTILES, GAINS>;

fn header() -> Header {
    let (form, fall) = (Form::Masked, Fall::Fourth);
    let lobe = LobeHeader { shape: SHAPE, form, fall, scale: ALPHA, grazing: 1.0, masking: ALPHA };
    Header {
        eta: RelativeIor::new(1.5).unwrap(),
        opaque: false,
        slope: ALPHA,
        lobes: [Some(lobe); 4],
        fluxes: [2, 2],
        grazing: [0.0; 2],
    }
}

fn quantiles() -> [u16; QUANTILES] {
    core::array::from_fn(|k| [0, 20_000, 65_000][k % 3])
}

fn build<S: Storage>(value: S, change: impl Fn(&mut Header)) -> Result<Table<S>, TableError> {
    let mut header = header();
    change(&mut header);
    BsdfTable::new(
        header,
        Arrays {
            gains: &[FRAC_1_PI / (S::FULL * S::FULL); GAINS],
            values: &[value; VALUES],
            quantiles: &quantiles(),
            leans: &[30; 4 * SHAPE.leans()],
            fluxes: &[[9000, 50_000, 0, 0]; 4],
        },
    )
}

fn directions() -> impl Iterator<Item = (Direction<f64>, Direction<f64>)> {
    (0..400).map(|k| {
        let x = f64::from(k);
        let side = |w: Direction<f64>, down: bool| {
            let [x, y, z] = w.xyz();
            Direction::from_unit(x, y, if down { -z } else { z })
        };
        let wi = Direction::from_angles(0.0039 * x, 0.7 * x);
        let wo = Direction::from_angles((0.0071 * x) % 1.55, 0.7 * x + 3.0 + 0.3 * (1.3 * x).sin());
        (side(wi, k % 2 == 0), side(wo, k % 3 == 0))
    })
}

fn agrees<T: Real, S: Storage>(full: S, tolerance: f64) {
    let table = build(full, |_| ()).unwrap();
    let view = table.view();
    let ggx = Ggx::new(Alpha::new(f64::from(ALPHA)).unwrap(), RelativeIor::new(1.5).unwrap());
    let mut lit = 0;
    for (wi, wo) in directions() {
        let cast = |w: Direction<f64>| {
            let [x, y, z] = w.xyz().map(T::from_f64);
            Direction::from_unit(x, y, z)
        };
        let exact = ggx.eval(wi, wo);
        let f = view.eval(cast(wi), cast(wo)).to_f64();
        assert!((f - exact).abs() <= tolerance * exact + 1e-9, "{wi:?} {wo:?}: {f} {exact}");
        lit += u32::from(exact > 0.0);
    }
    assert!(lit > 200);
}

#[test]
fn one_value_is_ggx_in_every_storage_and_precision() {
    agrees::<f64, u8>(255, 1e-5);
    agrees::<f64, u16>(65_535, 1e-5);
    agrees::<f32, f32>(1.0, 2e-4);
    agrees::<Fast<f32>, u8>(255, 2e-4);
}

#[test]
fn the_weight_of_a_sample_is_ars_over_pdf() {
    for form in [Form::Masked, Form::Drawn, Form::Direct] {
        for fall in [Fall::Fourth, Fall::Second, Fall::Flat] {
            let change = |header: &mut Header| {
                for lobe in header.lobes.iter_mut().flatten() {
                    *lobe = LobeHeader { form, fall, ..*lobe };
                }
            };
            let table = build::<u16>(65_535, change).unwrap();
            let view = table.view();
            let mut seen = 0;
            for (k, (wi, _)) in directions().enumerate() {
                let mut u = 0.17 * k as f64;
                let mut uniform = || {
                    u = (u + 0.618) % 1.0;
                    u
                };
                let Some(s) = view.sample(wi, &mut uniform) else { continue };
                let (ars, pdf) = (view.ars(wi, s.wo), view.pdf(wi, s.wo));
                let off = (ars / pdf - s.weight).abs();
                assert!(off <= 1e-6 * s.weight, "{form:?} {fall:?} {wi:?} {s:?} {ars} {pdf}");
                seen += 1;
            }
            assert!(seen > 150, "{form:?} {seen}");
        }
    }
}

#[test]
fn samples_of_light_along_the_normal_are_unit_vectors() {
    let table = build::<u16>(65_535, |_| ()).unwrap();
    let view = table.view();
    for x in [0.0, 1e-45, 1e-38, -3e-30, 1e-23, -2e-22, 1e-19, 1e-16, 1e-9_f32] {
        for (wi, lobe) in [(1.0, Lobe::Reflection), (-1.0, Lobe::Transmission)]
            .map(|(z, lobe)| (Direction::from_unit(0.6 * x, -0.8 * x, z), lobe))
        {
            let ray = view.sample_lobe(wi, lobe, [0.3, 0.6]).unwrap();
            assert!(
                (ray.wo.dot(ray.wo) - 1.0).abs() < 1e-6 && ray.wo.z().abs() < 0.999,
                "{x} {ray:?}"
            );
        }
    }
}

#[test]
fn extremes_are_finite_and_what_is_left_out_is_dark() {
    let table = build::<u8>(255, |h| h.lobes[3] = None);
    assert_eq!(table.unwrap_err(), TableError::Length);
    let table = build::<u8>(255, |_| ()).unwrap();
    let view = table.view();
    for z in [0.0, 1e-30, 1e-7, -1e-30, 1.0, -1.0, f32::NAN, f32::INFINITY] {
        for x in [0.0, 1.0, f32::NAN] {
            let (wi, up) = (Direction::from_unit(x, 0.0, z), Direction::normal());
            for (a, b) in [(wi, up), (up, wi), (wi, wi), (wi, wi.opposite())] {
                let all = [view.eval(a, b), view.ars(a, b), view.pdf(a, b)];
                assert!(all.iter().all(|f| f.is_finite() && *f >= 0.0), "{x} {z}: {all:?}");
                for lobe in [Lobe::Reflection, Lobe::Transmission] {
                    let ray = view.sample_lobe(a, lobe, [0.3, 0.9999999]);
                    assert!(ray.is_none_or(|r| r.weight.is_finite() && r.weight >= 0.0));
                }
            }
        }
    }
    let flux = view.reflectance(0.5_f32, Side::Air) + view.transmittance(0.5_f32, Side::Air);
    assert!((flux - 59_000.0 / 65_535.0).abs() < 1e-6);
    assert!(view.coherent(Direction::<f32>::normal()).unwrap().reflected.weight == 0.0);
}

#[test]
fn one_side_may_be_dark() {
    let table = build::<u16>(65_535, |_| ()).unwrap();
    let view = table.view();
    let (air, dark) = (*view.side(Side::Air), SideTable::DARK);
    let above = BsdfTableRef::new(view.eta(), ALPHA, air, dark).unwrap();
    let up = Direction::<f64>::from_angles(0.5, 0.0);
    assert!(above.ars(up, up) > 0.0 && above.pdf(up, up) > 0.0);
    let down = up.opposite();
    assert!(above.ars(down, down).to_bits() == 0 && above.sample(down, &mut || 0.5).is_none());
}

#[test]
fn an_opaque_body_reflects_light_from_the_air_and_does_nothing_else() {
    let arrays = Arrays {
        gains: &[FRAC_1_PI / (255.0 * 255.0); SHAPE.gains()],
        values: &[255_u8; SHAPE.values()],
        quantiles: &[0, 20_000, 65_000, 0, 20_000, 65_000, 0, 20_000, 65_000],
        leans: &[30; SHAPE.leans()],
        fluxes: &[[9000, 0, 0, 0]; 2],
    };
    let [lobe, ..] = header().lobes;
    let eta = RelativeIor::new(Header::STAND_IN).unwrap();
    let opaque =
        Header { eta, opaque: true, lobes: [lobe, None, None, None], fluxes: [2, 0], ..header() };
    let clear = Header { opaque: false, ..opaque };
    let table = opaque.table(arrays).unwrap();
    assert!(table.is_opaque() && !clear.table(arrays).unwrap().is_opaque());
    assert!(opaque.view(arrays).unwrap().is_opaque());
    let up = Direction::<f64>::from_angles(0.5, 0.0);
    assert!(table.ars(up, up) > 0.0);
    let below = up.opposite();
    assert!([(up, below), (below, below), (below, up)].iter().all(|p| table.ars(p.0, p.1) == 0.0));
    #[cfg(feature = "checksum")]
    assert_ne!(opaque.checksum(&arrays), clear.checksum(&arrays));
    // any other lobe, or fluxes from the inside
    for k in 1..4 {
        let mut lobes = [None; 4];
        lobes[k] = lobe;
        let fluxes = if k == 1 { [2, 0] } else { [0, 2] };
        let wrong = Header { lobes, fluxes, ..opaque };
        assert_eq!(wrong.table(arrays).unwrap_err(), TableError::Opaque, "lobe {k}");
    }
    let wrong = Header { fluxes: [2, 2], ..opaque };
    let fluxes = &[[9000, 0, 0, 0]; 4];
    assert_eq!(wrong.table(Arrays { fluxes, ..arrays }).unwrap_err(), TableError::Opaque);
}

#[test]
fn arrays_that_do_not_belong_together_are_refused() {
    let number = TableError::Number;
    let errors = [
        build::<u8>(1, |h| h.lobes[0] = None).unwrap_err(),
        build::<u8>(1, |h| h.slope = f32::NAN).unwrap_err(),
        build::<u8>(1, |h| h.eta = RelativeIor::new(1.0).unwrap()).unwrap_err(),
        build::<f32>(f32::NAN, |_| ()).unwrap_err(),
        build::<f32>(-1.0, |_| ()).unwrap_err(),
    ];
    assert_eq!(errors, [TableError::Length, number, number, number, number]);
    let small = BsdfTable::<u8, 1, 1, 1>::new(
        header(),
        Arrays {
            gains: &[1e-3; 12],
            values: &[1; VALUES],
            quantiles: &quantiles(),
            leans: &[0; 4 * SHAPE.leans()],
            fluxes: &[[0; 4]; 4],
        },
    );
    assert_eq!(small.unwrap_err(), TableError::Length);
}
