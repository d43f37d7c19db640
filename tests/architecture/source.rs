//! Rust source as a list of words and signs, without comments, strings and test items.

/// A word or a sign, and the line it stands in, from 1.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Token {
    pub(crate) text: String,
    pub(crate) line: usize,
}

/// Splits a source file; `::` is one token, every other sign is one character.
pub(crate) fn tokens(source: &str) -> Vec<Token> {
    let chars: Vec<char> = source.chars().collect();
    let at = |k: usize| chars.get(k).copied().unwrap_or('\0');
    let word = |c: char| c.is_alphanumeric() || c == '_';
    let (mut found, mut line, mut k) = (Vec::new(), 1, 0);
    while k < chars.len() {
        let start = k;
        match at(k) {
            '/' if at(k + 1) == '/' => {
                while k < chars.len() && at(k) != '\n' {
                    k += 1;
                }
            }
            '/' if at(k + 1) == '*' => k = block_comment_end(&chars, k),
            '"' => k = string_end(&chars, k + 1),
            '\'' if at(k + 1) == '\\' => {
                k += 3;
                while k < chars.len() && at(k) != '\'' {
                    k += 1;
                }
                k += 1;
            }
            '\'' if at(k + 2) == '\'' => k += 3,
            c if word(c) => {
                while word(at(k)) {
                    k += 1;
                }
                let text: String = chars[start..k].iter().collect();
                let raw = matches!(&*text, "r" | "br" | "cr") && matches!(at(k), '"' | '#');
                if let Some(end) = raw.then(|| raw_string_end(&chars, k)).flatten() {
                    k = end;
                } else {
                    found.push(Token { text, line });
                }
            }
            ':' if at(k + 1) == ':' => {
                found.push(Token { text: "::".into(), line });
                k += 2;
            }
            c => {
                if !c.is_whitespace() {
                    found.push(Token { text: c.into(), line });
                }
                k += 1;
            }
        }
        line += chars[start..k.min(chars.len())].iter().filter(|&&c| c == '\n').count();
    }
    found
}

fn block_comment_end(chars: &[char], start: usize) -> usize {
    let (mut k, mut depth) = (start, 0);
    while k < chars.len() {
        match (chars[k], chars.get(k + 1)) {
            ('/', Some('*')) => (depth, k) = (depth + 1, k + 2),
            ('*', Some('/')) => (depth, k) = (depth - 1, k + 2),
            _ => k += 1,
        }
        if depth == 0 {
            break;
        }
    }
    k
}

fn string_end(chars: &[char], mut k: usize) -> usize {
    while k < chars.len() && chars[k] != '"' {
        k += if chars[k] == '\\' { 2 } else { 1 };
    }
    k + 1
}

/// The end of `#"..."#` that starts at `k`, for any number of `#`; `None` if it is no string.
fn raw_string_end(chars: &[char], k: usize) -> Option<usize> {
    let hashes = chars[k..].iter().take_while(|&&c| c == '#').count();
    let closing: Vec<char> = std::iter::once('"').chain(std::iter::repeat_n('#', hashes)).collect();
    let body = k + hashes + 1;
    if chars.get(k + hashes) != Some(&'"') {
        return None;
    }
    let inside = chars.get(body..)?.windows(hashes + 1).position(|w| w == closing)?;
    Some(body + inside + hashes + 1)
}

/// The tokens without items under `#[cfg(test)]`, and the number of lines those items take.
pub(crate) fn without_tests(tokens: &[Token]) -> (Vec<Token>, usize) {
    let (mut kept, mut lines, mut k) = (Vec::new(), 0, 0);
    while k < tokens.len() {
        match test_attribute(&tokens[k..]) {
            Some((true, _)) => return (Vec::new(), tokens[tokens.len() - 1].line),
            Some((false, length)) => {
                let end = item_end(tokens, k + length);
                lines += tokens[end - 1].line - tokens[k].line + 1;
                k = end;
            }
            None => {
                kept.push(tokens[k].clone());
                k += 1;
            }
        }
    }
    (kept, lines)
}

/// `#[cfg(test)]` or `#[cfg(all(test, ...))]`: whether it is for the whole file (`#!`), and its length.
fn test_attribute(tokens: &[Token]) -> Option<(bool, usize)> {
    let text = |k: usize| tokens.get(k).map_or("", |t| &t.text);
    let whole = text(1) == "!";
    let open = 1 + usize::from(whole);
    if text(0) != "#" || text(open) != "[" || text(open + 1) != "cfg" {
        return None;
    }
    let length = tokens.iter().position(|t| t.text == "]")? + 1;
    let condition = &tokens[open..length];
    let has = |word: &str| condition.iter().any(|t| t.text == word);
    (has("test") && !has("not") && !has("any")).then_some((whole, length))
}

/// One past the item that starts at `k`: past its `;`, or past the bracket that closes its body.
fn item_end(tokens: &[Token], start: usize) -> usize {
    let mut depth = 0;
    for (k, token) in tokens.iter().enumerate().skip(start) {
        match &*token.text {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" => depth -= 1,
            "}" => {
                depth -= 1;
                if depth == 0 {
                    return k + 1;
                }
            }
            ";" if depth == 0 => return k + 1,
            _ => {}
        }
    }
    tokens.len()
}

#[test]
fn comments_strings_and_test_items_are_not_code() {
    let source = r##"
        // crate::a
        /* crate::b /* nested */ crate::c */
        const S: &str = "crate::d \" crate::e"; const R: &str = r#"crate::f " "#;
        fn f<'a>(x: &'a u8) -> char { '"' } const C: char = '\''; // quotes that open nothing
        #[cfg(test)]
        #[allow(dead_code)]
        mod tests { use crate::g; fn h() { { } } }
        #[cfg(not(test))] use crate::kept;
        #[cfg(all(test, unix))] use crate::i;
    "##;
    let (code, lines) = without_tests(&tokens(source));
    let text: Vec<&str> = code.iter().map(|t| &*t.text).collect();
    assert_eq!(text.iter().filter(|t| **t == "crate").count(), 1, "{text:?}");
    assert_eq!(lines, 4);
    let kept = code.iter().find(|t| t.text == "kept").unwrap();
    assert_eq!(kept.line, 9);
}
