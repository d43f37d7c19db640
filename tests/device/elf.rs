//! The little that these tests read from a 32-bit little-endian ELF file.

/// What a program takes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Size {
    /// Bytes that the file puts into memory before anything runs.
    pub(crate) flash: usize,
    /// Bytes of variables; the stack comes on top.
    pub(crate) variables: usize,
}

/// The sizes of its segments.
pub(crate) fn size(elf: &[u8]) -> Option<Size> {
    const LOAD: usize = 1;
    const RAM: usize = 0x2000_0000;
    let (start, size, count) = (word(elf, 0x1c)?, half(elf, 0x2a)?, half(elf, 0x2c)?);
    let mut total = Size { flash: 0, variables: 0 };
    for header in (0..count).map(|k| start + k * size) {
        if word(elf, header)? == LOAD {
            total.flash += word(elf, header + 0x10)?;
            if word(elf, header + 0x08)? >= RAM {
                total.variables += word(elf, header + 0x14)?;
            }
        }
    }
    Some(total)
}

/// The names in its symbol table.
pub(crate) fn symbols(elf: &[u8]) -> Option<Vec<String>> {
    Some(entries(elf)?.into_iter().map(|(name, _)| name).collect())
}

/// The value of the first symbol whose name has this in it.
pub(crate) fn address(elf: &[u8], part: &str) -> Option<usize> {
    entries(elf)?.into_iter().find(|(name, _)| name.contains(part)).map(|(_, value)| value)
}

/// Bytes of a section that takes flash; 0 if there is none of this name.
pub(crate) fn section(elf: &[u8], name: &str) -> Option<usize> {
    let (start, size, _) = sections(elf)?;
    let names = word(elf, start + half(elf, 0x32)? * size + 0x10)?;
    let mut total = 0;
    for header in section_headers(elf)? {
        if text(elf, names + word(elf, header)?)? == name {
            total += word(elf, header + 0x14)?;
        }
    }
    Some(total)
}

/// Names and values of its symbols.
fn entries(elf: &[u8]) -> Option<Vec<(String, usize)>> {
    const SYMBOLS: usize = 2;
    const ENTRY: usize = 16;
    let (start, size, _) = sections(elf)?;
    let mut found = Vec::new();
    for header in section_headers(elf)? {
        if word(elf, header + 4)? == SYMBOLS {
            let strings = word(elf, start + word(elf, header + 0x18)? * size + 0x10)?;
            let (table, bytes) = (word(elf, header + 0x10)?, word(elf, header + 0x14)?);
            for symbol in (table..table + bytes).step_by(ENTRY) {
                found.push((text(elf, strings + word(elf, symbol)?)?, word(elf, symbol + 4)?));
            }
        }
    }
    Some(found)
}

/// Where the section headers are, the size of one, and how many there are.
fn sections(elf: &[u8]) -> Option<(usize, usize, usize)> {
    Some((word(elf, 0x20)?, half(elf, 0x2e)?, half(elf, 0x30)?))
}

fn section_headers(elf: &[u8]) -> Option<impl Iterator<Item = usize>> {
    let (start, size, count) = sections(elf)?;
    Some((0..count).map(move |k| start + k * size))
}

fn text(elf: &[u8], at: usize) -> Option<String> {
    let name = elf.get(at..)?.split(|&b| b == 0).next()?;
    Some(String::from_utf8_lossy(name).into_owned())
}

fn word(elf: &[u8], at: usize) -> Option<usize> {
    let bytes = elf.get(at..)?.first_chunk::<4>()?;
    usize::try_from(u32::from_le_bytes(*bytes)).ok()
}

fn half(elf: &[u8], at: usize) -> Option<usize> {
    Some(usize::from(u16::from_le_bytes(*elf.get(at..)?.first_chunk::<2>()?)))
}
