//! A table as source code: constants for a Rust firmware, arrays for C.

use std::fmt::{Display, Write as _};

use asperity_core::table::{Header, LobeHeader};

use super::{EmbeddedTable, Values};

/// Numbers on a line of the source.
const PER_LINE: usize = 16;

/// A Rust module with the arrays as statics, and `TABLE`, a view of them made when the firmware is built.
pub fn rust_source(table: &EmbeddedTable, method: &str) -> String {
    let header = table.header();
    let mut text = format!(
        "//! BSDF table made by asperity of a model of method {method}; {} bytes.\n//! Do not edit: make it anew.\n\n\
         use asperity_core::quantity::RelativeIor;\n\
         use asperity_core::table::{{Arrays, BsdfTableRef, Fall, Form, Header, LobeHeader, Shape, TableError}};\n\n",
        table.bytes()
    );
    let name = table.storage();
    rust_array(
        &mut text,
        "GAINS",
        "f32",
        &table.gains.iter().map(|g| format!("{g:e}")).collect::<Vec<_>>(),
    );
    match &table.values {
        Values::U8(v) => rust_array(&mut text, "VALUES", name, v),
        Values::U16(v) => rust_array(&mut text, "VALUES", name, v),
        Values::F32(v) => {
            rust_array(
                &mut text,
                "VALUES",
                name,
                &v.iter().map(|x| format!("{x:e}")).collect::<Vec<_>>(),
            );
        }
    }
    rust_array(&mut text, "QUANTILES", "u16", &table.quantiles);
    rust_array(&mut text, "LEANS", "i8", &table.leans);
    let rows: Vec<String> = table.fluxes.iter().map(|row| format!("{row:?}")).collect();
    rust_array(&mut text, "FLUXES", "[u16; 4]", &rows);
    let lobes: Vec<String> =
        header.lobes.iter().map(|l| l.as_ref().map_or("None".into(), rust_lobe)).collect();
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "/// {}.\npub const ETA: RelativeIor<f32> = match RelativeIor::constant({:?}) {{\n    \
         Some(eta) => eta,\n    None => unreachable!(),\n}};\n\n\
         /// The numbers of the table.\npub const HEADER: Header = Header {{\n    eta: ETA,\n    opaque: {},\n    slope: {:e},\n    \
         lobes: [\n{}\n    ],\n    fluxes: {:?},\n    grazing: {:?},\n}};\n\n\
         /// The arrays of the table.\npub const ARRAYS: Arrays<'static, {name}> = Arrays {{\n    gains: &GAINS,\n    values: &VALUES,\n    \
         quantiles: &QUANTILES,\n    leans: &LEANS,\n    fluxes: &FLUXES,\n}};\n\n\
         /// CRC-32C of the header and the arrays, for `HEADER.verified(ARRAYS, CHECKSUM)`, with the feature `checksum` of core.\n\
         pub const CHECKSUM: u32 = 0x{:04x}_{:04x};\n\n\
         /// The table: a constant, so that the device has nothing to do before it evaluates.\n\
         pub static TABLE: BsdfTableRef<'static, {name}> = match HEADER.view(ARRAYS) {{\n    \
         Some(table) => table,\n    None => unreachable!(),\n}};\n\n\
         /// The same with every number checked, for a test.\n///\n/// # Errors\n/// None that a table as it was made could give.\n\
         pub fn table() -> Result<BsdfTableRef<'static, {name}>, TableError> {{\n    HEADER.table(ARRAYS)\n}}\n",
        index(header),
        header.eta.get(),
        header.opaque,
        header.slope,
        lobes.iter().map(|l| format!("        {l},")).collect::<Vec<_>>().join("\n"),
        header.fluxes,
        header.grazing,
        table.checksum() >> 16,
        table.checksum() & 0xffff,
    );
    text
}

/// What the index of a table is.
fn index(header: &Header) -> &'static str {
    if header.opaque {
        "A number of the format: the body is opaque and has no index"
    } else {
        "Index of the dielectric over that of air"
    }
}

fn rust_array<V: Display>(text: &mut String, name: &str, kind: &str, values: &[V]) {
    let _ = writeln!(text, "static {name}: [{kind}; {}] = [", values.len());
    lines(text, values);
    text.push_str("];\n\n");
}

fn lines<V: Display>(text: &mut String, values: &[V]) {
    for line in values.chunks(PER_LINE) {
        let line: Vec<String> = line.iter().map(ToString::to_string).collect();
        let _ = writeln!(text, "    {},", line.join(", "));
    }
}

