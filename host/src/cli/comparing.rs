//! Every method on every sample, and all that is written of it: the common part of `compare` and `demo`.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use super::error::Failure;
use super::fitted::Job;
use super::interrupt;
use super::trial::Trial;
use crate::measurement::noise;
use crate::output::{AtomicFile, write_text};
use crate::plot::{self, Scale};
use crate::report::{
    self, Attempt, Comparison, Entry, FigureError, FigureFiles, Picture, SampleResult,
};

/// A sample with the methods that are to be tried on it.
pub(super) struct Sample<'a> {
    /// What its files are called by.
    name: String,
    /// What people call it.
    title: String,
    job: Job<'a>,
    /// Each method with its laws, or why it cannot be used.
    plan: Vec<(String, Trial)>,
}

impl<'a> Sample<'a> {
    /// Finds out which methods can be used; `asked` says which of their optional parameters are fitted.
    ///
    /// # Errors
    /// If none can.
    pub(super) fn new(
        name: String,
        title: String,
        job: Job<'a>,
        methods: &[String],
        asked: &dyn Fn(&str) -> bool,
    ) -> Result<Self, Failure> {
        let with = |method: &String| (method.clone(), job.methods(method, None, asked));
        let plan: Vec<_> = methods.iter().map(with).collect();
        if let (true, Some((_, Err(why)))) = (plan.iter().all(|p| p.1.is_err()), plan.first()) {
            return Err(Failure::bad(format!("{}: {why}", job.input.path)));
        }
        Ok(Self { name, title, job, plan })
    }

    /// The plots, each by its stem: all incidences, then one by one.
    fn figures(&self) -> Vec<(String, Option<f64>)> {
        let sigmas: Vec<f64> = self.job.measurement.by_incidence().map(|i| i.sigma_deg).collect();
        let alone = plot::shown(sigmas.len()).into_iter().map(|k| sigmas[k]);
        let alone = alone.map(|sigma| (format!("{}-sigma{sigma}", self.name), Some(sigma)));
        std::iter::once((format!("{}-all", self.name), None)).chain(alone).collect()
    }

    /// One method after the other; a fit is written as soon as it is found.
    fn attempts(&self, folder: &Path, prefix: &str) -> Result<Vec<Attempt>, Failure> {
        let mut attempts = Vec::new();
        for (method, plan) in &self.plan {
            let stopped = interrupt::flag().load(Ordering::SeqCst);
            let result = match plan {
                Err(why) => Err(why.clone()),
                Ok(_) if stopped => Err("interrupted before it was begun".to_owned()),
                Ok(methods) => self.job.run(methods, prefix).map_err(|e| e.to_string()),
            };
            match &result {
                Ok((entry, model)) => {
                    let file = SampleResult::model_file(&self.name, method);
                    write_text(folder.join(file), &model.to_json())?;
                    let (rmsd, seconds) = (entry.fit.rmsd_percent, entry.fit.seconds);
                    eprintln!("{prefix}{}: {rmsd:.3} % in {seconds:.2} s", entry.label);
                }
                Err(why) => eprintln!("{prefix}{method}: {why}"),
            }
            attempts.push(Attempt { method: method.clone(), result });
        }
        Ok(attempts)
    }

