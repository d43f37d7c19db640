//! Pairs of directions from a file or a pipe of any length, a piece at a time.

use std::fs::File;
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::atomic::Ordering;

use asperity_core::direction::Direction;
use rayon::prelude::*;
use tempfile::SpooledTempFile;

use super::error::Failure;
use super::interrupt;
use crate::input;
use crate::message::excerpt;

/// The first line of unit vectors.
pub(super) const COLUMNS: &str = "wix,wiy,wiz,wox,woy,woz";
/// The first line of angles in degrees: theta from +z, 0 to 180; phi about it, from x to y.
pub(super) const ANGLES: &str = "theta_i,phi_i,theta_o,phi_o";

/// How directions are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Columns {
    /// As unit vectors.
    Vectors,
    /// As angles.
    Angles,
}

impl Columns {
    /// The first line.
    pub(super) fn head(self) -> &'static str {
        match self {
            Self::Vectors => COLUMNS,
            Self::Angles => ANGLES,
        }
    }
}
/// Bytes that are read at a time.
const PIECE: usize = 1 << 20;
/// Longest line, bytes.
const LINE: usize = 1 << 16;
/// Most bytes of a pipe, which are kept on the disk until they have been checked.
const MOST_PIPED: u64 = 4 << 30;
/// Bytes of a pipe that are kept in memory.
const IN_MEMORY: usize = 8 << 20;
/// Deviation of a length from 1 that is taken as rounding; more is taken as a mistake.
const LENGTH: f64 = 1e-3;

/// A row: its text as it was, and its directions `wi` and `wo`.
pub(super) type Pair<'a> = (&'a str, Direction<f64>, Direction<f64>);

const FIRST_LINE: &str = "`wix,wiy,wiz,wox,woy,woz` or `theta_i,phi_i,theta_o,phi_o`";

/// Where pairs come from. They can be gone through again: what comes from a pipe is kept.
pub(super) struct Pairs {
    name: String,
    source: Source,
    /// Found when they are gone through.
    columns: Option<Columns>,
}

enum Source {
    File(File),
    /// A pipe and what has been read of it.
    Pipe(Box<dyn Read>, SpooledTempFile),
    Kept(SpooledTempFile),
}

impl Pairs {
    /// Opens a file; stdin without one, or for `-`.
    pub(super) fn open(input: Option<&Path>) -> Result<Self, Failure> {
        let pipe = |from: Box<dyn Read>| Source::Pipe(from, SpooledTempFile::new(IN_MEMORY));
        let Some(path) = input.filter(|path| *path != Path::new("-")) else {
            return Ok(Self {
                name: "stdin".into(),
                source: pipe(Box::new(std::io::stdin())),
                columns: None,
            });
        };
        let name = path.display().to_string();
        let failed = |e| Failure::bad(format!("{name}: cannot be read ({e}); check the path"));
        if path.is_dir() {
            return Err(failed(std::io::Error::new(ErrorKind::IsADirectory, "it is a folder")));
        }
        let file = input::open(path).map_err(failed)?;
        let source = if path.is_file() { Source::File(file) } else { pipe(Box::new(file)) };
        Ok(Self { name, source, columns: None })
    }

    /// How the directions are written, as far as it is known: after they have been gone through.
    pub(super) fn columns(&self) -> Columns {
        self.columns.unwrap_or(Columns::Vectors)
    }

