//! Arrays of other types and orders, and damaged files.

use std::f64::consts::PI;

use super::*;
use crate::formats::read_bytes;
use crate::sampled::{Lobe, Side};

fn read_zip(files: &[(&str, Vec<u8>)]) -> Result<Vec<SampledBsdf>, Fault> {
    let files: Vec<_> = files.iter().map(|(n, b)| (format!("{n}.npy"), b.clone())).collect();
    let (format, lobes) = read_bytes("a.npz", &pack(&files).unwrap())?;
    assert_eq!(format.name, "npz");
    Ok(lobes)
}

/// An array as other writers put it: version 2, keys in another order, big-endian singles, a column.
fn other(values: &[f32]) -> Vec<u8> {
    let text =
        format!("{{\"shape\": ({}, 1), 'fortran_order': True, 'descr': '>f4'}}\n", values.len());
    let mut bytes = b"\x93NUMPY\x02\x00".to_vec();
    bytes.extend(u32::try_from(text.len()).unwrap().to_le_bytes());
    bytes.extend(text.bytes());
    bytes.extend(values.iter().flat_map(|v| v.to_be_bytes()));
    bytes
}

fn good() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("theta_i", array::of(&[150.0, 150.0])),
        ("phi_i", array::of(&[10.0, 10.0])),
        ("theta_o", other(&[20.0, 160.0])),
        ("phi_o", array::of(&[190.0, 280.0])),
        ("f", array::of(&[0.5, 0.25])),
        ("metadata", text_array(&["made by hand: µ".into(), "asperity: ior = 1.5".into()])),
        ("unknown", b"whatever".to_vec()),
    ]
}

#[test]
fn arrays_of_other_types_are_read() {
    let lobes = read_zip(&good()).unwrap();
    let [through, back] = lobes.as_slice() else { panic!() };
    assert_eq!((through.side, through.lobe), (Side::Dielectric, Lobe::Transmission));
    assert_eq!((back.lobe, back.index), (Lobe::Reflection, Some(1.5)));
    assert_eq!(back.notes, ["made by hand: µ"]);
    let at = through.incidences[0].nodes.directions()[0];
    assert!((at[0].to_degrees() - 20.0).abs() < 1e-9 && at[1].abs() < 1e-9);
    let at = back.incidences[0].nodes.directions()[0];
    assert!((at[0].to_degrees() - 20.0).abs() < 1e-9 && (at[1] - PI / 2.0).abs() < 1e-9);
}

#[test]
fn damaged_files_are_named_with_a_remedy() {
    let with = |name: &'static str, bytes: Vec<u8>| {
        let mut files = good();
        files.retain(|(n, _)| *n != name);
        files.push((name, bytes));
        files
    };
    let mut huge = array::of(&[1.0, 2.0]);
    let text = String::from_utf8_lossy(&huge).into_owned();
    let at = text.find("(2,)").unwrap() - 2; // the first byte is three in this text
    huge[at..at + 12].copy_from_slice(b"(99999999,) ");
    let mut without = good();
    without.remove(4);
    for (files, what) in [
        (without, "no array f"),
        (with("f", b"no array".to_vec()), "no .npy"),
        (with("f", array::of(&[0.5])), "2 numbers of theta_i where f has 1"),
        (with("f", array::of(&[0.5, f64::NAN])), "number 2 is not finite"),
        (with("f", array::of(&[0.5, -1.0])), "reading 2: a negative BSDF"),
        (with("theta_o", array::of(&[20.0, 200.0])), "reading 2: theta_o"),
        (with("wavelength_nm", array::of(&[550.0, 0.0])), "not positive"),
        (with("f", huge), "fewer numbers"),
        (with("f", array::of(&[0.5, 0.2])[..70].to_vec()), "it ends in its header"),
        (with("f", text_array(&["a".into(), "b".into()])), "type U1"),
        (with("f", [b"\x93NUMPY\x01\x00\x03\x00{}\n".to_vec()].concat()), "no descr"),
    ] {
        let text = read_zip(&files).unwrap_err().to_string();
        assert!(text.contains(what) && text.contains("export"), "{what}: {text}");
    }
    let files: Vec<_> = good().into_iter().map(|(n, b)| (format!("{n}.npy"), b)).collect();
    let zip = pack(&files).unwrap();
    for cut in [100, 400, zip.len() - 10] {
        let Err(e) = read_bytes("a.npz", &zip[..cut]) else { panic!("{cut}") };
        assert!(!e.to_string().is_empty());
    }
    // an array that inflates a thousand times is not a danger
    let zeros =
        pack(&[("theta_i.npy".into(), vec![0; 3 << 20]), ("theta_o.npy".into(), vec![0; 9])]);
    assert!(read_bytes("a.npz", &zeros.unwrap()).is_err());
}
