//! The examples in C and C++, compiled, run, and held against core bit by bit.

use std::path::Path;
use std::process::Command;

use asperity_core::bsdf::{Bsdf, Ggx, Normals, Scatter};
use asperity_core::direction::{Direction, Side};
use asperity_core::math::Fast;
use asperity_core::ndf::law::{Law, Profile};
use asperity_core::ndf::normals::NormalDensity;
use asperity_core::quantity::{Alpha, RelativeIor};
use asperity_needs::absent;

use crate::hostile::valgrind;
use crate::table::Example;
use crate::tools::{capi, program, run};

const WI: [f32; 3] = [0.6, 0.0, 0.8];
const WO: [[f32; 3]; 4] = [[-0.4, 0.0, -0.9], [-0.5, 0.1, 0.7], [0.1, -0.3, -1.0], [0.2, 0.2, 0.0]];

type F = Fast<f32>;

fn fast([x, y, z]: [f32; 3]) -> Direction<F> {
    Direction::new(Fast(x), Fast(y), Fast(z)).unwrap()
}

fn exact([x, y, z]: [f32; 3]) -> Direction<f32> {
    Direction::new(x, y, z).unwrap()
}

/// A hexadecimal float of C, `-0x1.8p+3`.
fn float(text: &str) -> f32 {
    let (negative, text) = text.strip_prefix('-').map_or((false, text), |t| (true, t));
    let (digits, exponent) = text.strip_prefix("0x").unwrap().split_once('p').unwrap();
    let (whole, part) = digits.split_once('.').unwrap_or((digits, ""));
    let mantissa = u64::from_str_radix(&format!("{whole}{part}"), 16).unwrap();
    let exponent: i32 = exponent.parse::<i32>().unwrap() - 4 * i32::try_from(part.len()).unwrap();
    // both factors are exact
    let value = (mantissa as f64 * 2_f64.powi(exponent)) as f32;
    if negative { -value } else { value }
}

/// The bits of every number of a line that begins with some words.
fn bits(output: &str, words: &str) -> Vec<u32> {
    let lines = output.lines().filter_map(|l| l.strip_prefix(words)?.strip_prefix(' '));
    lines.flat_map(|l| l.split(' ').map(|x| float(x).to_bits()).collect::<Vec<_>>()).collect()
}

fn compare(output: &str, words: &str, expected: impl IntoIterator<Item = f32>) {
    let expected: Vec<u32> = expected.into_iter().map(f32::to_bits).collect();
    assert!(!expected.is_empty());
    assert_eq!(bits(output, words), expected, "{words}:\n{output}");
}

/// The rays of a law with the generator of the example.
fn rays(law: &impl Scatter<F>) -> Vec<f32> {
    let mut word = 1_u32;
    let mut uniform = || {
        word = word.wrapping_mul(1664525).wrapping_add(1013904223);
        Fast((word >> 8) as f32 / 16_777_216.0)
    };
    let draw = |_| match law.sample(fast(WI), &mut uniform) {
        Some(ray) => {
            let [x, y, z] = ray.wo.xyz();
            [x.0, y.0, z.0, ray.weight.0]
        }
        None => [0.0; 4],
    };
    (0..4).flat_map(draw).collect()
}

fn normals<T: asperity_core::math::Real>(
    profile: Profile,
    delta: T,
    n: T,
    eta: T,
) -> Normals<T, 64> {
    let density = NormalDensity::new(Law::new(profile, delta, n, T::ZERO).unwrap());
    Normals::new(density, RelativeIor::new(eta).unwrap())
}

fn output_of(binary: &Path) -> String {
    String::from_utf8(run(&mut Command::new(binary), "").unwrap().stdout).unwrap()
}

#[test]
fn the_c_example_prints_the_bits_of_core_and_valgrind_finds_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let binary = folder.path().join("evaluate");
    if let Err(remedy) = program(&capi().join("examples/evaluate.c"), &binary) {
        return absent(&remedy);
    }
    let out = output_of(&binary);

    let eta = RelativeIor::new(1.49_f32).unwrap();
    let law = Ggx::new(Alpha::new(0.25_f32).unwrap(), eta);
    compare(&out, "ggx eval", WO.map(|wo| law.eval(exact(WI), exact(wo))));
    compare(&out, "ggx ars", WO.map(|wo| law.ars(exact(WI), exact(wo))));
    compare(&out, "ggx pdf", WO.map(|wo| law.pdf(exact(WI), exact(wo))));
    let law = Ggx::new(Alpha::new(Fast(0.25_f32)).unwrap(), eta.cast());
    compare(&out, "ggx eval", WO.map(|wo| law.eval(fast(WI), fast(wo)).0));
    compare(&out, "ggx ray", rays(&law));

    let law = normals(Profile::Gauss, 0.12_f32, 1.66, 1.49);
    compare(&out, "normals eval", WO.map(|wo| law.eval(exact(WI), exact(wo))));
    let law = normals(Profile::Gauss, Fast(0.12_f32), Fast(1.66), Fast(1.49));
    compare(&out, "normals pdf", WO.map(|wo| law.pdf(fast(WI), fast(wo)).0));
    compare(&out, "normals ray", rays(&law));

    let example = Example::read();
    let law = example.view();
    compare(&out, "table eval", WO.map(|wo| law.eval(fast(WI), fast(wo)).0));
    compare(&out, "table eval", WO.map(|wo| law.eval(exact(WI), exact(wo))));
    compare(&out, "table pdf", WO.map(|wo| law.pdf(fast(WI), fast(wo)).0));
    compare(&out, "table ray", rays(&law));
    compare(&out, "table reflectance", [law.reflectance(0.8_f32, Side::Air)]);
    compare(&out, "table transmittance", [law.transmittance(0.8_f32, Side::Air)]);

    match valgrind(&binary) {
        Ok(said) => assert!(said.contains("ERROR SUMMARY: 0 errors"), "{said}"),
        Err(remedy) => absent(&remedy),
    }
}

#[test]
fn the_cpp_example_prints_the_bits_of_core() {
    let folder = tempfile::tempdir().unwrap();
    let binary = folder.path().join("evaluate");
    if let Err(remedy) = program(&capi().join("examples/evaluate.cpp"), &binary) {
        return absent(&remedy);
    }
    let out = output_of(&binary);
    let (wi, wo) = (fast(WI), fast(WO[0]));
    let law = Ggx::new(Alpha::new(Fast(0.25_f32)).unwrap(), RelativeIor::new(Fast(1.49)).unwrap());
    compare(&out, "ggx", [law.eval(wi, wo).0]);
    let law = normals(Profile::Cauchy, Fast(0.12_f32), Fast(2.5), Fast(1.49));
    compare(&out, "normals", [law.eval(wi, wo).0]);
    compare(&out, "table", [Example::read().view().eval(wi, wo).0]);
    assert!(out.contains("refused: a number is outside its domain"), "{out}");
}

#[test]
fn hexadecimal_floats_are_read() {
    for (text, value) in
        [("0x1.8p+3", 12.0_f32), ("-0x0p+0", -0.0), ("0x1p-149", 1e-45), ("0x1.99999ap-4", 0.1)]
    {
        assert_eq!(float(text).to_bits(), value.to_bits(), "{text}");
    }
}
