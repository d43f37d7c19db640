//! `render`: a scene with any model.

use std::path::{Path, PathBuf};

use super::error::Failure;
use super::flags::rays::RayFlags;
use super::flags::scan::noise_share;
use super::rendering::{Job, Output, Pictures, read_regions, region_text};
use super::{print, progress, put, say};
use crate::output::{AtomicFile, ResultFolder, write_text};
use crate::render::Renderer;
use crate::render::tracer::image::{Effort, Share};
use crate::render::tracer::path::Tracer;
use crate::render::tracer::region::{Until, region_means};
use crate::render::tracer::scene_file::BUILT_IN;
use crate::shard::Shard;

/// Render a scene with models, to see what a small error of a law does
///
/// The built-in scene is a light booth: a plate, a sphere and a torus of rough glass under two
/// tubes. Light is followed through the solid bodies, into them and out of them, by the law of the
/// model from both sides; maps are traced themselves, waves by their mean law. Bodies are as bright
/// as the law says: what a law loses is missing in the image.
///
/// With -o FILE.png or FILE.exr one model is one image. With -o DIR there are NAME.png (sRGB, with
/// the same white for all), NAME.exr (linear, with noise, albedo and normals as layers), sheet.png
/// with all models side by side, differences.png from the reference, numbers.json, and NAME.tiles,
/// with which the same command goes on where it ended: with more paths, or after Ctrl-C. With
/// --regions the mean radiances of rectangles of the image are found to 0.2 %.
///
/// The same bits with any number of threads. --shard I/N renders a share of the tiles into a folder
/// of its own; `merge` puts them together, and the same command without --shard writes the images.
///
/// Examples:
///   asperity render fit.json -o fit.png
///   asperity render ggx.json normals.json measured.json --reference measured --until 2% -o booth
///   asperity render --scene-example booth > scene.toml
///   asperity render fit.json --scene scene.toml --regions regions.csv --json
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    /// Models and tables
    #[arg(value_name = "MODEL")]
    models: Vec<PathBuf>,
    /// A model, as the argument
    #[arg(long = "model", value_name = "FILE")]
    model: Vec<PathBuf>,
    /// The scene, a TOML file, or one of booth and furnace
    #[arg(long, value_name = "SCENE", default_value = "booth")]
    scene: PathBuf,
    /// Print a built-in scene: booth or furnace
    #[arg(long, value_name = "NAME", exclusive = true)]
    scene_example: Option<String>,
    /// Image (.png, .exr) of one model, or a folder; made if it does not exist
    #[arg(short, long, value_name = "PATH")]
    output: Option<PathBuf>,
    /// Pixels across and down, such as 640x480 [default: those of the scene]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Paths per pixel at most; rounded up to a multiple of 16 [default: 256]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    paths: Option<u32>,
    /// End where the noise of a tile is below this share of its mean, such as 2%
    #[arg(long, value_name = "NOISE", value_parser = noise_share)]
    until: Option<f64>,
    /// A preview: half the pixels each way, 16 paths
    #[arg(long, conflicts_with_all = ["size", "paths", "until"])]
    quick: bool,
    /// The model that the others are compared with, by its name [default: the first]
    #[arg(long, value_name = "NAME")]
    reference: Option<String>,
    /// Radiance to show as white [default: one that a hundredth of the reference exceeds]
    #[arg(long, value_name = "L")]
    white: Option<f64>,
    /// Mean radiances of rectangles of the image: a CSV file with the columns region,x0,y0,x1,y1 in pixels
    #[arg(long, value_name = "FILE", conflicts_with_all = ["size", "paths", "until", "quick", "shard"])]
    regions: Option<PathBuf>,
    /// Render one of N shares of the tiles, from 1
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Write the scene for another renderer into the folder -o instead; it says what that cannot hold
    #[arg(long, value_name = "RENDERER", value_enum, conflicts_with_all = ["quick", "regions", "shard", "until", "paths"])]
    export: Option<RendererFlag>,
    /// Print the numbers as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    rays: RayFlags,
}

/// Another renderer, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum RendererFlag {
    /// Mitsuba 3
    Mitsuba,
    /// pbrt, version 4
    Pbrt,
}

