//! The arrays that grow with a scene's triangles: its nodes, primitives and attributes. Where one
//! is too long for a binding, all are split into parts.

/// Most parts of an array.
pub const PARTS: usize = 6;
/// Words of a node.
pub const NODE_WORDS: usize = 2;
/// Words of a primitive.
pub const PRIMITIVE_WORDS: usize = 3;
/// Bytes of a word.
pub const WORD_BYTES: usize = 16;
/// Words that every binding takes: 128 MiB, what WebGPU promises and the most that lavapipe has.
const BINDING_WORDS: usize = 1 << 23;

/// How long the parts are into which nodes, primitives and attributes are split.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Split {
    /// Nodes in a part.
    pub nodes: usize,
    /// Primitives in a part.
    pub primitives: usize,
    /// Words of attributes in a part.
    pub words: usize,
}

impl Split {
    /// The split that `nodes`, `primitives` and `words` of attributes need; `None` where each of
    /// the arrays fits a binding.
    pub fn of(nodes: usize, primitives: usize, words: usize) -> Option<Self> {
        let holds = |split: Self, parts: usize| {
            nodes <= parts * split.nodes
                && primitives <= parts * split.primitives
                && words <= parts * split.words
        };
        let mut words = BINDING_WORDS;
        if holds(Self::of_words(words), 1) {
            return None;
        }
        while !holds(Self::of_words(words), PARTS) {
            words *= 2;
        }
        Some(Self::of_words(words))
    }

    /// Parts of `words` words, as far as these hold whole records.
    pub fn of_words(words: usize) -> Self {
        Self {
            nodes: words / NODE_WORDS,
            primitives: words / PRIMITIVE_WORDS,
            words,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_binding_holds_is_not_split() {
        let most = (1 << 27) / (PRIMITIVE_WORDS * WORD_BYTES);
        assert_eq!(Split::of(most, most, 1 << 23), None);
        let split = Some(Split::of_words(1 << 23));
        assert_eq!(Split::of(0, most + 1, 0), split);
        assert_eq!(Split::of((1 << 22) + 1, 0, 0), split);
        assert_eq!(Split::of(0, 0, (1 << 23) + 1), split);
    }

    #[test]
    fn parts_grow_with_what_they_have_to_hold() {
        let words = |count| Split::of(0, 0, count).expect("a split").words;
        assert_eq!(words(PARTS << 23), 1 << 23);
        assert_eq!(words((PARTS << 23) + 1), 1 << 24);
        let split = Split::of(0, 100_000_000, 0).expect("a split");
        assert!(PARTS * split.primitives >= 100_000_000);
    }
}
