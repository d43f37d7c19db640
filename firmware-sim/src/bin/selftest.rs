//! The self test on a bare Cortex-M4F (QEMU's mps2-an386), reported by semihosting.
//!
//! One line a section, `section NAME DIGEST INSTRUCTIONS`, then `digest DIGEST`, `ggx-eval-f32 N`
//! instructions a call, and `ok`. On a host the same digests without the counts.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod ticks;

#[cfg(target_os = "none")]
mod device {
    use core::hint::black_box;

    use asperity_core::bsdf::{Bsdf, Ggx};
    use asperity_core::direction::Direction;
    use asperity_core::quantity::{Alpha, RelativeIor};
    use asperity_firmware_sim::selftest;
    use cortex_m_rt::entry;
    use cortex_m_semihosting::hprintln;
    use panic_semihosting as _;

    use crate::ticks;

    #[entry]
    fn main() -> ! {
        ticks::end(report())
    }

    fn report() -> Option<()> {
        ticks::start()?;

        let mut done = [("", 0_u64); selftest::COUNT];
        for (slot, (name, run)) in done.iter_mut().zip(selftest::SECTIONS) {
            let (digest, instructions) = ticks::count(run);
            hprintln!("section {} {:016x} {}", name, digest, instructions);
            *slot = (name, digest);
        }
        hprintln!("digest {:016x}", selftest::combine(&done));
        hprintln!("ggx-eval-f32 {}", ggx_eval()?);
        hprintln!("ok");
        Some(())
    }

    /// Instructions of one GGX evaluation in `f32`, without the loop around it.
    fn ggx_eval() -> Option<u32> {
        const CALLS: u32 = 4096;
        let eta = RelativeIor::new(1.49_f32).ok()?;
        let law = Ggx::new(Alpha::new(0.3_f32).ok()?, eta);
        let wi = Direction::from_angles(0.5, 0.0);
        let wo = Direction::from_angles(2.4, 1.0);
        let each = |work: &dyn Fn(Direction<f32>, Direction<f32>) -> f32| {
            ticks::count(|| {
                for _ in 0..CALLS {
                    black_box(work(black_box(wi), black_box(wo)));
                }
            })
            .1
        };
        let evaluations = each(&|wi, wo| law.eval(wi, wo));
        let nothing = each(&|wi, _| wi.z());
        Some(evaluations.saturating_sub(nothing) / CALLS)
    }
}

#[cfg(not(target_os = "none"))]
#[expect(clippy::print_stdout, reason = "its purpose")]
fn main() {
    use asperity_firmware_sim::selftest;

    let sections = selftest::sections();
    for (name, digest) in sections {
        println!("section {name} {digest:016x}");
    }
    println!("digest {:016x}\nok", selftest::combine(&sections));
}
