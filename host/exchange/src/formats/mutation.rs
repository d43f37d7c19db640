//! Damaged files of every format that is written: a reader may refuse them and must not panic.

use std::f64::consts::FRAC_1_PI;

use super::{FORMATS, Law, Options, Subject, read_bytes};
use crate::sampled::{Band, Lobe, Side, Symmetry};

/// A perfect diffuser.
struct Level;

impl Law for Level {
    fn value(&self, _: [f64; 2], _: [f64; 2]) -> f64 {
        FRAC_1_PI
    }
}

/// Numbers of D. Lehmer's generator modulo a power of two.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
        (self.0 >> 33) as usize % n.max(1)
    }
}

const WORDS: [&[u8]; 10] = [
    b"-1",
    b"nan",
    b"1e308",
    b"999999999",
    b"",
    b"\n",
    b" ",
    b"{",
    b"\xff\x00",
    b"18446744073709551615",
];

/// Puts a word of harm somewhere, or takes bytes away.
fn damage(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..=random.below(3) {
        let start = random.below(bytes.len());
        let end = (start + random.below(12)).min(bytes.len());
        bytes.splice(start..end, WORDS[random.below(WORDS.len())].iter().copied());
    }
    if random.below(8) == 0 {
        bytes.truncate(random.below(bytes.len()));
    }
}

#[test]
fn damaged_files_do_not_panic() {
    let subject = Subject {
        side: Side::Air,
        lobe: Lobe::Reflection,
        index: None,
        symmetry: Symmetry::Isotropic,
        band: Band::Wavelength(550.0),
        notes: Vec::new(),
        coherent: 0.0,
        closed: None,
    };
    let options = Options { incidences: vec![[0.5, 0.0]], most_nodes: 100, ..Options::default() };
    let mut random = Random(17);
    for format in FORMATS {
        let Some(write) = format.write else { continue };
        let Ok(sampled) = (write.sample)(&Level, &subject, &options) else { continue };
        let Ok(good) = (write.encode)(&[sampled]) else { continue };
        let mut refused = 0;
        for _ in 0..400 {
            let mut bytes = good.clone();
            damage(&mut bytes, &mut random);
            refused += usize::from(read_bytes("file", &bytes).is_err());
        }
        assert!(refused > 0 || format.read.is_none(), "{}: all damage is accepted", format.name);
    }
}
