//! Materials in the scene files of Mitsuba 3 and pbrt-v4, for laws that these programs have in closed form.
//!
//! Both have GGX facets on a dielectric (Mitsuba `roughdielectric`, documentation of its BSDF plugins; pbrt `dielectric`, its file format) with the separable masking
//! of Smith in pbrt's and Mitsuba's own way. They trace radiance: what is transmitted into the material has the BTDF here times
//! `(n_out/n_in)^2`. Their tables (`measured`) hold reflection alone, in a parametrisation of visible normals that a grid of
//! angles is not; so other laws are refused.

use crate::error::CannotHold;
use crate::interpolation::Interpolation;
use crate::law::{Closed, Law, Options, Subject};
use crate::sampled::{Incidence, Nodes, SampledBsdf};

use super::{Format, Writer, own};

/// How a comment of the sampled lobe says what the snippet is of.
const CLOSED: &str = "closed form: ggx alpha = ";

pub(super) const MITSUBA: Format = Format {
    name: "mitsuba",
    title: "Mitsuba 3 scene",
    extensions: &["xml"],
    sniff: |_| false,
    read: None,
    write: Some(Writer { sample: sample_mitsuba, encode: encode_mitsuba, notes: NOTES }),
};

pub(super) const PBRT: Format = Format {
    name: "pbrt",
    title: "pbrt-v4 scene",
    extensions: &["pbrt"],
    sniff: |_| false,
    read: None,
    write: Some(Writer { sample: sample_pbrt, encode: encode_pbrt, notes: NOTES }),
};

const NOTES: &[&str] = &[
    "one material is all four lobes: both sides, reflection and transmission",
    "the program scales transmitted radiance by eta^2: its BTDF is that of the other formats times (n_in/n_out)^2, n_in the side the camera path comes from",
];

fn sample_mitsuba(_: &dyn Law, subject: &Subject, _: &Options) -> Result<SampledBsdf, CannotHold> {
    sample("Mitsuba 3", subject)
}

fn sample_pbrt(_: &dyn Law, subject: &Subject, _: &Options) -> Result<SampledBsdf, CannotHold> {
    sample("pbrt-v4", subject)
}

/// A lobe without values whose notes carry the parameters.
fn sample(format: &'static str, subject: &Subject) -> Result<SampledBsdf, CannotHold> {
    let Some(Closed::Ggx { alpha }) = subject.closed else {
        return Err(CannotHold {
            format,
            what: "a law other than GGX: its tables hold reflection alone, over visible normals"
                .into(),
            remedy: "fit GGX and export that, or use csv or npz for a plugin of your own".into(),
        });
    };
    if subject.index.is_none() {
        return Err(CannotHold {
            format,
            what: "GGX facets without an index".into(),
            remedy: "give --ior".into(),
        });
    }
    let mut notes = vec![format!("{CLOSED}{alpha}")];
    notes.extend(subject.notes.iter().cloned());
    Ok(SampledBsdf {
        side: subject.side,
        lobe: subject.lobe,
        index: subject.index,
        symmetry: subject.symmetry,
        bands: vec![subject.band.clone()],
        interpolation: Interpolation::Nearest,
        incidences: vec![Incidence {
            theta: 0.0,
            phi: 0.0,
            nodes: Nodes::Points(Vec::new()),
            values: Vec::new(),
            stated: Vec::new(),
        }],
        has_level: true,
        notes,
    })
}

/// Width and index of a lobe made by [`sample`].
fn parameters(
    format: &'static str,
    lobes: &[SampledBsdf],
) -> Result<(f64, f64, Vec<String>), CannotHold> {
    let refuse = || CannotHold {
        format,
        what: "values of a table".into(),
        remedy: "export a fitted GGX model, or use csv or npz".into(),
    };
    let first = lobes.first().ok_or_else(refuse)?;
    let closed = first.notes.iter().find_map(|note| note.strip_prefix(CLOSED));
    let alpha = closed.and_then(|alpha| alpha.parse::<f64>().ok()).ok_or_else(refuse)?;
    let index = first.index.ok_or_else(refuse)?;
    if lobes.iter().any(|l| l.index != first.index || l.notes != first.notes) {
        return Err(refuse());
    }
    // one material is of all lobes: their names would mislead
    let lines = own::lines(first)
        .into_iter()
        .filter(|line| !line.contains(": side = ") && !line.contains(": lobe = "));
    Ok((alpha, index, lines.collect()))
}

