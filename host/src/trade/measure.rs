//! Every way to evaluate one model, measured.

use std::time::Instant;

use asperity_core::bsdf::{Bsdf, LobeSet, Scatter};
use asperity_core::direction::Direction;
use asperity_core::math::{Fast, Real};

use super::beams::Beams;
use super::device::{Counted, Counts, Device};
use super::formula::Formula;
use super::pairs::Pairs;
use super::payload::Payload;
use super::row::{Evaluator, Marks, Row, Tier};
use super::scan::{STEP, Scan};
use super::tier::Through;
use super::timing::{eval_ns, sample_ns};
use crate::boundary::{Boundary, with_boundary};
use crate::embedded::{EmbeddedTable, with_view};
use crate::forward::Rays;
use crate::tabulate::{Budget, NoTable, distance, energy_error, tabulate};
use crate::watch::Watch;

/// Share of coherent light from which on the scan of a table, which is of diffuse light, says nothing.
const COHERENT: f64 = 1e-3;

/// A model, and how it was found.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// Method with its law.
    pub method: &'a str,
    /// The boundary.
    pub boundary: &'a Boundary,
    /// Eq. (18) of the fit, %.
    pub misfit_percent: Option<f64>,
    /// Seconds of the fit.
    pub fit_seconds: Option<f64>,
    /// The measurement it was fitted to.
    pub scan: Option<&'a Scan>,
}

/// The measurements to make, and their means.
pub struct Work<'a> {
    /// Sizes of the tables, KiB.
    pub table_kib: &'a [usize],
    /// Rays per incidence for the table of a model that is traced.
    pub rays: Rays,
    /// The device.
    pub device: Option<&'a Device>,
    /// Ends the work, and is told what is next.
    pub watch: Watch<'a>,
}

impl std::fmt::Debug for Work<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Work").field("table_kib", &self.table_kib).finish_non_exhaustive()
    }
}

/// All rows of a model, and notes on what could not be measured. Finished rows are kept when the user stops.
pub fn rows(subject: &Subject<'_>, work: &Work<'_>) -> (Vec<Row>, Vec<String>) {
    let boundary = subject.boundary;
    let pairs = Pairs::of(boundary, boundary.eta().is_none());
    let (beams, usual) = with_boundary!(boundary,
        b => (Some(Beams::of(b)), Scan::usual(b, boundary.eta())),
        traced _t => (None, None));
    let scan = subject.scan.filter(|scan| !is_coherent(boundary, scan));
    let mut bench =
        Bench { subject, work, pairs, beams, usual, scan, rows: Vec::new(), notes: Vec::new() };
    if scan.is_none() && subject.scan.is_some() {
        bench.note("a part of the light is coherent, which a scan of a table does not show");
    }
    match boundary {
        Boundary::Ggx(law) => bench.formula(law, Some(&Payload::ggx(law))),
        Boundary::Microfacet(law) => bench.formula(&**law, None),
        Boundary::AllGgx(law) => bench.formula(&**law, None),
        Boundary::AllMicrofacet(law) => bench.formula(&**law, None),
        Boundary::Normals(law) => bench.formula(&**law, Some(&Payload::normals(law))),
        Boundary::Opaque(law) => bench.formula(law, None),
        Boundary::Tail(law) => bench.formula(law, None),
        Boundary::Mix(mix) => {
            let eval = eval_ns::<f64, _>(&**mix, &bench.pairs);
            bench.model(&**mix, Some(eval));
        }
        Boundary::Wave(wave) => {
            let eval = eval_ns::<f64, _>(&**wave, &bench.pairs);
            bench.model(&**wave, Some(eval));
        }
        Boundary::Table(table) => {
            let eval = eval_ns::<f64, _>(&**table, &bench.pairs);
            bench.model(&**table, Some(eval));
        }
        Boundary::Traced(traced) => bench.model(traced, None),
        Boundary::Walk(walk) => bench.model(&**walk, None),
        Boundary::Hybrid(hybrid) => bench.model(&**hybrid, None),
    }
    for kib in work.table_kib {
        bench.table(*kib);
    }
    (bench.rows, bench.notes)
}

