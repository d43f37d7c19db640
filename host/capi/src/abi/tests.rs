//! The border crossed from Rust; what is the same from C is in `tests/capi`. Made for Miri: few and small.

use core::ffi::c_void;
use core::ptr::{null, null_mut};
use std::vec::Vec;

use asperity_core::bsdf::{Bsdf as _, Ggx};
use asperity_core::direction::Direction;
use asperity_core::quantity::{Alpha, RelativeIor};
use asperity_core::table::{Arrays, Fall, Form, Header, LobeHeader, Shape};

use super::ggx::*;
use super::normals::*;
use super::source::{AsperityTable, AsperityTableSource};
use super::table::*;
use crate::law::AsperityRay;
use crate::status::AsperityStatus as Status;

const WI: [f32; 3] = [0.3, 0.1, 0.9];
const WO: [f32; 3] = [-0.2, 0.05, -0.8];

unsafe extern "C" fn uniform(state: *mut c_void) -> f32 {
    // SAFETY: the tests give a u32
    let word = unsafe { &mut *state.cast::<u32>() };
    *word = word.wrapping_mul(1664525).wrapping_add(1013904223);
    (*word >> 8) as f32 / 16_777_216.0
}

unsafe extern "C" fn no_uniform(_: *mut c_void) -> f32 {
    f32::NAN
}

fn ggx() -> AsperityGgx {
    let mut ggx = AsperityGgx::EMPTY;
    // SAFETY: storage of its own
    assert_eq!(unsafe { asperity_ggx_init(&raw mut ggx, 0.3, 1.5, 0) }, Status::Ok);
    ggx
}

#[test]
fn values_are_those_of_core_and_outputs_may_overlap_inputs() {
    let ggx = ggx();
    let law = Ggx::new(Alpha::new(0.3_f32).unwrap(), RelativeIor::new(1.5).unwrap());
    let d = |[x, y, z]: [f32; 3]| Direction::new(x, y, z).unwrap();
    let expected = law.eval(d(WI), d(WO));
    let mut out = 0.0;
    // SAFETY: storage of its own
    let status =
        unsafe { asperity_ggx_eval(&raw const ggx, WI.as_ptr(), WO.as_ptr(), &raw mut out) };
    assert_eq!((status, out.to_bits()), (Status::Ok, expected.to_bits()));

    let mut both = [WI, WO, WI, WO].concat();
    both[6] = f32::NAN;
    let p = both.as_mut_ptr();
    // SAFETY: 12 floats; one value for each pair lands on directions already read
    let status = unsafe { asperity_ggx_batch(&raw const ggx, 0, 2, p, 6, p.add(3), 6, p) };
    assert_eq!(status, Status::NotFinite);
    assert_eq!(both[0].to_bits(), expected.to_bits());
    assert!(both[1].is_nan());
}

