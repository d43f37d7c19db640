//! x3p files made here: every data type, axis and way to store points, and what is refused.

use std::io::{Cursor, Write};

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg32;
use zip::write::SimpleFileOptions;

use super::{archive::check_md5, detect};
use crate::io::{MapFault, RawMap};

fn read(bytes: &[u8]) -> Result<RawMap, MapFault> {
    super::read(bytes, false)
}

/// `main.xml` around the axes and `Record3`.
fn xml(axes: [&str; 3], record3: &str) -> String {
    let [x, y, z] = axes;
    let axes = format!("<CX>{x}</CX><CY>{y}</CY><CZ>{z}</CZ>");
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?><p:ISO5436_2 xmlns:p=\"x\"><Record1>\
         <FeatureType>SUR</FeatureType><Axes>{axes}</Axes></Record1><Record2><Instrument>\
         <Manufacturer>A &amp; B</Manufacturer><Model>C</Model></Instrument></Record2>\
         <Record3>{record3}</Record3></p:ISO5436_2>"
    )
}

const EVEN: &str = "<AxisType>I</AxisType><DataType>D</DataType><Increment>5e-7</Increment>";
const OWN: &str = "<AxisType>A</AxisType><DataType>D</DataType>";
const MATRIX: &str =
    "<MatrixDimension><SizeX>3</SizeX><SizeY>2</SizeY><SizeZ>1</SizeZ></MatrixDimension>";
const LINK: &str = "<DataLink><PointDataLink>bindata/data.bin</PointDataLink></DataLink>";
const MASK: &str = "<DataLink><PointDataLink>bindata\\data.bin</PointDataLink>\
     <ValidPointsLink>bindata/valid.bin</ValidPointsLink></DataLink>";

