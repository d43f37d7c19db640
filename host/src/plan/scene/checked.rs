//! From what a file says to what it means.

use std::f64::consts::SQRT_2;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::content::{
    Behind, Body, BodyKind, Emission, Face, Figures, Grasp, Quantity, Scene, Source, Statistics,
    Surface, Target, TargetKind, Wanted,
};
use super::draft::{BodyDraft, Draft, SourceDraft, SurfaceDraft, TargetDraft, WantedDraft};
use super::error::SceneError;
use super::faults::Place;
use super::rays;

const BODIES: [(&str, BodyKind); 6] = [
    ("film", BodyKind::Film),
    ("plate", BodyKind::Plate),
    ("light-guide", BodyKind::LightGuide),
    ("lens", BodyKind::Lens),
    ("fibre-end", BodyKind::FibreEnd),
    ("object", BodyKind::Object),
];
const TARGETS: [(&str, TargetKind); 5] = [
    ("host", TargetKind::Host),
    ("cortex-m4f", TargetKind::CortexM4f),
    ("zemax", TargetKind::Zemax),
    ("radiance", TargetKind::Radiance),
    ("mitsuba", TargetKind::Mitsuba),
];
const FACES: [(&str, Face); 2] = [("source", Face::Source), ("detector", Face::Detector)];
const GUIDE_FACES: [(&str, Face); 2] = [("top", Face::Source), ("bottom", Face::Detector)];
const LEAVING: [(&str, Face); 2] = [("reflected", Face::Source), ("transmitted", Face::Detector)];
/// Angle of incidence, degrees.
const INCIDENCE: [f64; 2] = [0.0, 89.0];
/// Most steps of flash, KiB.
const KIB: [f64; 2] = [1.0, 65536.0];
/// Green, which stands for light without a wavelength.
const GREEN_NM: f64 = 550.0;

/// A scene from its file.
pub(super) fn checked(
    place: &Place<'_>,
    draft: Draft,
    sha256: String,
) -> Result<Scene, SceneError> {
    let folder = place.path.parent().unwrap_or_else(|| Path::new("")).to_owned();
    let stem = || place.path.file_stem().map(|s| s.to_string_lossy().into_owned());
    let name = draft.name.map(toml::Spanned::into_inner).or_else(stem).unwrap_or_default();
    let body = body(place, place.table("body", draft.body)?)?;
    let surface = match draft.surface {
        None => Surface::Unknown,
        Some(said) => surface(place, (said.span(), said.into_inner()), &folder)?,
    };
    let source = source(place, place.table("source", draft.source)?, (&body, &folder))?;
    let wanted = wanted(place, place.table("wanted", draft.wanted)?, &body)?;
    let target = target(place, place.table("target", draft.target)?)?;
    Ok(Scene { name, sha256, body, surface, source, wanted, target, rigorous: None })
}

type Table<T> = (Range<usize>, T);

fn body(place: &Place<'_>, (span, draft): Table<BodyDraft>) -> Result<Body, SceneError> {
    let kind = place.needed(&span, "kind", draft.kind)?;
    let (word, kind) = place.word("kind", &kind, &BODIES)?;
    let ior = place.needed(&span, "ior", draft.ior)?;
    let limits = [1.01, 5.0];
    let ior = place.number("ior", &ior, limits)?;
    let abbe = draft.abbe.map(|said| place.number("abbe", &said, [5.0, 200.0])).transpose()?;
    let guide = kind == BodyKind::LightGuide;
    let flat = matches!(kind, BodyKind::Film | BodyKind::Plate | BodyKind::Lens);
    let rough = if flat || guide {
        let Some(said) = &draft.rough else {
            return Err(place.fault(span, "rough is missing; say which face it is"));
        };
        place.word("rough", said, if guide { &GUIDE_FACES } else { &FACES })?.1
    } else {
        place.without("rough", draft.rough.as_ref(), &format!("a {word} has one face"))?;
        Face::Source
    };
    let behind = match (&draft.behind, kind) {
        (None, _) => Behind::Air,
        (Some(said), BodyKind::Film | BodyKind::Plate) => {
            place.word("behind", said, &[("air", Behind::Air), ("black", Behind::Black)])?.1
        }
        (said, _) => {
            place.without(
                "behind",
                said.as_ref(),
                "only a film or a plate can stand on something",
            )?;
            Behind::Air
        }
    };
    if behind == Behind::Black && rough == Face::Detector {
        let said = draft.rough.as_ref().map_or(span, toml::Spanned::span);
        let what = "a rough face in contact with black has no air to scatter into; write rough = \"source\" or behind = \"air\"";
        return Err(place.fault(said, what));
    }
    let mut sizes = [0.0; 2];
    for ((key, said), size) in
        [("thickness_mm", draft.thickness_mm), ("length_mm", draft.length_mm)]
            .into_iter()
            .zip(&mut sizes)
    {
        if guide {
            let said = place.needed(&span, key, said)?;
            *size = place.number(key, &said, [1e-3, 1e5])?;
        } else {
            place.without(key, said.as_ref(), "only the size of a light-guide matters")?;
        }
    }
    let [thickness_mm, length_mm] = sizes;
    if guide && length_mm > 2000.0 * thickness_mm {
        return Err(place.fault(span, "the light-guide is more than 2000 times as long as thick; check thickness_mm and length_mm"));
    }
    Ok(Body { kind, ior, abbe, rough, behind, thickness_mm, length_mm })
}

