//! Parts of a scan: what the header of each says of the whole, and the whole of all parts.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::error::Failure;
use super::flags::subject::SubjectFlags;
use super::parts::{Claim, MOST_BYTES, header, of_one_work, opened, sealed};
use super::print;
use crate::input::{InputFile, read_file};
use crate::measurement::{Measurement, Metadata, Reading, csv, write};
use crate::output::AtomicFile;
use crate::reconstruct::{RayNoise, ScanRequest};
use crate::shard::Shard;

/// Header keys of a part: which one it is, of what, and the noise of its incidences.
const PART: &str = "part";
const WHOLE: &str = "part_of";
const NOISE: &str = "part_noise";

/// Which part of which scan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Part {
    pub(super) shard: Shard,
    /// Incidences and rotations of all parts.
    pub(super) incidences: usize,
    /// SHA-256 of the subject, the request and the version.
    whole: String,
}

impl Part {
    /// # Errors
    /// The file of the subject cannot be read again.
    pub(super) fn of(
        shard: Shard,
        request: &ScanRequest,
        (flags, path): (&SubjectFlags, &Path),
    ) -> Result<Self, Failure> {
        let bytes = read_file(path, MOST_BYTES)
            .map_err(|e| Failure::bad(format!("{}: {e}", path.display())))?;
        let file = InputFile::of_bytes(path, &bytes).sha256;
        let asked = ScanRequest { shard: None, ..request.clone() };
        let text = format!("{}\n{file}\n{asked:?}\n{flags:?}", env!("CARGO_PKG_VERSION"));
        let whole = InputFile::of_bytes("", text.as_bytes()).sha256;
        Ok(Self { shard, incidences: request.incidences(), whole })
    }

    /// Says in a header which part it is.
    pub(super) fn say(&self, noise: &[RayNoise], meta: &mut Metadata) {
        let mut say = |key: &str, value: String| meta.other.push((key.to_owned(), value));
        say(PART, self.shard.to_string());
        say(WHOLE, format!("{} incidences, {}", self.incidences, self.whole));
        if !noise.is_empty() {
            let one = |n: &RayNoise| format!("{:e} {:e} {}", n.squares, n.largest, n.readings);
            say(NOISE, noise.iter().map(one).collect::<Vec<_>>().join(", "));
        }
    }

    /// The file of a part that holds no incidence.
    pub(super) fn without_readings(&self) -> String {
        let mut meta = Metadata::default();
        self.say(&[], &mut meta);
        let mut text = String::new();
        for (key, value) in meta.entries() {
            let _ = writeln!(text, "# {key}: {value}");
        }
        sealed(&(text + "sigma_deg,theta_deg,reading\n"))
    }

    /// Number of incidences that it holds.
    fn held(&self) -> usize {
        (0..self.incidences).filter(|k| self.shard.holds(*k)).count()
    }
}

/// A part that was read.
struct Found<'a> {
    path: &'a Path,
    part: Part,
    noise: Vec<RayNoise>,
    /// `None` in a part that holds no incidence.
    scan: Option<Measurement>,
}

/// One file of all parts: the bytes that a single run would have written.
///
/// # Errors
/// Parts that are missing, doubled, unfinished, or of other scans.
pub(super) fn merge_scans(parts: &[PathBuf], output: &Path) -> Result<(), Failure> {
    let parts = parts.iter().map(|p| read(p)).collect::<Result<Vec<_>, _>>()?;
    let claims: Vec<Claim<'_>> = parts
        .iter()
        .map(|Found { path, part, .. }| Claim { path, shard: part.shard, whole: &part.whole })
        .collect();
    let order =
        of_one_work(&claims, "scans: another subject, other options or version", "of one scan")?;
    let scan = together(&order.into_iter().map(|place| &parts[place]).collect::<Vec<_>>())?;
    let mut text = Vec::new();
    write::write(&scan, &mut text).map_err(Failure::bad)?;
    AtomicFile::create(output)?.finish(&text)?;
    let (readings, of) = (scan.readings().len(), parts.len());
    print(&format!("{readings} readings of {of} parts are in {}\n", output.display()))
}

/// The scan of all parts, which are in their order.
fn together(parts: &[&Found<'_>]) -> Result<Measurement, Failure> {
    let incidences = parts[0].part.incidences;
    let of = |k: usize| parts[k % parts.len()];
    // the header of a single run is completed at its last incidence
    let last = of(incidences.saturating_sub(1)).scan.as_ref();
    let mut meta = last.map(|scan| scan.meta.clone()).unwrap_or_default();
    meta.other.retain(|(key, _)| ![PART, WHOLE, NOISE].contains(&key.as_str()));
    let noise: Vec<RayNoise> =
        (0..incidences).filter_map(|k| of(k).noise.get(k / parts.len()).copied()).collect();
    if !noise.is_empty() {
        meta.noise_floor_percent = RayNoise::percent(&noise);
    }
    let scans = parts.iter().filter_map(|part| part.scan.as_ref());
    let readings: Vec<Reading> = scans.flat_map(|scan| scan.readings().to_vec()).collect();
    Measurement::new(meta, readings).map_err(Failure::bad)
}

/// What is said of a file that is no part, and what mends one.
const NO_PART: &str = "this is no part of a scan; give the files of `scan --shard`";
const AGAIN: &str = "run `scan --shard` of this part again";

fn read(path: &Path) -> Result<Found<'_>, Failure> {
    let bad = |what: &str| Failure::bad(format!("{}: {what}", path.display()));
    let rest = &opened(path, NO_PART, AGAIN)?;
    let part = part_of(rest).ok_or_else(|| bad(NO_PART))?;
    let unfinished = || bad(&format!("it is not finished; {AGAIN}"));
    if part.held() == 0 {
        return Ok(Found { path, part, noise: Vec::new(), scan: None });
    }
    let scan = csv::parse(rest, path).map_err(Failure::bad)?;
    let mut held: Vec<(f64, f64)> =
        scan.by_plane().map(|p| (p.sigma_deg, p.rotation_deg)).collect();
    held.dedup();
    let noise = match header(rest, NOISE) {
        Some(line) => noise_of(line).filter(|n| n.len() == part.held()).ok_or_else(unfinished)?,
        None => Vec::new(),
    };
    if held.len() != part.held() {
        return Err(unfinished());
    }
    Ok(Found { path, part, noise, scan: Some(scan) })
}

fn part_of(text: &str) -> Option<Part> {
    let shard = header(text, PART)?.parse().ok()?;
    let (incidences, whole) = header(text, WHOLE)?.split_once(" incidences, ")?;
    Some(Part { shard, incidences: incidences.parse().ok()?, whole: whole.to_owned() })
}

fn noise_of(line: &str) -> Option<Vec<RayNoise>> {
    let one = |text: &str| {
        let mut words = text.split_whitespace();
        let squares = words.next()?.parse().ok()?;
        let largest = words.next()?.parse().ok()?;
        Some(RayNoise { squares, largest, readings: words.next()?.parse().ok()? })
    };
    line.split(',').map(one).collect()
}
