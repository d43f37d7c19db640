//! A line of a text file, read word by word: which unit belongs to which name, which number is a pixel size.

use super::said::Said;
use super::unit::LengthUnit;
use super::vocabulary::{
    FILL, LINKS, Name, ONE_NUMBER, OTHER_UNITS, PER_PIXEL, SIZED, SIZES, name,
};
use super::words::{Token, tokens};

impl Said {
    /// Takes a line in, and says whether anything was understood.
    pub(super) fn take(&mut self, line: &str) -> bool {
        let tokens = tokens(line);
        if let Some(units) = only_units(&tokens) {
            match *units.as_slice() {
                [unit] => self.set(Name::All, unit),
                [x, y, z] => {
                    for (name, unit) in [(Name::X, x), (Name::Y, y), (Name::Z, z)] {
                        self.set(name, unit);
                    }
                }
                _ => return false,
            }
            return true;
        }
        Line::new(self).read(&tokens)
    }
}

/// The units of a line of nothing else.
fn only_units(tokens: &[Token]) -> Option<Vec<LengthUnit>> {
    let tokens = tokens.iter().filter(|t| **t != Token::Comma);
    let units: Option<Vec<_>> =
        tokens.map(|t| if let Token::Unit { unit, .. } = t { Some(*unit) } else { None }).collect();
    units.filter(|units| !units.is_empty())
}

/// A line on its way.
#[expect(clippy::struct_excessive_bools, reason = "each says what stood before in the line")]
pub(super) struct Line<'a> {
    said: &'a mut Said,
    /// What was named since the last unit.
    names: Vec<Name>,
    /// Whether a word or sign says that a unit comes for all of them.
    linked: bool,
    /// Whether the next name is that of one number, such as the largest height.
    veto: bool,
    /// Numbers since the last name or unit.
    numbers: Vec<f64>,
    /// Whether it was of pixels before.
    about_pixels: bool,
    /// Whether a number is a distance of points even without a unit.
    sized: bool,
    /// Whether a second distance may follow.
    second: bool,
    understood: bool,
}

impl<'a> Line<'a> {
    pub(super) fn new(said: &'a mut Said) -> Self {
        Self {
            said,
            names: Vec::new(),
            linked: false,
            veto: false,
            numbers: Vec::new(),
            about_pixels: false,
            sized: false,
            second: false,
            understood: false,
        }
    }

    pub(super) fn read(mut self, tokens: &[Token]) -> bool {
        let mut rest = tokens;
        while let Some((token, behind)) = rest.split_first() {
            rest = behind;
            match token {
                Token::Number(value) => self.numbers.push(*value),
                Token::Assign => self.linked = true,
                Token::Comma => {}
                Token::Word { text, bracketed } => self.word(text, *bracketed),
                Token::Unit { unit, bracketed } => {
                    let more = run(rest);
                    if self.numbers.is_empty() && !more.is_empty() {
                        rest = rest
                            .iter()
                            .position(not_listed)
                            .and_then(|k| rest.get(k..))
                            .unwrap_or_default();
                        self.list(&[&[*unit], more.as_slice()].concat());
                    } else if self.numbers.is_empty() {
                        let values = values_behind(rest);
                        self.unit(*unit, *bracketed, &values);
                    } else {
                        self.quantity(*unit, rest);
                    }
                }
            }
        }
        if self.sized && self.names.iter().any(|n| n.is_pixel()) {
            self.pitches(None);
        }
        self.understood
    }

    fn word(&mut self, text: &str, bracketed: bool) {
        self.second = false;
        if let Some(name) = name(text) {
            self.name(name, text);
        } else if LINKS.contains(&text) {
            self.linked = true;
        } else if SIZES.contains(&text) {
            self.sized = self.about_pixels;
            self.sharpen(text, "width", Name::PixelX);
        } else if ONE_NUMBER.contains(&text) {
            self.forget();
            self.veto = true;
        } else if !FILL.contains(&text) {
            let is_unit = (bracketed || self.linked) && OTHER_UNITS.contains(&text);
            if is_unit && self.numbers.is_empty() && !self.veto {
                for name in std::mem::take(&mut self.names) {
                    for place in self.said.of(name) {
                        place.wrong = Some(format!("the unit `{text}`"));
                        self.understood = true;
                    }
                }
            }
            self.forget();
        }
    }

    fn name(&mut self, name: Name, text: &str) {
        // `z unit`: the word goes with the name before it
        if name == Name::All && !self.names.is_empty() {
            self.linked = true;
            return;
        }
        if self.sharpen(text, "height", Name::PixelY) {
            return;
        }
        self.numbers.clear();
        self.linked = false;
        if name.is_pixel() {
            self.about_pixels = true;
            self.sized |= SIZED.contains(&text);
        }
        self.names.push(name);
    }

