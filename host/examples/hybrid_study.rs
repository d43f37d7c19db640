//! Rays, waves and both on Gaussian surfaces of Rq 0.01 to 13 um: `hybrid_study FOLDER [POINTS] [RAYS]`.
//!
//! Writes `hybrid.csv` and `hybrid.svg` into the folder and prints the table of `docs/bench/hybrid.md`.
#![expect(clippy::print_stdout, clippy::unwrap_used, reason = "a program for measurements")]

use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use asperity::boundary::Boundary;
use asperity::forward::{Effort, Plan, Rays, Readings, Sample, Setup, simulate};
use asperity::hybrid::HybridBoundary;
use asperity::kirchhoff::{Shadowing, Speckle, WaveBoundary, WaveOptions, Wavelengths};
use asperity::measurement::Quantity;
use asperity::plot::{Across, Curve, CurveStyle, Figure, Panel, Scale, svg};
use asperity::raytrace::{Field, TracedBoundary};
use asperity::surface::{Edges, GaussianSurface, HeightMap};
use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;
use asperity_core::quantity::RelativeIor;

const NM: f64 = 550.0;
const IOR: f64 = 1.49;
const RQ_UM: [f64; 12] = [0.01, 0.03, 0.1, 0.2, 0.3, 0.45, 0.7, 1.1, 1.8, 3.0, 6.0, 13.0];
/// Texture on the last surfaces: rms height and correlation length, um.
const TEXTURE_UM: (f64, f64) = (0.06, 1.5);
const SIGMAS_DEG: [&[f64]; 2] = [&[0.0, 30.0], &[60.0]];

/// Three simulations of one scan, and the noise of rays.
struct Row {
    rq_um: f64,
    textured: bool,
    set: usize,
    /// `(q_z Rq)^2` of light that passes at normal incidence.
    g: f64,
    scales: String,
    /// Eq. (18) in % of ray and hybrid to wave, and of wave and hybrid to ray.
    to_wave: [f64; 2],
    to_ray: [f64; 2],
    noise: f64,
    seconds: [f64; 3],
}

fn surface(rq_um: f64, length_um: f64, pitch_um: f64, points: usize, seed: u64) -> HeightMap {
    let lengths_um = (length_um, length_um);
    let size = (points, points);
    GaussianSurface { size, pitches_um: (pitch_um, pitch_um), rq_um, lengths_um, seed }
        .map()
        .unwrap()
}

/// Eq. (18) in %, of the larger of the two.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    let largest = b.iter().copied().fold(0.0, f64::max);
    let sum: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    100.0 * (sum / a.len() as f64).sqrt() / largest
}

fn study(rq_um: f64, textured: bool, points: usize, count: u64, rows: &mut Vec<Row>) {
    let length_um = (10.0 * rq_um).max(5.0);
    let pitch_um = if textured { 0.3 } else { (length_um / 40.0).clamp(0.2, 0.8) };
    let mut map = surface(rq_um, length_um, pitch_um, points, 1);
    if textured {
        let texture = surface(TEXTURE_UM.0, TEXTURE_UM.1, pitch_um, points, 2);
        map = map.map(|x, y, h| h + texture.height_um(x, y).unwrap());
    }
    let eta = RelativeIor::new(IOR).unwrap();
    let options = WaveOptions {
        wavelengths: Wavelengths::single(NM).unwrap(),
        speckle: Speckle::Averaged,
        shadowing: Shadowing::Off,
    };
    let setup = Setup {
        sample: Sample::Plate { eta, rough_side: RoughSide::Source },
        geometry: Geometry::Transmission,
        aperture_deg: 0.6,
        quantity: Quantity::Flux,
    };
    let angles: Vec<f64> = (0..721).map(|k| f64::from(k) * 0.25 - 90.0).collect();
    let edges = Edges::Periodic;
    let field = Arc::new(Field::new(&map, edges).unwrap());
    let ray = Boundary::Traced(TracedBoundary { field, eta });
    let start = Instant::now();
    let wave = Boundary::Wave(Box::new(WaveBoundary::of_map(&map, edges, eta, &options).unwrap()));
    let of_wave = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let hybrid = HybridBoundary::of_map(&map, edges, eta, &options).unwrap();
    let of_hybrid = start.elapsed().as_secs_f64();
    let scales = *hybrid.scales();
    let hybrid = Boundary::Hybrid(Box::new(hybrid));
    let g = (std::f64::consts::TAU / (NM * 1e-3) * (IOR - 1.0) * rq_um).powi(2);
    let cutoff = scales.cutoff_um.map_or("all short".to_owned(), |c| format!("{c:.2}"));
    let scales = format!("{cutoff} | {:.3} | {:.4}", scales.long_um, scales.short_um);
    for (set, sigmas) in SIGMAS_DEG.iter().enumerate() {
        let plan = Plan::product(sigmas, &angles);
        let run = |boundary: &Boundary, seed: u64| -> (Readings, f64) {
            let (rays, stop) = (Rays { count, seed }, AtomicBool::new(false));
            let start = Instant::now();
            let done = simulate(boundary, &setup, &plan, Effort::Full, rays, &stop).unwrap();
            (done, start.elapsed().as_secs_f64())
        };
        let ((r, r_seconds), (w, w_seconds), (h, h_seconds)) =
            (run(&ray, 1), run(&wave, 1), run(&hybrid, 2));
        let again = run(&hybrid, 3).0;
        rows.push(Row {
            rq_um,
            textured,
            set,
            g,
            scales: scales.clone(),
            to_wave: [distance(&r.values, &w.values), distance(&h.values, &w.values)],
            to_ray: [distance(&w.values, &r.values), distance(&h.values, &r.values)],
            noise: distance(&h.values, &again.values),
            seconds: [r_seconds, of_wave + w_seconds, of_hybrid + h_seconds],
        });
        println!("{}", rows.last().unwrap().markdown());
    }
}