fn surface(
    place: &Place<'_>,
    (span, draft): Table<SurfaceDraft>,
    folder: &Path,
) -> Result<Surface, SceneError> {
    let figures = [
        ("rq_um", &draft.rq_um),
        ("correlation_um", &draft.correlation_um),
        ("rms_slope", &draft.rms_slope),
        ("alpha", &draft.alpha),
    ];
    if let (Some(map), Some(model)) = (&draft.map, &draft.model) {
        let last = map.span().start.max(model.span().start);
        return Err(
            place.fault(last..last, "a surface has a map or a model; leave one of them out")
        );
    }
    if let Some(said) = &draft.map {
        for (key, figure) in figures {
            place.without(key, figure.as_ref(), "the map tells it")?;
        }
        place.without("statistics", draft.statistics.as_ref(), "the map tells them")?;
        let pixel_um =
            draft.pixel_um.map(|said| place.number("pixel_um", &said, [1e-6, 1e6])).transpose()?;
        return Ok(Surface::Map { file: beside(place, said, folder)?, pixel_um });
    }
    place.without("pixel_um", draft.pixel_um.as_ref(), "there is no map")?;
    if let Some(said) = &draft.model {
        for (key, figure) in figures {
            place.without(key, figure.as_ref(), "the model tells it")?;
        }
        place.without("statistics", draft.statistics.as_ref(), "the model tells them")?;
        return Ok(Surface::Model(beside(place, said, folder)?));
    }
    let number = |key: &str, said: &Option<toml::Spanned<f64>>, limits| {
        said.as_ref().map(|said| place.number(key, said, limits)).transpose()
    };
    let rq_um = number("rq_um", &draft.rq_um, [1e-6, 1e4])?;
    let correlation_um = number("correlation_um", &draft.correlation_um, [1e-3, 1e6])?;
    let slope = number("rms_slope", &draft.rms_slope, [1e-5, 3.0])?;
    let alpha = number("alpha", &draft.alpha, [1e-5, 4.0])?;
    let statistics = match &draft.statistics {
        None => Statistics::Gaussian,
        Some(said) => {
            let words = [("gaussian", Statistics::Gaussian), ("ggx", Statistics::Ggx)];
            place.word("statistics", said, &words)?.1
        }
    };
    let from_heights = rq_um.zip(correlation_um).map(|(rq, length)| 2.0 * rq / length);
    let ways = [alpha, slope.map(|s| SQRT_2 * s), from_heights];
    let given: Vec<f64> = ways.into_iter().flatten().collect();
    let Some(&first) = given.first() else {
        return if rq_um.is_none() && correlation_um.is_none() && draft.statistics.is_none() {
            Ok(Surface::Unknown)
        } else {
            let what = "the width of the slopes does not follow; give rq_um and correlation_um, rms_slope, or alpha";
            Err(place.fault(span, what))
        };
    };
    if let Some(other) = given.iter().find(|other| (*other / first - 1.0).abs() > 0.05) {
        let what = format!(
            "the figures contradict each other: the width of slopes is {first:.4} by one and {other:.4} by another (alpha = sqrt(2) rms_slope = \
             2 rq_um / correlation_um); keep one"
        );
        return Err(place.fault(span, what));
    }
    if first > 4.0 {
        let what = format!(
            "the width of slopes is {first:.1}, steeper than any law; check rq_um and correlation_um"
        );
        return Err(place.fault(span, what));
    }
    Ok(Surface::Figures(Figures { rq_um, correlation_um, alpha: first, statistics }))
}