/// Paths per pixel where the user says nothing.
const PATHS: u32 = 256;
/// Paths of a preview.
const QUICK_PATHS: u32 = 16;
/// Standard error of a region, as a share of its mean.
const REGION_ERROR: f64 = 0.002;
/// Paths of a region at most.
const MOST_PATHS: u64 = 1 << 28;

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    if let Some(name) = &args.scene_example {
        let found = BUILT_IN.iter().find(|(other, _)| other == name).ok_or_else(|| {
            let names: Vec<&str> = BUILT_IN.iter().map(|(name, _)| *name).collect();
            let what =
                format!("--scene-example {name} is not known; give one of {}", names.join(", "));
            Failure::bad(what)
        })?;
        return print(found.1);
    }
    let files: Vec<&Path> = args.models.iter().chain(&args.model).map(PathBuf::as_path).collect();
    if files.is_empty() {
        return Err(Failure::bad(
            "no model is given; `asperity model` or `asperity fit` makes one",
        ));
    }
    let mut job = Job::read(&files, &args.scene, args.rays.rays())?;
    if let Some(path) = &args.regions {
        return regions(args, path, &job);
    }
    let Some(path) = &args.output else {
        let what = "where to? give -o FILE.png, FILE.exr or a folder, or --regions FILE";
        return Err(Failure::bad(what));
    };
    if let Some(renderer) = args.export {
        return export(args, path, &mut job, renderer);
    }
    let output = Output::at(path, files.len(), args.shard.is_some())?;
    let pixels = job.pixels();
    job.set_pixels(match (args.size, args.quick) {
        (Some(size), _) => size,
        (None, true) => pixels.map(|n| n.div_ceil(2)),
        (None, false) => pixels,
    });
    let paths = if args.quick { QUICK_PATHS } else { args.paths.unwrap_or(PATHS) };
    let effort = Effort { paths, until: args.until, seed: args.rays.rays().seed };
    let share = args.shard.map_or(Share::ALL, |s| Share { part: s.part - 1, of: s.of });
    let pictures = Pictures {
        job: &job,
        effort,
        reference: args.reference.as_deref(),
        white: args.white,
        replaces: false,
    };
    let done = pictures.render(&output, args.shard, share)?;
    if args.json { print(&done.json()) } else { print(&done.text()) }?;
    if done.interrupted {
        return Err(Failure::No(
            "interrupted; what is written is as far as it was rendered".into(),
        ));
    }
    Ok(())
}

/// The scene in the language of another renderer.
fn export(
    args: &Args,
    folder: &Path,
    job: &mut Job,
    renderer: RendererFlag,
) -> Result<(), Failure> {
    job.set_pixels(args.size.unwrap_or_else(|| job.pixels()));
    let renderer = match renderer {
        RendererFlag::Mitsuba => Renderer::Mitsuba,
        RendererFlag::Pbrt => Renderer::Pbrt,
    };
    let Some(foreign) = job.foreign(renderer) else {
        return Err(Failure::bad("no model is given"));
    };
    let _made = ResultFolder::create(folder)?;
    for (name, content) in &foreign.files {
        write_text(folder.join(name), content)?;
    }
    for sentence in &foreign.missing {
        say::note(format_args!("note: {sentence}"));
    }
    let names: Vec<&str> = foreign.files.iter().map(|(name, _)| name.as_str()).collect();
    print(&format!("{} in {}\n", names.join(", "), folder.display()))
}

/// The mean radiances of the regions, for each model.
fn regions(args: &Args, path: &Path, job: &Job) -> Result<(), Failure> {
    let regions = read_regions(path, job.pixels())?;
    let output = args.output.as_ref().map(AtomicFile::create).transpose()?;
    let until = Until { relative: REGION_ERROR, most: MOST_PATHS, seed: args.rays.rays().seed };
    let mut found = Vec::new();
    let mut interrupted = false;
    for (name, scene) in job.scenes() {
        let tracer = Tracer::new(&scene);
        let bar = progress::bar(1000, name);
        let means = bar.watch(|watch| {
            let means = region_means(&tracer, &regions, until, &mut |done| watch.share(done));
            interrupted |= watch.is_stopped();
            means
        });
        found.push((name.to_owned(), means));
        if interrupted {
            break;
        }
    }
    let text = region_text(&regions, &found, args.json);
    put(output, &text)?;
    if interrupted {
        return Err(Failure::No("interrupted; the means are as exact as they say".into()));
    }
    say::detail(format_args!("{} regions", regions.len()));
    Ok(())
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let number = |text: &str| text.trim().parse::<u32>().ok().filter(|n| (1..=16_384).contains(n));
    let pair = text.split_once(['x', 'X']).and_then(|(w, h)| Some([number(w)?, number(h)?]));
    pair.ok_or_else(|| "write pixels across and down, 1 to 16384, such as 640x480".to_owned())
}
