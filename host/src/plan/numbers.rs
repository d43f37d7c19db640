//! The numbers of a path: the first from a lattice, which fills its cube evenly, the others from a generator.

/// Numbers of a path that the lattice gives.
const LATTICE: usize = 8;

/// The numbers of one path, each in [0, 1).
#[derive(Clone, Debug)]
pub(super) struct Numbers {
    path: u64,
    seed: u64,
    next: u64,
    steps: [f64; LATTICE],
}

/// Mixes 64 bits (`SplitMix64`).
fn mixed(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

impl Numbers {
    /// The numbers of a path of a seed, which shifts the lattice.
    pub(super) fn of(path: u64, seed: u64) -> Self {
        // the root of x^9 = x + 1: its powers step through eight dimensions evenly
        let root = 1.085_070_245_491_450_8_f64;
        let mut power = 1.0;
        let steps = [(); LATTICE].map(|()| {
            power /= root;
            power
        });
        Self { path, seed, next: 0, steps }
    }

    /// The next number.
    pub(super) fn take(&mut self) -> f64 {
        let k = self.next;
        self.next += 1;
        match self.steps.get(k as usize) {
            Some(step) => {
                let shift = unit(mixed(mixed(self.seed) ^ k.wrapping_mul(0x2545_f491_4f6c_dd1d)));
                (shift + self.path as f64 * step).fract().min(1.0 - f64::EPSILON)
            }
            None => {
                unit(mixed(mixed(self.seed ^ self.path.rotate_left(32)).wrapping_add(mixed(k))))
            }
        }
    }

    /// Two numbers.
    pub(super) fn pair(&mut self) -> [f64; 2] {
        [self.take(), self.take()]
    }
}

#[cfg(test)]
mod tests {
    use super::Numbers;

    #[test]
    fn numbers_are_even_and_their_own() {
        let mean = |seed: u64, skip: usize| {
            let one = |path| {
                let mut numbers = Numbers::of(path, seed);
                for _ in 0..skip {
                    let _ = numbers.take();
                }
                numbers.take()
            };
            (0..4096).map(one).sum::<f64>() / 4096.0
        };
        for skip in [0, 3, 7, 8, 20] {
            assert!((mean(1, skip) - 0.5).abs() < 0.02, "{skip}: {}", mean(1, skip));
        }
        let first = |path, seed| Numbers::of(path, seed).take().to_bits();
        assert_eq!(first(5, 1), first(5, 1));
        assert_ne!(first(5, 1), first(5, 2));
        assert_ne!(first(5, 1), first(6, 1));
    }
}