/// A file beside the scene.
fn beside(
    place: &Place<'_>,
    said: &toml::Spanned<String>,
    folder: &Path,
) -> Result<PathBuf, SceneError> {
    let path = folder.join(said.as_ref());
    if path.is_file() {
        return Ok(path);
    }
    let what = format!("{} is no file; give a path relative to the scene", path.display());
    Err(place.fault(said.span(), what))
}

fn source(
    place: &Place<'_>,
    (span, draft): Table<SourceDraft>,
    (body, folder): (&Body, &Path),
) -> Result<Source, SceneError> {
    let kind = place.needed(&span, "kind", draft.kind)?;
    let names = ["collimated", "lambertian", "led", "lamp", "laser", "rays"];
    let (word, ()) = place.word("kind", &kind, &names.map(|name| (name, ())))?;
    let angles = draft.incidence_deg.as_ref();
    let angles = angles.map(|said| place.two("incidence_deg", said, INCIDENCE)).transpose()?;
    let none = |why: &str| place.without("incidence_deg", draft.incidence_deg.as_ref(), why);
    if word != "led" {
        place.without("half_angle_deg", draft.half_angle_deg.as_ref(), "only an led has a cone")?;
    }
    if word != "rays" {
        place.without("file", draft.file.as_ref(), "only rays come from a file")?;
    }
    let emission = match word {
        "lambertian" => {
            none("a lambertian source lights from everywhere")?;
            Emission::Lambertian
        }
        "led" => {
            let said = place.needed(&span, "half_angle_deg", draft.half_angle_deg)?;
            let half_deg = place.number("half_angle_deg", &said, [0.1, 80.0])?;
            let [axis_deg, to] = angles.unwrap_or([0.0; 2]);
            if to > axis_deg {
                let said = draft.incidence_deg.as_ref().map_or(span, toml::Spanned::span);
                return Err(place.fault(said, "an led has one axis; give one incidence_deg"));
            }
            Emission::Cone { axis_deg, half_deg }
        }
        "rays" => {
            none("the file tells it")?;
            let said = place.needed(&span, "file", draft.file)?;
            Emission::Histogram(rays::read(&beside(place, &said, folder)?)?)
        }
        _ => {
            let said = place.needed(&span, "incidence_deg", draft.incidence_deg)?;
            Emission::Collimated(place.two("incidence_deg", &said, INCIDENCE)?)
        }
    };
    let wavelength_nm = match &draft.wavelength_nm {
        Some(said) => place.two("wavelength_nm", said, [150.0, 20000.0])?,
        None if ["laser", "lamp"].contains(&word) || body.abbe.is_some() => {
            let why = format!(
                "wavelength_nm is missing: {} needs it; add it, in nm",
                if body.abbe.is_some() { "a body with abbe" } else { word }
            );
            return Err(place.fault(span, why));
        }
        None => [GREEN_NM; 2],
    };
    if let (true, Some(said)) =
        (word == "laser" && wavelength_nm[0] < wavelength_nm[1], &draft.wavelength_nm)
    {
        return Err(
            place.fault(said.span(), "a laser has one wavelength_nm; give one, or write lamp")
        );
    }
    Ok(Source { emission, coherent: word == "laser", wavelength_nm })
}

