//! The least firmware that evaluates one law: what a sensor says in, a value out, and nothing else.
//!
//! ```text
//! cargo build --profile firmware -p asperity-evaluator --features table --target thumbv7em-none-eabihf
//! ```
//!
//! `tests/device` looks at the linked program: how much flash and RAM it takes, that it has neither texts of a panic
//! nor an allocator, and, in QEMU, that its value has the bits of the host's and how deep its stack was.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(all(target_os = "none", feature = "table"))]
#[rustfmt::skip]
#[allow(dead_code, missing_docs, unreachable_pub, reason = "generated; not all of it is used")]
mod example;
#[cfg(all(target_os = "none", any(feature = "ggx", feature = "normals", feature = "table")))]
mod law;

#[cfg(target_os = "none")]
mod device {
    use core::hint::black_box;
    use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

    use cortex_m_rt::entry;

    /// Where light comes from and where it goes, as the bits of floats; the tests know these values.
    static FROM_SENSOR: [AtomicU32; 6] = [
        AtomicU32::new((-0.36_f32).to_bits()),
        AtomicU32::new(0.0_f32.to_bits()),
        AtomicU32::new(0.8_f32.to_bits()),
        AtomicU32::new(0.28_f32.to_bits()),
        AtomicU32::new(0.1_f32.to_bits()),
        AtomicU32::new((-0.9_f32).to_bits()),
    ];
    /// The value, as the bits of a float; NaN until there is one.
    static TO_MOTOR: AtomicU32 = AtomicU32::new(f32::NAN.to_bits());

    #[entry]
    fn main() -> ! {
        let law = law();
        loop {
            let [ix, iy, iz, ox, oy, oz] =
                black_box(&FROM_SENSOR).each_ref().map(|bits| f32::from_bits(bits.load(Relaxed)));
            if let Some(law) = &law
                && let Some(value) = law([ix, iy, iz], [ox, oy, oz])
            {
                black_box(&TO_MOTOR).store(value.to_bits(), Relaxed);
            }
        }
    }

    #[cfg(any(feature = "ggx", feature = "normals", feature = "table"))]
    use crate::law::law;

    /// Without a law: what everything else takes.
    #[cfg(not(any(feature = "ggx", feature = "normals", feature = "table")))]
    fn law() -> Option<fn([f32; 3], [f32; 3]) -> Option<f32>> {
        None
    }

    /// Nothing leads here, but a program must have it; a text would cost flash.
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
    println!("this is firmware for a Cortex-M4F; tests/device builds it and runs it");
}
