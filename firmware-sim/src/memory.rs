//! The points of one segment, five bytes each: first the sums of the light, then the readings.

use asperity_core::protocol::{MAX_POINTS, RANGES, Reading};
use heapless::Vec;

const SIZE: usize = MAX_POINTS as usize;
/// The range is in the three bits below.
const OVER: u8 = 8;
const UNDER: u8 = 16;

/// Relative light where a point is not measured yet, a photocurrent where it is.
#[derive(Clone, Debug)]
pub(crate) struct Memory {
    values: Vec<f32, SIZE>,
    flags: Vec<u8, SIZE>,
}

impl Memory {
    pub(crate) const fn new() -> Self {
        Self { values: Vec::new(), flags: Vec::new() }
    }

    /// Begins anew, dark, with room for the points of a segment: `count`, at most [`MAX_POINTS`].
    pub(crate) fn begin(&mut self, count: u16) {
        let count = usize::from(count).min(SIZE);
        self.values.clear();
        self.flags.clear();
        // never an error: cut to the capacity
        let _ = self.values.resize(count, 0.0);
        let _ = self.flags.resize(count, 0);
    }

    pub(crate) fn sums(&mut self) -> &mut [f32] {
        &mut self.values
    }

    /// The light of a point that is not measured yet.
    pub(crate) fn light(&self, index: u16) -> f32 {
        self.values.get(usize::from(index)).copied().unwrap_or(0.0)
    }

    /// Keeps a reading in the place of its light.
    pub(crate) fn keep(&mut self, index: u16, reading: &Reading) {
        let index = usize::from(index);
        if let (Some(value), Some(flags)) = (self.values.get_mut(index), self.flags.get_mut(index))
        {
            *value = reading.signal;
            *flags = reading.range
                | if reading.over { OVER } else { 0 }
                | if reading.under { UNDER } else { 0 };
        }
    }

    /// A reading kept; `dark` are the currents it was read with.
    pub(crate) fn reading(&self, index: u16, dark: &[f32; RANGES as usize]) -> Reading {
        let flags = self.flags.get(usize::from(index)).copied().unwrap_or(0);
        let range = flags & 7;
        Reading {
            signal: self.light(index),
            dark: dark.get(usize::from(range)).copied().unwrap_or(0.0),
            range,
            over: flags & OVER != 0,
            under: flags & UNDER != 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Memory;
    use asperity_core::protocol::Reading;

    #[test]
    fn a_reading_comes_back_as_it_was() {
        let mut memory = Memory::new();
        memory.begin(1801);
        let dark = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        for (over, under) in [(false, false), (true, false), (false, true)] {
            for range in 0..6_u8 {
                let index = 1795 + u16::from(range);
                let reading = Reading { signal: 0.125, dark: f32::from(range), range, over, under };
                memory.keep(index, &reading);
                assert_eq!(memory.reading(index, &dark), reading);
            }
        }
        // beyond the segment there is nothing to keep a reading in
        memory.keep(1801, &memory.reading(1800, &dark));
        assert_eq!(memory.light(1801).to_bits(), 0);
        memory.begin(1801);
        assert_eq!(memory.light(1800).to_bits(), 0);
        memory.begin(u16::MAX);
        assert_eq!(memory.sums().len(), 1801);
        memory.begin(3);
        assert_eq!(memory.sums(), [0.0; 3]);
    }
}