fn wanted(
    place: &Place<'_>,
    (span, draft): Table<WantedDraft>,
    body: &Body,
) -> Result<Wanted, SceneError> {
    let said = place.needed(&span, "quantity", draft.quantity)?;
    let names = ["flux", "haze", "glare", "signal", "image"];
    let (word, ()) = place.word("quantity", &said, &names.map(|name| (name, ())))?;
    let error = place.needed(&span, "error_percent", draft.error_percent)?;
    let error_percent = place.number("error_percent", &error, [1e-6, 50.0])?;
    let face = match (body.kind, &draft.face) {
        (BodyKind::FibreEnd, said) => {
            place.without("face", said.as_ref(), "light leaves a fibre-end one way")?;
            Face::Source
        }
        (BodyKind::Object, said) => {
            place.without("face", said.as_ref(), "an object is seen from outside")?;
            Face::Source
        }
        (_, said) if word == "haze" => {
            place.without("face", said.as_ref(), "haze is of transmitted light")?;
            Face::Detector
        }
        (kind, said) => {
            let words = if kind == BodyKind::LightGuide { &GUIDE_FACES } else { &LEAVING };
            let said = said.as_ref().ok_or_else(|| {
                let what = format!(
                    "face is missing; write face = \"{}\" or \"{}\"",
                    words[0].0, words[1].0
                );
                place.fault(span.clone(), what)
            })?;
            place.word("face", said, words)?.1
        }
    };
    if (word == "haze" || face == Face::Detector) && body.behind == Behind::Black {
        return Err(place.fault(
            said.span(),
            "nothing is transmitted into black; want what is reflected, or write behind = \"air\"",
        ));
    }
    if word == "haze" && !matches!(body.kind, BodyKind::Film | BodyKind::Plate | BodyKind::Lens) {
        return Err(place.fault(
            said.span(),
            "haze is of a film, a plate or a lens; want flux, glare, signal or image",
        ));
    }
    let is_cone = ["glare", "signal"].contains(&word);
    if !is_cone {
        place.without(
            "theta_deg",
            draft.theta_deg.as_ref(),
            "only glare and signal have a direction",
        )?;
        place.without(
            "azimuth_deg",
            draft.azimuth_deg.as_ref(),
            "only glare and signal have a direction",
        )?;
    }
    if word != "image" {
        place.without(
            "observation_deg",
            draft.observation_deg.as_ref(),
            "only an image has a range",
        )?;
    }
    if ["haze", "image"].contains(&word) {
        place.without("half_angle_deg", draft.half_angle_deg.as_ref(), "its cone is fixed")?;
    }
    let quantity = match word {
        "haze" => Quantity::Haze,
        "image" => {
            let said = place.needed(&span, "observation_deg", draft.observation_deg)?;
            let observation_deg = place.two("observation_deg", &said, [-85.0, 85.0])?;
            Quantity::Image { face, observation_deg }
        }
        "flux" => {
            let half = draft.half_angle_deg.as_ref();
            let half =
                half.map(|said| place.number("half_angle_deg", said, [0.1, 90.0])).transpose()?;
            Quantity::Flux { face, half_deg: half.unwrap_or(90.0) }
        }
        _ => {
            let theta = place.needed(&span, "theta_deg", draft.theta_deg)?;
            let theta_deg = place.number("theta_deg", &theta, [-89.0, 89.0])?;
            let half = place.needed(&span, "half_angle_deg", draft.half_angle_deg)?;
            let half_deg = place.number("half_angle_deg", &half, [0.05, 45.0])?;
            let azimuth = draft.azimuth_deg.as_ref();
            let azimuth = azimuth
                .map(|said| place.number("azimuth_deg", said, [-360.0, 360.0]))
                .transpose()?;
            if theta_deg.abs() + half_deg > 90.0 {
                let what = "the cone reaches below the horizon; give a smaller half_angle_deg or theta_deg";
                return Err(place.fault(half.span(), what));
            }
            Quantity::Cone(Grasp { face, theta_deg, azimuth_deg: azimuth.unwrap_or(0.0), half_deg })
        }
    };
    Ok(Wanted { quantity, word, error_percent })
}

fn target(place: &Place<'_>, (span, draft): Table<TargetDraft>) -> Result<Target, SceneError> {
    let kind = place.needed(&span, "kind", draft.kind)?;
    let (word, kind) = place.word("kind", &kind, &TARGETS)?;
    if kind != TargetKind::CortexM4f {
        let why = format!("a {word} has no such limit");
        place.without("kib", draft.kib.as_ref(), &why)?;
        place.without("instructions", draft.instructions.as_ref(), &why)?;
        return Ok(Target { kind, bytes: usize::MAX, instructions: u32::MAX });
    }
    let kib = place.needed(&span, "kib", draft.kib)?;
    let bytes = (1024.0 * place.number("kib", &kib, KIB)?) as usize;
    let count = place.needed(&span, "instructions", draft.instructions)?;
    let instructions = place.number("instructions", &count, [1.0, 1e9])? as u32;
    Ok(Target { kind, bytes, instructions })
}
