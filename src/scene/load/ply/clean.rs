//! The text of a PLY file as the crate `ply-rs-bw` reads it.
//!
//! What the format or its writers allow and the crate does not: comments in another encoding than
//! UTF-8, names with other characters than letters and digits, properties of one name, blank lines,
//! and numbers such as `.5`, `1.` and `nan`.

use crate::scene::load::text;
use std::collections::HashSet;

/// A header for the crate, and where the file's own ends.
pub(super) struct Header {
    /// A line per line of the file.
    pub(super) text: String,
    /// Index of the first byte behind it.
    pub(super) end: usize,
}

/// The header of the file `bytes`: up to `end_header`, the first line that is not text of a header,
/// or the end.
pub(super) fn header(bytes: &[u8]) -> Header {
    let mut names = HashSet::new();
    let mut clean = String::new();
    let mut end = 0;
    // A line feed behind the carriage return may be the first byte of binary data, unless lines end
    // in both.
    let first = bytes.iter().position(|b| matches!(b, b'\n' | b'\r'));
    let both = first.is_some_and(|at| bytes[at..].starts_with(b"\r\n"));
    while end < bytes.len() {
        let rest = &bytes[end..];
        let length = rest.iter().position(|b| matches!(b, b'\n' | b'\r'));
        let line = &rest[..length.unwrap_or(rest.len())];
        let ending = match rest.get(line.len()) {
            None => 0,
            Some(b'\r') if both && rest.get(line.len() + 1) == Some(&b'\n') => 2,
            Some(_) => 1,
        };
        let is_first = end == 0;
        end += line.len() + ending;
        let line = text::decode(line);
        let words: Vec<&str> = line.split_whitespace().collect();
        clean += &header_line(&words, &mut names);
        clean.push('\n');
        let is_magic = words == ["ply"];
        if words == ["end_header"] || (is_first && !is_magic) {
            break;
        }
    }
    Header { text: clean, end }
}

/// A line of a header; `names` are those of the element so far.
fn header_line(words: &[&str], names: &mut HashSet<String>) -> String {
    match words {
        [] | ["comment" | "obj_info", ..] => "comment".to_owned(),
        ["element", name, count] => {
            names.clear();
            format!("element {} {count}", identifier(name))
        }
        ["property", types @ .., name] if !types.is_empty() => {
            let mut name = identifier(name);
            while !names.insert(name.clone()) {
                name.push('_');
            }
            format!("property {} {name}", types.join(" "))
        }
        _ => words.join(" "),
    }
}

/// `name` with letters, digits and `_` alone.
fn identifier(name: &str) -> String {
    let allowed = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let name: String = name
        .chars()
        .map(|c| if allowed(c) { c } else { '_' })
        .collect();
    match name.chars().next() {
        Some(first) if first.is_ascii_alphabetic() || first == '_' => name,
        _ => format!("_{name}"),
    }
}

/// The data of an ascii file: a line per element.
pub(super) fn data(bytes: &[u8]) -> String {
    let text = text::decode(bytes);
    let mut clean = String::with_capacity(text.len());
    for line in text::lines(&text) {
        let before = clean.len();
        for word in line.split_whitespace() {
            if clean.len() > before {
                clean.push(' ');
            }
            push_number(&mut clean, word);
        }
        if clean.len() > before {
            clean.push('\n');
        }
    }
    clean
}

/// Appends `word`, as digits, an optional fraction between digits and an optional exponent where it
/// is a number. What is no number is none in the crate either; what is infinite or not a number
/// becomes a number that is infinite as a float.
fn push_number(out: &mut String, word: &str) {
    let digits = word.strip_prefix(['-', '+']).unwrap_or(word);
    if digits.bytes().all(|b| b.is_ascii_digit()) && !digits.is_empty() {
        out.push_str(word);
        return;
    }
    match text::number(word) {
        None => out.push_str(word),
        Some(number) if !number.is_finite() => {
            let sign = if number < 0.0 { "-" } else { "" };
            out.push_str(sign);
            out.push_str("1e999");
        }
        Some(_) => {
            let (mantissa, exponent) = split_exponent(word);
            let sign = &mantissa[..mantissa.len() - mantissa.trim_start_matches(['-', '+']).len()];
            let (whole, fraction) = mantissa[sign.len()..]
                .split_once('.')
                .unwrap_or((&mantissa[sign.len()..], ""));
            out.push_str(sign);
            out.push_str(if whole.is_empty() { "0" } else { whole });
            if !fraction.is_empty() {
                out.push('.');
                out.push_str(fraction);
            }
            if !exponent.is_empty() {
                out.push('e');
                out.push_str(exponent);
            }
        }
    }
}

fn split_exponent(word: &str) -> (&str, &str) {
    word.split_once(['e', 'E', 'd', 'D']).unwrap_or((word, ""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_end_where_their_lines_do() {
        for (bytes, text, rest) in [
            (
                &b"ply\nend_header\n\n\r"[..],
                "ply\nend_header\n",
                &b"\n\r"[..],
            ),
            (b"ply\r\nend_header\r\n\n", "ply\nend_header\n", b"\n"),
            (b"ply\rend_header\r\n", "ply\nend_header\n", b"\n"),
            (b"plyx\nformat\n", "plyx\n", b"format\n"),
            (b"ply", "ply\n", b""),
        ] {
            let header = header(bytes);
            assert_eq!(header.text, text);
            assert_eq!(&bytes[header.end..], rest);
        }
    }

    #[test]
    fn what_the_crate_cannot_read_is_rewritten() {
        let file = b"ply\ncomment f\xfcr\n\nelement  face 2 \nproperty\tfloat a(b)\nproperty float a b\nproperty list uchar int 1\nend_header\n";
        assert_eq!(
            header(file).text,
            "ply\ncomment\ncomment\nelement face 2\nproperty float a_b_\nproperty float a b\nproperty list uchar int _1\nend_header\n"
        );
        let twice =
            b"ply\nelement a 1\nproperty int x\nproperty int x\nelement b 1\nproperty int x\n";
        assert_eq!(
            header(twice).text,
            "ply\nelement a 1\nproperty int x\nproperty int x_\nelement b 1\nproperty int x\n"
        );
    }

    #[test]
    fn data_has_a_line_per_element() {
        let text = "\n 1\t.5  -.25 \r\n\r\n+3. 1.e2 1.5d-1\nnan -inf 7 zero";
        assert_eq!(
            data(text.as_bytes()),
            "1 0.5 -0.25\n+3 1e2 1.5e-1\n1e999 -1e999 7 zero\n"
        );
    }
}
