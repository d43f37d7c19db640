//! Instructions a call on a Cortex-M4F, by QEMU's `-icount shift=0` and `SysTick`.
//!
//! One line a case: `count LAW TIER WHAT INSTRUCTIONS`. Pairs of directions are the same in all, transmission and
//! reflection in turn; "+unit" makes both directions from ready components, "+new" normalises them. The uniforms of a
//! sample are ready, too, and its rays are not lost, which would spare the rest.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod ticks;

#[cfg(target_os = "none")]
mod device {
    use core::hint::black_box;

    use asperity_core::bsdf::{AllBounces, Bsdf, COMPENSATION_NUMBERS, Compensation, Ggx, Normals};
    use asperity_core::direction::Direction;
    use asperity_core::math::{Fast, Real};
    use asperity_core::ndf::law::{Law, Profile};
    use asperity_core::ndf::normals::NormalDensity;
    use asperity_core::quantity::{Alpha, RelativeIor};
    use asperity_core::table::{Arrays, Fall, Form, Header, LobeHeader, Shape, Storage};
    use cortex_m_rt::entry;
    use cortex_m_semihosting::hprintln;
    use panic_semihosting as _;

    use crate::ticks;

    const PAIRS: usize = 32;
    const ROUNDS: u32 = 128;

    type Pair = ([f32; 3], [f32; 3]);

    /// The fast tier, or the exact one.
    trait Tier: Real {
        fn of(x: f32) -> Self;
        fn value(self) -> f32;
    }

    impl Tier for f32 {
        #[inline(always)]
        fn of(x: f32) -> Self {
            x
        }
        #[inline(always)]
        fn value(self) -> f32 {
            self
        }
    }

    impl Tier for Fast<f32> {
        #[inline(always)]
        fn of(x: f32) -> Self {
            Self(x)
        }
        #[inline(always)]
        fn value(self) -> f32 {
            self.0
        }
    }

    #[entry]
    fn main() -> ! {
        ticks::end(report())
    }

    /// Incidence 0 to 80 degrees from both sides, observation about the lobe; transmission, reflection,
    /// transmission and so on.
    fn pairs() -> [Pair; PAIRS] {
        core::array::from_fn(|k| {
            let x = k as f32;
            let below = k % 4 >= 2;
            let wi = Direction::from_angles(0.04 * x, 0.2 * x);
            let wo = Direction::from_angles(0.04 * x + 0.01 * (x - 15.0), 0.2 * x + 3.0);
            let flip = |w: Direction<f32>, flip: bool| {
                let [x, y, z] = w.xyz();
                [x, y, if flip { -z } else { z }]
            };
            (flip(wi, below), flip(wo, below ^ (k % 2 == 0)))
        })
    }

    fn report() -> Option<()> {
        ticks::start()?;

        let raw = pairs();
        laws::<f32>("exact", &raw)?;
        laws::<Fast<f32>>("fast", &raw)?;
        table::<u8>("table-u8", &raw)?;
        table::<u16>("table-u16", &raw)?;
        table::<f32>("table-f32", &raw)?;
        hprintln!("ok");
        Some(())
    }

    fn laws<T: Tier>(tier: &str, raw: &[Pair; PAIRS]) -> Option<()> {
        let eta = RelativeIor::new(T::of(1.49)).ok()?;
        let ggx = Ggx::new(Alpha::new(T::of(0.3)).ok()?, eta);
        let profile = Law::new(Profile::Gauss, T::of(0.15), T::of(2.0), T::of(0.0)).ok()?;
        let normals: Normals<T, 64> = Normals::new(NormalDensity::new(profile), eta);
        law(tier, "ggx", &ggx, raw);
        law(tier, "normals", &normals, raw);
        let later = Compensation::from_numbers(&[T::of(0.1); COMPENSATION_NUMBERS])?;
        law(tier, "ggx-ms", &AllBounces { single: ggx, later }, raw);
        Some(())
    }

    const SHAPE: Shape = Shape { incidences: 6, azimuths: 4, radii: 16, intervals: 8 };