    /// Draws all plots; gives those with all incidences. What cannot be drawn is said and left out.
    fn draw(&self, folder: &Path, attempts: &[Attempt]) -> Result<Vec<Picture>, Failure> {
        let entries: Vec<&Entry> = attempts.iter().filter_map(Attempt::entry).collect();
        let scan = self.job.measurement;
        let mut pictures = Vec::new();
        for (stem, sigma) in self.figures() {
            let figure = |scale| match sigma {
                None => report::figure(&self.title, scan, &entries, scale),
                Some(sigma) => report::figure_at(sigma, &self.title, scan, &entries, scale),
            };
            match FigureFiles::create(folder, &stem)?.write(&figure) {
                Ok(_) => {}
                Err(FigureError::Plot(e)) => {
                    eprintln!("warning: {stem} cannot be drawn: {e}");
                    continue;
                }
                Err(FigureError::Output(e)) => return Err(e.into()),
            }
            if sigma.is_none() {
                for (scale, caption) in [
                    (Scale::Linear, "Measured and fitted readings, linear scale."),
                    (Scale::LOG, "The same, logarithmic."),
                ] {
                    let svg = plot::svg(&figure(scale)).map_err(Failure::bad)?;
                    pictures.push(Picture { caption: caption.into(), svg });
                }
            }
        }
        Ok(pictures)
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
}

/// The files over all samples.
const SUMMARIES: [&str; 4] = ["compare.csv", "compare.md", "compare.json", "report.html"];

impl Work<'_> {
    /// Makes the folder, makes sure that everything can be written there and that nothing of it is read, fits, and writes.
    pub(super) fn carry_out(&self, folder: &Path) -> Result<Comparison, Failure> {
        make_folder(folder)?;
        self.check(folder)?;
        let [csv, markdown, json, html] = SUMMARIES.map(|n| AtomicFile::create(folder.join(n)));
        let (csv, markdown, json, html) = (csv?, markdown?, json?, html?);
        let mut results = Vec::new();
        let mut plots = Vec::new();
        for sample in &self.samples {
            let alone = self.samples.len() == 1;
            let prefix = if alone { String::new() } else { format!("{}: ", sample.name) };
            let attempts = sample.attempts(folder, &prefix)?;
            plots.push(sample.draw(folder, &attempts)?);
            results.push(SampleResult {
                name: sample.name.clone(),
                title: sample.title.clone(),
                noise_floor_percent: SampleResult::floor_of(&attempts)
                    .or_else(|| noise::before_fit(sample.job.measurement)),
                attempts,
            });
        }
        let comparison = Comparison {
            title: self.title.clone(),
            what: self.what.clone(),
            methods: self.methods.clone(),
            samples: results,
        };
        csv.finish(comparison.csv().as_bytes())?;
        markdown.finish(comparison.markdown().as_bytes())?;
        json.finish(format!("{:#}\n", comparison.json()).as_bytes())?;
        html.finish(report::page(&comparison, &plots).as_bytes())?;
        Ok(comparison)
    }

    /// Makes sure, before the long work, that every file can be written, and that none of them is an input.
    fn check(&self, folder: &Path) -> Result<(), Failure> {
        let inputs: Vec<PathBuf> = self
            .samples
            .iter()
            .flat_map(|s| std::iter::once(s.job.input).chain(s.job.map.map(|m| &m.input)))
            .filter_map(|input| Path::new(&input.path).canonicalize().ok())
            .collect();
        let mut outputs: Vec<PathBuf> = SUMMARIES.iter().map(|name| folder.join(name)).collect();
        for sample in &self.samples {
            let models = self.methods.iter().map(|m| SampleResult::model_file(&sample.name, m));
            outputs.extend(models.map(|name| folder.join(name)));
            let figures = sample.figures();
            outputs.extend(figures.iter().flat_map(|(stem, _)| FigureFiles::names(folder, stem)));
        }
        for output in outputs {
            drop(AtomicFile::create(&output)?);
            if output.canonicalize().is_ok_and(|path| inputs.contains(&path)) {
                return Err(Failure::bad(format!(
                    "{}: is an input and would be overwritten; choose another folder",
                    output.display()
                )));
            }
        }
        Ok(())
    }
}

/// The end of the verb: no if the user stopped it, or a sample has no description.
pub(super) fn verdict(comparison: &Comparison) -> Result<(), Failure> {
    if interrupt::flag().load(Ordering::SeqCst) {
        return Err(Failure::No("interrupted; what was finished is written".into()));
    }
    let titles: Vec<&str> = comparison.undescribed().map(|s| s.title.as_str()).collect();
    if titles.is_empty() {
        return Ok(());
    }
    Err(Failure::No(format!("no method describes {}", titles.join(", "))))
}

/// Makes a folder for results.
pub(super) fn make_folder(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|e| {
        Failure::bad(format!("{}: cannot be made ({e}); choose another folder", folder.display()))
    })
}