#[test]
fn hostile_calls_come_back_with_the_reason() {
    let ggx = ggx();
    let g = &raw const ggx;
    let mut out = [7.0_f32; 2];
    let o = out.as_mut_ptr();
    let empty = AsperityNormals::EMPTY;
    let bad = [[f32::NAN, 0.0, 1.0], [f32::INFINITY, 0.0, 1.0], [0.0; 3]];
    // SAFETY: every pointer is null, misaligned, or to storage of its own
    unsafe {
        assert_eq!(asperity_ggx_init(null_mut(), 0.3, 1.5, 0), Status::NullPointer);
        assert_eq!(asperity_ggx_eval(null(), WI.as_ptr(), WO.as_ptr(), o), Status::NullPointer);
        assert_eq!(asperity_ggx_eval(g, null(), WO.as_ptr(), o), Status::NullPointer);
        assert_eq!(asperity_ggx_eval(g, WI.as_ptr(), WO.as_ptr(), null_mut()), Status::NullPointer);
        let odd = WI.as_ptr().wrapping_byte_add(1);
        assert_eq!(asperity_ggx_eval(g, odd, WO.as_ptr(), o), Status::Misaligned);
        assert_eq!(
            asperity_ggx_batch(g, 9, 1, WI.as_ptr(), 0, WO.as_ptr(), 0, o),
            Status::UnknownOption
        );
        let far = asperity_ggx_batch(g, 0, usize::MAX / 2, WI.as_ptr(), 3, WO.as_ptr(), 0, o);
        assert_eq!(far, Status::OutOfDomain);
        for (wi, reason) in
            bad.iter().zip([Status::NotFinite, Status::NotFinite, Status::ZeroVector])
        {
            *o = 7.0;
            assert_eq!(asperity_ggx_eval(g, wi.as_ptr(), WO.as_ptr(), o), reason);
            assert!((*o).is_nan());
        }
        let mut ray = AsperityRay::LOST;
        let mut sample = |u| asperity_ggx_sample(g, WI.as_ptr(), u, null_mut(), &raw mut ray);
        assert_eq!(sample(None), Status::NullPointer);
        assert_eq!(sample(Some(no_uniform)), Status::OutOfDomain);
        // of another kind, never made, made without success
        assert_eq!(
            asperity_normals_eval((&raw const empty).cast(), WI.as_ptr(), WO.as_ptr(), o),
            Status::NotInitialised
        );
        let mut other = ggx;
        for (alpha, eta, tier, reason) in [
            (f32::NAN, 1.5, 0, Status::NotFinite),
            (-1.0, 1.5, 0, Status::OutOfDomain),
            (0.3, 99.0, 0, Status::OutOfDomain),
            (0.3, 1.5, 2, Status::UnknownOption),
        ] {
            assert_eq!(asperity_ggx_init(&raw mut other, alpha, eta, tier), reason);
            let status = asperity_ggx_eval(&raw const other, WI.as_ptr(), WO.as_ptr(), o);
            assert_eq!(status, Status::NotInitialised);
        }
    }
}

#[test]
fn rays_of_both_tiers_are_unit_vectors_or_lost() {
    let mut rays = [AsperityRay::LOST; 8];
    for tier in [0, 1] {
        let (mut ggx, mut normals) = (AsperityGgx::EMPTY, AsperityNormals::EMPTY);
        let mut seed = 5_u32;
        let state = (&raw mut seed).cast();
        let (wi, to) = (WI.as_ptr(), rays.as_mut_ptr());
        // SAFETY: storage of its own
        unsafe {
            assert_eq!(asperity_ggx_init(&raw mut ggx, 0.3, 1.5, tier), Status::Ok);
            assert_eq!(
                asperity_ggx_sample_batch(&raw const ggx, 4, wi, Some(uniform), state, to),
                Status::Ok
            );
            // Miri takes minutes for the integrals of a density
            if !cfg!(miri) || tier == 0 {
                let status = asperity_normals_init(&raw mut normals, 0, 0.2, 2.0, 0.0, 1.5, tier);
                assert_eq!(status, Status::Ok);
                let copy = normals;
                let status = asperity_normals_sample_batch(
                    &raw const copy,
                    4,
                    wi,
                    Some(uniform),
                    state,
                    to.add(4),
                );
                assert_eq!(status, Status::Ok);
            }
        }
        for AsperityRay { wo: [x, y, z], weight } in rays {
            let length = x * x + y * y + z * z;
            assert!(
                (weight > 0.0 && (length - 1.0).abs() < 1e-5) || (weight <= 0.0 && length <= 0.0)
            );
        }
    }
}

/// A lobe of 2 incidences, 2 azimuths, 2 radii and one interval, as a payload of words so that it is aligned.
fn payload() -> Vec<u32> {
    let mut bytes = Vec::new();
    bytes.extend([2e-5_f32; 9].iter().flat_map(|g| g.to_le_bytes()));
    bytes.extend([100_u8, 90, 80, 70, 60, 50, 40, 30]);
    bytes.extend([0_u16, 40_000, 0, 40_000].iter().flat_map(|q| q.to_le_bytes()));
    bytes.extend([5_u8, 10]);
    bytes.extend([0_u16, 50_000, 0, 0, 0, 40_000, 0, 0].iter().flat_map(|f| f.to_le_bytes()));
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    bytes.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b)).collect()
}

