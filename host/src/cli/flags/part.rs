//! The flag of a part of a work, for verbs whose pieces are numbers: balances, rays of a table, replicas.

use std::sync::Arc;

use crate::cli::error::Failure;
use crate::cli::work_part::WorkPart;
use crate::cli::{interrupt, print};
use crate::output::AtomicFile;
use crate::shard::{Piece, Pieces, Results, Shard};

/// One part of a work, or all of them.
#[derive(Clone, Debug, clap::Args)]
pub(in crate::cli) struct PartFlags {
    /// Do part I of N only and write what it has found to -o; `merge` then runs the same command with what all parts have found
    #[arg(long, value_name = "I/N", requires = "output", hide_short_help = true)]
    shard: Option<Shard>,
    /// The whole command line.
    #[arg(skip)]
    command: Vec<String>,
    #[arg(skip)]
    pieces: Option<Arc<Pieces>>,
}

impl PartFlags {
    /// Takes the command line, and what parts have found.
    pub(in crate::cli) fn begin(
        &mut self,
        kind: Piece,
        command: &[String],
        known: Option<Results>,
    ) {
        command.clone_into(&mut self.command);
        let known = known.map(|known| Pieces::with_known(kind, known));
        let of_part = self.shard.map(|shard| Pieces::of_part(kind, shard));
        self.pieces = known.or(of_part).map(Arc::new);
    }

    /// What the work shares with other machines.
    pub(in crate::cli) fn pieces(&self) -> Option<&Pieces> {
        self.pieces.as_deref()
    }

    /// Whether only a part is done.
    pub(in crate::cli) fn is_part(&self) -> bool {
        self.shard.is_some()
    }

    /// Refuses a part of a work that has no pieces.
    ///
    /// # Errors
    /// If only a part is to be done.
    pub(in crate::cli) fn need_pieces(&self, has_pieces: bool, why: &str) -> Result<(), Failure> {
        if self.is_part() && !has_pieces {
            return Err(Failure::bad(format!("--shard is of no use here: {why}; leave it out")));
        }
        Ok(())
    }

    /// Writes what the part has found to its output, without which there is no part.
    ///
    /// # Errors
    /// An interrupt, and trouble with files.
    pub(in crate::cli) fn finish(&self, output: Option<AtomicFile>) -> Result<(), Failure> {
        let (Some(shard), Some(pieces), Some(output)) = (self.shard, &self.pieces, output) else {
            return Ok(());
        };
        if interrupt::asked() {
            let why = format!("interrupted; part {shard} is not finished, and nothing was written");
            return Err(Failure::No(why));
        }
        let part = WorkPart::new(shard, &self.command, pieces.take_made())?;
        let (path, count) = (output.path().to_owned(), part.pieces.len());
        output.finish(part.text().as_bytes())?;
        print(&format!(
            "part {shard}, {count} pieces, is in {}; `asperity merge` makes the whole of all parts\n",
            path.display()
        ))
    }
}
