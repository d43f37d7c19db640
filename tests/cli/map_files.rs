//! Small files of height maps, written field by field so that each can be made wrong.

use std::io::Cursor;

use flate2::{Compress, Compression, Crc, FlushCompress};
use tiff::encoder::{TiffEncoder, TiffValue, colortype};
use tiff::tags::Tag;

/// An entry of a zip: its name, its bytes as stored, the method (0 stored, 8 deflate), the size it claims.
pub(crate) struct Entry {
    pub(crate) name: &'static str,
    pub(crate) packed: Vec<u8>,
    pub(crate) method: u16,
    pub(crate) size: u32,
}

/// An entry that is not packed.
pub(crate) fn stored(name: &'static str, bytes: impl AsRef<[u8]>) -> Entry {
    let packed = bytes.as_ref().to_vec();
    let size = packed.len() as u32;
    Entry { name, packed, method: 0, size }
}

/// A zip archive; what an entry claims is not checked.
pub(crate) fn zip(entries: &[Entry]) -> Vec<u8> {
    let (mut file, mut directory) = (Vec::new(), Vec::new());
    for entry in entries {
        let mut sum = Crc::new();
        sum.update(&entry.packed);
        let (at, name) = (file.len() as u32, entry.name.as_bytes());
        let mut common = [20_u16, 0, entry.method, 0, 0x21].map(u16::to_le_bytes).concat();
        common.extend(sum.sum().to_le_bytes());
        common.extend((entry.packed.len() as u32).to_le_bytes());
        common.extend(entry.size.to_le_bytes());
        common.extend((name.len() as u16).to_le_bytes());
        common.extend([0, 0]);
        file.extend([b"PK\x03\x04", common.as_slice(), name, &entry.packed].concat());
        let tail = [&[0; 10][..], &at.to_le_bytes(), name].concat();
        directory.extend([b"PK\x01\x02\x14\0", common.as_slice(), &tail].concat());
    }
    let counts = [0, 0, entries.len() as u16, entries.len() as u16].map(u16::to_le_bytes).concat();
    let place = [directory.len() as u32, file.len() as u32].map(u32::to_le_bytes).concat();
    [file, directory, b"PK\x05\x06".to_vec(), counts, place, vec![0, 0]].concat()
}

/// So many MiB of zeros in a deflate stream, without ever making them.
pub(crate) fn zeros(mebibytes: usize) -> Vec<u8> {
    let mut stream = Compress::new(Compression::best(), false);
    let mebibyte = vec![0; 1 << 20];
    let mut block = || {
        let mut block = Vec::with_capacity(1 << 16);
        stream.compress_vec(&mebibyte, &mut block, FlushCompress::Sync).unwrap();
        block
    };
    let (first, other) = (block(), block());
    // zeros repeat zeros, so the second block does for all that follow; then the last, empty one
    [first, other.repeat(mebibytes - 1), vec![3, 0]].concat()
}

pub(crate) fn npy(dictionary: &str, data: &[u8]) -> Vec<u8> {
    let length = (dictionary.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\0", &length[..], dictionary.as_bytes(), data].concat()
}

/// The dictionary of an array.
pub(crate) fn array(descr: &str, fortran: bool, shape: &str) -> String {
    let fortran = if fortran { "True" } else { "False" };
    format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}\n")
}

/// A `main.xml` of 3 x 2 points beside it, with pitches in m.
pub(crate) fn main_xml(nx: &str, dx: &str, more: &str) -> String {
    let axis =
        |d| format!("<AxisType>I</AxisType><DataType>D</DataType><Increment>{d}</Increment>");
    let z = "<AxisType>A</AxisType><DataType>D</DataType>";
    format!(
        "<?xml version=\"1.0\"?><p:ISO5436_2 xmlns:p=\"x\"><Record1><Axes><CX>{}</CX><CY>{}</CY>\
         <CZ>{z}</CZ></Axes></Record1><Record3><MatrixDimension><SizeX>{nx}</SizeX><SizeY>2</SizeY>\
         <SizeZ>1</SizeZ></MatrixDimension><DataLink><PointDataLink>data.bin</PointDataLink>{more}\
         </DataLink></Record3></p:ISO5436_2>",
        axis(dx),
        axis("1e-6")
    )
}

pub(crate) fn x3p(main: &str, more: Vec<Entry>) -> Vec<u8> {
    let mut entries = vec![stored("main.xml", main)];
    entries.extend(more);
    zip(&entries)
}

/// A binary SDF header and its points.
pub(crate) fn sdf(kind: u8, shape: [u16; 2], scales: [f64; 3], points: &[u8]) -> Vec<u8> {
    let mut file = b"bISO-1.0maker\0\0\0\0\x00010120200000010120200000".to_vec();
    file.extend(shape.map(u16::to_le_bytes).concat());
    file.extend(scales.map(f64::to_le_bytes).concat());
    file.extend([0; 8]);
    file.extend([0, kind, 0]);
    file.extend(points);
    file
}

pub(crate) fn sdf_text(nx: &str, dx: &str, points: &str) -> String {
    format!(
        "aISO-1.0\nManufacID = maker\nNumPoints = {nx}\nNumProfiles = 2\nXscale = {dx}\n\
         Yscale = 1e-6\nZscale = 1e-9\nDataType = 5\n*\n{points}\n*\n"
    )
}

