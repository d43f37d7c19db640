//! Every method on every sample, and all that is written of it: the common part of `compare` and `demo`.
//!
//! | module | concept |
//! |---|---|
//! | `booth` | the methods of a sample in the light booth |
//! | `cuts` | Maxwell's equations on cuts of the map of a sample |
//! | `crew` | several fits at once, within a budget of memory |
//! | `sample` | a sample: which methods can be tried, its fits and plots |

mod booth;
mod crew;
mod cuts;
mod sample;

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crew::Job;
use sample::Planned;

use super::error::{Failure, all};
use super::fitted::warn_of_failed;
use super::progress::Board;
use super::{interrupt, say};
use crate::output::{AtomicFile, ResultFolder, check_all, finish_all, internal, write_text};
use crate::provenance::InputFile;
use crate::reconstruct::{Attempt, Cell, Comparison, Index, SampleResult, Store};
use crate::report::{self, FigureFiles, Origin};
use crate::shard::Shard;

pub(super) use sample::Sample;

/// All that is to be done, and how it is introduced.
pub(super) struct Work<'a> {
    /// One line.
    pub(super) title: String,
    /// What the data are.
    pub(super) what: String,
    /// The methods, in the order of the columns.
    pub(super) methods: Vec<String>,
    /// The samples, in the order of the rows, then those with the maps of the lit spots.
    pub(super) samples: Vec<Sample<'a>>,
    /// Whether it is said how long it took.
    pub(super) timing: bool,
    /// Whether the fits are ranked by what the data support.
    pub(super) rank: bool,
    /// Whether the methods are rendered in the light booth.
    pub(super) render: bool,
    /// Cuts of each map on which Maxwell's equations are solved.
    pub(super) rigorous: Option<usize>,
    /// Fits at once; as many as threads without it.
    pub(super) jobs: Option<usize>,
    /// The part of the fits that is made; all without it.
    pub(super) shard: Option<Shard>,
    /// Memory for them, bytes; half of what is free without it.
    pub(super) memory: Option<u64>,
}

/// The files over all samples.
const SUMMARIES: [&str; 5] =
    ["compare.csv", "compare.md", "compare.json", "report.html", Index::NAME];

