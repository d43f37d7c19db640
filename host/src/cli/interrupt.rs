//! Signals: the first asks the work to end with what it has, the second ends the program.
//!
//! Ctrl-C, the request to terminate and the loss of the terminal are one. A verb that never asks for [`flag`] has
//! nothing to keep: the first ends it. Temporary files are removed in any case.

use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::scratch;
use crate::watch::Watch;

static STOP: AtomicBool = AtomicBool::new(false);
/// Whether anyone looks at the flag.
static HEEDED: AtomicBool = AtomicBool::new(false);
static INSTALLED: Once = Once::new();

/// The flag that the first signal sets.
pub(super) fn flag() -> &'static AtomicBool {
    listen();
    HEEDED.store(true, Ordering::SeqCst);
    &STOP
}

/// Whether the first signal has come.
pub(super) fn asked() -> bool {
    flag().load(Ordering::SeqCst)
}

/// Work that the first signal ends, without a bar.
pub(super) fn watch() -> Watch<'static> {
    Watch::silent(flag())
}

/// Installs the handler. Without one a signal simply ends the program: no reason to refuse to work.
pub(super) fn listen() {
    INSTALLED.call_once(install);
}

/// The signal of this number has come.
fn on_signal(number: i32) {
    let is_second = STOP.swap(true, Ordering::SeqCst);
    if HEEDED.load(Ordering::SeqCst) && !is_second {
        return;
    }
    super::last_words::wait();
    scratch::remove_all();
    if is_second {
        std::process::exit(128 + number);
    }
    super::say::error(format_args!("no: interrupted"));
    std::process::exit(1);
}

#[cfg(unix)]
fn install() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    // a file that grows beyond the limit of the shell: heard, it is an error of that file, unheard, the end
    let mut signals = vec![SIGINT, SIGTERM, SIGXFSZ];
    if !is_ignored(SIGHUP) {
        signals.push(SIGHUP);
    }
    let Ok(mut signals) = signal_hook::iterator::Signals::new(signals) else { return };
    let wait = move || signals.forever().filter(|s| *s != SIGXFSZ).for_each(on_signal);
    let _ = std::thread::Builder::new().name("signals".into()).spawn(wait);
}

/// Whether the program was started deaf to a signal, as `nohup` does it; where the system does not tell, it was not.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).unwrap_or("0");
    u64::from_str_radix(ignored.trim(), 16).is_ok_and(|set| set & (1 << (signal - 1)) != 0)
}

#[cfg(not(unix))]
fn install() {
    const CTRL_C: i32 = 2;
    drop(ctrlc::set_handler(|| on_signal(CTRL_C)));
}