static ETA: f32 = 1.5;
static MATCHED: f32 = 1.0;
static SLOPE: f32 = 0.3;
/// Without anything but an index.
const SOURCE: AsperityTableSource = AsperityTableSource {
    eta: &raw const ETA,
    slope: &raw const SLOPE,
    lobes: null(),
    scales: null(),
    flux_incidences: null(),
    flux_grazing: null(),
    gains: null(),
    values: null(),
    quantiles: null(),
    leans: null(),
    fluxes: null(),
    checksum: null(),
    gains_length: 0,
    values_length: 0,
    quantiles_length: 0,
    leans_length: 0,
    fluxes_length: 0,
    value_bytes: 1,
    opaque: 0,
};
const BYTES: usize = 36 + 8 + 8 + 2 + 16;

#[test]
fn a_table_is_viewed_in_its_payload_or_refused() {
    let words = payload();
    let lobes: [[u16; 6]; 4] = [[0; 6], [2, 2, 2, 1, 0, 4], [0; 6], [0; 6]];
    let scales = [[0.0_f32; 3], [0.3, 1.0, 0.3], [0.0; 3], [0.0; 3]];
    let source = AsperityTableSource {
        lobes: lobes.as_ptr().cast(),
        scales: scales.as_ptr().cast(),
        flux_incidences: [2, 0].as_ptr(),
        flux_grazing: [1.0, 0.0].as_ptr(),
        ..SOURCE
    };
    let start = words.as_ptr().cast::<u8>();
    let mut table = AsperityTable::EMPTY;
    let t = &raw mut table;
    let init = |source: &AsperityTableSource, at: *const u8, bytes| {
        // SAFETY: no more bytes than the payload has are read
        unsafe { asperity_table_init_payload(t, source, at.cast(), bytes, 0) }
    };
    assert_eq!(init(&source, start, BYTES - 1), Status::TableLength);
    assert_eq!(init(&source, start, 0), Status::TableLength);
    assert_eq!(init(&source, null(), BYTES), Status::NullPointer);
    assert_eq!(init(&source, start.wrapping_add(2), BYTES), Status::Misaligned);
    assert_eq!(
        init(&AsperityTableSource { value_bytes: 3, ..source }, start, BYTES),
        Status::UnknownOption
    );
    assert_eq!(
        init(&AsperityTableSource { eta: &raw const MATCHED, ..source }, start, BYTES),
        Status::TableNumber
    );
    assert_eq!(
        init(&AsperityTableSource { lobes: null(), ..source }, start, BYTES),
        Status::NullPointer
    );
    let huge: [[u16; 6]; 4] = [[4096, 4096, 4096, 4096, 0, 4]; 4];
    let huge = AsperityTableSource { lobes: huge.as_ptr().cast(), ..source };
    assert_eq!(init(&huge, start, BYTES), Status::TableShape);
    assert_eq!(init(&source, start, BYTES), Status::Ok);

    let (mut out, mut seed) = (0.0, 3_u32);
    let mut rays = [AsperityRay::LOST; 4];
    // SAFETY: storage of its own
    unsafe {
        assert_eq!(asperity_table_eval(t, WI.as_ptr(), WO.as_ptr(), &raw mut out), Status::Ok);
        assert!(out > 0.0);
        assert_eq!(asperity_table_transmittance(t, 1.0, 0, &raw mut out), Status::Ok);
        assert_eq!(out.to_bits(), (50_000.0_f32 * (1.0 / 65535.0)).to_bits());
        assert_eq!(asperity_table_reflectance(t, 1.5, 0, &raw mut out), Status::OutOfDomain);
        assert_eq!(asperity_table_reflectance(t, 0.5, 2, &raw mut out), Status::UnknownOption);
        let (wi, state, to) = (WI.as_ptr(), (&raw mut seed).cast(), rays.as_mut_ptr());
        assert_eq!(asperity_table_sample_batch(t, 4, wi, Some(uniform), state, to), Status::Ok);
        // the arrays apart, the values at an odd address
        let apart =
            AsperityTableSource { gains: start.wrapping_add(1).cast(), gains_length: 9, ..source };
        assert_eq!(asperity_table_init(t, &raw const apart, 0), Status::Misaligned);
        assert_eq!(
            asperity_table_eval(t, WI.as_ptr(), WO.as_ptr(), &raw mut out),
            Status::NotInitialised
        );
    }
}

