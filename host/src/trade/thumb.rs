//! Bytes of code that a function of a Thumb program needs: its own, and of all that it calls.
//!
//! Calls are found by reading the instructions `BL` and `B.W` between the symbols of the ELF; what is called through a pointer,
//! and constants outside functions, are not counted.

use std::collections::{BTreeMap, BTreeSet};

use object::read::elf::ElfFile32;
use object::{LittleEndian, Object as _, ObjectSegment as _, ObjectSymbol as _, SymbolKind};

/// The functions of a program: address to bytes, and the program's bytes by address.
#[derive(Clone, Debug)]
pub(super) struct Functions {
    /// Where each begins, and how long it is.
    sizes: BTreeMap<u32, u32>,
    /// Address and content of what is loaded.
    loaded: Vec<(u32, Vec<u8>)>,
    /// Address from which on there is data or code: `$d` and `$t`.
    is_data: BTreeMap<u32, bool>,
}

impl Functions {
    /// Reads a 32-bit little-endian ELF; `None` if it is none, or has no symbols.
    pub(super) fn of(elf: &[u8]) -> Option<Self> {
        let file = ElfFile32::<LittleEndian>::parse(elf).ok()?;
        let loaded = file.segments().map(|segment| {
            Some((u32::try_from(segment.address()).ok()?, segment.data().ok()?.to_vec()))
        });
        let (mut sizes, mut is_data) = (BTreeMap::new(), BTreeMap::new());
        for symbol in file.symbols() {
            let value = u32::try_from(symbol.address()).ok()?;
            match symbol.name_bytes().ok()? {
                name if name.starts_with(b"$d") => drop(is_data.insert(value, true)),
                name if name.starts_with(b"$t") => drop(is_data.insert(value, false)),
                _ if symbol.kind() == SymbolKind::Text => {
                    sizes.insert(value & !1, u32::try_from(symbol.size()).ok()?);
                }
                _ => {}
            }
        }
        let loaded = loaded.collect::<Option<_>>()?;
        (!sizes.is_empty()).then_some(Self { sizes, loaded, is_data })
    }

    /// Bytes of these functions and of all that they call, each counted once; `None` for an address that is no function's.
    pub(super) fn bytes(&self, entries: &[u32]) -> Option<usize> {
        let mut seen = BTreeSet::new();
        let mut open: Vec<u32> = entries.iter().map(|a| a & !1).collect();
        if open.iter().any(|a| !self.sizes.contains_key(a)) {
            return None;
        }
        while let Some(address) = open.pop() {
            if seen.insert(address) {
                open.extend(self.calls(address));
            }
        }
        Some(seen.iter().filter_map(|a| self.sizes.get(a)).map(|n| *n as usize).sum())
    }

    /// The functions that one calls.
    fn calls(&self, start: u32) -> Vec<u32> {
        let end = start + self.sizes.get(&start).copied().unwrap_or(0);
        let mut found = Vec::new();
        let mut at = start;
        while at < end {
            let data = self.is_data.range(..=at).next_back().is_some_and(|(_, data)| *data);
            let Some(first) = self.half(at) else { break };
            if data || first >> 11 < 0b11101 {
                at += 2;
                continue;
            }
            let Some(second) = self.half(at + 2) else { break };
            if first >> 11 == 0b11110 && matches!(second & 0xd000, 0xd000 | 0x9000) {
                let target = at.wrapping_add(4).wrapping_add(offset(first, second));
                if self.sizes.contains_key(&target) {
                    found.push(target);
                }
            }
            at += 4;
        }
        found
    }

    fn half(&self, address: u32) -> Option<u32> {
        let (base, bytes) = self
            .loaded
            .iter()
            .find(|(base, b)| address >= *base && address - base < b.len() as u32)?;
        half(bytes, (address - base) as usize).map(|h| h as u32)
    }
}

/// The offset of `BL` and `B.W`, encodings T1 and T4.
fn offset(first: u32, second: u32) -> u32 {
    let (s, j1, j2) = (first >> 10 & 1, second >> 13 & 1, second >> 11 & 1);
    let (i1, i2) = (1 ^ j1 ^ s, 1 ^ j2 ^ s);
    let raw = s << 24 | i1 << 23 | i2 << 22 | (first & 0x3ff) << 12 | (second & 0x7ff) << 1;
    // 25 bits with their sign
    ((raw << 7) as i32 >> 7) as u32
}

fn half(bytes: &[u8], at: usize) -> Option<usize> {
    Some(usize::from(u16::from_le_bytes(*bytes.get(at..)?.first_chunk::<2>()?)))
}

#[cfg(test)]
mod tests {
    use super::{Functions, offset};

    #[test]
    fn offsets_are_those_of_the_manual() {
        // bl +0, bl -4, b.w +0x1000
        assert_eq!(offset(0xf000, 0xf800), 0);
        assert_eq!(offset(0xf7ff, 0xfffe), -4_i32 as u32);
        assert_eq!(offset(0xf001, 0xb800), 0x1000);
    }

    #[test]
    fn a_function_counts_with_all_it_calls_once() {
        let code = [
            0xf000_u16, 0xf802, // 0: bl 8
            0xf000, 0xf800, // 4: bl 8
            0xf000, 0xb801, // 8: b.w 14
            0x4770, 0x4770, // 12: nobody's, bx lr
        ];
        let bytes = code.iter().flat_map(|h| h.to_le_bytes()).collect();
        let program = Functions {
            sizes: [(0, 8), (8, 4), (14, 2)].into(),
            loaded: vec![(0, bytes)],
            is_data: [(0, false)].into(),
        };
        assert_eq!(program.bytes(&[1]), Some(14));
        assert_eq!(program.bytes(&[9, 15]), Some(6));
        assert_eq!(program.bytes(&[12]), None);
        assert!(Functions::of(b"#!/bin/sh\n").is_none());
    }
}
