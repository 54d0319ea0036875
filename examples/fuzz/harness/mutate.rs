//! Damage to files: to bytes, to words of text, to lines, and to numbers.

use super::random::Random;
use std::ops::Range;

/// Longest input: what is longer finds nothing that is not found in what is short, and takes its
/// time.
pub const MAX_BYTES: usize = 4096;

/// Numbers at the edges of types, formats and domains, and what is no number at all.
pub const NUMBERS: [&str; 44] = [
    "0",
    "-0.0",
    "1",
    "-1",
    "2",
    "3",
    "0.5",
    "127",
    "128",
    "255",
    "256",
    "1024",
    "32768",
    "32769",
    "65535",
    "65536",
    "16777217",
    "2147483647",
    "2147483648",
    "-2147483648",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551615",
    "99999999999999999999999",
    "1e-5",
    "1e-12",
    "1e-38",
    "1e-45",
    "1e-160",
    "1e-308",
    "5e-324",
    "1e7",
    "1e19",
    "3.5e38",
    "1e155",
    "1e308",
    "-1e308",
    "1e400",
    "nan",
    "inf",
    "-inf",
    "0x10",
];

/// Damages `bytes` in one way; `pool` are whole inputs to take pieces from, `words` what the format
/// knows.
pub fn damage(random: &mut Random, bytes: &mut Vec<u8>, pool: &[Vec<u8>], words: &[&str]) {
    match random.below(10) {
        0..3 => replace_number(random, bytes),
        3..5 => in_words(random, bytes, words),
        5 => in_lines(random, bytes),
        6 => splice(random, bytes, pool),
        7 => in_runs(random, bytes),
        _ => in_bytes(random, bytes),
    }
    bytes.truncate(MAX_BYTES);
}

/// A number of the text is written otherwise.
pub fn replace_number(random: &mut Random, bytes: &mut Vec<u8>) {
    let is_number = |b: u8| b.is_ascii_digit() || matches!(b, b'.' | b'-' | b'+');
    let mut numbers = runs(bytes, is_number);
    numbers.retain(|r| {
        let follows_a_letter = r.start > 0 && bytes[r.start - 1].is_ascii_alphabetic();
        !follows_a_letter && bytes[r.clone()].iter().any(u8::is_ascii_digit)
    });
    if numbers.is_empty() {
        return in_bytes(random, bytes);
    }
    let number = random.one_of(&numbers).clone();
    let written = if random.below(4) == 0 {
        let bits = f64::from_bits(random.word());
        format!("{bits:e}")
    } else {
        (*random.one_of(&NUMBERS)).to_owned()
    };
    bytes.splice(number, written.into_bytes());
}

/// A word goes, comes twice, changes places with another or becomes one that the format knows.
fn in_words(random: &mut Random, bytes: &mut Vec<u8>, words: &[&str]) {
    let is_word = |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'.' | b'-' | b'+' | b'_');
    let found = runs(bytes, is_word);
    if found.is_empty() {
        return in_bytes(random, bytes);
    }
    let one = random.one_of(&found).clone();
    let other = random.one_of(&found).clone();
    match random.below(5) {
        0 => drop(bytes.splice(one, [])),
        1 => {
            let twice = [&bytes[one.clone()], b" ", &bytes[one.clone()]].concat();
            bytes.splice(one, twice);
        }
        2 => {
            let text = bytes[other].to_vec();
            bytes.splice(one, text);
        }
        3 if one.end <= other.start => {
            let (first, second) = (bytes[one.clone()].to_vec(), bytes[other.clone()].to_vec());
            bytes.splice(other, first);
            bytes.splice(one, second);
        }
        _ if !words.is_empty() => {
            let word = random.one_of(words).as_bytes().to_vec();
            bytes.splice(one, word);
        }
        _ => in_bytes(random, bytes),
    }
}

