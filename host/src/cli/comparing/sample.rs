//! A sample of a comparison: the methods that can be tried on it, its fits and its plots.

use std::path::Path;

use crate::cli::error::Failure;
use crate::cli::fitted::trials;
use crate::cli::{progress, say};
use crate::measurement::noise;
use crate::method::{Kind, Waves};
use crate::model::Rank;
use crate::plot;
use crate::reconstruct::{
    Attempt, Cell, Grounds, IndexedCell, IndexedSample, SampleResult, Store, SurfaceFigures, Task,
    Trials,
};
use crate::report::{self, Drawn, FigureError, FigureFiles};

/// A sample with the methods that are to be tried on it.
pub(in crate::cli) struct Sample<'a> {
    /// Its folder.
    pub(super) name: String,
    /// What people call it.
    title: String,
    pub(super) task: Task<'a>,
    pub(super) plan: Vec<Planned>,
    /// Of which sample, by its place, this has the map of the lit spot; it is set beside that one and is no row of its own.
    pub(super) lit_of: Option<usize>,
}

/// A method that is to be tried.
pub(super) struct Planned {
    pub(super) method: String,
    /// Its laws, or why it cannot be used.
    pub(super) laws: Result<Trials, String>,
    /// What names its data and options.
    pub(super) key: Option<String>,
}

impl<'a> Sample<'a> {
    /// Finds out which methods can be used; `asked` says which of their optional parameters are fitted.
    ///
    /// # Errors
    /// If none can.
    pub(in crate::cli) fn new(
        name: String,
        title: String,
        task: Task<'a>,
        methods: &[String],
        asked: &dyn Fn(&str) -> bool,
    ) -> Result<Self, Failure> {
        let with = |method: &String| {
            let laws = trials(&task, method, None, asked);
            let key = laws.as_ref().ok().map(|laws| task.key(method, laws));
            Planned { method: method.clone(), laws, key }
        };
        let plan: Vec<Planned> = methods.iter().map(with).collect();
        let all_fail = plan.iter().all(|p| p.laws.is_err());
        if let (true, Some(Planned { laws: Err(why), .. })) = (all_fail, plan.first()) {
            let path = task.input.map(|input| input.path.as_str()).unwrap_or_default();
            return Err(Failure::bad(format!("{path}: {why}")));
        }
        Ok(Self { name, title, task, plan, lit_of: None })
    }

    /// The same as the sample at `place` with the map of the spot that was lit.
    pub(in crate::cli) fn with_lit_map_of(self, place: usize) -> Self {
        Self { lit_of: Some(place), ..self }
    }

    /// Its entry in the index of the folder; `done` says which fits are there.
    pub(super) fn indexed(&self, done: &dyn Fn(&str) -> bool) -> IndexedSample {
        let cell = |p: &Planned| IndexedCell {
            method: p.method.clone(),
            key: p.key.clone(),
            model: done(&p.method).then(|| SampleResult::model_file(&self.name, &p.method)),
        };
        let inputs = self.task.input.into_iter().chain(self.task.map.map(|map| &map.input));
        IndexedSample {
            name: self.name.clone(),
            inputs: inputs.cloned().collect(),
            cells: self.plan.iter().map(cell).collect(),
        }
    }

    /// The cell of a method that an earlier run has finished.
    pub(super) fn kept(&self, planned: &Planned, store: Store<'_>) -> Option<Cell> {
        let cell = store.load(&self.name, &planned.method, planned.key.as_ref()?)?;
        (cell.readings.len() == self.task.measurement.readings().len()).then_some(cell)
    }

    /// About the memory that a fit takes, bytes: rays need the map as triangles and waves its transforms.
    pub(super) fn bytes(&self, planned: &Planned) -> u64 {
        const LEAST: u64 = 32 << 20;
        let points = self.task.map.map_or(0, |map| (map.map.nx() * map.map.ny()) as u64);
        let of_point = match Kind::named(&planned.method) {
            Ok(kind) if kind.needs_map && kind.waves != Waves::None => 700,
            Ok(kind) if kind.needs_map => 250,
            _ => 0,
        };
        LEAST + points * of_point
    }

    /// The result of all fits.
    pub(super) fn result(&self, attempts: Vec<Attempt>, rank: bool) -> SampleResult {
        let (ranking, grounds) =
            if rank { self.rank(&attempts) } else { (Vec::new(), Grounds::default()) };
        SampleResult {
            ranking,
            grounds,
            name: self.name.clone(),
            title: self.title.clone(),
            noise_floor_percent: SampleResult::floor_of(&attempts)
                .or_else(|| noise::before_fit(self.task.measurement)),
            surface: self.task.map.map(|map| SurfaceFigures::of(&map.map)),
            attempts,
            lit: Vec::new(),
            rigorous: None,
        }
    }

    /// The fits in the order of what the data support.
    fn rank(&self, attempts: &[Attempt]) -> (Vec<Rank>, Grounds) {
        let with_laws = attempts.iter().zip(&self.plan);
        let with_laws =
            with_laws.filter_map(|(attempt, planned)| Some((attempt, planned.laws.as_ref().ok()?)));
        let with_laws: Vec<_> = with_laws.collect();
        progress::counter("").watch(|watch| self.task.rank_attempts(&with_laws, watch))
    }

    /// The plots, each by its stem: all incidences, then one by one.
    pub(super) fn figures(&self) -> Vec<(String, Option<f64>)> {
        let sigmas: Vec<f64> = self.task.measurement.by_incidence().map(|i| i.sigma_deg).collect();
        let alone = plot::shown(sigmas.len()).into_iter().map(|k| sigmas[k]);
        let alone = alone.map(|sigma| (format!("sigma{sigma}"), Some(sigma)));
        std::iter::once(("all".to_owned(), None)).chain(alone).collect()
    }

    /// Draws all plots. What cannot be drawn is said and left out; after one that cannot be written no other is.
    pub(super) fn draw(
        &self,
        attempts: &[Attempt],
        (folder, failures): (&Path, &mut Vec<Failure>),
    ) {
        let fits: Vec<Drawn<'_>> =
            attempts.iter().filter_map(Attempt::cell).map(Drawn::from).collect();
        let scan = self.task.measurement;
        for (stem, sigma) in self.figures() {
            let figure = |scale| match sigma {
                None => report::figure(&self.title, scan, &fits, scale),
                Some(sigma) => report::figure_at(sigma, &self.title, scan, &fits, scale),
            };
            let write = || FigureFiles::create(&folder.join(&self.name), &stem)?.write(&figure);
            let written = if failures.is_empty() { write() } else { Ok(Vec::new()) };
            match written {
                Ok(_) => {}
                Err(FigureError::Plot(e)) => {
                    let name = &self.name;
                    say::note(format_args!("warning: {name}/{stem} cannot be drawn: {e}"));
                }
                Err(FigureError::Output(e)) => failures.push(e.into()),
            }
        }
    }
}
