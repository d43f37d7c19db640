//! The self test on a bare Cortex-M4F (QEMU's mps2-an386), reported by semihosting.
//!
//! One line a section, `section NAME DIGEST INSTRUCTIONS`, then `digest DIGEST`, `ggx-eval-f32 N`
//! instructions a call, and `ok`. On a host the same digests without the counts.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod device {
    use core::hint::black_box;

    use asperity_core::bsdf::{Bsdf, Ggx};
    use asperity_core::direction::Direction;
    use asperity_core::quantity::{Alpha, RelativeIor};
    use asperity_firmware_sim::selftest;
    use cortex_m::asm;
    use cortex_m::peripheral::SYST;
    use cortex_m::peripheral::syst::SystClkSource;
    use cortex_m_rt::entry;
    use cortex_m_semihosting::{debug, hprintln};
    use panic_semihosting as _;

    /// `SysTick` counts the board's 25 MHz; with `-icount shift=0` QEMU takes 1 ns an instruction.
    const INSTRUCTIONS_PER_TICK: u32 = 40;

    /// The counter is 24 bits wide and counts down.
    const RELOAD: u32 = 0x00ff_ffff;

    #[entry]
    fn main() -> ! {
        debug::exit(match report() {
            Some(()) => debug::EXIT_SUCCESS,
            None => debug::EXIT_FAILURE,
        });
        loop {
            asm::wfi();
        }
    }

    fn report() -> Option<()> {
        let timer = &mut cortex_m::Peripherals::take()?.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(RELOAD);
        timer.clear_current();
        timer.enable_counter();

        let mut done = [("", 0_u64); selftest::COUNT];
        for (slot, (name, run)) in done.iter_mut().zip(selftest::SECTIONS) {
            let (digest, instructions) = count(run);
            hprintln!("section {} {:016x} {}", name, digest, instructions);
            *slot = (name, digest);
        }
        hprintln!("digest {:016x}", selftest::combine(&done));
        hprintln!("ggx-eval-f32 {}", ggx_eval()?);
        hprintln!("ok");
        Some(())
    }

    /// Runs `work`; the instructions are right up to 671 million, where the counter has gone round.
    fn count<R>(work: impl FnOnce() -> R) -> (R, u32) {
        let start = SYST::get_current();
        let result = work();
        let ticks = start.wrapping_sub(SYST::get_current()) & RELOAD;
        (result, ticks * INSTRUCTIONS_PER_TICK)
    }

    /// Instructions of one GGX evaluation in `f32`, without the loop around it.
    fn ggx_eval() -> Option<u32> {
        const CALLS: u32 = 4096;
        let eta = RelativeIor::new(1.49_f32).ok()?;
        let law = Ggx::new(Alpha::new(0.3_f32).ok()?, eta);
        let wi = Direction::from_angles(0.5, 0.0);
        let wo = Direction::from_angles(2.4, 1.0);
        let each = |work: &dyn Fn(Direction<f32>, Direction<f32>) -> f32| {
            count(|| {
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
