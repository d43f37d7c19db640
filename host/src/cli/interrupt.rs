//! Ctrl-C: the first asks the work to end with what it has, the second ends the program.

use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

static STOP: AtomicBool = AtomicBool::new(false);
static INSTALLED: Once = Once::new();

/// The flag that the first Ctrl-C sets; installs the handler.
pub(super) fn flag() -> &'static AtomicBool {
    INSTALLED.call_once(|| {
        // Without a handler Ctrl-C simply ends the program: no reason to refuse to work.
        drop(ctrlc::set_handler(|| {
            if STOP.swap(true, Ordering::SeqCst) {
                super::last_words::wait();
                std::process::exit(130);
            }
        }));
    });
    &STOP
}