impl Work<'_> {
    /// Makes the folder, makes sure that everything can be written there and that nothing of it is read, fits, writes, and
    /// ends the verb. `say` prints the result, before the plots are drawn: they must not cost it.
    ///
    /// Fits that an earlier run into the same folder has finished are taken from there.
    pub(super) fn carry_out(
        &self,
        folder: &Path,
        say: &dyn Fn(&Comparison) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        self.index(&|_, _| false).check(folder).map_err(Failure::bad)?;
        let _made = ResultFolder::create(folder)?;
        let own = self.samples.iter().map(|s| ResultFolder::create(&folder.join(&s.name)));
        let _own = own.collect::<Result<Vec<_>, _>>()?;
        check_all(self.names(folder))?;
        let before = internal::text(&folder.join(Index::NAME));
        let [csv, markdown, json, html, index] =
            SUMMARIES.map(|n| AtomicFile::create(folder.join(n)));
        let (csv, markdown, json, html, index) = (csv?, markdown?, json?, html?, index?);
        self.index(&|_, _| false).mark(folder).map_err(|e| {
            Failure::Trouble(format!("{}: the index cannot be written: {e}", folder.display()))
        })?;
        let mut failures = Vec::new();
        let (attempts, is_new) = self.attempts(folder, &mut failures);
        let done = |name: &str, method: &str| {
            let rows = self.samples.iter().zip(&attempts).filter(|(s, _)| s.name == name);
            rows.flat_map(|(_, row)| row).any(|a| a.method == method && a.result.is_ok())
        };
        let now = self.index(&done).text();
        if let Some(shard) = self.shard {
            let written = index.finish(now.as_bytes());
            failures.extend(written.err().map(Failure::from));
            return end_part(shard, failures);
        }
        let mut attempts = attempts;
        let of_lit = attempts.split_off(self.rows().len());
        let results = self.rows().iter().zip(attempts);
        let result = |(sample, attempts): (&Sample<'_>, Vec<Attempt>)| {
            let rigorous = self.rigorous.and_then(|solved| {
                let done = cuts::solve(&folder.join(&sample.name), sample, solved);
                done.unwrap_or_else(|failure| {
                    failures.push(failure);
                    None
                })
            });
            SampleResult { rigorous, ..sample.result(attempts, self.rank) }
        };
        let mut comparison = Comparison {
            title: self.title.clone(),
            what: self.what.clone(),
            methods: self.methods.clone(),
            samples: results.map(result).collect(),
            timing: self.timing,
        };
        for (sample, attempts) in self.samples[self.rows().len()..].iter().zip(of_lit) {
            if let Some(result) = sample.lit_of.and_then(|of| comparison.samples.get_mut(of)) {
                result.lit = attempts;
            }
        }
        let is_drawn = !is_new && before == now && self.pictures(folder).all(|path| path.exists());
        let tables = finish_all(vec![
            (csv, comparison.csv().into_bytes()),
            (markdown, comparison.markdown().into_bytes()),
            (json, format!("{:#}\n", comparison.json()).into_bytes()),
            (index, now.into_bytes()),
        ]);
        failures.extend(tables.err().map(Failure::from));
        failures.extend(say(&comparison).err());
        let drawn = self.rows().iter().zip(&comparison.samples);
        for (sample, result) in drawn.filter(|_| !is_drawn) {
            sample.draw(&result.attempts, (folder, &mut failures));
        }
        let scans: Vec<_> = self.rows().iter().map(|sample| sample.task.measurement).collect();
        let mut origin = self.origin();
        if self.render && !interrupt::asked() {
            let of = self.rows().iter().zip(&comparison.samples);
            origin.booths = of
                .map(|(sample, result)| {
                    let done = booth::render(&folder.join(&sample.name), &result.attempts);
                    done.unwrap_or_else(|failure| {
                        failures.push(failure);
                        None
                    })
                })
                .collect();
        }
        let page = html.finish(report::page(&comparison, &scans, &origin).as_bytes());
        failures.extend(page.err().map(Failure::from));
        all(failures.into_iter().map(Err).chain([verdict(&comparison)]))
    }

    /// The index of the folder; `done` says which fits are there, by sample and method.
    fn index(&self, done: &dyn Fn(&str, &str) -> bool) -> Index {
        // methods may be added later; data and options may not
        let identity: Vec<String> =
            self.rows().iter().map(|s| s.task.key(&s.name, &vec![])).collect();
        Index {
            asperity: 1,
            title: self.title.clone(),
            shard: self.shard,
            comparison: InputFile::of_bytes("", identity.join("\n").as_bytes()).sha256,
            samples: self
                .samples
                .iter()
                .map(|s| s.indexed(&|method| done(&s.name, method)))
                .collect(),
        }
    }

    /// All fits, several at once, and whether any of them is new; a fit is written as soon as it is found. What cannot be
    /// written is said at the end.
    fn attempts(&self, folder: &Path, failures: &mut Vec<Failure>) -> (Vec<Vec<Attempt>>, bool) {
        let store = Store::new(folder);
        let mut found: Vec<Vec<Option<Attempt>>> = Vec::new();
        let mut jobs = Vec::new();
        let (mut kept, mut number) = (0, 0);
        for (s, sample) in self.samples.iter().enumerate() {
            let mut row = Vec::new();
            for (m, planned) in sample.plan.iter().enumerate() {
                number += usize::from(planned.laws.is_ok());
                if planned.laws.is_ok() && self.shard.is_some_and(|part| !part.holds(number - 1)) {
                    row.push(None);
                    continue;
                }
                let known = match &planned.laws {
                    Err(why) => {
                        say::note(format_args!("{}{}: {why}", self.prefix(sample), planned.method));
                        Some(Err(why.clone()))
                    }
                    Ok(_) => sample.kept(planned, store).map(Ok),
                };
                let known = known.map(|result| Attempt { method: planned.method.clone(), result });
                if known.is_none() {
                    jobs.push(Job { what: (s, m), bytes: sample.bytes(planned) });
                }
                kept += usize::from(known.as_ref().is_some_and(|a| a.result.is_ok()));
                row.push(known);
            }
            found.push(row);
        }
        if kept > 0 {
            say::note(format_args!("{kept} fits of an earlier run are taken as they are"));
        }
        let board = Board::new(jobs.len());
        let is_new = !jobs.is_empty();
        let done = Mutex::new((found, Vec::new()));
        let workers = self.jobs.unwrap_or_else(rayon::current_num_threads);
        let budget = self.memory.unwrap_or_else(crew::usual_budget);
        crew::carry_out(jobs, (workers, budget), &|(s, m)| {
            let sample = &self.samples[s];
            let planned = &sample.plan[m];
            let (attempt, unwritten) = self.attempt(sample, planned, store, &board);
            let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
            done.0[s][m] = Some(attempt);
            done.1.extend(unwritten);
        });
        let (found, unwritten) = done.into_inner().unwrap_or_else(PoisonError::into_inner);
        failures.extend(unwritten);
        (found.into_iter().map(|row| row.into_iter().flatten().collect()).collect(), is_new)
    }

    /// One method on one sample, and its files.
    fn attempt(
        &self,
        sample: &Sample<'_>,
        planned: &Planned,
        store: Store<'_>,
        board: &Board,
    ) -> (Attempt, Vec<Failure>) {
        let (method, prefix) = (&planned.method, self.prefix(sample));
        let (attempt, failed) = board.watch(&format!("{prefix}{method}"), |watch| {
            sample.task.attempt(method, &planned.laws, watch)
        });
        warn_of_failed(&failed);
        let mut failures = Vec::new();
        match &attempt.result {
            Ok(cell) => {
                let seconds = cell.seconds().unwrap_or(0.0);
                board.say(format_args!(
                    "{prefix}{}: {:.3} % in {seconds:.2} s",
                    cell.label,
                    cell.rmsd_percent()
                ));
                failures.extend(self.write(sample, planned, cell, store).err());
            }
            Err(why) => board.say(format_args!("{prefix}{method}: {why}")),
        }
        (attempt, failures)
    }

    /// The model, and the cell if it is finished.
    fn write(
        &self,
        sample: &Sample<'_>,
        planned: &Planned,
        cell: &Cell,
        store: Store<'_>,
    ) -> Result<(), Failure> {
        let mut cell = cell.clone();
        cell.model.timing = cell.model.timing.filter(|_| self.timing);
        let path = store.path(&sample.name, &planned.method);
        write_text(path.with_file_name(format!("{}.json", planned.method)), &cell.model.to_json())?;
        match &planned.key {
            Some(key) if !cell.is_interrupted() && !interrupt::asked() => {
                Ok(store.save((&sample.name, &planned.method), key, &cell)?)
            }
            _ => Ok(()),
        }
    }

    /// Where the page comes from; without timing nothing differs between two runs.
    fn origin(&self) -> Origin {
        let command: Vec<String> = std::env::args().skip(1).collect();
        Origin {
            command: self.timing.then(|| format!("asperity {}", command.join(" "))),
            date: self.timing.then(|| chrono::Utc::now().format("%Y-%m-%d").to_string()),
            booths: Vec::new(),
        }
    }

    /// The samples that are rows of the tables.
    fn rows(&self) -> &[Sample<'_>] {
        let count = self.samples.iter().take_while(|s| s.lit_of.is_none()).count();
        &self.samples[..count]
    }

    /// What goes before a line about a sample.
    fn prefix(&self, sample: &Sample<'_>) -> String {
        if self.samples.len() == 1 { String::new() } else { format!("{}: ", sample.name) }
    }

    /// All files that may be written.
    fn names(&self, folder: &Path) -> Vec<PathBuf> {
        let mut names: Vec<PathBuf> = SUMMARIES.iter().map(|name| folder.join(name)).collect();
        for sample in &self.samples {
            let models = self.methods.iter().map(|m| SampleResult::model_file(&sample.name, m));
            names.extend(models.map(|name| folder.join(name)));
            let cells = self.methods.iter().map(|m| Store::new(folder).path(&sample.name, m));
            names.extend(cells);
            names.extend(self.rigorous.map(|_| folder.join(&sample.name).join(cuts::NAME)));
        }
        names.extend(self.pictures(folder));
        names
    }

    /// The files of the plots.
    fn pictures(&self, folder: &Path) -> impl Iterator<Item = PathBuf> {
        let of = |sample: &Sample<'_>| {
            let own = folder.join(&sample.name);
            let figures = sample.figures();
            figures.iter().flat_map(|(stem, _)| FigureFiles::names(&own, stem)).collect::<Vec<_>>()
        };
        self.rows().iter().flat_map(of).collect::<Vec<_>>().into_iter()
    }
}

/// The end of a part: its tables are made of all parts together.
fn end_part(shard: Shard, failures: Vec<Failure>) -> Result<(), Failure> {
    say::note(format_args!(
        "part {shard} is done; `asperity merge` puts the parts together, and the same command without --shard makes the tables, \
         the pictures and what --render and --rigorous ask for"
    ));
    let stopped = interrupt::asked().then(|| {
        Err(Failure::No("interrupted; what was finished is kept, the same command goes on".into()))
    });
    all(failures.into_iter().map(Err).chain(stopped))
}

/// The end of the verb: no if the user stopped it, or a sample has no description.
fn verdict(comparison: &Comparison) -> Result<(), Failure> {
    if interrupt::asked() {
        return Err(Failure::No("interrupted; what was finished is written".into()));
    }
    let titles: Vec<&str> = comparison.undescribed().map(|s| s.title.as_str()).collect();
    if titles.is_empty() {
        return Ok(());
    }
    Err(Failure::No(format!("no method describes {}", titles.join(", "))))
}
