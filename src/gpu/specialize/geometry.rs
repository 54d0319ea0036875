//! What a ray meets of the primitives that are written out.
//!
//! A planar primitive is met where its plane is, and there within its edges: in coordinates along
//! these, whose scale and origin are literals. Where an edge lies on another primitive, both overlap
//! by what rounding may put a ray off by, so that none passes between them. For shadow rays nothing
//! does: small lights would see the difference, while rays between neighbours are too few to.

use super::bounds::bounding;
use super::boxes::{self, Solid};
use super::condition::{Condition, Target, edges};
use crate::accel::PrimitiveGeometry;
use crate::prepare::Prepared;
use glam::DVec3;
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// The functions that ask what a ray meets.
pub(super) fn functions(prepared: &Prepared) -> String {
    let shapes = Shapes::new(prepared, prepared.overlap());
    let exact = Shapes::new(prepared, 0.0);
    let bounding = bounding(prepared, prepared.overlap());
    let all = |_: &Target| true;
    let between = |target: &Target| !bounding.contains(&target.index);
    let emitting = |target: &Target| target.emits;
    [
        boxes::away_from_zero(),
        shapes.closest_hit(),
        shapes.meets_any("any_hit(ray: Ray, t_max: f32)", "t_max", all),
        exact.meets_any("hides_light(ray: Ray)", "1.0", between),
        shapes.meets_any("may_meet_light(ray: Ray)", "T_MAX", emitting),
    ]
    .concat()
}

/// The primitives of a scene that are written out.
struct Shapes {
    targets: Vec<Target>,
    /// Boxes that some of them are the sides of.
    boxes: Vec<Solid>,
}

impl Shapes {
    /// Those of `prepared`, of which neighbours overlap by `overlap`.
    fn new(prepared: &Prepared, overlap: f64) -> Self {
        let data = &prepared.data;
        let emitting: BTreeSet<_> = prepared.emitters.primitives().collect();
        let targets = prepared.written_out().map(|index| {
            let primitive = &data.primitives[index];
            let emits = emitting.contains(&(index as u32));
            Target {
                index,
                geometry: primitive.geometry,
                one_sided: !data.scene.materials[primitive.material.index()].double_sided,
                emits,
                // What emits is as bright as it is large.
                overlap: if emits {
                    [0.0; 4]
                } else {
                    overlaps(prepared, index, overlap)
                },
            }
        });
        let targets: Vec<_> = targets.collect();
        let may_be_sides = targets.iter().filter(|t| !t.one_sided && !t.emits);
        let boxes = boxes::find(&may_be_sides.copied().collect::<Vec<_>>());
        Self { targets, boxes }
    }

    /// What is no side of a box.
    fn single(&self) -> impl Iterator<Item = &Target> {
        let is_side = |target: &&Target| self.boxes.iter().any(|b| b.has(target.index));
        self.targets.iter().filter(move |target| !is_side(target))
    }

    fn closest_hit(&self) -> String {
        let mut text = "fn specialized_closest_hit(ray: Ray) -> Hit {\n    let o = ray.origin;\n    let d = ray.direction;\n    \
                        var t = T_MAX;\n    var primitive = NONE;\n"
            .to_owned();
        for (number, solid) in self.boxes.iter().enumerate() {
            text.push_str(&solid.closest(number));
        }
        for target in self.single() {
            if let Some(Condition { before, holds }) = target.meets("t") {
                let i = target.index;
                let _ = write!(
                    text,
                    "{before}    let h{i} = {holds};\n    t = select(t, t{i}, h{i});\n    \
                     primitive = select(primitive, {i}u, h{i});\n"
                );
            }
        }
        text.push_str("    return Hit(t, primitive, vec2f(0.0));\n}\n\n");
        text
    }

    /// A function that says whether any of the primitives `of` is met before `t_max`; of a box where
    /// any of its sides is one of them.
    fn meets_any(&self, head: &str, t_max: &str, of: impl Fn(&Target) -> bool) -> String {
        let is_of = |solid: &Solid| self.targets.iter().any(|t| solid.has(t.index) && of(t));
        let boxes = self.boxes.iter().enumerate();
        let boxes = boxes.filter(|(_, solid)| is_of(solid));
        let boxes = boxes.map(|(number, solid)| solid.meets(number, t_max));
        let single = self.single().filter(|target| of(target));
        let single = single.filter_map(|target| target.meets(t_max));
        let mut text = format!(
            "fn specialized_{head} -> bool {{\n    let o = ray.origin;\n    let d = ray.direction;\n    var meets = false;\n"
        );
        for Condition { before, holds } in boxes.chain(single) {
            let _ = writeln!(text, "{before}    meets = meets | ({holds});");
        }
        text.push_str("    return meets;\n}\n\n");
        text
    }
}

/// `overlap` at each edge of primitive `index` that lies on another one, or may lie on one that is
/// loaded.
fn overlaps(prepared: &Prepared, index: usize, overlap: f64) -> [f64; 4] {
    let primitives = &prepared.data.primitives;
    let others = prepared.written_out().filter(|other| *other != index);
    let others = others.map(|other| &primitives[other].geometry);
    let loaded = prepared.loaded().map(|small| small.bounds);
    let mut overlaps = [0.0; 4];
    let at_edges = overlaps.iter_mut().zip(edges(&primitives[index].geometry));
    for (at_edge, ends) in at_edges {
        if loaded.is_some_and(|bounds| touches(ends, bounds, overlap))
            || others.clone().any(|other| lies_on(ends, other, overlap))
        {
            *at_edge = overlap;
        }
    }
    overlaps
}

/// Whether the box around an edge touches a box, within `slack`.
fn touches([a, b]: [DVec3; 2], [low, high]: [DVec3; 2], slack: f64) -> bool {
    let around = DVec3::splat(slack);
    a.min(b).cmple(high + around).all() && a.max(b).cmpge(low - around).all()
}

/// Whether an edge lies in the plane of a primitive and touches the box around it, within `slack`.
fn lies_on([a, b]: [DVec3; 2], other: &PrimitiveGeometry, slack: f64) -> bool {
    let (PrimitiveGeometry::Triangle { a: on, u, v }
    | PrimitiveGeometry::Rectangle { a: on, u, v }
    | PrimitiveGeometry::Disk { a: on, u, v }) = *other
    else {
        return false;
    };
    let n = u.cross(v).normalize_or_zero();
    [a, b].iter().all(|end| n.dot(*end - on).abs() <= slack)
        && touches([a, b], other.bounds().into(), slack)
}
