//! What these tests ask of a 32-bit little-endian ELF file.

use object::read::elf::ElfFile32;
use object::{
    LittleEndian, Object as _, ObjectSection as _, ObjectSegment as _, ObjectSymbol as _,
};

/// Where the RAM of the device begins.
const RAM: u64 = 0x2000_0000;

/// What a program takes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Size {
    /// Bytes that the file puts into memory before anything runs.
    pub(crate) flash: usize,
    /// Bytes of variables; the stack comes on top.
    pub(crate) variables: usize,
}

fn parsed(elf: &[u8]) -> Option<ElfFile32<'_, LittleEndian>> {
    ElfFile32::parse(elf).ok()
}

/// The sizes of its segments.
pub(crate) fn size(elf: &[u8]) -> Option<Size> {
    let mut total = Size { flash: 0, variables: 0 };
    for segment in parsed(elf)?.segments() {
        let (_, in_file) = segment.file_range();
        total.flash += usize::try_from(in_file).ok()?;
        if segment.address() >= RAM {
            total.variables += usize::try_from(segment.size()).ok()?;
        }
    }
    Some(total)
}

/// The names in its symbol table.
pub(crate) fn symbols(elf: &[u8]) -> Option<Vec<String>> {
    let file = parsed(elf)?;
    let names = file.symbols().map(|symbol| symbol.name_bytes().map(String::from_utf8_lossy));
    names.map(|name| Some(name.ok()?.into_owned())).collect()
}

/// The value of the first symbol whose name has this in it.
pub(crate) fn address(elf: &[u8], part: &str) -> Option<usize> {
    let file = parsed(elf)?;
    let found = file.symbols().find(|s| s.name().is_ok_and(|name| name.contains(part)))?;
    usize::try_from(found.address()).ok()
}

/// Bytes of a section that takes flash; 0 if there is none of this name.
pub(crate) fn section(elf: &[u8], name: &str) -> Option<usize> {
    let section = parsed(elf)?.section_by_name(name).map_or(0, |section| section.size());
    usize::try_from(section).ok()
}