pub(crate) fn al3d(columns: &str, pitch: &str) -> Vec<u8> {
    let tags = [
        ("Version", "1"),
        ("TagCount", "5"),
        ("Cols", columns),
        ("Rows", "2"),
        ("DepthImageOffset", "381"),
        ("PixelSizeXMeter", pitch),
        ("PixelSizeYMeter", pitch),
    ];
    let mut file = b"AliconaImaging\0\r\n".to_vec();
    for (key, value) in tags {
        file.extend(format!("{key:\0<20}{value:\0<30}\r\n").bytes());
    }
    file.extend([0; 16]);
    file
}

pub(crate) fn opd(heights: &str, pixel: f32) -> Vec<u8> {
    let data = [[2_u16, 2, 4].map(u16::to_le_bytes).concat(), vec![0; 16]].concat();
    let float = |x: f32| x.to_le_bytes().to_vec();
    let blocks = [("Wavelength", float(500.0)), ("Pixel_size", float(pixel)), (heights, data)];
    let mut file = vec![1, 0];
    let sizes = blocks.iter().map(|(name, block)| (*name, block.len()));
    for (name, length) in std::iter::once(("Directory", 96)).chain(sizes) {
        file.extend(format!("{name:\0<16}\0\0").bytes());
        file.extend((length as u32).to_le_bytes());
        file.extend([8, 0]);
    }
    file.extend(blocks.into_iter().flat_map(|(_, block)| block));
    file
}

pub(crate) fn di(lines: &str, unit: &str) -> Vec<u8> {
    let header = format!(
        "\\*File list\r\n\\Version: 0x05120130\r\n\\*Ciao scan list\r\n\\@Sens. Zsens: V 50 {unit}\r\n\
         \\*Ciao image list\r\n\\Data offset: 1000\r\n\\Data length: 8\r\n\\Bytes/pixel: 2\r\n\
         \\Samps/line: 2\r\n\\Number of lines: {lines}\r\n\\Scan Size: 1 1 ~m\r\n\
         \\@2:Z scale: V [Sens. Zsens] (0.3 mV/LSB) 6 V\r\n\\*File list end\r\n"
    );
    let mut file = header.into_bytes();
    file.resize(1000, 0);
    file.extend([1, 0, 2, 0, 3, 0, 4, 0]);
    file
}

/// A Digital Surf file of `n` x `n` points of 32 bits.
pub(crate) fn sur(magic: &[u8; 12], n: i32, pitch: f32, points: &[u8]) -> Vec<u8> {
    let mut file = [magic, [0_i16, 1, 1, 2].map(i16::to_le_bytes).as_flattened()].concat();
    file.resize(80, b' ');
    file.extend([1_i16, 9, 0, 1, 0, 0, 0, 0, 0, 32].map(i16::to_le_bytes).concat());
    file.extend([-7, 3, n, n, n.wrapping_mul(n)].map(i32::to_le_bytes).concat());
    file.extend([pitch, pitch, 1.0].map(f32::to_le_bytes).concat());
    for word in ["X", "Y", "Z", "um", "um", "um"] {
        file.extend(format!("{word:\0<16}").bytes());
    }
    file.resize(512, 0);
    file.extend(points);
    file
}

/// A Gwyddion file of one channel of 2 x 2 heights.
pub(crate) fn gwy(xres: i32, unit: &str) -> Vec<u8> {
    let object = |name: &str, parts: &[Vec<u8>]| {
        let body = parts.concat();
        [name.as_bytes(), &[0], &(body.len() as u32).to_le_bytes(), &body].concat()
    };
    let part = |key: &str, kind: u8, value: &[u8]| [key.as_bytes(), &[0, kind], value].concat();
    let unit = part("unitstr", b's', format!("{unit}\0").as_bytes());
    let field = [
        part("xres", b'i', &xres.to_le_bytes()),
        part("yres", b'i', &2_i32.to_le_bytes()),
        part("si_unit_z", b'o', &object("GwySIUnit", &[unit])),
        part("data", b'D', &[&4_u32.to_le_bytes()[..], &[0; 32]].concat()),
    ];
    let channel = part("/0/data", b'o', &object("GwyDataField", &field));
    [b"GWYP".to_vec(), object("GwyContainer", &[channel])].concat()
}

pub(crate) fn png(color: png::ColorType, depth: png::BitDepth, bytes: usize) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 2, 2);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.write_header().unwrap().write_image_data(&vec![7; bytes]).unwrap();
    file
}

/// The same image, said to be 16384 points wide and high.
pub(crate) fn huge(mut png: Vec<u8>) -> Vec<u8> {
    png[16..24].copy_from_slice(&[0, 0, 64, 0, 0, 0, 64, 0]);
    let mut sum = Crc::new();
    sum.update(&png[12..29]);
    png[29..33].copy_from_slice(&sum.sum().to_be_bytes());
    png
}

pub(crate) fn tiff<C: colortype::ColorType>(pixels: &[C::Inner]) -> Vec<u8>
where
    [C::Inner]: TiffValue,
{
    let mut file = Cursor::new(Vec::new());
    TiffEncoder::new(&mut file).unwrap().write_image::<C>(2, 2, pixels).unwrap();
    file.into_inner()
}

/// A TIFF with one number of its directory changed.
pub(crate) fn with_tag(mut tiff: Vec<u8>, tag: Tag, value: u32) -> Vec<u8> {
    let at = u32::from_le_bytes([tiff[4], tiff[5], tiff[6], tiff[7]]) as usize;
    let count = usize::from(u16::from_le_bytes([tiff[at], tiff[at + 1]]));
    let wanted = tag.to_u16().to_le_bytes();
    let mut entries = (0..count).map(|k| at + 2 + 12 * k);
    let entry = entries.find(|e| tiff[*e..*e + 2] == wanted).unwrap();
    tiff[entry + 8..entry + 12].copy_from_slice(&value.to_le_bytes());
    tiff
}
