//! Damage to the JSON of a glTF, which stays JSON; and the GLB around it.

use super::random::Random;
use serde_json::{Value, json};

/// Damages one value of `root`, which is chosen at random.
pub fn damage(random: &mut Random, root: &mut Value, words: &[&str]) {
    let count = count(root);
    let (at, from) = (random.below(count), random.below(count));
    let other = nth(root, &mut { from }).map_or(Value::Null, |v| v.clone());
    if let Some(value) = nth(root, &mut { at }) {
        match random.below(8) {
            0 => *value = other,
            1..3 => change_container(random, value, other),
            _ => *value = scalar(random, words),
        }
    }
}

/// An entry of an array or object goes, comes twice, or another comes in.
fn change_container(random: &mut Random, value: &mut Value, other: Value) {
    match value {
        Value::Array(array) if !array.is_empty() => {
            let at = random.below(array.len());
            match random.below(3) {
                0 => drop(array.remove(at)),
                1 => array.insert(at, array[at].clone()),
                _ => array.push(other),
            }
        }
        Value::Object(object) if !object.is_empty() => {
            let keys: Vec<String> = object.keys().cloned().collect();
            let (one, two) = (random.one_of(&keys), random.one_of(&keys));
            if let Some(entry) = object.remove(one)
                && random.below(2) == 0
            {
                object.insert(two.clone(), entry);
            }
        }
        scalar => *scalar = other,
    }
}

fn scalar(random: &mut Random, words: &[&str]) -> Value {
    match random.below(12) {
        0 => Value::Null,
        1 => json!({}),
        2 => json!([]),
        3 => json!(true),
        4 => json!(random.one_of(words)),
        5 => json!([0, 0, 0]),
        6 => json!([1e38, 1e38, 1e38, 1e38]),
        7 => json!(random.below(8)),
        8 => json!(f64::from_bits(random.word())),
        9 => json!(u64::MAX >> random.below(64)),
        10 => json!(-1 - random.below(3) as i64),
        _ => json!(*random.one_of(&[
            0.0,
            -0.0,
            0.5,
            1e-38,
            5126.0,
            3e38,
            1e39,
            1e308,
            f64::MIN_POSITIVE
        ])),
    }
}

fn count(value: &Value) -> usize {
    1 + match value {
        Value::Array(array) => array.iter().map(count).sum(),
        Value::Object(object) => object.values().map(count).sum(),
        _ => 0,
    }
}

/// The value that comes `left` places after `value`, from the outside in.
fn nth<'a>(value: &'a mut Value, left: &mut usize) -> Option<&'a mut Value> {
    if *left == 0 {
        return Some(value);
    }
    *left -= 1;
    match value {
        Value::Array(array) => array.iter_mut().find_map(|v| nth(v, left)),
        Value::Object(object) => object.values_mut().find_map(|v| nth(v, left)),
        _ => None,
    }
}

/// A GLB of a JSON chunk and a binary chunk (glTF 2.0, section 4.4).
pub fn glb(json: &Value, bin: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + text.len() as u32 + 8 + bin.len() as u32;
    [
        b"glTF",
        &2u32.to_le_bytes()[..],
        &length.to_le_bytes(),
        &(text.len() as u32).to_le_bytes(),
        b"JSON",
        &text,
        &(bin.len() as u32).to_le_bytes(),
        b"BIN\0",
        bin,
    ]
    .concat()
}

/// The JSON of a glTF or GLB, and the bytes after it; `None` where it is damaged.
pub fn parts(bytes: &[u8]) -> Option<(Value, &[u8])> {
    if !bytes.starts_with(b"glTF") {
        return Some((serde_json::from_slice(bytes).ok()?, &[]));
    }
    let length = u32::from_le_bytes(bytes.get(12..16)?.try_into().ok()?) as usize;
    let text = bytes.get(20..20usize.checked_add(length)?)?;
    let rest = bytes.get(20 + length + 8..).unwrap_or(&[]);
    Some((serde_json::from_slice(text).ok()?, rest))
}