fn pack(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

fn inline(axes: [&str; 3], size: &str, points: &[&str]) -> Vec<u8> {
    let points = points.join("</Datum><Datum>");
    let record3 = format!("{size}<DataList><Datum>{points}</Datum></DataList>");
    pack(&[("main.xml", xml(axes, &record3).as_bytes())])
}

fn check(map: &RawMap, heights_um: [f64; 6], pixel_um: [f64; 2]) {
    assert_eq!((map.nx, map.ny), (3, 2));
    assert!((map.dx_um.unwrap() - pixel_um[0]).abs() < 1e-9, "{:?}", map.dx_um);
    assert!((map.dy_um.unwrap() - pixel_um[1]).abs() < 1e-9, "{:?}", map.dy_um);
    assert_eq!(map.instrument.as_deref(), Some("A & B C"));
    for (read, put) in map.heights_um.iter().zip(heights_um) {
        assert!((read - put).abs() < 1e-6 || (read.is_nan() && put.is_nan()), "{read} {put}");
    }
}

/// A file of points beside `main.xml`, with a mask.
pub(in crate::io) fn linked() -> Vec<u8> {
    let main = xml([EVEN, EVEN, OWN], &format!("{MATRIX}{MASK}"));
    let points = HEIGHTS.map(|z| (z * 1e-6).to_le_bytes()).concat();
    pack(&[
        ("main.xml", main.as_bytes()),
        ("bindata/data.bin", &points),
        ("bindata/valid.bin", &[0b1111_1011]),
    ])
}

/// A file of points with all coordinates in `main.xml`.
pub(in crate::io) fn listed() -> Vec<u8> {
    let points = ["0;0;1e-6", "1e-6;0;2e-6", "0;1e-6;nan", "1e-6;1e-6;4e-6"];
    inline([OWN, OWN, OWN], "<ListDimension>4</ListDimension>", &points)
}

const HEIGHTS: [f64; 6] = [1.0, 2.0, f64::NAN, 4.0, -5.0, 6.0];

#[test]
fn every_data_type_and_the_mask_are_read() {
    for (name, bytes) in [
        ('I', [1i16, 2, 3, 4, -5, 6].map(|z| z.to_le_bytes().to_vec()).concat()),
        ('L', [1i32, 2, 3, 4, -5, 6].map(|z| z.to_le_bytes().to_vec()).concat()),
        ('F', HEIGHTS.map(|z| (z as f32).to_le_bytes().to_vec()).concat()),
        ('D', HEIGHTS.map(|z| z.to_le_bytes().to_vec()).concat()),
    ] {
        let z = format!(
            "<AxisType>A</AxisType><DataType>{name}</DataType><Increment>1e-6</Increment>\
             <Offset/>"
        );
        let main = xml([EVEN, EVEN, &z], &format!("{MATRIX}{MASK}"));
        let file = pack(&[
            ("__MACOSX/main.xml", b"junk"),
            ("a/b/Main.XML", &[b"\xef\xbb\xbf", main.as_bytes()].concat()),
            ("a/b/bindata/data.bin", &bytes),
            ("a/b/bindata/valid.bin", &[0b1111_1011]),
        ]);
        assert!(detect(&file));
        check(&read(&file).unwrap(), HEIGHTS, [0.5, 0.5]);
    }
}

#[test]
fn inline_points_may_have_coordinates() {
    let heights = ["1e-6", "2e-6", "", "4e-6", "-5e-6", "6e-6"];
    check(&read(&inline([EVEN, EVEN, OWN], MATRIX, &heights)).unwrap(), HEIGHTS, [0.5, 0.5]);
    // the integers of an absolute axis, as in the ISO's third sample
    let rows: Vec<String> = (0..6)
        .map(|k| match heights[k] {
            "" => String::new(),
            z => format!("{};{z}", 1 + k / 3),
        })
        .collect();
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    let scaled = "<AxisType>A</AxisType><DataType>I</DataType><Increment>2e-6</Increment>\
                  <Offset>1</Offset>";
    check(&read(&inline([EVEN, scaled, OWN], MATRIX, &rows)).unwrap(), HEIGHTS, [0.5, 2.0]);
    // a list of x, y, z, with points out of place or on one line
    let list = |size: &str, x: [f64; 6], y: [f64; 6]| {
        let points: Vec<String> =
            (0..6).map(|k| format!("{}e-6;{}e-6;{}", x[k], y[k], k + 1)).collect();
        let points: Vec<&str> = points.iter().map(String::as_str).collect();
        read(&inline([OWN, OWN, OWN], size, &points))
    };
    let (x, y) = ([1.0, 2.0, 3.0, 1.0, 2.0, 3.0], [7.0, 7.0, 7.0, 9.0, 9.0, 9.0]);
    let size = "<ListDimension>6</ListDimension>";
    let list_map = list(size, x, y).unwrap();
    check(&list_map, [1e6, 2e6, 3e6, 4e6, 5e6, 6e6], [1.0, 2.0]);
    assert_eq!(list(MATRIX, x, y).unwrap(), list_map);
    for x in [
        [1.0, 2.0, 3.1, 1.0, 2.0, 3.1],
        [1.0, 1.5, 3.0, 1.0, 2.0, 3.0],
        [1.0, 2.0, 3.0, 4.0, 1.0, 2.0],
        [1.0, 1.0, 2.0, 2.0, 3.0, 3.0],
        [f64::NAN, 2.0, 3.0, 1.0, f64::INFINITY, 3.0],
        [3.0, 2.0, 1.0, 3.0, 2.0, 1.0],
    ] {
        assert!(list(size, x, y).is_err(), "{x:?}");
    }
    let uneven = list(size, [1.0, 2.0, 3.2, 1.0, 2.0, 3.2], y).unwrap_err();
    assert!(uneven.to_string().contains("resample"), "{uneven}");
}

#[test]
fn a_profile_is_a_map_of_one_row() {
    let file = inline([EVEN, EVEN, OWN], "<ListDimension>3</ListDimension>", &["1", "2", "3"]);
    let map = read(&file).unwrap();
    assert_eq!((map.nx, map.ny, map.heights_um.len()), (3, 1, 3));
}

#[test]
fn binary_points_may_have_coordinates() {
    let points: Vec<u8> = (0..6)
        .flat_map(|k| [f64::from(k % 3) * 1e-6, f64::from(k / 3) * 2e-6, f64::from(k)])
        .flat_map(f64::to_le_bytes)
        .collect();
    let main = xml([OWN, OWN, OWN], &format!("<ListDimension>6</ListDimension>{LINK}"));
    let file = pack(&[("main.xml", main.as_bytes()), ("bindata/data.bin", &points)]);
    check(&read(&file).unwrap(), [0.0, 1e6, 2e6, 3e6, 4e6, 5e6], [1.0, 2.0]);
}

#[test]
fn checksums_are_compared() {
    let main = xml([EVEN, EVEN, OWN], &format!("{MATRIX}{LINK}"));
    let data = [0; 48];
    let with = |sum: &str, main: &str| {
        read(&pack(&[
            ("main.xml", main.as_bytes()),
            ("bindata/data.bin", &data),
            ("md5checksum.hex", sum.as_bytes()),
        ]))
    };
    assert!(with("", &main).is_ok());
    let fault = with("0123 *main.xml", &main).unwrap_err().to_string();
    let sum = fault.split(' ').find(|word| word.len() == 33).unwrap().trim_end_matches(',');
    assert!(fault.contains("0123 as the file says"), "{fault}");
    for text in [sum.to_owned(), format!("{} *main.xml\r\n", sum.to_uppercase())] {
        assert!(with(&text, &main).is_ok());
    }
    let link = "<MD5ChecksumPointData>00</MD5ChecksumPointData></DataLink>";
    let fault = with("", &main.replace("</DataLink>", link)).unwrap_err().to_string();
    assert!(fault.contains("bindata/data.bin"), "{fault}");
    // RFC 1321, A.5
    assert!(check_md5("abc", b"abc", "900150983CD24FB0D6963F7D28E17F72").is_ok());
}

#[test]
fn malformed_files_are_refused() {
    let heights = ["1e-6", "2e-6", "", "4e-6", "-5e-6", "6e-6"];
    let good = xml([EVEN, EVEN, OWN], &format!("{MATRIX}{LINK}"));
    let data = [0; 48];
    let file = pack(&[("main.xml", good.as_bytes()), ("bindata/data.bin", &data)]);
    assert!(read(&file).is_ok());
    for end in [0, 3, 4, 30, 100, file.len() / 2, file.len() - 23, file.len() - 1] {
        assert!(read(&file[..end]).is_err(), "{end}");
    }
    let points = "<Record3><DataList><Datum>1</Datum></DataList></Record3>";
    for (old, new) in [
        ("<SizeX>3", "<SizeX>0"),
        ("<SizeX>3", "<SizeX>-3"),
        ("<SizeX>3", "<SizeX>4"),
        ("<SizeX>3", "<SizeX>2"),
        ("<SizeX>3", "<SizeX>40000000000"),
        ("<SizeX>3", "<SizeX>18446744073709551615"),
        ("<SizeX>3", "<SizeX>100000000"),
        ("<SizeZ>1", "<SizeZ>2"),
        (MATRIX, ""),
        (MATRIX, "<ListDimension>268435457</ListDimension>"),
        (LINK, ""),
        (LINK, points),
        ("bindata/data.bin", "bindata/other.bin"),
        ("5e-7", "0"),
        ("5e-7", "-5e-7"),
        ("5e-7", "nan"),
        ("5e-7", "x"),
        (EVEN, OWN),
        ("<AxisType>I", "<AxisType>Q"),
        ("<AxisType>I</AxisType>", ""),
        ("<DataType>D", "<DataType>Q"),
        ("<DataType>D</DataType>", ""),
        (OWN, "<AxisType>A</AxisType><DataType>D</DataType><Increment>0</Increment>"),
        (OWN, "<AxisType>A</AxisType><DataType>F</DataType>"),
        ("</Record1>", ""),
        ("<", "&"),
    ] {
        assert!(good.contains(old), "{old}");
        let main = good.replace(old, new);
        let file = pack(&[("main.xml", main.as_bytes()), ("bindata/data.bin", &data)]);
        assert!(read(&file).is_err(), "{old} {new}");
    }
    let main = xml([EVEN, EVEN, OWN], &format!("{MATRIX}{MASK}"));
    for mask in [&b""[..], b"\xff\xff"] {
        let files = [("main.xml", main.as_bytes()), ("bindata/data.bin", &data[..])];
        let file = pack(&[files[0], files[1], ("bindata/valid.bin", mask)]);
        assert!(read(&file).is_err());
    }
    assert!(read(&inline([EVEN, EVEN, OWN], MATRIX, &heights[1..])).is_err());
    assert!(read(&inline([OWN, OWN, OWN], MATRIX, &heights)).is_err());
    assert!(read(&inline([EVEN, EVEN, OWN], MATRIX, &["1;2"; 6])).is_err());
    assert!(read(&pack(&[("other.xml", good.as_bytes())])).is_err());
    assert!(read(&pack(&[])).is_err() && !detect(&pack(&[("a.npy", b"")])));
}

#[test]
fn a_zip_bomb_is_refused_early() {
    let main = xml([EVEN, EVEN, OWN], &format!("{MATRIX}{LINK}"));
    let zeros = vec![0; 96 << 20];
    let too_large = |file: &[u8]| {
        let fault = read(file).unwrap_err();
        assert!(matches!(fault, MapFault::Inflates { .. }), "{fault}");
    };
    // more than the dimensions need
    too_large(&pack(&[("main.xml", main.as_bytes()), ("bindata/data.bin", &zeros)]));
    // as much as the dimensions say, out of nothing
    let huge = main.replace(">3<", ">4194304<");
    too_large(&pack(&[("main.xml", huge.as_bytes()), ("bindata/data.bin", &zeros)]));
    // the header itself, with an honest and a lying size
    let mut file = pack(&[("main.xml", &zeros)]);
    too_large(&file);
    let size = (96u32 << 20).to_le_bytes();
    while let Some(at) = file.windows(4).position(|w| w == size) {
        file[at..at + 4].copy_from_slice(&5000u32.to_le_bytes());
    }
    assert!(read(&file).is_err());
}

#[test]
fn random_damage_never_panics() {
    let mut random = Pcg32::seed_from_u64(7);
    let points = ["1e-6;1", "2e-6;1", "", "1e-6;1", "2e-6;2", "3e-6;3"].join("</Datum><Datum>");
    let inline = format!("{MATRIX}<DataList><Datum>{points}</Datum></DataList>");
    for main in [xml([EVEN, OWN, OWN], &inline), xml([OWN, EVEN, OWN], &format!("{MATRIX}{MASK}"))]
    {
        for _ in 0..300 {
            // the checksums of the archive would catch damage behind them
            let mut damaged = main.clone().into_bytes();
            for _ in 0..=random.next_u32() % 4 {
                let at = random.next_u32() as usize % damaged.len();
                damaged[at] = b"0123456789<>/;.-e\x00\xffA"[random.next_u32() as usize % 20];
            }
            let data = [0, 0, 0, 0, 0, 0, 0xf0, 0x3f].repeat(12);
            let _ = read(&pack(&[
                ("main.xml", &damaged),
                ("bindata/data.bin", &data),
                ("bindata/valid.bin", &[0x3e]),
            ]));
        }
    }
}