    /// Goes through all pairs, in order, some thousands at a time.
    ///
    /// # Errors
    /// Those of `work`; a line that holds no pair; a signal.
    pub(super) fn each(
        &mut self,
        mut work: impl FnMut(&[Pair<'_>]) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let name = self.name.clone();
        let failed = |e| Failure::bad(format!("{name}: cannot be read ({e}); check the path"));
        self.source.rewind().map_err(failed)?;
        let mut lines = Lines { name: &name, header: None, count: 0 };
        let (mut bytes, mut length) = (Vec::new(), 0);
        loop {
            // who waits for a pipe cannot look at a flag: there a signal ends the program
            let is_pipe = matches!(self.source, Source::Pipe(..));
            if !is_pipe && interrupt::flag().load(Ordering::SeqCst) {
                return Err(Failure::No("interrupted before all pairs were evaluated".into()));
            }
            let kept = bytes.len();
            let read = self.source.read(&mut bytes).map_err(failed)?;
            length += read as u64;
            if length > MOST_PIPED && is_pipe {
                let most = MOST_PIPED >> 30;
                return Err(Failure::bad(format!(
                    "{name}: more than {most} GiB come from the pipe; give fewer pairs, or a file with --input"
                )));
            }
            let last = bytes[kept..].iter().rposition(|b| *b == b'\n').map(|k| kept + k + 1);
            let end = if read == 0 { bytes.len() } else { last.unwrap_or(0) };
            let rest = bytes.split_off(end);
            if rest.len() > LINE {
                return Err(lines
                    .bad(lines.count + 1, "the line is too long; write the numbers of one pair"));
            }
            let text = std::str::from_utf8(&bytes).map_err(|_| {
                let what = format!("{name}: is not text; give CSV with the columns {COLUMNS}");
                Failure::Bad(what)
            })?;
            let pairs = lines.parse(text)?;
            if !pairs.is_empty() {
                work(&pairs)?;
            }
            if read == 0 {
                break;
            }
            bytes = rest;
        }
        self.source.is_read();
        self.columns = lines.header;
        if lines.header.is_some() {
            Ok(())
        } else {
            let what = format!("there is nothing to read; the first line must be {FIRST_LINE}");
            Err(lines.bad(1, &what))
        }
    }
}

impl Source {
    fn rewind(&mut self) -> std::io::Result<()> {
        match self {
            Self::File(file) => file.seek(SeekFrom::Start(0)).map(|_| ()),
            Self::Kept(file) => file.seek(SeekFrom::Start(0)).map(|_| ()),
            Self::Pipe(..) => Ok(()),
        }
    }

    /// Adds the next piece; gives its length, 0 at the end.
    fn read(&mut self, bytes: &mut Vec<u8>) -> std::io::Result<usize> {
        let from = bytes.len();
        match self {
            Self::File(file) => file.take(PIECE as u64).read_to_end(bytes),
            Self::Kept(file) => file.take(PIECE as u64).read_to_end(bytes),
            Self::Pipe(pipe, kept) => {
                let read = pipe.take(PIECE as u64).read_to_end(bytes)?;
                kept.write_all(&bytes[from..])?;
                Ok(read)
            }
        }
    }

    /// All of a pipe is read: from now on it is what was kept.
    fn is_read(&mut self) {
        if let Self::Pipe(_, kept) = self {
            *self = Self::Kept(std::mem::replace(kept, SpooledTempFile::new(IN_MEMORY)));
        }
    }
}

/// How far the text is read.
struct Lines<'a> {
    name: &'a str,
    /// The columns, once their line has been seen.
    header: Option<Columns>,
    /// Lines so far.
    count: usize,
}

impl Lines<'_> {
    fn bad(&self, line: usize, what: &str) -> Failure {
        Failure::bad(format!("{}:{line}: {what}", self.name))
    }

    /// The pairs of the next lines.
    fn parse<'t>(&mut self, text: &'t str) -> Result<Vec<Pair<'t>>, Failure> {
        let mut rows = Vec::new();
        for line in text.lines() {
            self.count += 1;
            let line = line.trim().trim_start_matches('\u{feff}');
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            if self.header.is_some() {
                rows.push((self.count, line));
                continue;
            }
            let found: String = line.split(',').map(str::trim).collect::<Vec<_>>().join(",");
            let columns =
                [Columns::Vectors, Columns::Angles].into_iter().find(|c| c.head() == found);
            if columns.is_none() {
                return Err(self.bad(self.count, &format!("the first line must be {FIRST_LINE}")));
            }
            self.header = columns;
        }
        let columns = self.header.unwrap_or(Columns::Vectors);
        let parsed: Vec<Result<Pair<'_>, String>> =
            rows.par_iter().map(|(_, line)| pair(line, columns)).collect();
        let named = |(parsed, (line, _)): (Result<_, String>, &(usize, &str))| {
            parsed.map_err(|what| self.bad(*line, &what))
        };
        parsed.into_iter().zip(&rows).map(named).collect()
    }
}

/// The pair in a row.
fn pair(line: &str, columns: Columns) -> Result<Pair<'_>, String> {
    match columns {
        Columns::Vectors => {
            let [ix, iy, iz, ox, oy, oz] = numbers(line, columns)?;
            Ok((line, vector("wi", [ix, iy, iz])?, vector("wo", [ox, oy, oz])?))
        }
        Columns::Angles => {
            let [theta_i, phi_i, theta_o, phi_o] = numbers(line, columns)?;
            Ok((line, angles("theta_i", theta_i, phi_i)?, angles("theta_o", theta_o, phi_o)?))
        }
    }
}

/// The numbers of a row, as many as there are columns.
fn numbers<const N: usize>(line: &str, columns: Columns) -> Result<[f64; N], String> {
    let mut values = [0.0; N];
    let mut count = 0;
    for field in line.split(',') {
        let field = field.trim();
        let value = field.parse::<f64>().ok().filter(|x| x.is_finite());
        let not_finite =
            || format!("`{}` is not a finite number; write one like 0.5", excerpt(field));
        let value = value.ok_or_else(not_finite)?;
        if let Some(slot) = values.get_mut(count) {
            *slot = value;
        }
        count += 1;
    }
    if count == N {
        return Ok(values);
    }
    let wanted = if N == 6 { "six" } else { "four" };
    Err(format!("{count} values; write {wanted}: {}", columns.head()))
}

