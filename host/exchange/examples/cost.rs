//! What a file costs: evaluations of the law and time, of sampling, encoding, reading back and comparing: `cargo run --example cost -- [FORMAT...]`.
#![allow(clippy::print_stdout, reason = "the result of an example")]

use std::error::Error;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use asperity_core::bsdf::{Bsdf, Ggx};
use asperity_core::direction::Direction;
use asperity_core::quantity::{Alpha, RelativeIor};
use asperity_exchange::compare::compare;
use asperity_exchange::compare_patches::compare_patches;
use asperity_exchange::convention::Global;
use asperity_exchange::frame::Frame;
use asperity_exchange::law::{Law, Options, Subject};
use asperity_exchange::resample::FileLaw;
use asperity_exchange::{
    Band, FORMATS, Format, Lobe, Nodes, SampledBsdf, Side, Symmetry, read_bytes,
};

/// GGX of index 1.49 that counts how often it is asked.
struct Counted {
    ggx: Ggx<f64>,
    side: Side,
    lobe: Lobe,
    asked: AtomicU64,
}

impl Law for Counted {
    fn value(&self, incidence: [f64; 2], out: [f64; 2]) -> f64 {
        self.asked.fetch_add(1, Ordering::Relaxed);
        let of = |g: Global| {
            let (sin, cos) = g.theta.sin_cos();
            Direction::new(sin * g.phi.cos(), sin * g.phi.sin(), cos)
        };
        let wi = of(Global::of_incidence(self.side, incidence));
        let wo = of(Global::of_outgoing(self.side, self.lobe, incidence[1], out));
        wi.zip(wo).map_or(0.0, |(wi, wo)| self.ggx.eval(wi, wo))
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut names: Vec<String> = std::env::args().skip(1).collect();
    if names.is_empty() {
        names = FORMATS.iter().filter(|f| f.write.is_some()).map(|f| f.name.to_owned()).collect();
    }
    println!(
        "{:15} {:5} {:12} {:>10} {:>8} {:>12} {:>7} {:>7} {:>12} {:>7} {:>9} {:>9} {:>9}",
        "format",
        "alpha",
        "lobe",
        "nodes",
        "bytes",
        "sampled",
        "s",
        "s file",
        "compared",
        "s",
        "flux %",
        "peak %",
        "between %"
    );
    for name in &names {
        if let Some(to) = name.strip_prefix("klems>") {
            converted(to)?;
            continue;
        }
        for alpha in [0.2, 0.6] {
            for lobe in [Lobe::Reflection, Lobe::Transmission] {
                report(name, alpha, lobe)?;
            }
        }
    }
    Ok(())
}

/// Writes a lobe from the air at the usual incidences, reads it back and compares it.
fn report(name: &str, alpha: f64, lobe: Lobe) -> Result<(), Box<dyn Error>> {
    let format = Format::of_name(name).ok_or("no such format")?;
    let (Some(write), Some(_)) = (format.write, format.read) else { return Ok(()) };
    let (law, subject) = facets(alpha, lobe)?;
    let mut options = Options::default();
    if matches!(name, "pab" | "openmaterial") {
        options.incidences.truncate(10);
        options.incidences.drain(..9);
    }
    let mut start = Instant::now();
    let mut lap = || {
        let seconds = start.elapsed().as_secs_f64();
        start = Instant::now();
        seconds
    };
    let made = match (write.sample)(&law, &subject, &options) {
        Ok(made) => made,
        Err(e) => {
            println!("{name:15} {alpha:5} {:12} {e}", lobe.name());
            return Ok(());
        }
    };
    let (sampled, time) = (law.asked.swap(0, Ordering::Relaxed), lap());
    let bytes = match (write.encode)(std::slice::from_ref(&made)) {
        Ok(bytes) => bytes,
        Err(e) => {
            println!("{name:15} {alpha:5} {:12} {e}", lobe.name());
            return Ok(());
        }
    };
    let file = read_bytes("file", &bytes)?.1;
    let of_file = lap();
    let file = file.into_iter().next().ok_or("no lobe")?;
    let rows = compare_patches(&file, &law).unwrap_or_else(|| compare(&file, &made, &law));
    let (compared, of_compare) = (law.asked.load(Ordering::Relaxed), lap());
    let most = |of: fn(&asperity_exchange::compare::Row) -> f64| {
        rows.iter().filter(|r| r.flux_law > 1e-6).map(|r| of(r).abs()).fold(0.0, f64::max)
    };
    let nodes: usize = made.incidences.iter().map(|i| i.nodes.len()).sum();
    println!(
        "{name:15} {alpha:5} {:12} {nodes:10} {:8} {sampled:12} {time:7.2} {of_file:7.2} {compared:12} {of_compare:7.2} {:9.4} {:9.4} {:9.4}",
        lobe.name(),
        bytes.len(),
        most(asperity_exchange::compare::Row::flux_percent),
        most(asperity_exchange::compare::Row::peak_percent),
        between(&made, &law)
    );
    Ok(())
}

/// GGX from the air.
fn facets(alpha: f64, lobe: Lobe) -> Result<(Counted, Subject), Box<dyn Error>> {
    let (width, index) = (Alpha::new(alpha), RelativeIor::new(1.49));
    let (Ok(width), Ok(index)) = (width, index) else { return Err("a width and an index".into()) };
    let side = Side::Air;
    let law = Counted { ggx: Ggx::new(width, index), side, lobe, asked: AtomicU64::new(0) };
    let subject = Subject {
        side,
        lobe,
        index: Some(1.49),
        symmetry: Symmetry::Isotropic,
        band: Band::Wavelength(550.0),
        notes: Vec::new(),
        coherent: 0.0,
        closed: None,
    };
    Ok((law, subject))
}

/// Largest distance of interpolation from the law at directions about the ray, closer near it, percent of the peak.
fn between(made: &SampledBsdf, law: &Counted) -> f64 {
    let mut worst = 0.0_f64;
    for incidence in &made.incidences {
        if !matches!(incidence.nodes, Nodes::Grid(_)) {
            return f64::NAN;
        }
        let from = [incidence.theta, incidence.phi];
        let peak = incidence.values.iter().copied().fold(0.0, f64::max);
        let Some(theta) = made.specular(incidence.theta) else { continue };
        let frame = Frame::Specular { theta };
        for k in 0..20_000 {
            let u = |m: f64| (f64::from(k) * m).fract();
            let out =
                frame.absolute([3.0 * u(0.754_877_666_25).powi(3), 3.0 * u(0.569_840_290_998)]);
            if out[0] < 1.56 && peak > 0.0 {
                let is = incidence.value(0, out, made.interpolation);
                worst = worst.max((is - law.value(from, out)).abs() / peak);
            }
        }
    }
    100.0 * worst
}

/// A Klems matrix sampled anew in another format.
fn converted(to: &str) -> Result<(), Box<dyn Error>> {
    let [from, to] = ["klems", to].map(|name| Format::of_name(name).and_then(|f| f.write));
    let (Some(from), Some(to)) = (from, to) else { return Err("no such format".into()) };
    let (law, subject) = facets(0.6, Lobe::Reflection)?;
    let mut lobe = (from.sample)(&law, &subject, &Options::default())?;
    if std::env::var_os("ANISOTROPIC").is_some() {
        lobe.symmetry = Symmetry::None;
    }
    let of_file = FileLaw::new(&lobe);
    let options = Options { incidences: of_file.incidences(), ..Options::default() };
    let start = Instant::now();
    let made = (to.sample)(&of_file, &of_file.subject(), &options)?;
    let sampled = start.elapsed().as_secs_f64();
    let bytes = (to.encode)(std::slice::from_ref(&made))?;
    let file = read_bytes("file", &bytes)?.1.into_iter().next().ok_or("no lobe")?;
    let read = start.elapsed().as_secs_f64();
    let rows = compare(&file, &made, &of_file);
    let flux = rows.iter().map(|r| r.flux_percent().abs()).fold(0.0, f64::max);
    let nodes: usize = made.incidences.iter().map(|i| i.nodes.len()).sum();
    println!(
        "klems to another: {nodes} nodes, {} bytes, sampled {sampled:.2} s, read {read:.2} s, compared {:.2} s, flux {flux:.4} %",
        bytes.len(),
        start.elapsed().as_secs_f64()
    );
    Ok(())
}
