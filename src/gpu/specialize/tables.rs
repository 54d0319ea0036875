//! Records of a table as chains of selections by their index.

use super::expressions::literal;
use crate::accel::parts::PRIMITIVE_WORDS;
use crate::gpu::layout::{LIGHT_WORDS, MATERIAL_WORDS};
use crate::gpu::scene_buffers::Word;
use std::collections::BTreeMap;

/// An expression that has the value `values[index]`.
fn select(values: &[u32], literal: impl Fn(u32) -> String) -> String {
    let mut of_value: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (index, value) in values.iter().enumerate() {
        of_value.entry(*value).or_default().push(index);
    }
    let mut groups: Vec<_> = of_value.into_iter().collect();
    groups.sort_by_key(|(_, indices)| std::cmp::Reverse(indices.len()));
    let mut groups = groups.into_iter();
    let Some((most, _)) = groups.next() else {
        return literal(0);
    };
    groups.fold(literal(most), |otherwise, (value, indices)| {
        let is = indices.iter().map(|i| format!("(index == {i}u)"));
        let is: Vec<_> = is.collect();
        format!(
            "select({otherwise}, {}, {})",
            literal(value),
            is.join(" | ")
        )
    })
}

/// Records of `length` words.
struct Table<'a> {
    words: &'a [Word],
    length: usize,
}

impl Table<'_> {
    fn component(&self, word: usize, component: usize) -> Vec<u32> {
        let records = self.words.chunks_exact(self.length);
        records.map(|record| record[word][component]).collect()
    }

    fn number(&self, word: usize, component: usize) -> String {
        select(&self.component(word, component), |bits| {
            literal(f32::from_bits(bits))
        })
    }

    fn integer(&self, word: usize, component: usize) -> String {
        select(&self.component(word, component), |bits| format!("{bits}u"))
    }

    fn vector(&self, word: usize) -> String {
        let [x, y, z] = [0, 1, 2].map(|component| self.number(word, component));
        format!("vec3f({x}, {y}, {z})")
    }
}

/// The function specialized_`name`, which returns a `record`: of each word a vector and what stands
/// beside it, in `integers` a whole number.
fn function(name: &str, record: &str, table: &Table<'_>, integers: &[usize]) -> String {
    let members = (0..table.length).map(|word| {
        let beside = if integers.contains(&word) {
            table.integer(word, 3)
        } else {
            table.number(word, 3)
        };
        format!("        {},\n        {beside},\n", table.vector(word))
    });
    let members: String = members.collect();
    format!(
        "fn specialized_{name}(index: u32) -> {record} {{\n    return {record}(\n{members}    );\n}}\n\n"
    )
}

/// The primitives.
pub(super) fn primitives(words: &[Word]) -> String {
    let length = PRIMITIVE_WORDS;
    let table = Table { words, length };
    function("primitive", "PrimitiveRecord", &table, &[0, 1, 2])
}

/// The materials.
pub(super) fn materials(words: &[Word]) -> String {
    let length = MATERIAL_WORDS as usize;
    let table = Table { words, length };
    function("material", "MaterialRecord", &table, &[2, 4])
}

/// The lights.
pub(super) fn lights(words: &[Word]) -> String {
    let length = LIGHT_WORDS as usize;
    let table = Table { words, length };
    function("light", "LightRecord", &table, &[0, 3])
}
