//! Every method on every sample, and all that is written of it: the common part of `compare` and `demo`.

use std::path::{Path, PathBuf};

use super::error::{Failure, all};
use super::fitted::{trials, warn_of_failed};
use super::{interrupt, progress, say};
use crate::measurement::noise;
use crate::model::Rank;
use crate::output::{AtomicFile, ResultFolder, check_all, finish_all, write_text};
use crate::plot::{self, Scale};
use crate::reconstruct::{Attempt, Comparison, Entry, Grounds, SampleResult, Task, Trials};
use crate::report::{self, FigureError, FigureFiles, Picture};

/// A sample with the methods that are to be tried on it.
pub(super) struct Sample<'a> {
    /// What its files are called by.
    name: String,
    /// What people call it.
    title: String,
    task: Task<'a>,
    /// Each method with its laws, or why it cannot be used.
    plan: Vec<(String, Result<Trials, String>)>,
}

impl<'a> Sample<'a> {
    /// Finds out which methods can be used; `asked` says which of their optional parameters are fitted.
    ///
    /// # Errors
    /// If none can.
    pub(super) fn new(
        name: String,
        title: String,
        task: Task<'a>,
        methods: &[String],
        asked: &dyn Fn(&str) -> bool,
    ) -> Result<Self, Failure> {
        let with = |method: &String| (method.clone(), trials(&task, method, None, asked));
        let plan: Vec<_> = methods.iter().map(with).collect();
        if let (true, Some((_, Err(why)))) = (plan.iter().all(|p| p.1.is_err()), plan.first()) {
            let path = task.input.map(|input| input.path.as_str()).unwrap_or_default();
            return Err(Failure::bad(format!("{path}: {why}")));
        }
        Ok(Self { name, title, task, plan })
    }

    /// The plots, each by its stem: all incidences, then one by one.
    fn figures(&self) -> Vec<(String, Option<f64>)> {
        let sigmas: Vec<f64> = self.task.measurement.by_incidence().map(|i| i.sigma_deg).collect();
        let alone = plot::shown(sigmas.len()).into_iter().map(|k| sigmas[k]);
        let alone = alone.map(|sigma| (format!("{}-sigma{sigma}", self.name), Some(sigma)));
        std::iter::once((format!("{}-all", self.name), None)).chain(alone).collect()
    }

    /// One method after the other; a fit is written as soon as it is found. What cannot be written is said at the end.
    fn attempts(&self, work: &Work<'_>, to: (&Path, &mut Vec<Failure>)) -> Vec<Attempt> {
        let (folder, failures) = to;
        let alone = work.samples.len() == 1;
        let prefix = &if alone { String::new() } else { format!("{}: ", self.name) };
        let mut attempts = Vec::new();
        for (method, plan) in &self.plan {
            let bar = progress::counter(prefix);
            let (mut attempt, failed) = bar.watch(|watch| self.task.attempt(method, plan, watch));
            warn_of_failed(&failed);
            match &mut attempt.result {
                Ok((entry, model)) => {
                    let file = SampleResult::model_file(&self.name, method);
                    model.timing = model.timing.filter(|_| work.timing);
                    let written = write_text(folder.join(file), &model.to_json());
                    failures.extend(written.err().map(Failure::from));
                    let (rmsd, seconds) = (entry.fit.rmsd_percent, entry.fit.seconds);
                    say::note(format_args!(
                        "{prefix}{}: {rmsd:.3} % in {seconds:.2} s",
                        entry.label
                    ));
                }
                Err(why) => say::note(format_args!("{prefix}{method}: {why}")),
            }
            attempts.push(attempt);
        }
        attempts
    }

    /// The fits in the order of what the data support.
    fn rank(&self, attempts: &[Attempt]) -> (Vec<Rank>, Grounds) {
        let with_laws = attempts.iter().zip(&self.plan);
        let with_laws =
            with_laws.filter_map(|(attempt, (_, laws))| Some((attempt, laws.as_ref().ok()?)));
        let with_laws: Vec<_> = with_laws.collect();
        progress::counter("").watch(|watch| self.task.rank_attempts(&with_laws, watch))
    }

