//! What a verb has to say to an instrument before the program may end: stop.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

static OPEN: AtomicBool = AtomicBool::new(false);

/// The longest time that the end of the program is held up: last words take a second where the line works.
const LONGEST: Duration = Duration::from_secs(3);
/// How often it is looked.
const PAUSE: Duration = Duration::from_millis(10);

/// While this lives the program is not to end by a signal: the stage would go on.
#[derive(Debug)]
pub(super) struct LastWords(());

impl LastWords {
    /// From now on there is something to be said.
    pub(super) fn keep() -> Self {
        OPEN.store(true, Ordering::SeqCst);
        Self(())
    }
}

impl Drop for LastWords {
    fn drop(&mut self) {
        OPEN.store(false, Ordering::SeqCst);
    }
}

/// Waits until all is said, three seconds at most. For whoever is about to end the program.
pub(super) fn wait() {
    let mut waited = Duration::ZERO;
    while OPEN.load(Ordering::SeqCst) && waited < LONGEST {
        thread::sleep(PAUSE);
        waited += PAUSE;
    }
}
