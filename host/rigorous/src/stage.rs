//! How a long solution is watched: what it is doing, how far it is, and whether it goes on.

use std::cell::Cell;
use std::ops::ControlFlow;

/// How far a solution is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// Which solution of the same problem, from 1: there are more if the number of nodes is raised.
    pub run: usize,
    /// What is being done.
    pub part: Part,
    /// Share of this solution that is done, 0 to 1, by the number of operations.
    pub done: f64,
}

/// The parts of a solution, in the order in which they are met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Integrals of the Green's functions over the surface.
    Kernels,
    /// The normal derivative is eliminated; both polarisations share this part.
    Elimination,
    /// The matrices of TE and TM are factored.
    Factors,
}

impl Part {
    /// The part in a few words, for a line of progress.
    pub fn words(self) -> &'static str {
        match self {
            Self::Kernels => "integrating the Green's functions",
            Self::Elimination => "eliminating the normal derivative",
            Self::Factors => "factoring the matrices of TE and TM",
        }
    }
}

/// Who is asked between two blocks of work whether it goes on; `Break` ends the work within some milliseconds.
pub type Watcher<'a> = &'a dyn Fn(Stage) -> ControlFlow<()>;

/// Goes on to the end.
pub fn nobody(_: Stage) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// The work was ended by whoever watched it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stopped;

/// Counts operations and asks the watcher.
pub(crate) struct Tally<'a> {
    watcher: Watcher<'a>,
    all: f64,
    done: Cell<f64>,
    part: Cell<Part>,
}

impl<'a> Tally<'a> {
    /// `all`: operations of the whole work.
    pub(crate) fn new(watcher: Watcher<'a>, all: f64) -> Self {
        Self { watcher, all, done: Cell::new(0.0), part: Cell::new(Part::Kernels) }
    }

    /// What is done from now on.
    pub(crate) fn enter(&self, part: Part) {
        self.part.set(part);
    }

    /// So many more operations are done.
    ///
    /// # Errors
    /// The watcher wants the work to end.
    pub(crate) fn spend(&self, operations: f64) -> Result<(), Stopped> {
        let done = self.done.get() + operations;
        self.done.set(done);
        let stage = Stage { run: 1, part: self.part.get(), done: (done / self.all).min(1.0) };
        match (self.watcher)(stage) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Stopped),
        }
    }
}
