//! Long work without Python's lock, that Ctrl-C ends.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use asperity::watch::Watch;
use pyo3::prelude::*;

/// How often Python is asked whether a signal came.
const PATIENCE: Duration = Duration::from_millis(50);

/// Runs `work` on a thread of its own while other Python threads run.
///
/// A signal whose handler raises (Ctrl-C) stops the work; when the work has ended the exception goes on
/// and the result is dropped.
///
/// # Errors
/// What the handler of a signal raised.
pub(crate) fn interruptible<T: Send>(
    py: Python<'_>,
    work: impl FnOnce(Watch<'_>) -> T + Send,
) -> PyResult<T> {
    let stop = &AtomicBool::new(false);
    let (done, raised) = py.detach(|| {
        thread::scope(|scope| {
            let waiting = thread::current();
            let worker = scope.spawn(move || {
                let done = work(Watch::silent(stop));
                waiting.unpark();
                done
            });
            let mut raised = None;
            while !worker.is_finished() {
                thread::park_timeout(PATIENCE);
                if raised.is_none() {
                    #[expect(
                        clippy::redundant_closure_for_method_calls,
                        reason = "the method itself is not general enough in its lifetime"
                    )]
                    let signal = Python::attach(|py| py.check_signals());
                    raised = signal.err();
                    stop.store(raised.is_some(), Ordering::Relaxed);
                }
            }
            (worker.join(), raised)
        })
    });
    match (done, raised) {
        (_, Some(raised)) => Err(raised),
        (Ok(done), None) => Ok(done),
        // pyo3 makes a Python exception of it
        (Err(panic), None) => std::panic::resume_unwind(panic),
    }
}