fn rust_lobe(l: &LobeHeader) -> String {
    let s = l.shape;
    format!(
        "Some(LobeHeader {{ shape: Shape {{ incidences: {}, azimuths: {}, radii: {}, intervals: {} }}, form: Form::{:?}, \
         fall: Fall::{:?}, scale: {:e}, grazing: {:e}, masking: {:e} }})",
        s.incidences,
        s.azimuths,
        s.radii,
        s.intervals,
        l.form,
        l.fall,
        l.scale,
        l.grazing,
        l.masking
    )
}

/// A C header with the arrays and their sizes; `name` becomes the prefix of all names.
pub fn c_header(table: &EmbeddedTable, method: &str, name: &str) -> String {
    let prefix: String = name
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' })
        .collect();
    let prefix = format!("bsdf_{prefix}");
    let guard = format!("{}_H", prefix.to_uppercase());
    let header = table.header();
    let mut text = format!(
        "/* BSDF table made by asperity of a model of method {method}; {} bytes. Do not edit: make it anew.\n   \
         Arrays hold the lobes one after the other: from the air reflection and transmission, from the\n   \
         dielectric reflection and transmission. Values run over radii, azimuths, incidences. */\n\
         #ifndef {guard}\n#define {guard}\n\n#include <stdint.h>\n\n\
         /* {} */\nstatic const float {prefix}_eta = {}f;\n\
         /* 1 for an opaque body */\nenum {{ {prefix}_opaque = {} }};\nstatic const float {prefix}_slope = {}f;\n",
        table.bytes(),
        index(header),
        c_float(header.eta.get()),
        u8::from(header.opaque),
        c_float(header.slope),
    );
    text.push_str("\n/* incidences, azimuths, radii, intervals, form (0 masked, 1 drawn, 2 direct), fall; 0 of a lobe left out */\n");
    let rows: Vec<String> = header
        .lobes
        .iter()
        .map(|l| l.map_or("{ 0, 0, 0, 0, 0, 0 }".into(), |l| c_lobe(&l)))
        .collect();
    let _ =
        writeln!(text, "static const uint16_t {prefix}_lobes[4][6] = {{ {} }};", rows.join(", "));
    let numbers: Vec<String> = header
        .lobes
        .iter()
        .map(|l| {
            l.map_or("{ 0.0f, 0.0f, 0.0f }".into(), |l| {
                let [s, k, a] = [l.scale, l.grazing, l.masking].map(c_float);
                format!("{{ {s}f, {k}f, {a}f }}")
            })
        })
        .collect();
    let _ = writeln!(
        text,
        "/* scale of slopes, crowding of incidences, width of masking */\nstatic const float {prefix}_scales[4][3] = {{ {} }};",
        numbers.join(", ")
    );
    let [a, b] = header.fluxes;
    let [k, l] = header.grazing.map(c_float);
    let _ = writeln!(
        text,
        "static const uint16_t {prefix}_flux_incidences[2] = {{ {a}, {b} }};\nstatic const float {prefix}_flux_grazing[2] = {{ {k}f, {l}f }};\n"
    );
    let _ = writeln!(
        text,
        "/* CRC-32C of all numbers and arrays */\nstatic const uint32_t {prefix}_checksum = {:#010x}u;\n",
        table.checksum()
    );
    let floats = |v: &[f32]| v.iter().map(|x| format!("{}f", c_float(*x))).collect::<Vec<_>>();
    c_array(&mut text, &prefix, "gains", "float", &floats(&table.gains));
    match &table.values {
        Values::U8(v) => c_array(&mut text, &prefix, "values", "uint8_t", v),
        Values::U16(v) => c_array(&mut text, &prefix, "values", "uint16_t", v),
        Values::F32(v) => c_array(&mut text, &prefix, "values", "float", &floats(v)),
    }
    c_array(&mut text, &prefix, "quantiles", "uint16_t", &table.quantiles);
    c_array(&mut text, &prefix, "leans", "int8_t", &table.leans);
    let flat: Vec<u16> = table.fluxes.iter().flatten().copied().collect();
    c_array(&mut text, &prefix, "fluxes", "uint16_t", &flat);
    let _ = writeln!(text, "#endif");
    text
}

fn c_float(x: f32) -> String {
    format!("{x:?}")
}

fn c_lobe(l: &LobeHeader) -> String {
    let s = l.shape;
    let (form, fall) = (l.form.number(), l.fall.number());
    format!("{{ {}, {}, {}, {}, {form}, {fall} }}", s.incidences, s.azimuths, s.radii, s.intervals)
}

fn c_array<V: Display>(text: &mut String, prefix: &str, name: &str, kind: &str, values: &[V]) {
    // an array of C has at least one element
    if values.is_empty() {
        return;
    }
    let _ = writeln!(text, "static const {kind} {prefix}_{name}[{}] = {{", values.len());
    lines(text, values);
    text.push_str("};\n\n");
}