    /// Makes of a pixel its width or height, and says whether it did.
    fn sharpen(&mut self, text: &str, wanted: &str, to: Name) -> bool {
        match self.names.last_mut() {
            Some(last) if *last == Name::Pixel && text == wanted => {
                *last = to;
                self.sized = true;
                true
            }
            _ => false,
        }
    }

    fn forget(&mut self) {
        self.names.clear();
        self.numbers.clear();
        self.linked = false;
        self.sized = false;
    }

    /// A unit without a number before it; `values` are the numbers behind it.
    fn unit(&mut self, unit: LengthUnit, bracketed: bool, values: &[f64]) {
        if self.names.iter().any(|n| n.is_pixel()) {
            // `pixel size [um]: 0.5`
            self.numbers = values.to_vec();
            self.pitches(Some(unit));
        } else if values.is_empty() && !self.veto {
            let all = self.linked && !bracketed;
            let from = if all { 0 } else { self.names.len().saturating_sub(1) };
            let names = self.names.split_off(from);
            self.set(&names, |_| unit);
        }
        self.veto = false;
        self.forget();
    }

    /// As many units as names, in their order.
    fn list(&mut self, units: &[LengthUnit]) {
        let mut names = std::mem::take(&mut self.names);
        let unnamed = !names.is_empty() && names.iter().all(|n| *n == Name::All);
        names.retain(|n| *n != Name::All);
        if unnamed && units.len() == 3 {
            names = vec![Name::X, Name::Y, Name::Z];
        }
        if names.len() == units.len() && !self.veto {
            self.set(&names, |k| units.get(k).copied().unwrap_or(LengthUnit::Metre));
        }
        self.veto = false;
        self.forget();
    }

    /// Sets the units of names; `all` beside others means these others.
    fn set(&mut self, names: &[Name], unit: impl Fn(usize) -> LengthUnit) {
        let others = names.iter().any(|n| *n != Name::All);
        for (k, name) in names.iter().enumerate() {
            if *name != Name::All || !others {
                self.said.set(*name, unit(k));
                self.understood = true;
            }
        }
    }

    /// A unit behind numbers: counts for the distance of points only.
    fn quantity(&mut self, unit: LengthUnit, rest: &[Token]) {
        let named = self.names.iter().any(|n| n.is_pixel());
        let axis = !self.names.is_empty()
            && self.about_pixels
            && self.names.iter().all(|n| matches!(n, Name::X | Name::Y));
        let second = self.second && self.names.is_empty();
        let counts = (named || axis || second || is_per_pixel(rest)) && !self.veto;
        if counts {
            if second {
                self.names.push(Name::PixelY);
            }
            self.about_pixels = true;
            self.pitches(Some(unit));
        }
        self.veto = false;
        self.forget();
        self.second = counts && !second;
    }

    /// The numbers as distances of points.
    fn pitches(&mut self, unit: Option<LengthUnit>) {
        let has = |wanted: &[Name]| self.names.iter().any(|n| wanted.contains(n));
        if has(&[Name::Z]) {
            return;
        }
        let (x, y) = (has(&[Name::X, Name::PixelX]), has(&[Name::Y, Name::PixelY]));
        match *self.numbers.as_slice() {
            [value] => self.said.set_pitch(usize::from(y && !x), value, unit),
            [first, second] if x == y => {
                self.said.set_pitch(0, first, unit);
                self.said.set_pitch(1, second, unit);
            }
            _ => return,
        }
        self.understood = true;
    }
}

/// Whether what follows a quantity says that it is that of a pixel.
fn is_per_pixel(rest: &[Token]) -> bool {
    let word = |k: usize| match rest.get(k) {
        Some(Token::Word { text, .. }) => text.as_str(),
        _ => "",
    };
    PER_PIXEL.contains(&word(0)) || (word(0) == "per" && PER_PIXEL.contains(&word(1)))
}

/// Whether a token ends a list of units.
fn not_listed(token: &Token) -> bool {
    !matches!(token, Token::Unit { .. } | Token::Comma)
}

/// The units that follow at once, commas apart.
fn run(rest: &[Token]) -> Vec<LengthUnit> {
    let listed = rest.iter().take_while(|t| !not_listed(t));
    listed
        .filter_map(|t| if let Token::Unit { unit, .. } = t { Some(*unit) } else { None })
        .collect()
}

/// The numbers that follow at once, behind a sign or none, commas apart; not those of a list, as `2:` is.
fn values_behind(rest: &[Token]) -> Vec<f64> {
    let rest = if let [Token::Assign, rest @ ..] = rest { rest } else { rest };
    let is_numbering = matches!(rest, [Token::Number(_), Token::Assign, ..]);
    if is_numbering || !matches!(rest.first(), Some(Token::Number(_))) {
        return Vec::new();
    }
    let listed = rest.iter().take_while(|t| matches!(t, Token::Number(_) | Token::Comma));
    listed.filter_map(|t| if let Token::Number(value) = t { Some(*value) } else { None }).collect()
}