fn encode_mitsuba(lobes: &[SampledBsdf]) -> Result<Vec<u8>, CannotHold> {
    let (alpha, index, lines) = parameters("Mitsuba 3", lobes)?;
    let comments: Vec<_> =
        lines.iter().map(|line| format!("    <!-- {} -->\n", line.replace("--", "- -"))).collect();
    // int is the side against the normal: the dielectric
    let text = format!(
        "<scene version=\"3.0.0\">\n{}    \
         <!-- GGX facets, separable masking. Transmitted radiance is scaled by eta^2 here: the BTDF of Mitsuba is the flux BTDF times \
         (n of the side of wi / n of the side of wo)^2. The normal points into the air. -->\n    \
         <bsdf type=\"roughdielectric\" id=\"rough_surface\">\n        \
         <string name=\"distribution\" value=\"ggx\"/>\n        \
         <float name=\"alpha\" value=\"{alpha}\"/>\n        \
         <float name=\"int_ior\" value=\"{index}\"/>\n        \
         <float name=\"ext_ior\" value=\"1\"/>\n    </bsdf>\n</scene>\n",
        comments.concat()
    );
    Ok(text.into_bytes())
}

fn encode_pbrt(lobes: &[SampledBsdf]) -> Result<Vec<u8>, CannotHold> {
    let (alpha, index, lines) = parameters("pbrt-v4", lobes)?;
    let comments: Vec<_> = lines.iter().map(|line| format!("# {line}\n")).collect();
    let text = format!(
        "{}# GGX facets with the height-correlated masking of pbrt. Transmitted radiance is scaled by eta^2: a BTDF value of pbrt for paths \
         from the camera is the flux BTDF divided by eta^2.\n# The normal points into the air.\n\
         MakeNamedMaterial \"rough_surface\"\n    \"string type\" \"dielectric\"\n    \
         \"float eta\" {index}\n    \"float roughness\" {alpha}\n    \"bool remaproughness\" false\n",
        comments.concat()
    );
    Ok(text.into_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampled::{Band, Lobe, Side, Symmetry};

    struct Nothing;
    impl Law for Nothing {
        fn value(&self, _: [f64; 2], _: [f64; 2]) -> f64 {
            0.0
        }
    }

    fn subject(closed: Option<Closed>) -> Subject {
        Subject {
            side: Side::Air,
            lobe: Lobe::Transmission,
            index: Some(1.49),
            symmetry: Symmetry::Isotropic,
            band: Band::Wavelength(550.0),
            notes: vec!["Sample: a -- b".into()],
            coherent: 0.0,
            closed,
        }
    }

    #[test]
    fn materials_have_width_and_index() {
        let subject = subject(Some(Closed::Ggx { alpha: 0.25 }));
        let sampled = sample_mitsuba(&Nothing, &subject, &Options::default()).unwrap();
        let text =
            String::from_utf8(encode_mitsuba(std::slice::from_ref(&sampled)).unwrap()).unwrap();
        for part in
            ["value=\"ggx\"", "\"alpha\" value=\"0.25\"", "\"int_ior\" value=\"1.49\"", "a - - b"]
        {
            assert!(text.contains(part), "{text}");
        }
        let text = String::from_utf8(encode_pbrt(&[sampled]).unwrap()).unwrap();
        for part in ["\"float roughness\" 0.25", "\"float eta\" 1.49", "remaproughness\" false"] {
            assert!(text.contains(part), "{text}");
        }
    }

    #[test]
    fn other_laws_are_refused() {
        for format in [MITSUBA, PBRT] {
            let write = format.write.unwrap();
            let e = (write.sample)(&Nothing, &subject(None), &Options::default()).unwrap_err();
            assert!(e.to_string().contains("fit GGX"), "{e}");
        }
    }
}