impl Row {
    /// Kirchhoff while the light is partly coherent and on textures, rays where heights are many waves, both between.
    fn references(&self) -> (bool, bool) {
        (self.g < 100.0 || self.textured, self.g > 10.0 && !self.textured)
    }

    fn markdown(&self) -> String {
        let (wave, ray) = self.references();
        let shown =
            |known: bool, value: f64| if known { format!("{value:.2}") } else { "-".into() };
        let texture = if self.textured { " + texture" } else { "" };
        let sigmas: Vec<String> = SIGMAS_DEG[self.set].iter().map(|s| format!("{s:.0}")).collect();
        format!(
            "| {}{texture} | {:.3} | {} | {} | {} | {} | {} | {} | {:.2} | {:.1} / {:.1} / {:.1} |",
            self.rq_um,
            self.g,
            sigmas.join(", "),
            self.scales,
            shown(wave, self.to_wave[0]),
            shown(wave, self.to_wave[1]),
            shown(ray, self.to_ray[0]),
            shown(ray, self.to_ray[1]),
            self.noise,
            self.seconds[0],
            self.seconds[1],
            self.seconds[2],
        )
    }
}

/// One panel a reference, over Rq: distances of the other engine and of both together.
fn figure(rows: &[Row]) -> Figure {
    let curve = |label: &str, style, value: &dyn Fn(&Row) -> f64| Curve {
        label: label.into(),
        points: rows
            .iter()
            .filter(|r| r.set == 0 && !r.textured)
            .map(|r| (r.rq_um, value(r)))
            .collect(),
        style,
    };
    let panel = |caption: &str, other: &str, pick: fn(&Row) -> [f64; 2]| Panel {
        caption: caption.into(),
        curves: vec![
            curve("noise of the rays", CurveStyle::Measured, &|r| r.noise),
            curve(other, CurveStyle::Fitted, &|r| pick(r)[0]),
            curve("hybrid", CurveStyle::Fitted, &|r| pick(r)[1]),
        ],
    };
    Figure {
        title: "Distance of rays, waves and both, transmission, σ = 0 and 30°, 550 nm".into(),
        x_label: "Rq, um".into(),
        y_label: "eq. (18), %".into(),
        x_range: (0.01, 13.0),
        across: Across::Log,
        scale: Scale::Log { decades: 4 },
        shared_y: true,
        panels: vec![
            panel("to waves (Kirchhoff)", "rays", |r| r.to_wave),
            panel("to rays (all bounces)", "waves", |r| r.to_ray),
        ],
    }
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().unwrap_or_else(|| ".".into()));
    let points = arguments.next().and_then(|a| a.parse().ok()).unwrap_or(1024);
    let rays = arguments.next().and_then(|a| a.parse().ok()).unwrap_or(2_000_000);
    println!(
        "| Rq, um | g | sigma, deg | split, um | long Rq, um | short Rq, um | ray to wave, % | hybrid to wave, % | wave to ray, % \
         | hybrid to ray, % | noise, % | s: ray / wave / hybrid |\n|---|---|---|---|---|---|---|---|---|---|---|---|"
    );
    let mut rows = Vec::new();
    for (rq_um, textured) in RQ_UM.iter().map(|rq| (*rq, false)).chain([(1.0, true), (3.0, true)]) {
        study(rq_um, textured, points, rays, &mut rows);
    }
    let mut csv =
        "rq_um,textured,sigmas,g,ray_to_wave,hybrid_to_wave,wave_to_ray,hybrid_to_ray,noise\n"
            .to_owned();
    for r in &rows {
        let ([a, b], [c, d], sigmas) = (r.to_wave, r.to_ray, SIGMAS_DEG[r.set]);
        let (rq, textured, g, noise) = (r.rq_um, r.textured, r.g, r.noise);
        writeln!(csv, "{rq},{textured},{sigmas:?},{g:.4},{a:.4},{b:.4},{c:.4},{d:.4},{noise:.4}")
            .unwrap();
    }
    std::fs::write(folder.join("hybrid.csv"), csv.replace(", ", ";")).unwrap();
    std::fs::write(folder.join("hybrid.svg"), svg(&figure(&rows)).unwrap()).unwrap();
}