    /// Arrays of four lobes of one value, in flash as those of any firmware.
    trait Level: Storage {
        const VALUES: &'static [Self];
        const ARRAYS: Arrays<'static, Self> = Arrays {
            gains: &[4.0 / (Self::FULL * Self::FULL); 4 * SHAPE.gains()],
            values: Self::VALUES,
            quantiles: &QUANTILES,
            leans: &[20; 4 * SHAPE.leans()],
            fluxes: &[[6000, 50_000, 0, 0]; 16],
        };
    }

    const QUANTILES: [u16; 4 * SHAPE.quantiles()] = {
        let mut quantiles = [0; 4 * SHAPE.quantiles()];
        let mut k = 0;
        while k < quantiles.len() {
            quantiles[k] = 7000 * (k % 9) as u16;
            k += 1;
        }
        quantiles
    };

    impl Level for u8 {
        const VALUES: &'static [Self] = &[140; 4 * SHAPE.values()];
    }
    impl Level for u16 {
        const VALUES: &'static [Self] = &[36_000; 4 * SHAPE.values()];
    }
    impl Level for f32 {
        const VALUES: &'static [Self] = &[0.55; 4 * SHAPE.values()];
    }

    /// What a call costs does not depend on what it finds.
    #[inline(never)]
    fn table<S: Level>(name: &str, raw: &[Pair; PAIRS]) -> Option<()>
    where
        for<'a> asperity_core::table::BsdfTableRef<'a, S>: Bsdf<Fast<f32>>,
    {
        let lobe = LobeHeader {
            shape: SHAPE,
            form: Form::Masked,
            fall: Fall::Fourth,
            scale: 0.3,
            grazing: 1.0,
            masking: 0.3,
        };
        let header = Header {
            eta: RelativeIor::new(1.49).ok()?,
            opaque: false,
            slope: 0.3,
            lobes: [Some(lobe); 4],
            fluxes: [8; 2],
            grazing: [1.0; 2],
        };
        law::<Fast<f32>, _>("fast", name, &header.table(S::ARRAYS).ok()?, raw);
        Some(())
    }

    fn law<T: Tier, B: Bsdf<T>>(tier: &str, name: &str, law: &B, raw: &[Pair; PAIRS]) {
        let unit = |v: [f32; 3]| Direction::from_unit(T::of(v[0]), T::of(v[1]), T::of(v[2]));
        let ready = raw.map(|(i, o)| (unit(i), unit(o)));
        let floor = each(&ready, |(i, o)| (i.z() + o.z()).value());
        let say = |what: &str, count: u32| {
            hprintln!("count {} {} {} {}", name, tier, what, count.saturating_sub(floor));
        };
        say("ars", each(&ready, |(i, o)| law.ars(i, o).value()));
        say("eval", each(&ready, |(i, o)| law.eval(i, o).value()));
        say("pdf", each(&ready, |(i, o)| law.pdf(i, o).value()));
        say("ars+unit", each(raw, |(i, o)| law.ars(unit(i), unit(o)).value()));
        let normalised = |v: [f32; 3]| Direction::new(T::of(v[0]), T::of(v[1]), T::of(v[2]));
        let built = each(raw, |(i, o)| match (normalised(i), normalised(o)) {
            (Some(i), Some(o)) => law.ars(i, o).value(),
            _ => 0.0,
        });
        say("ars+new", built);
        let mut step = 0.0;
        let rays = ready.map(|(i, _)| {
            for _ in 0..100 {
                step += 1.0;
                let uniforms = [0.618, 0.755, 0.570].map(|each: f32| (0.5 + each * step) % 1.0);
                if drawn(law, i, uniforms) {
                    return (i, uniforms);
                }
            }
            (i, [0.5; 3])
        });
        let floor = each(&rays, |(i, [a, b, c])| i.z().value() + a + b + c);
        let sample = each(&rays, |(i, u)| {
            let mut next = u.into_iter();
            let mut uniform = || T::of(next.next().unwrap_or(0.5));
            law.sample(i, &mut uniform).map_or(0.0, |s| (s.weight + s.wo.z()).value())
        });
        hprintln!("count {} {} sample {}", name, tier, sample.saturating_sub(floor));
    }

    /// Whether these uniforms draw a ray.
    #[inline(never)]
    fn drawn<T: Tier, B: Bsdf<T>>(law: &B, wi: Direction<T>, uniforms: [f32; 3]) -> bool {
        let mut next = uniforms.into_iter();
        law.sample(wi, &mut || T::of(next.next().unwrap_or(0.5))).is_some()
    }

    /// Instructions a call, with the loop.
    fn each<P: Copy>(pairs: &[P; PAIRS], mut work: impl FnMut(P) -> f32) -> u32 {
        let ((), instructions) = ticks::count(|| {
            for _ in 0..ROUNDS {
                for pair in pairs {
                    black_box(work(*black_box(pair)));
                }
            }
        });
        instructions / (ROUNDS * PAIRS as u32)
    }
}

#[cfg(not(target_os = "none"))]
#[expect(clippy::print_stdout, reason = "its purpose")]
fn main() {
    println!("instructions are counted on the emulated device");
}
