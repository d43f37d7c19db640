//! Where a panic would end on bare metal; nothing leads here, but a static library must have it.

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