/// Gains, values, quantiles, leans and fluxes of a lobe of `incidences`, 3 azimuths, `radii` and one interval, whose
/// values have `bytes` bytes; and how far each array is from the start.
fn parts(incidences: usize, radii: usize, bytes: usize) -> (Vec<u8>, [usize; 5]) {
    let mut all = Vec::new();
    let mut starts = [0; 5];
    for _ in 0..=8 * (incidences - 1) {
        all.extend(1e-4_f32.to_le_bytes());
    }
    starts[1] = all.len();
    for k in 0..incidences * 3 * radii {
        all.extend_from_slice(&(k as u32 + 50).to_le_bytes()[..bytes]);
    }
    starts[2] = all.len();
    for _ in 0..incidences {
        all.extend([0_u16, 40_000].iter().flat_map(|q| q.to_le_bytes()));
    }
    starts[3] = all.len();
    all.resize(all.len() + incidences, 5);
    starts[4] = all.len();
    all.extend([0_u16, 50_000, 0, 0, 0, 40_000, 0, 0].iter().flat_map(|f| f.to_le_bytes()));
    (all, starts)
}

#[test]
fn a_payload_at_any_address_is_viewed_or_refused_as_misaligned() {
    let mut seen = [0; 2];
    for (incidences, radii, bytes) in [(2, 2, 1), (2, 2, 2), (3, 2, 1), (3, 3, 1), (3, 2, 2)] {
        let (content, starts) = parts(incidences, radii, bytes);
        let n = u16::try_from(incidences).unwrap();
        let lobes = [[0; 6], [n, 3, u16::try_from(radii).unwrap(), 1, 0, 4], [0; 6], [0; 6]];
        let scales = [[0.0_f32; 3], [0.3, 1.0, 0.3], [0.0; 3], [0.0; 3]];
        let source = AsperityTableSource {
            lobes: lobes.as_ptr().cast(),
            scales: scales.as_ptr().cast(),
            flux_incidences: [2, 0].as_ptr(),
            flux_grazing: [1.0, 0.0].as_ptr(),
            value_bytes: u32::try_from(bytes).unwrap(),
            ..SOURCE
        };
        // words, so that offset 0 is aligned to all
        let mut room = std::vec![0_u64; content.len() / 8 + 3];
        let start = room.as_mut_ptr().cast::<u8>();
        for offset in 0..8 {
            let mut table = AsperityTable::EMPTY;
            let (t, mut out) = (&raw mut table, 0.0_f32);
            // SAFETY: the room has eight bytes more than the content at the farthest offset
            let (status, value) = unsafe {
                let at = start.add(offset);
                at.copy_from_nonoverlapping(content.as_ptr(), content.len());
                let status =
                    asperity_table_init_payload(t, &raw const source, at.cast(), content.len(), 0);
                let value = asperity_table_eval(t, WI.as_ptr(), WO.as_ptr(), &raw mut out);
                (status, value)
            };
            let aligns = [4, bytes, 2, 1, 2];
            let fine = starts.iter().zip(aligns).all(|(s, a)| (s + offset).is_multiple_of(a));
            seen[usize::from(fine)] += 1;
            if fine {
                assert_eq!((status, value), (Status::Ok, Status::Ok), "{bytes} at {offset}");
                assert!(out > 0.0 && out.is_finite());
            } else {
                let refused = (Status::Misaligned, Status::NotInitialised);
                assert_eq!((status, value), refused, "{bytes} at {offset}");
            }
        }
    }
    assert_eq!(seen, [36, 4]);
}

#[test]
fn an_opaque_body_is_one_by_its_flag_and_reflects_only() {
    static STAND_IN: f32 = Header::STAND_IN;
    let words = payload();
    let lobe = [2_u16, 2, 2, 1, 0, 4];
    let number = [0.3_f32, 1.0, 0.3];
    for (k, opaque, expected) in [
        (0, 1_u32, (Status::Ok, 1)),
        (0, 0, (Status::Ok, 0)),
        // an index of 10 alone makes no body opaque
        (1, 0, (Status::Ok, 0)),
        (1, 1, (Status::TableOpaque, 7)),
        (2, 1, (Status::TableOpaque, 7)),
        (3, 1, (Status::TableOpaque, 7)),
    ] {
        let (mut lobes, mut scales) = ([[0; 6]; 4], [[0.0; 3]; 4]);
        (lobes[k], scales[k]) = (lobe, number);
        let fluxes: [u16; 2] = if k < 2 { [2, 0] } else { [0, 2] };
        let source = AsperityTableSource {
            eta: &raw const STAND_IN,
            opaque,
            lobes: lobes.as_ptr().cast(),
            scales: scales.as_ptr().cast(),
            flux_incidences: fluxes.as_ptr(),
            flux_grazing: [1.0, 0.0].as_ptr(),
            ..SOURCE
        };
        let (mut table, mut said) = (AsperityTable::EMPTY, 7_u32);
        let t = &raw mut table;
        // SAFETY: all pointers are to live storage of the right kind
        let status = unsafe {
            let status =
                asperity_table_init_payload(t, &raw const source, words.as_ptr().cast(), BYTES, 0);
            let asked = asperity_table_is_opaque(t, &raw mut said);
            assert_eq!(asked == Status::Ok, status == Status::Ok, "lobe {k}");
            status
        };
        assert_eq!((status, said), expected, "lobe {k}");
    }
}