/// Whether a measured incidence has light that keeps its direction.
fn is_coherent(boundary: &Boundary, scan: &Scan) -> bool {
    scan.sigmas_deg().any(|deg| {
        let (s, c) = deg.to_radians().sin_cos();
        let there = boundary.coherent(Direction::from_unit(-s, 0.0, c));
        there.reflected.max(there.transmitted) > COHERENT
    })
}

/// One model under measurement.
struct Bench<'a> {
    subject: &'a Subject<'a>,
    work: &'a Work<'a>,
    pairs: Pairs,
    /// Of a model that can be evaluated.
    beams: Option<Beams>,
    /// The scan of the model itself.
    usual: Option<Scan>,
    /// The measured scan, if evaluators can be held against it.
    scan: Option<&'a Scan>,
    rows: Vec<Row>,
    notes: Vec<String>,
}

impl Bench<'_> {
    fn stopped(&self) -> bool {
        self.work.watch.is_stopped()
    }

    fn note(&mut self, what: &str) {
        let note = format!("{}: {what}", self.subject.method);
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    fn begin(&self, what: &str) {
        self.work.watch.now(&format!("{}, {what}", self.subject.method));
    }

    /// Runs a model on the device, if there is one.
    fn count(&mut self, payload: Option<&Payload>) -> Counts {
        let (Some(device), Some(payload)) = (self.work.device, payload) else {
            return Counts::new();
        };
        if self.stopped() {
            return Counts::new();
        }
        device.run(payload, &self.pairs, self.work.watch).unwrap_or_else(|why| {
            self.note(&format!("not counted on the device: {why}"));
            Counts::new()
        })
    }

    /// A closed form in every tier.
    fn formula<F: Formula>(&mut self, law: &F, payload: Option<&Payload>) {
        self.begin("on the device");
        let counts = self.count(payload);
        self.tier::<f64, F>(law, (Tier::Exact, "f64", "f64-exact"), &counts);
        self.tier::<Fast<f64>, F>(law, (Tier::Fast, "f64", "f64-fast"), &counts);
        self.tier::<f32, F>(law, (Tier::Exact, "f32", "f32-exact"), &counts);
        self.tier::<Fast<f32>, F>(law, (Tier::Fast, "f32", "f32-fast"), &counts);
    }

    fn tier<T: Real, F: Formula>(
        &mut self,
        law: &F,
        (tier, precision, name): (Tier, &'static str, &str),
        counts: &Counts,
    ) {
        let Some(law) = law.of::<T>().filter(|_| !self.stopped()) else { return };
        self.begin(name);
        let mut row = self.measured::<T, _>(&law, counts.get(name));
        (row.tier, row.precision) = (tier, precision);
        let through = Through::<T, _>::new(&law);
        row.energy_percent = self.beams.as_ref().map(|b| 100.0 * b.flux_error(&through));
        row.distance_percent = self.usual.as_ref().and_then(|s| s.error(&through));
        self.rows.push(row);
    }

    /// The measurements common to formulas and tables.
    fn measured<T: Real, B: Bsdf<T> + Sync>(&mut self, law: &B, counted: Option<&Counted>) -> Row {
        let through = Through::<T, _>::new(law);
        let accuracy = self.beams.as_ref().map(|b| b.accuracy(&through));
        let counted = counted.copied().unwrap_or_default();
        let same = counted.digest.is_none_or(|d| d == self.pairs.digest::<T, _>(law));
        if !same {
            self.note("the device computes other bits than this machine; build its program anew");
        }
        let counted = if same { counted } else { Counted::default() };
        Row {
            max_percent: accuracy.as_ref().map(|a| a.max_percent),
            rms_percent: accuracy.as_ref().map(|a| a.rms_percent),
            max_at: accuracy.and_then(|a| a.worst).map(|beam| beam.to_string()),
            scan_percent: self.scan.and_then(|s| s.error(&through)),
            eval_ns: Some(eval_ns::<T, _>(law, &self.pairs)),
            sample_ns: sample_ns::<T, _>(law, &self.pairs),
            eval_instructions: counted.eval,
            sample_instructions: counted.sample,
            code_bytes: counted.code,
            ram_bytes: counted.ram,
            ..self.row()
        }
    }

    /// A row of the model, nothing measured yet.
    fn row(&self) -> Row {
        Row {
            method: self.subject.method.to_owned(),
            evaluator: Evaluator::Formula,
            tier: Tier::Exact,
            precision: "f64",
            misfit_percent: self.subject.misfit_percent,
            scan_percent: None,
            distance_percent: None,
            max_percent: None,
            max_at: None,
            rms_percent: None,
            energy_percent: None,
            eval_ns: None,
            sample_ns: f64::NAN,
            eval_instructions: None,
            sample_instructions: None,
            code_bytes: None,
            data_bytes: None,
            ram_bytes: None,
            fit_seconds: self.subject.fit_seconds,
            table_seconds: None,
            marks: Marks::default(),
        }
    }

    /// The model itself, rays or waves: it is its own reference.
    fn model<B: Scatter<f64>>(&mut self, model: &B, eval: Option<f64>) {
        if self.stopped() {
            return;
        }
        self.begin("itself");
        let row = Row {
            evaluator: Evaluator::Model,
            scan_percent: self.subject.scan.and(self.subject.misfit_percent),
            distance_percent: Some(0.0),
            eval_ns: eval,
            sample_ns: sample_ns::<f64, _>(model, &self.pairs),
            ..self.row()
        };
        self.rows.push(row);
    }

    /// A table of the model, evaluated as a device does it.
    fn table(&mut self, kib: usize) {
        if self.stopped() {
            return;
        }
        self.begin(&format!("table of {kib} KiB"));
        let (boundary, rays) = (self.subject.boundary, self.work.rays);
        let plan = Budget { lobes: LobeSet::ALL, bytes: kib << 10, kept: None, rays };
        let begun = Instant::now();
        let table = match tabulate(boundary, &plan, self.work.watch.quiet()) {
            Ok(table) => table,
            Err(NoTable::Stopped) => return,
            // of all models alike
            Err(why @ NoTable::Small(..)) => {
                return self.notes.push(format!("no table of {kib} KiB: {why}"));
            }
            // whatever its size
            Err(why @ (NoTable::Directional { .. } | NoTable::DirectionalWaves { .. })) => {
                return self.note(&format!("no table: {why}"));
            }
            Err(why) => return self.note(&format!("no table of {kib} KiB: {why}")),
        };
        let seconds = begun.elapsed().as_secs_f64();
        let counts = self.count(Payload::table(&table).as_ref());
        let row = with_view!(&table, view => {
            Some(self.measured::<Fast<f32>, _>(&view, counts.get("f32-fast")))
        }, else None);
        let distance = distance(boundary, &table, STEP, rays, self.work.watch);
        let energy = energy_error(boundary, &table, rays, self.work.watch);
        let Some(row) = row.filter(|_| !self.stopped()) else { return };
        self.rows.push(Row {
            evaluator: evaluator(kib, &table),
            tier: Tier::Fast,
            precision: "f32",
            distance_percent: distance.map(|d| d.percent),
            energy_percent: energy.map(|e| 100.0 * e),
            data_bytes: Some(table.bytes()),
            table_seconds: Some(seconds),
            ..row
        });
    }
}

fn evaluator(kib: usize, table: &EmbeddedTable) -> Evaluator {
    Evaluator::Table { kib, bytes: table.bytes(), storage: table.storage() }
}