fn vector(which: &str, v: [f64; 3]) -> Result<Direction<f64>, String> {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    if (length - 1.0).abs() > LENGTH {
        return Err(format!("{which} has length {length}; give a unit vector"));
    }
    Direction::new(v[0], v[1], v[2]).ok_or_else(|| format!("{which} is no direction"))
}

fn angles(which: &str, theta_deg: f64, phi_deg: f64) -> Result<Direction<f64>, String> {
    if !(0.0..=180.0).contains(&theta_deg) {
        return Err(format!("{which} is {theta_deg}; give 0 to 180 degrees from +z"));
    }
    let ((sin, cos), (y, x)) = (theta_deg.to_radians().sin_cos(), phi_deg.to_radians().sin_cos());
    // in the surface there is no light, not what rounding leaves of it
    let cos = if theta_deg.total_cmp(&90.0).is_eq() { 0.0 } else { cos };
    Direction::new(sin * x, sin * y, cos).ok_or_else(|| format!("{which} is no direction"))
}

#[cfg(test)]
mod tests {
    use super::{ANGLES, COLUMNS, Columns, Pairs, Source};
    use crate::cli::error::Failure;
    use std::io::Read;
    use tempfile::SpooledTempFile;

    /// A pipe that gives a few bytes at a time.
    struct Slow(Vec<u8>, usize);

    impl Read for Slow {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            let n = buffer.len().min(7).min(self.0.len() - self.1);
            buffer[..n].copy_from_slice(&self.0[self.1..self.1 + n]);
            self.1 += n;
            Ok(n)
        }
    }

    fn piped(text: String) -> Pairs {
        let pipe = Box::new(Slow(text.into_bytes(), 0));
        let source = Source::Pipe(pipe, SpooledTempFile::new(100));
        Pairs { name: "pipe".into(), source, columns: None }
    }

    #[test]
    fn pieces_hold_what_the_whole_holds_twice() {
        let rows: Vec<String> = (0..40_000)
            .map(|k| {
                format!(
                    "{:e},0,1,0,0,{}1",
                    1e-6 * f64::from(k % 1000),
                    if k % 2 == 0 { "" } else { "-" }
                )
            })
            .collect();
        let mut pairs = piped(format!("# comment\n{COLUMNS}\r\n\n{}", rows.join("\n")));
        for _ in 0..2 {
            let (mut found, mut pieces) = (Vec::new(), 0);
            let add = |piece: &[super::Pair<'_>]| {
                pieces += 1;
                found.extend(piece.iter().map(|p| p.0.to_owned()));
                Ok(())
            };
            assert!(pairs.each(add).is_ok());
            assert!(found == rows && pieces > 0, "{} in {pieces}", found.len());
        }
    }

    #[test]
    fn the_first_bad_line_is_named_wherever_it_is() {
        let good = "0,0,1,0,0,1\n".repeat(120_000);
        let mut pairs = piped(format!("{COLUMNS}\n{good}0,0,1,0,0,2\n{good}x\n"));
        let error = format!("{:?}", pairs.each(|_| Ok(())).unwrap_err());
        assert!(error.contains("pipe:120002: wo has length 2"), "{error}");
        let error = format!("{:?}", piped("0".repeat(3 << 20)).each(|_| Ok(())).unwrap_err());
        assert!(error.contains("pipe:1: the line is too long"), "{error}");
    }

    #[test]
    fn angles_are_directions() {
        let piped = |text: String| {
            let pipe = Box::new(Slow(text.into_bytes(), 0));
            let source = Source::Pipe(pipe, SpooledTempFile::new(100));
            Pairs { name: "pipe".into(), source, columns: None }
        };
        let mut found = Vec::new();
        let mut pairs = piped(format!("{ANGLES}\n30,0,150,90\n90,45,0,7\n"));
        pairs
            .each(|some| {
                found.extend(some.iter().flat_map(|pair| [pair.1.xyz(), pair.2.xyz()]));
                Ok(())
            })
            .unwrap();
        assert_eq!(pairs.columns(), Columns::Angles);
        let (half, cos, diagonal) = (0.5, 0.75_f64.sqrt(), 0.5_f64.sqrt());
        let right =
            [[half, 0.0, cos], [0.0, half, -cos], [diagonal, diagonal, 0.0], [0.0, 0.0, 1.0]];
        for (found, right) in found.iter().zip(right) {
            for (a, b) in found.iter().zip(right) {
                assert!((a - b).abs() < 1e-15, "{found:?}");
            }
        }
        for (row, what) in
            [("181,0,0,0", "0 to 180"), ("1,2,3", "write four"), ("a,0,0,0", "finite")]
        {
            let done = piped(format!("{ANGLES}\n{row}\n")).each(|_| Ok(()));
            let Err(Failure::Bad(said)) = done else { panic!("{row}") };
            assert!(said.contains(what) && said.starts_with("pipe:2:"), "{said}");
        }
    }
}
