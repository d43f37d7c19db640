//! Which line a curve has: by the name of its method, so that a method looks the same in every picture and on the page of a comparison.

use crate::method::KINDS;

/// Lines of methods in their plain form; their variants follow.
const PLAIN: usize = 16;

/// The numbers of the lines of curves with these names, all different.
///
/// A name that holds that of a method has the line of this method, as `normals (gauss) (0.98 %)` has; if two names claim one line, the
/// first has it. All others have the first lines that are free.
#[must_use]
pub fn slots(names: &[&str]) -> Vec<usize> {
    let mut taken: Vec<usize> = Vec::new();
    let mut found: Vec<Option<usize>> = Vec::new();
    for name in names {
        let slot = claim(name).filter(|slot| !taken.contains(slot));
        taken.extend(slot);
        found.push(slot);
    }
    let mut next = 0;
    let mut free = || {
        while taken.contains(&next) {
            next += 1;
        }
        next += 1;
        next - 1
    };
    found.into_iter().map(|slot| slot.unwrap_or_else(&mut free)).collect()
}

/// The name of a method that a text holds as a word, the first one and there the longest.
#[must_use]
pub fn method_in(text: &str) -> Option<&'static str> {
    let is_free = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric());
    let place = |name: &'static str| {
        let words = text.match_indices(name).filter(|(at, _)| {
            is_free(text[..*at].chars().next_back())
                && is_free(text[at + name.len()..].chars().next())
        });
        words.map(|(at, _)| at).next().map(|at| (at, name))
    };
    let found = KINDS.iter().filter_map(|kind| place(kind.name));
    found.min_by_key(|(at, name)| (*at, usize::MAX - name.len())).map(|(_, name)| name)
}

/// The line that a name asks for.
fn claim(name: &str) -> Option<usize> {
    let method = method_in(name)?;
    let plain = KINDS.iter().position(|kind| kind.name == method)?;
    let bounces = match name {
        _ if name.contains("all bounces") => 2,
        _ if name.contains("walk") => 3,
        _ => 0,
    };
    let variant = (usize::from(name.contains("cauchy")) + bounces) % 4;
    Some(plain + PLAIN * variant)
}

#[cfg(test)]
mod tests {
    use super::{KINDS, PLAIN, method_in, slots};

    #[test]
    fn a_method_has_its_line_whatever_stands_beside_it() {
        let alone = slots(&["beckmann"])[0];
        assert_eq!(slots(&["ggx (2.14 %)", "beckmann (0.98 %)"]), [0, alone]);
        assert_eq!(slots(&["beckmann", "ggx", "normals (gauss)"]), [alone, 0, 1]);
        assert_eq!(slots(&["Pareto front", "ggx", "fit (ggx)"]), [1, 0, 2]);
        let both = slots(&["normals (gauss)", "normals (cauchy)"]);
        assert_eq!(both, [1, slots(&["normals (cauchy)"])[0]]);
        assert_eq!(slots(&["a", "b", "c"]), [0, 1, 2]);
        assert!(KINDS.len() <= PLAIN);
    }

    #[test]
    fn methods_are_found_as_words() {
        for (text, method) in [
            ("smith-normals (3 %)", Some("smith-normals")),
            ("results/measured-ray.json", Some("measured-ray")),
            ("mix (ggx + beckmann)", Some("mix")),
            ("plate_5 (ggx)", Some("ggx")),
            ("mixture", None),
            ("normalsx", None),
        ] {
            assert_eq!(method_in(text), method, "{text}");
        }
    }
}