    /// Draws all plots; gives those with all incidences. What cannot be drawn is said and left out; after one that cannot
    /// be written no other is.
    fn draw(
        &self,
        attempts: &[Attempt],
        (folder, failures): (&Path, &mut Vec<Failure>),
    ) -> Vec<Picture> {
        let entries: Vec<&Entry> = attempts.iter().filter_map(Attempt::entry).collect();
        let scan = self.task.measurement;
        let mut pictures = Vec::new();
        for (stem, sigma) in self.figures() {
            let figure = |scale| match sigma {
                None => report::figure(&self.title, scan, &entries, scale),
                Some(sigma) => report::figure_at(sigma, &self.title, scan, &entries, scale),
            };
            let write = || FigureFiles::create(folder, &stem)?.write(&figure);
            let written = if failures.is_empty() { write() } else { Ok(Vec::new()) };
            match written {
                Ok(_) => {}
                Err(FigureError::Plot(e)) => {
                    say::note(format_args!("warning: {stem} cannot be drawn: {e}"));
                    continue;
                }
                Err(FigureError::Output(e)) => failures.push(e.into()),
            }
            if sigma.is_none() {
                for (scale, caption) in [
                    (Scale::Linear, "Measured and fitted readings, linear scale."),
                    (Scale::LOG, "The same, logarithmic."),
                ] {
                    let caption = caption.into();
                    let drawn = plot::svg(&figure(scale)).map(|svg| Picture { caption, svg });
                    pictures.extend(drawn.ok());
                }
            }
        }
        pictures
    }
}

/// All that is to be done, and how it is introduced.
pub(super) struct Work<'a> {
    /// One line.
    pub(super) title: String,
    /// What the data are.
    pub(super) what: String,
    /// The methods, in the order of the columns.
    pub(super) methods: Vec<String>,
    /// The samples, in the order of the rows.
    pub(super) samples: Vec<Sample<'a>>,
    /// Whether it is said how long it took.
    pub(super) timing: bool,
    /// Whether the fits are ranked by what the data support.
    pub(super) rank: bool,
}

/// The files over all samples.
const SUMMARIES: [&str; 4] = ["compare.csv", "compare.md", "compare.json", "report.html"];

impl Work<'_> {
    /// Makes the folder, makes sure that everything can be written there and that nothing of it is read, fits, writes, and
    /// ends the verb. `say` prints the result, before the plots are drawn: they must not cost it.
    pub(super) fn carry_out(
        &self,
        folder: &Path,
        say: &dyn Fn(&Comparison) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let _made = ResultFolder::create(folder)?;
        check_all(self.names(folder))?;
        let [csv, markdown, json, html] = SUMMARIES.map(|n| AtomicFile::create(folder.join(n)));
        let (csv, markdown, json, html) = (csv?, markdown?, json?, html?);
        let mut failures = Vec::new();
        let result = |sample: &Sample<'_>| {
            let attempts = sample.attempts(self, (folder, &mut failures));
            let (ranking, grounds) =
                if self.rank { sample.rank(&attempts) } else { (Vec::new(), Grounds::default()) };
            SampleResult {
                ranking,
                grounds,
                name: sample.name.clone(),
                title: sample.title.clone(),
                noise_floor_percent: SampleResult::floor_of(&attempts)
                    .or_else(|| noise::before_fit(sample.task.measurement)),
                attempts,
            }
        };
        let comparison = Comparison {
            title: self.title.clone(),
            what: self.what.clone(),
            methods: self.methods.clone(),
            samples: self.samples.iter().map(result).collect(),
            timing: self.timing,
        };
        let tables = finish_all(vec![
            (csv, comparison.csv().into_bytes()),
            (markdown, comparison.markdown().into_bytes()),
            (json, format!("{:#}\n", comparison.json()).into_bytes()),
        ]);
        failures.extend(tables.err().map(Failure::from));
        failures.extend(say(&comparison).err());
        let drawn = self.samples.iter().zip(&comparison.samples);
        let plots: Vec<_> =
            drawn.map(|(s, result)| s.draw(&result.attempts, (folder, &mut failures))).collect();
        let page = html.finish(report::page(&comparison, &plots).as_bytes());
        failures.extend(page.err().map(Failure::from));
        all(failures.into_iter().map(Err).chain([verdict(&comparison)]))
    }

    /// All files that may be written.
    fn names(&self, folder: &Path) -> Vec<PathBuf> {
        let mut names: Vec<PathBuf> = SUMMARIES.iter().map(|name| folder.join(name)).collect();
        for sample in &self.samples {
            let models = self.methods.iter().map(|m| SampleResult::model_file(&sample.name, m));
            names.extend(models.map(|name| folder.join(name)));
            let figures = sample.figures();
            names.extend(figures.iter().flat_map(|(stem, _)| FigureFiles::names(folder, stem)));
        }
        names
    }
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