/// A line goes, comes again elsewhere or changes places with another.
fn in_lines(random: &mut Random, bytes: &mut Vec<u8>) {
    let mut lines: Vec<Vec<u8>> = bytes
        .split_inclusive(|b| *b == b'\n')
        .map(<[u8]>::to_vec)
        .collect();
    if lines.is_empty() {
        return;
    }
    let (one, other) = (random.below(lines.len()), random.below(lines.len()));
    match random.below(3) {
        0 => drop(lines.remove(one)),
        1 => lines.insert(other, lines[one].clone()),
        _ => lines.swap(one, other),
    }
    *bytes = lines.concat();
}

/// The beginning of this input and the end of another, or a piece of another in this one.
fn splice(random: &mut Random, bytes: &mut Vec<u8>, pool: &[Vec<u8>]) {
    let other = random.one_of(pool);
    let (from, at) = (random.below(other.len() + 1), random.below(bytes.len() + 1));
    if random.below(2) == 0 {
        bytes.truncate(at);
        bytes.extend_from_slice(&other[from..]);
    } else {
        let to = from + random.below((other.len() - from).min(64) + 1);
        bytes.splice(at..at, other[from..to].iter().copied());
    }
}

/// A run of bytes goes, comes twice or many times over; or the end is cut off.
fn in_runs(random: &mut Random, bytes: &mut Vec<u8>) {
    let start = random.below(bytes.len() + 1);
    let end = start + random.below((bytes.len() - start).min(64) + 1);
    match random.below(4) {
        0 => bytes.truncate(start),
        1 => drop(bytes.splice(start..end, [])),
        2 => {
            let run = bytes[start..end].to_vec();
            bytes.splice(end..end, run);
        }
        _ => {
            let times = 1 + random.below(512);
            let run = bytes[start..end.min(start + 4)].repeat(times);
            bytes.splice(end..end, run);
        }
    }
}

/// A bit flips, or a byte or a word of two, four or eight bytes is overwritten.
fn in_bytes(random: &mut Random, bytes: &mut Vec<u8>) {
    if bytes.is_empty() {
        bytes.push(random.word() as u8);
        return;
    }
    let at = random.below(bytes.len());
    match random.below(4) {
        0 => bytes[at] ^= 1 << random.below(8),
        1 => bytes[at] = random.word() as u8,
        2 => bytes[at] = *random.one_of(&[0, 1, 0x7f, 0x80, 0xff, b' ', b'"', b'[', b'{', b'\n']),
        _ => overwrite_word(random, &mut bytes[at..]),
    }
}

fn overwrite_word(random: &mut Random, bytes: &mut [u8]) {
    let width = *random.one_of(&[2, 4, 8]);
    let edge = *random.one_of(&[
        0,
        1,
        0x7f,
        0xff,
        0x7fff,
        0xffff,
        0x0001_0000,
        0x7f80_0000,
        0x7fc0_0000,
        0x7fff_ffff,
        0x8000_0000,
        0xffff_ffff,
        0x7ff0_0000_0000_0000,
        u64::MAX,
    ]);
    let value = edge.wrapping_add(random.word() % 3).wrapping_sub(1);
    let (little, big) = (value.to_le_bytes(), value.to_be_bytes());
    let word = if random.below(2) == 0 {
        &little[..width]
    } else {
        &big[8 - width..]
    };
    for (byte, new) in bytes.iter_mut().zip(word) {
        *byte = *new;
    }
}

/// The longest runs of bytes that `belongs`.
fn runs(bytes: &[u8], belongs: impl Fn(u8) -> bool) -> Vec<Range<usize>> {
    let mut runs = Vec::new();
    let mut start = None;
    for (at, byte) in bytes.iter().enumerate() {
        match (belongs(*byte), start) {
            (true, None) => start = Some(at),
            (false, Some(first)) => {
                runs.push(first..at);
                start = None;
            }
            _ => {}
        }
    }
    runs.extend(start.map(|first| first..bytes.len()));
    runs
}
