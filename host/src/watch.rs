//! How long work is watched: whether it has to end, and how far it is.

use std::fmt;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::shard::{Piece, Pieces};

/// What work tells whoever watches it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress<'a> {
    /// What is done from now on, in a few words.
    Now(&'a str),
    /// So many steps are done, of `all` (0: the number is not known).
    Done {
        /// Steps since the beginning.
        done: usize,
        /// Steps in all.
        all: usize,
    },
    /// So many more steps are done.
    More(u64),
}

/// A flag that ends the work, an ear for its progress, and what is known of its pieces.
///
/// Work looks at the flag often enough to end within a second, and then gives what it has or `None`, as its own
/// documentation says. Progress is told from any thread.
/// ```
/// use std::sync::atomic::AtomicBool;
///
/// use asperity::watch::{Progress, Watch};
///
/// let stop = AtomicBool::new(false); // set it from another thread to end the work
/// let watch = Watch::new(&stop, &|progress| {
///     if let Progress::Done { done, all } = progress {
///         println!("{done} of {all}");
///     }
/// });
/// assert!(!watch.is_stopped());
/// ```
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    stop: &'a AtomicBool,
    progress: &'a (dyn Fn(Progress<'_>) + Sync),
    pieces: Option<&'a Pieces>,
}

static NEVER: AtomicBool = AtomicBool::new(false);

impl Watch<'static> {
    /// Nobody watches: the work goes on to its end and tells nothing.
    pub fn nobody() -> Self {
        Self::silent(&NEVER)
    }
}

impl<'a> Watch<'a> {
    /// Work ends soon after `stop` is set, and tells its progress.
    pub fn new(stop: &'a AtomicBool, progress: &'a (dyn Fn(Progress<'_>) + Sync)) -> Self {
        Self { stop, progress, pieces: None }
    }

    /// Work ends soon after `stop` is set, and tells nothing.
    pub fn silent(stop: &'a AtomicBool) -> Self {
        Self::new(stop, &|_| ())
    }

    /// The same flag, nothing told: for a part of work whose steps are not those of the whole.
    pub fn quiet(self) -> Self {
        Self { progress: &|_| (), ..self }
    }

    /// The same flag with another ear.
    pub fn telling(self, progress: &'a (dyn Fn(Progress<'_>) + Sync)) -> Self {
        Self { progress, ..self }
    }

    /// The same of a work that is divided among machines.
    pub fn sharing(self, pieces: Option<&'a Pieces>) -> Self {
        Self { pieces, ..self }
    }

    /// Whether only a part of the work of this kind is done.
    pub fn is_part_of(self, kind: Piece) -> bool {
        self.pieces_of(kind).is_some_and(|pieces| pieces.shard().is_some())
    }

    fn pieces_of(self, kind: Piece) -> Option<&'a Pieces> {
        self.pieces.filter(|pieces| pieces.kind() == kind)
    }

    /// What piece `number` of those of a name gives: by `work`, or as another machine has found it. `None` if another part has
    /// it, if the work gives nothing, or if it was stopped.
    pub fn piece(
        self,
        kind: Piece,
        (name, number): (&str, usize),
        work: impl FnOnce() -> Option<Vec<f64>>,
    ) -> Option<Vec<f64>> {
        // one that was cut short is none
        let work = || work().filter(|_| !self.is_stopped());
        match self.pieces_of(kind) {
            Some(pieces) => pieces.piece(name, number, work),
            None => work(),
        }
    }

    /// Whether the work has to end.
    #[inline]
    pub fn is_stopped(self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Tells what is done from now on.
    pub fn now(self, what: &str) {
        (self.progress)(Progress::Now(what));
    }

    /// Tells that `done` steps of `all` are done.
    pub fn done(self, done: usize, all: usize) {
        (self.progress)(Progress::Done { done, all });
    }

    /// Tells the share of the work that is done, 0 to 1, and says whether to go on.
    pub fn share(self, done: f64) -> ControlFlow<()> {
        self.done((1000.0 * done) as usize, 1000);
        if self.is_stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Tells that `steps` more are done.
    pub fn more(self, steps: u64) {
        (self.progress)(Progress::More(steps));
    }
}

impl fmt::Debug for Watch<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Watch").field("stop", &self.stop).finish_non_exhaustive()
    }
}
