//! A small valid file of every format and variant, for tests over all readers.

use tiff::encoder::{Compression, DeflateLevel};

use super::{
    al3d, di, frt, gsf, ibw, keyence_csv, metropro, mnt, nid, nms, npy, opd, opdx, plu, plux,
    png16, sdf, sur, tests_gwy, tiff_float, tmd, vk, x3p, zygo_text,
};

/// A file that is read without options.
pub(super) struct Sample {
    /// Name of the variant.
    pub(super) name: &'static str,
    /// Name of the format in [`super::FORMATS`].
    pub(super) format: &'static str,
    pub(super) bytes: Vec<u8>,
}

const DHM: &str = "h=3 w=2\npixel size=3.7e-007 m\ndata unit=rad\n\
                   height conversion factor (-> m)=2.9e-008\n-4.4 1 \n2.5 -1e-3 \n0 7\n";
const GWYDDION: &str = "# Channel: a\n# Width: 2 \u{b5}m\n# Height: 1 \u{b5}m\n# Value units: m\n\
                        1e-9\t2e-9\n3e-9\tnan\n";
const POINTS: &str = "# Lateral units: mm\nx;y;z [um]\n0;0;1\n1;0;2\n0;0,5;3\n1;0,5;-4\n2;0,5;0\n";

/// All of them.
pub(super) fn samples() -> Vec<Sample> {
    let scalar =
        npy::tests::npy(1, "{'descr': '<f8', 'fortran_order': False, 'shape': ()}", &[0; 8]);
    let npz = |deflate| {
        npy::tests::npz(&[("a.npy", scalar.clone()), ("b.npy", npy::tests::sample())], deflate)
    };
    let png = png16::tests::sample(&[(b"pCAL", png16::tests::PCAL), (b"sCAL", png16::tests::SCAL)]);
    let tiff = tiff_float::tests::sample;
    [
        ("x3p linked", "x3p", x3p::tests::linked()),
        ("x3p inline", "x3p", x3p::tests::listed()),
        ("sdf text", "SDF", sdf::tests::text("1 2 BAD 4 5 100").into()),
        ("sdf binary", "SDF", sdf::tests::binary(5, [3, 2], &sdf::tests::points(5))),
        ("al3d", "Alicona al3d", al3d::tests::sample()),
        ("opd", "Wyko opd", opd::tests::file(&opd::tests::parts())),
        ("di", "Bruker/DI", di::tests::file(|h| h, &di::tests::points())),
        ("sur 16", "Digital Surf sur", sur::tests::sample(false, 16)),
        ("sur 32", "Digital Surf sur", sur::tests::sample(false, 32)),
        ("sur zipped", "Digital Surf sur", sur::tests::sample(true, 32)),
        ("metropro", "Zygo MetroPro", metropro::tests::sample(0x6f)),
        ("metropro 3", "Zygo MetroPro", metropro::tests::sample(0x71)),
        ("nms", "NanoFocus nms", nms::tests::sample()),
        ("tmd", "TrueMap tmd", tmd::tests::sample("by hand")),
        ("nid", "Nanosurf nid", nid::tests::sample(|t| t)),
        ("frt", "FRT MicroProf", frt::tests::sample()),
        ("opdx", "Vision opdx", opdx::tests::sample()),
        ("mnt", "MountainsMap mnt", mnt::tests::Parts::new().file()),
        ("ibw", "Igor ibw", ibw::tests::Parts::new().file()),
        ("plu", "Sensofar plu", plu::tests::sample()),
        ("plux", "Sensofar plux", plux::tests::sample(|i| i)),
        ("vk4", "Keyence vk", vk::tests::plain(*b"VK4_", 16)),
        ("vk6", "Keyence vk", vk::tests::packed()),
        ("gsf", "Gwyddion gsf", gsf::tests::sample(|h| h)),
        ("zygo ascii", "Zygo text", zygo_text::tests::sample(false, |t| t)),
        ("zygo xyz", "Zygo text", zygo_text::tests::sample(true, |t| t)),
        ("keyence csv", "Keyence CSV", keyence_csv::tests::sample(|t| t)),
        ("gwy", "Gwyddion gwy", tests_gwy::sample()),
        ("gwyddion text", "Gwyddion text", GWYDDION.into()),
        ("dhm", "matrix text", DHM.into()),
        ("matrix", "matrix text", "# heights in um\n1,5;2;3\n4;5;6,5\n".into()),
        ("xyz", "xyz", POINTS.into()),
        ("npy", "npy/npz", npy::tests::sample()),
        ("npz", "npy/npz", npz(false)),
        ("npz zipped", "npy/npz", npz(true)),
        ("png", "PNG", png),
        ("tiff", "TIFF", tiff(Compression::Uncompressed)),
        ("tiff lzw", "TIFF", tiff(Compression::Lzw)),
        ("tiff zipped", "TIFF", tiff(Compression::Deflate(DeflateLevel::default()))),
    ]
    .map(|(name, format, bytes)| Sample { name, format, bytes })
    .into()
}
