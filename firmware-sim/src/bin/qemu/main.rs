//! The instrument on a bare Cortex-M4F (QEMU's mps2-an386): its line is UART0, QEMU's `-serial`.
//!
//! The same [`Simulator`] as everywhere else, fed with the bytes of the serial port and the board's
//! clock. On a host this binary only says where to find the program for hosts.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod board;

#[cfg(target_os = "none")]
mod device {
    use asperity_firmware_sim::{Config, Instant, Simulator};
    use cortex_m_rt::entry;

    use crate::board::{Board, stack_bytes};

    const BAUD: u32 = 115_200;

    #[entry]
    fn main() -> ! {
        let mut board = Board::new(BAUD);
        let mut instrument = Simulator::new(Config::emulated());
        loop {
            if let Some(board) = &mut board {
                turn(board, &mut instrument);
            }
        }
    }

    /// What has come goes in, what comes out is sent.
    fn turn(board: &mut Board, instrument: &mut Simulator) {
        let received = board.receive::<32>();
        let now = Instant(board.now_us());
        if !received.is_empty() || instrument.poll_at().is_some_and(|due| due <= now) {
            instrument.set_stack_bytes(stack_bytes());
            instrument.handle(&received, now, &mut |bytes: &[u8]| board.send(bytes));
        }
    }

    /// No message: formatting one would cost more flash than the instrument has to spare.
    #[panic_handler]
    fn halt(_: &core::panic::PanicInfo<'_>) -> ! {
        loop {
            cortex_m::asm::bkpt();
        }
    }
}

#[cfg(not(target_os = "none"))]
#[expect(clippy::print_stdout, reason = "its purpose")]
fn main() {
    println!("this is the firmware for a Cortex-M4F; on a computer, run the program gonio-sim");
}
