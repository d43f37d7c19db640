//! The board: a serial port, a clock, and how deep the stack has been.
//!
//! The only file of the firmware with `unsafe`: registers at fixed addresses, an interrupt handler, and
//! the memory between the variables and the stack. ARM's "Cortex-M System Design Kit" documents the
//! serial port, AN386 the addresses.
#![allow(unsafe_code, reason = "registers and the stack's own memory")]

use core::cell::RefCell;

use cortex_m::interrupt::{Mutex, free};
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{NVIC, SYST};
use cortex_m_rt::exception;
use heapless::{Deque, Vec};
use vcell::VolatileCell;

/// Ticks of the board's clock in a microsecond.
const TICKS_PER_US: u32 = 25;

/// The counter of `SysTick` is 24 bits wide and counts down.
const RELOAD: u32 = 0x00ff_ffff;

/// A page of registers of the CMSDK APB UART.
#[repr(C)]
struct Uart {
    data: VolatileCell<u32>,
    /// Bit 0: transmitter full; bit 1: receiver full.
    state: VolatileCell<u32>,
    /// Bit 0: transmitter on; bit 1: receiver on; bit 3: interrupt for a byte received.
    control: VolatileCell<u32>,
    /// Bit 1: a byte was received; written as 1 to clear it.
    interrupt: VolatileCell<u32>,
    /// Clock ticks a bit, at least 16.
    divider: VolatileCell<u32>,
}

fn uart() -> &'static Uart {
    // SAFETY: UART0's registers are there on every AN386, for ever, and are only read and written
    // through volatile cells.
    unsafe { &*(0x4000_4000 as *const Uart) }
}

/// 11 ms at 115200 baud: longer than the instrument ever computes in one piece.
const QUEUE: usize = 128;

/// Bytes received and not yet taken; a full queue drops what comes, as hardware does.
static RECEIVED: Mutex<RefCell<Deque<u8, QUEUE>>> = Mutex::new(RefCell::new(Deque::new()));

/// The serial port and the clock.
pub(crate) struct Board {
    timer: SYST,
    /// Ticks up to `last`.
    elapsed: u64,
    last: u32,
}

impl Board {
    /// Sets up the peripherals; `None` if somebody has them already.
    pub(crate) fn new(baud: u32) -> Option<Self> {
        let mut timer = cortex_m::Peripherals::take()?.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(RELOAD);
        timer.clear_current();
        timer.enable_counter();
        uart().divider.set((TICKS_PER_US * 1_000_000 / baud.max(1)).max(16));
        uart().control.set(0b1011);
        // SAFETY: the handler below shares its queue through a critical section only.
        unsafe { NVIC::unmask(Receiver) };
        Some(Self { timer, elapsed: 0, last: RELOAD })
    }

    /// Microseconds since power-on. To be asked at least every 0.6 s, or a turn of the counter is missed.
    pub(crate) fn now_us(&mut self) -> u64 {
        // the timer is ours alone: nobody else clears or reloads it
        let current = { &self.timer }.cvr.read();
        self.elapsed += u64::from(self.last.wrapping_sub(current) & RELOAD);
        self.last = current;
        self.elapsed / u64::from(TICKS_PER_US)
    }

    /// Takes what was received, as much as fits.
    pub(crate) fn receive<const N: usize>(&mut self) -> Vec<u8, N> {
        let mut bytes = Vec::new();
        while !bytes.is_full()
            && let Some(byte) = free(|cs| RECEIVED.borrow(cs).borrow_mut().pop_front())
        {
            let _ = bytes.push(byte);
        }
        bytes
    }

    /// Sends, waiting for the line.
    pub(crate) fn send(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            while uart().state.get() & 1 != 0 {}
            uart().data.set(u32::from(byte));
        }
    }
}

/// Interrupt 0: UART0 has received a byte.
#[derive(Clone, Copy)]
struct Receiver;

// SAFETY: AN386, table of interrupts.
unsafe impl cortex_m::interrupt::InterruptNumber for Receiver {
    fn number(self) -> u16 {
        0
    }
}

#[exception]
unsafe fn DefaultHandler(number: i16) {
    if number == 0 {
        uart().interrupt.set(0b10);
        if uart().state.get() & 0b10 != 0 {
            let byte = uart().data.get() as u8;
            let _ = free(|cs| RECEIVED.borrow(cs).borrow_mut().push_back(byte));
        }
    }
}

/// Bytes of stack used at most since power-on; the runtime has painted all of it before `main`.
pub(crate) fn stack_bytes() -> u32 {
    /// What `cortex-m-rt` paints with.
    const PAINT: u32 = 0xcccc_cccc;
    unsafe extern "C" {
        static _stack_end: u32;
        static _stack_start: u32;
    }
    let (mut at, top) = (&raw const _stack_end, &raw const _stack_start);
    // SAFETY: aligned words between the linker's marks are memory that nothing else names; what the
    // stack holds now lies above the first word that is not paint, and is not read.
    while at < top && unsafe { at.read_volatile() } == PAINT {
        at = at.wrapping_add(1);
    }
    (top as usize - at as usize) as u32
}
