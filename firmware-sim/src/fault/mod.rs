//! What goes wrong on purpose: in the machine, and on the line.

mod link;
mod machine;

pub use link::{Direction, Link, LinkFaults};
pub(crate) use machine::Injected;
pub use machine::MachineFault;
