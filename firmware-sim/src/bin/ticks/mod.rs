//! What QEMU's board has executed, by `SysTick`; for the programs that report by semihosting.

use cortex_m::asm;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_semihosting::debug;

/// `SysTick` counts the board's 25 MHz; with `-icount shift=0` QEMU takes 1 ns an instruction.
const INSTRUCTIONS_PER_TICK: u32 = 40;

/// The counter is 24 bits wide and counts down.
const RELOAD: u32 = 0x00ff_ffff;

/// Starts the counter; `None` if somebody has the peripherals already.
pub(crate) fn start() -> Option<()> {
    let timer = &mut cortex_m::Peripherals::take()?.SYST;
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(RELOAD);
    timer.clear_current();
    timer.enable_counter();
    Some(())
}

/// Runs `work`; the instructions are right up to 671 million, where the counter has gone round.
pub(crate) fn count<R>(work: impl FnOnce() -> R) -> (R, u32) {
    let start = SYST::get_current();
    let result = work();
    let ticks = start.wrapping_sub(SYST::get_current()) & RELOAD;
    (result, ticks * INSTRUCTIONS_PER_TICK)
}

/// Ends the program: well, if there was a report.
pub(crate) fn end(report: Option<()>) -> ! {
    debug::exit(match report {
        Some(()) => debug::EXIT_SUCCESS,
        None => debug::EXIT_FAILURE,
    });
    loop {
        asm::wfi();
    }
}
