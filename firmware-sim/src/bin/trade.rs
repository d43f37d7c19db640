//! What a model costs on a Cortex-M4F: `asperity trade` writes the model into this program and runs it in QEMU.
//!
//! The model stands in `SLOT`, in flash, where a device would have it; `host/src/trade/payload.rs` finds it in the ELF by
//! its first words and fills it. What it looks like is `asperity_core::slot`. For every tier one line a figure: `count TIER WHAT INSTRUCTIONS` a call, loop
//! and call itself taken off; `digest TIER HASH` of all results; `ram TIER BYTES` of the evaluator; `code TIER WHAT ADDRESS`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod ticks;

#[cfg(target_os = "none")]
mod device {
    use core::hint::black_box;

    use asperity_core::bsdf::{Bsdf, Normals};
    use asperity_core::direction::Direction;
    use asperity_core::math::{Fast, Real};
    use asperity_core::slot::{Kind, PAIRS, Pair, Slot};
    use asperity_core::table::{Arrays, BsdfTableRef, Storage};
    use cortex_m_rt::entry;
    use cortex_m_semihosting::hprintln;
    use panic_semihosting as _;

    use crate::ticks;

    static SLOT: Slot = Slot::EMPTY;

    #[entry]
    fn main() -> ! {
        // what stands there is not what the compiler saw
        ticks::end(report(black_box(&SLOT)))
    }

    fn report(slot: &'static Slot) -> Option<()> {
        ticks::start()?;
        match slot.words.kind() {
            Kind::Empty => hprintln!("empty"),
            Kind::Ggx | Kind::Normals => {
                law::<f64>("f64-exact", slot)?;
                law::<Fast<f64>>("f64-fast", slot)?;
                law::<f32>("f32-exact", slot)?;
                law::<Fast<f32>>("f32-fast", slot)?;
            }
            Kind::TableOfBytes => table(slot, &slot.bytes)?,
            Kind::TableOfHalves => table(slot, &slot.halves)?,
        }
        hprintln!("ok");
        Some(())
    }

    fn law<T: Real>(tier: &str, slot: &Slot) -> Option<()> {
        if slot.words.kind() == Kind::Ggx {
            figures::<T, _>(tier, &slot.words.ggx()?, slot);
        } else {
            figures::<T, Normals<T, 64>>(tier, &slot.words.normals()?, slot);
        }
        Some(())
    }

    fn table<S: Storage>(slot: &'static Slot, values: &'static [S]) -> Option<()>
    where
        BsdfTableRef<'static, S>: Bsdf<Fast<f32>>,
    {
        let header = slot.words.table()?;
        let [gains, count, quantiles, leans, fluxes] = header.lengths();
        let table = header.table(Arrays {
            gains: slot.gains.get(..gains)?,
            values: values.get(..count)?,
            quantiles: slot.quantiles.get(..quantiles)?,
            leans: slot.leans.get(..leans)?,
            fluxes: slot.fluxes.get(..fluxes)?,
        });
        figures::<Fast<f32>, _>("f32-fast", &table.ok()?, slot);
        Some(())
    }

    fn figures<T: Real, B: Bsdf<T>>(tier: &str, law: &B, slot: &Slot) {
        let pairs = &slot.pairs;
        // called through pointers the compiler does not know: nothing is kept from one call to the next
        let of_value: fn(&B, Direction<T>, Direction<T>) -> T = black_box(value);
        let of_drawn: fn(&B, Direction<T>, &Pair) -> T = black_box(drawn);
        let no_value: fn(&B, Direction<T>, Direction<T>) -> T = black_box(no_value);
        let no_drawn: fn(&B, Direction<T>, &Pair) -> T = black_box(no_drawn);
        let floor = each(pairs, |p| no_value(law, from(p), to(p)));
        let calls = each(pairs, |p| of_value(law, from(p), to(p)));
        hprintln!("count {} ars {}", tier, calls.saturating_sub(floor));
        let floor = each(pairs, |p| no_drawn(law, from(p), p));
        let calls = each(pairs, |p| of_drawn(law, from(p), p));
        hprintln!("count {} sample {}", tier, calls.saturating_sub(floor));
        hprintln!("ram {} {}", tier, size_of_val(law));
        hprintln!("code {} ars {}", tier, of_value as usize);
        hprintln!("code {} sample {}", tier, of_drawn as usize);
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut add = |x: T| {
            hash = (hash ^ x.to_f64().to_bits()).wrapping_mul(0x0100_0000_01b3);
        };
        for p in pairs {
            add(value(law, from(p), to(p)));
            add(drawn(law, from(p), p));
        }
        hprintln!("digest {} {:016x}", tier, hash);
    }

    #[inline(never)]
    fn value<T: Real, B: Bsdf<T>>(law: &B, wi: Direction<T>, wo: Direction<T>) -> T {
        law.ars(wi, wo)
    }

    #[inline(never)]
    fn drawn<T: Real, B: Bsdf<T>>(law: &B, wi: Direction<T>, pair: &Pair) -> T {
        law.sample(wi, &mut uniforms(pair)).map_or(T::ZERO, |s| s.weight + s.wo.z())
    }

    /// The call without the work.
    #[inline(never)]
    fn no_value<T: Real, B: Bsdf<T>>(_: &B, wi: Direction<T>, _: Direction<T>) -> T {
        wi.x()
    }

    #[inline(never)]
    fn no_drawn<T: Real, B: Bsdf<T>>(_: &B, wi: Direction<T>, pair: &Pair) -> T {
        let mut uniform = uniforms::<T>(pair);
        uniform() + uniform() + uniform() + wi.x()
    }

    /// The numbers that samples are drawn from; `host/src/trade/pairs.rs` draws the same.
    #[inline(always)]
    fn uniforms<T: Real>(p: &Pair) -> impl FnMut() -> T {
        let mut state = p[0].to_bits() ^ p[4].to_bits().rotate_left(16);
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            T::from_f64(f64::from((state >> 8) as f32 * (1.0 / 16_777_216.0)))
        }
    }

    #[inline(always)]
    fn from<T: Real>(p: &Pair) -> Direction<T> {
        let [x, y, z] = [p[0], p[1], p[2]].map(|x| T::from_f64(f64::from(x)));
        Direction::from_unit(x, y, z)
    }

    #[inline(always)]
    fn to<T: Real>(p: &Pair) -> Direction<T> {
        let [x, y, z] = [p[3], p[4], p[5]].map(|x| T::from_f64(f64::from(x)));
        Direction::from_unit(x, y, z)
    }

    /// Instructions a call, with the loop.
    fn each<T: Real>(pairs: &[Pair; PAIRS], mut work: impl FnMut(&Pair) -> T) -> u32 {
        let ((), instructions) = ticks::count(|| {
            for pair in pairs {
                black_box(work(black_box(pair)));
            }
        });
        instructions / PAIRS as u32
    }
}

#[cfg(not(target_os = "none"))]
#[expect(clippy::print_stdout, reason = "its purpose")]
fn main() {
    println!("instructions are counted on the emulated device");
}