/// Every bit of the payload and of the numbers beside it: 32 bits of a sum see one that is turned.
#[test]
fn a_flipped_bit_of_a_table_is_refused() {
    let words = payload();
    let lobes: [[u16; 6]; 4] = [[0; 6], [2, 2, 2, 1, 0, 4], [0; 6], [0; 6]];
    let scales = [[0.0_f32; 3], [0.3, 1.0, 0.3], [0.0; 3], [0.0; 3]];
    let shape = Shape { incidences: 2, azimuths: 2, radii: 2, intervals: 1 };
    let lobe = LobeHeader {
        shape,
        form: Form::Masked,
        fall: Fall::Fourth,
        scale: 0.3,
        grazing: 1.0,
        masking: 0.3,
    };
    let header = Header {
        eta: RelativeIor::new(ETA).unwrap(),
        opaque: false,
        slope: SLOPE,
        lobes: [None, Some(lobe), None, None],
        fluxes: [2, 0],
        grazing: [1.0, 0.0],
    };
    let sum = header.checksum(&Arrays::<u8> {
        gains: &[2e-5; 9],
        values: &[100, 90, 80, 70, 60, 50, 40, 30],
        quantiles: &[0, 40_000, 0, 40_000],
        leans: &[5, 10],
        fluxes: &[[0, 50_000, 0, 0], [0, 40_000, 0, 0]],
    });
    let source = AsperityTableSource {
        lobes: lobes.as_ptr().cast(),
        scales: scales.as_ptr().cast(),
        flux_incidences: [2, 0].as_ptr(),
        flux_grazing: [1.0, 0.0].as_ptr(),
        checksum: &raw const sum,
        ..SOURCE
    };
    let init = |source: &AsperityTableSource, words: &[u32]| {
        let mut table = AsperityTable::EMPTY;
        // SAFETY: the payload has as many bytes
        unsafe {
            asperity_table_init_payload(&raw mut table, source, words.as_ptr().cast(), BYTES, 0)
        }
    };
    assert_eq!(init(&source, &words), Status::Ok);
    let mut seen = 0;
    for bit in (0..8 * BYTES).step_by(if cfg!(miri) { 41 } else { 1 }) {
        let mut bad = words.clone();
        bad[bit / 32] ^= 1 << (bit % 32);
        let status = init(&source, &bad);
        assert!(status != Status::Ok, "bit {bit}");
        seen += usize::from(status == Status::TableChecksum);
    }
    assert!(cfg!(miri) || seen > 4 * BYTES, "{seen}");
    for bit in 0..8 * 48 {
        let mut bad = lobes;
        bad[bit / 96][bit % 96 / 16] ^= 1 << (bit % 16);
        let bad = AsperityTableSource { lobes: bad.as_ptr().cast(), ..source };
        assert!(init(&bad, &words) != Status::Ok, "lobes, bit {bit}");
    }
    for bit in 0..32 {
        let eta = f32::from_bits(ETA.to_bits() ^ (1 << bit));
        let bad = AsperityTableSource { eta: &raw const eta, ..source };
        assert!(init(&bad, &words) != Status::Ok, "eta, bit {bit}");
        let other = sum ^ (1 << bit);
        let bad = AsperityTableSource { checksum: &raw const other, ..source };
        assert_eq!(init(&bad, &words), Status::TableChecksum);
    }
}
