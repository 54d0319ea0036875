//! Text in whatever encoding a mesh file has.

use std::borrow::Cow;

const UTF8_MARK: &[u8] = b"\xef\xbb\xbf";

/// The text of a file: UTF-8, or UTF-16 after a byte order mark. Lines that are neither, such as
/// comments of old exporters, are taken as Latin-1. The mark itself is left out.
pub(super) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    match bytes {
        [0xff, 0xfe, rest @ ..] => Cow::Owned(utf16(rest, u16::from_le_bytes)),
        [0xfe, 0xff, rest @ ..] => Cow::Owned(utf16(rest, u16::from_be_bytes)),
        _ => {
            let bytes = bytes.strip_prefix(UTF8_MARK).unwrap_or(bytes);
            match std::str::from_utf8(bytes) {
                Ok(text) => Cow::Borrowed(text),
                Err(_) => Cow::Owned(decode_lines(bytes)),
            }
        }
    }
}

fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> String {
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    char::decode_utf16(units)
        .map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER))
        .collect()
}

fn decode_lines(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len());
    for line in bytes.split_inclusive(|b| *b == b'\n') {
        match std::str::from_utf8(line) {
            Ok(line) => text.push_str(line),
            Err(_) => text.extend(line.iter().map(|b| char::from(*b))),
        }
    }
    text
}

/// The lines of `text`, whether they end in LF, CR LF or CR.
pub(super) fn lines(text: &str) -> impl Iterator<Item = &str> {
    text.split('\n')
        .flat_map(|line| line.strip_suffix('\r').unwrap_or(line).split('\r'))
}

/// The number that `word` spells: also with Fortran's exponent, `1d0`, and as C runtimes print what
/// is none, `-1.#IND`.
pub(super) fn number(word: &str) -> Option<f64> {
    if let Ok(number) = word.parse() {
        return Some(number);
    }
    let tail = word.split_once(".#").map(|(_, tail)| tail);
    match tail {
        Some(tail) if tail.starts_with("INF") => Some(f64::INFINITY),
        Some(_) => Some(f64::NAN),
        None => word.replace(['d', 'D'], "e").parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings_are_told_apart() {
        let text = "v 1 é\nw";
        assert_eq!(decode(text.as_bytes()), text);
        assert_eq!(decode(&[UTF8_MARK, text.as_bytes()].concat()), text);
        for big in [false, true] {
            let bytes = |unit: u16| {
                if big {
                    unit.to_be_bytes()
                } else {
                    unit.to_le_bytes()
                }
            };
            let units = std::iter::once(0xfeff).chain(text.encode_utf16());
            let encoded: Vec<u8> = units.flat_map(bytes).collect();
            assert_eq!(decode(&encoded), text);
        }
        assert_eq!(decode(b"v 1 \xe9\nw \xc3\xa9"), "v 1 é\nw é");
    }

    #[test]
    fn lines_end_in_three_ways() {
        for end in ["\n", "\r\n", "\r"] {
            let text = ["a", "", "b"].join(end);
            assert_eq!(lines(&text).collect::<Vec<_>>(), ["a", "", "b"], "{end:?}");
        }
    }

    #[test]
    fn numbers_are_spelt_in_many_ways() {
        for (word, value) in [
            ("+1", 1.0),
            ("1.e5", 1e5),
            (".5", 0.5),
            ("-2.", -2.0),
            ("1d0", 1.0),
            ("2.5D-1", 0.25),
        ] {
            assert_eq!(number(word), Some(value), "{word}");
        }
        assert!(number("-1.#IND").is_some_and(f64::is_nan));
        assert!(number("nan").is_some_and(f64::is_nan));
        for word in ["", "zero", "1,5", "0x1", "1 2"] {
            assert_eq!(number(word), None, "{word}");
        }
    }
}
