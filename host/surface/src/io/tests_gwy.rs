//! Tests of the reader of Gwyddion files, on files built here.

use super::gwy::{self, detect};
use super::{MapFault, OpenOptions, RawMap};

fn read(bytes: &[u8]) -> Result<RawMap, MapFault> {
    gwy::read(bytes, &OpenOptions::default())
}

fn component(key: &str, kind: char, value: &[u8]) -> Vec<u8> {
    [key.as_bytes(), &[0, kind as u8], value].concat()
}

fn object(name: &str, components: &[Vec<u8>]) -> Vec<u8> {
    let body = components.concat();
    [name.as_bytes(), &[0], &(body.len() as u32).to_le_bytes(), &body].concat()
}

fn unit(key: &str, unit: &str) -> Vec<u8> {
    let text = component("unitstr", 's', &[unit.as_bytes(), &[0]].concat());
    component(key, 'o', &object("GwySIUnit", &[text]))
}

/// A channel of 3 x 2 values 0, 1 ... times `step`, 6 by 2 units.
fn channel(key: &str, xy: &str, z: &str, step: f64) -> Vec<u8> {
    let values = (0..6).flat_map(|k| (f64::from(k) * step).to_le_bytes());
    let data: Vec<u8> = 6_u32.to_le_bytes().into_iter().chain(values).collect();
    let parts = [
        component("xres", 'i', &3_i32.to_le_bytes()),
        component("yres", 'i', &2_i32.to_le_bytes()),
        component("xreal", 'd', &6e-6_f64.to_le_bytes()),
        component("yreal", 'd', &2e-6_f64.to_le_bytes()),
        unit("si_unit_xy", xy),
        unit("si_unit_z", z),
        component("data", 'D', &data),
    ];
    component(key, 'o', &object("GwyDataField", &parts))
}

fn file(components: &[Vec<u8>]) -> Vec<u8> {
    [b"GWYP".to_vec(), object("GwyContainer", components)].concat()
}

/// A file with components of all kinds, a channel of volts and two of heights.
pub(super) fn sample() -> Vec<u8> {
    let one = 1_u32.to_le_bytes();
    let meta = component("Instrument", 's', b"AFM 7\0");
    file(&[
        component("/0/data/title", 's', b"Amplitude\0"),
        component("/flags", 'b', &[1]),
        component("/byte", 'c', b"x"),
        component("/long", 'q', &[0; 8]),
        component("/bytes", 'C', &[&one[..], &[7]].concat()),
        component("/ints", 'I', &[&one[..], &[7; 4]].concat()),
        component("/longs", 'Q', &[&one[..], &[7; 8]].concat()),
        component("/names", 'S', &[&one[..], b"a\0"].concat()),
        component("/objects", 'O', &[&one[..], &object("GwyX", &[])].concat()),
        channel("/10/data", "m", "m", 1e-6),
        channel("/0/data", "m", "V", 1.0),
        channel("/2/data", "m", "m", 1e-9),
        channel("/2/mask", "m", "", 1.0),
        component("/2/meta", 'o', &object("GwyContainer", &[meta])),
    ])
}

#[test]
fn the_first_channel_of_heights_is_read() {
    assert!(detect(&sample()));
    let map = read(&sample()).unwrap();
    assert_eq!((map.nx, map.ny, map.instrument.as_deref()), (3, 2, Some("AFM 7")));
    assert!((map.dx_um.unwrap() - 2.0).abs() < 1e-12 && (map.dy_um.unwrap() - 1.0).abs() < 1e-12);
    assert!((map.heights_um[5] - 5e-3).abs() < 1e-12);
}

#[test]
fn without_units_nothing_is_guessed() {
    let file = file(&[channel("/0/data", "", "", 1.0)]);
    let fault = read(&file).unwrap_err().to_string();
    assert!(fault.contains("--z-unit") && fault.contains("--pixel-um"), "{fault}");
    let nm = OpenOptions { z_unit: "nm".parse().ok(), ..OpenOptions::default() };
    let map = gwy::read(&file, &nm).unwrap();
    assert_eq!((map.dx_um, map.dy_um), (None, None));
    assert!((map.heights_um[5] - 5e-3).abs() < 1e-12);
    // the sizes are numbers that wait for their unit
    let metres = OpenOptions { xy_unit: "m".parse().ok(), ..nm };
    let map = gwy::read(&file, &metres).unwrap();
    assert!((map.dx_um.unwrap() - 2.0).abs() < 1e-12 && (map.dy_um.unwrap() - 1.0).abs() < 1e-12);
}

#[test]
fn malformed_files_are_refused() {
    let good = channel("/0/data", "m", "m", 1.0);
    let with = |key: &str, skip: usize, new: &[u8]| {
        let mut channel = good.clone();
        let at = channel.windows(key.len()).rposition(|w| w == key.as_bytes()).unwrap();
        let at = at + key.len() + 2 + skip;
        channel[at..at + new.len()].copy_from_slice(new);
        file(&[channel])
    };
    let whole = file(std::slice::from_ref(&good));
    for (bytes, word) in [
        (b"GWYO".to_vec(), "not GWYP"),
        (b"GWYP".to_vec(), "ends early"),
        (whole[..whole.len() - 1].to_vec(), "ends early"),
        (whole[..60].to_vec(), "ends early"),
        (file(&[]), "without a channel"),
        (file(&[channel("/0/data", "m", "V", 1.0)]), "units: V"),
        (file(&[channel("/0/data", "deg", "m", 1.0)]), "`deg`"),
        (file(&[component("/x", 'z', &[])]), "`/x` has no known type"),
        (file(&[component("/x", 'S', &[255; 4])]), "ends early"),
        (file(&[component("/x", 'O', &[255; 4])]), "ends early"),
        (file(&[component("/x", 'D', &[255; 4])]), "ends early"),
        (with("xres", 0, &(-3_i32).to_le_bytes()), "negative"),
        (with("xres", 0, &0_i32.to_le_bytes()), "0 x 2"),
        (with("xres", 0, &4_i32.to_le_bytes()), "do not fill 4 x 2"),
        (with("xres", 0, &i32::MAX.to_le_bytes()), "crop the map"),
        (with("xreal", 0, &(-1.0_f64).to_le_bytes()), "its size gives"),
        (with("yreal", 0, &f64::NAN.to_le_bytes()), "its size gives"),
        (with("data", 0, &[255; 4]), "ends early"),
    ] {
        let fault = read(&bytes).unwrap_err().to_string();
        assert!(fault.contains(word), "{word}: {fault}");
    }
}
