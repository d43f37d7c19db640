//! Parts of a work whose pieces are numbers: a file of each part, and the same command with what all of them have found.
//!
//! A file begins with the checksum of the rest. It names the part, the command without `--shard` and `-o`, and the SHA-256 of
//! that command, the files it reads, and the version; then there is a line for each piece.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::error::Failure;
use super::parts::{Claim, MOST_BYTES, has_header, header, of_one_work, opened, sealed};
use crate::input::{InputFile, read_file};
use crate::shard::{Results, Shard};

/// Header keys: which part, of what, and the command.
const PART: &str = "work_part";
const WHOLE: &str = "work_of";
const COMMAND: &str = "command";
/// Between the name of a piece and its numbers.
const COLON: &str = ": ";

/// What a part has found.
#[derive(Debug)]
pub(super) struct WorkPart {
    shard: Shard,
    whole: String,
    /// The command line of the whole, without an output.
    command: Vec<String>,
    pub(super) pieces: Results,
}

impl WorkPart {
    /// # Errors
    /// An input that cannot be read.
    pub(super) fn new(shard: Shard, command: &[String], pieces: Results) -> Result<Self, Failure> {
        let command = of_whole(command);
        Ok(Self { shard, whole: hash(&command)?, command, pieces })
    }

    /// The file.
    pub(super) fn text(&self) -> String {
        let command = serde_json::Value::from(self.command.clone());
        let mut text = format!(
            "# {PART}: {}\n# {WHOLE}: {}\n# {COMMAND}: {command}\n",
            self.shard, self.whole
        );
        for (name, numbers) in &self.pieces {
            let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
            // writing to a string cannot fail
            let _ = writeln!(text, "{name}{COLON}{}", numbers.join(" "));
        }
        sealed(&text)
    }

    fn read(path: &Path) -> Result<Self, Failure> {
        let again = "run the same command with --shard again";
        let text = opened(path, "this is no part; give files of `--shard`", again)?;
        let no_part =
            || Failure::bad(format!("{}: this is no part of such a work", path.display()));
        Self::parsed(&text).ok_or_else(no_part)
    }

    fn parsed(text: &str) -> Option<Self> {
        let shard = header(text, PART)?.parse().ok()?;
        let command = serde_json::from_str(header(text, COMMAND)?).ok()?;
        let piece = |line: &str| {
            let (name, numbers) = line.rsplit_once(COLON)?;
            let numbers = numbers.split_whitespace().map(|n| n.parse().ok());
            Some((name.to_owned(), numbers.collect::<Option<Vec<f64>>>()?))
        };
        let lines = text.lines().filter(|line| !line.starts_with('#'));
        let pieces = lines.map(piece).collect::<Option<Results>>()?;
        Some(Self { shard, whole: header(text, WHOLE)?.to_owned(), command, pieces })
    }
}

/// Whether a file is a part of such a work.
pub(super) fn is_work_part(path: &Path) -> bool {
    has_header(path, PART)
}

/// The command that makes the whole, and what all parts have found.
///
/// # Errors
/// Parts that are missing, doubled, damaged, or of other work, and inputs that have changed since.
pub(super) fn whole(parts: &[PathBuf], output: &Path) -> Result<(Vec<String>, Results), Failure> {
    let found = parts.iter().map(|path| WorkPart::read(path)).collect::<Result<Vec<_>, _>>()?;
    let claims: Vec<Claim<'_>> = found
        .iter()
        .zip(parts)
        .map(|(part, path)| Claim { path, shard: part.shard, whole: &part.whole })
        .collect();
    of_one_work(&claims, "commands: other input, options or version", "of one command")?;
    let Some(first) = found.first() else { return Err(Failure::bad("give the parts")) };
    let mut command = first.command.clone();
    if hash(&command)? != first.whole {
        return Err(Failure::bad(format!(
            "the input of `asperity {}` is not what it was when the parts were made, or this is another version; merge with the \
             files, and in the folder, of the parts",
            command[1..].join(" ")
        )));
    }
    command.extend(["-o".to_owned(), output.to_string_lossy().into_owned()]);
    Ok((command, found.into_iter().flat_map(|part| part.pieces).collect()))
}

/// A command line without `--shard` and without its output; the name of the program is that of all.
fn of_whole(command: &[String]) -> Vec<String> {
    let mut rest = command.iter().skip(1);
    let mut kept = vec!["asperity".to_owned()];
    while let Some(argument) = rest.next() {
        match argument.as_str() {
            "--shard" | "-o" | "--output" => {
                rest.next();
            }
            a if ["--shard=", "--output=", "-o"].iter().any(|flag| a.starts_with(flag)) => {}
            a => kept.push(a.to_owned()),
        }
    }
    kept
}

/// SHA-256 of a command, the version, and the files that it names.
fn hash(command: &[String]) -> Result<String, Failure> {
    let mut text = format!("{}\n{command:?}\n", env!("CARGO_PKG_VERSION"));
    for argument in &command[1..] {
        let path = Path::new(argument.split_once('=').map_or(argument.as_str(), |(_, file)| file));
        if path.is_file() {
            let bytes = read_file(path, MOST_BYTES)
                .map_err(|e| Failure::bad(format!("{}: {e}", path.display())))?;
            let _ = writeln!(text, "{}", InputFile::of_bytes(path, &bytes).sha256);
        }
    }
    Ok(InputFile::of_bytes("", text.as_bytes()).sha256)
}

#[cfg(test)]
mod tests {
    use super::{WorkPart, of_whole};
    use crate::shard::{Results, Shard};

    fn words(line: &str) -> Vec<String> {
        line.split(' ').map(str::to_owned).collect()
    }

    #[test]
    fn the_whole_has_neither_part_nor_output() {
        let given =
            words("./asperity check --map m --shard 1/3 -o=x --ior 1.5 --output y --shard=2/3 -oz");
        assert_eq!(of_whole(&given), words("asperity check --map m --ior 1.5"));
    }

    #[test]
    fn a_part_is_read_as_it_was_written() {
        let numbers = vec![0.1 + 0.2, -0.0, f64::NAN, f64::INFINITY, 5e-324];
        let pieces = Results::from([("a: b 1".into(), Vec::new()), ("c 7".into(), numbers)]);
        let part = WorkPart {
            shard: Shard { part: 2, of: 3 },
            whole: "abc".into(),
            command: words("asperity check \"a b\""),
            pieces,
        };
        let text = part.text();
        let (_, rest) = text.split_once('\n').unwrap();
        let again = WorkPart::parsed(rest).unwrap();
        let bits = |p: &WorkPart| -> Vec<Vec<u64>> {
            p.pieces.values().map(|v| v.iter().map(|x| x.to_bits()).collect()).collect()
        };
        assert_eq!(
            (again.shard, &again.whole, &again.command),
            (part.shard, &part.whole, &part.command)
        );
        assert_eq!(bits(&again), bits(&part));
    }
}
