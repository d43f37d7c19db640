//! Parts of work that were done apart: whether they are of one work, their order, and files that say so and are whole.

use std::io::Read;
use std::path::Path;

use super::error::Failure;
use crate::input::{InputFile, open, read_all, read_file};
use crate::shard::Shard;

/// The SHA-256 of all other lines of a part, its first line.
const SUM: &str = "part_sha256";

/// Most bytes of a part and of an input, and of the header that tells what a part is of.
pub(super) const MOST_BYTES: u64 = 4 << 30;
const HEAD_BYTES: u64 = 1 << 16;

/// What a part says of itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct Claim<'a> {
    pub(super) path: &'a Path,
    pub(super) shard: Shard,
    /// SHA-256 of the whole work.
    pub(super) whole: &'a str,
}

/// Places of the parts in their order, 1 to `of`; all of them are of one work. `differ` says what two are parts of otherwise, as
/// in "scans: another subject", `one` what to give, as in "of one scan". Files and folders are claimed alike.
///
/// # Errors
/// Parts of other work or of another number of parts, a part that is there twice, or is missing.
pub(super) fn of_one_work(
    parts: &[Claim<'_>],
    differ: &str,
    one: &str,
) -> Result<Vec<usize>, Failure> {
    let Some(first) = parts.first() else { return Err(Failure::bad("give the parts")) };
    for other in parts {
        let differ = if first.whole != other.whole {
            format!("are parts of different {differ}")
        } else if first.shard.of != other.shard.of {
            "are parts of different numbers of parts".to_owned()
        } else {
            continue;
        };
        let two = format!("{} and {}", first.path.display(), other.path.display());
        return Err(Failure::bad(format!("{two} {differ}; give the parts {one}")));
    }
    let shards: Vec<(&Path, Shard)> = parts.iter().map(|part| (part.path, part.shard)).collect();
    in_order(&shards, first.shard.of)
}

/// The text of a part with its checksum as the first line.
pub(super) fn sealed(text: &str) -> String {
    format!("# {SUM}: {}\n{text}", InputFile::of_bytes("", text.as_bytes()).sha256)
}

/// The text of a part without its checksum, which must be right. `no_part` says what else it is, `again` what mends it.
///
/// # Errors
/// A file that cannot be read, is no part, or is damaged.
pub(super) fn opened(path: &Path, no_part: &str, again: &str) -> Result<String, Failure> {
    let bad = |what: &str| Failure::bad(format!("{}: {what}", path.display()));
    if path.is_dir() {
        return Err(bad("this is a folder beside files of parts; give files of `--shard` alone"));
    }
    let bytes = read_file(path, MOST_BYTES)
        .map_err(|e| bad(&format!("{e}; give the files of all parts")))?;
    let text = String::from_utf8_lossy(&bytes);
    if header(&text, SUM).is_none() {
        return Err(bad(no_part));
    }
    match text.split_once('\n').filter(|(first, rest)| sealed(rest) == format!("{first}\n{rest}")) {
        Some((_, rest)) => Ok(rest.to_owned()),
        None => Err(bad(&format!("it was cut off or changed since it was written; {again}"))),
    }
}

/// Whether the header of a file has a key.
pub(super) fn has_header(path: &Path, key: &str) -> bool {
    let head = || read_all(open(path)?.take(HEAD_BYTES), HEAD_BYTES);
    path.is_file()
        && head().is_ok_and(|head| header(&String::from_utf8_lossy(&head), key).is_some())
}

/// The value of a header line.
pub(super) fn header<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    let lines = text.lines().map_while(|line| line.strip_prefix('#'));
    lines
        .filter_map(|line| line.split_once(':'))
        .find(|(k, _)| k.trim() == key)
        .map(|(_, v)| v.trim())
}

/// Places of the parts in their order, 1 to `of`.
///
/// # Errors
/// A part that is there twice, or is missing.
fn in_order(parts: &[(&Path, Shard)], of: usize) -> Result<Vec<usize>, Failure> {
    let mut owners: Vec<Option<usize>> = vec![None; of];
    for (place, (folder, shard)) in parts.iter().enumerate() {
        if let Some(other) = owners[shard.part - 1].replace(place) {
            return Err(Failure::bad(format!(
                "{} and {} are both part {shard}; give each part once",
                parts[other].0.display(),
                folder.display()
            )));
        }
    }
    let missing: Vec<String> =
        (1..=of).filter(|k| owners[k - 1].is_none()).map(|k| format!("{k}/{of}")).collect();
    if !missing.is_empty() {
        let missing = missing.join(", ");
        return Err(Failure::bad(format!("parts are missing: {missing}; give all of them")));
    }
    Ok(owners.into_iter().flatten().collect())
}
