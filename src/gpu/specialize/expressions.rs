//! Numbers and sums as WGSL writes them.

use glam::DVec3;

/// Components of a vector below this part of its length count as 0: less than rounding.
const TRACE: f64 = 1e-9;

/// A number of type f32.
pub(super) fn literal(x: f32) -> String {
    format!("{x:?}f")
}

/// A vector of f32.
pub(super) fn vector(v: DVec3) -> String {
    let [x, y, z] = v.to_array().map(|c| literal(c as f32));
    format!("vec3f({x}, {y}, {z})")
}

/// `v` with 0 in place of components that are 0 but for rounding.
pub(super) fn without_traces(v: DVec3) -> DVec3 {
    let least = TRACE * v.length();
    DVec3::from_array(v.to_array().map(|c| if c.abs() < least { 0.0 } else { c }))
}

/// The direction of `v`, turned so that its first component that is not 0 is positive, and whether
/// it was turned: what is parallel is written alike, and computed once.
pub(super) fn turned(v: DVec3) -> (DVec3, bool) {
    let v = without_traces(v.normalize());
    let first = v.to_array().into_iter().find(|c| *c != 0.0);
    let is_turned = first.is_some_and(|c| c < 0.0);
    (if is_turned { -v } else { v }, is_turned)
}

/// n · `variable` + `plus`.
pub(super) fn linear(n: DVec3, variable: &str, plus: f64) -> String {
    let parts = ["x", "y", "z"].into_iter().zip(n.to_array());
    let parts = parts.map(|(axis, c)| (format!("{variable}.{axis}"), c as f32));
    let mut parts: Vec<_> = parts.filter(|(_, c)| *c != 0.0).collect();
    let product = |(axis, c): (String, f32)| match c {
        1.0 => axis,
        -1.0 => format!("-{axis}"),
        _ => format!("{} * {axis}", literal(c)),
    };
    let start = match plus as f32 {
        0.0 => parts.pop().map_or_else(|| literal(0.0), product),
        plus => literal(plus),
    };
    let sum = parts
        .into_iter()
        .rev()
        .fold(start, |sum, (axis, c)| match c {
            1.0 => format!("{axis} + {sum}"),
            _ => format!("fma({}, {axis}, {sum})", literal(c)),
        });
    format!("({sum})")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_leave_out_what_is_zero_or_one() {
        let of = |x: f64, y: f64, z: f64, plus: f64| linear(DVec3::new(x, y, z), "o", plus);
        assert_eq!(of(0.0, 1.0, 0.0, 0.0), "(o.y)");
        assert_eq!(of(0.0, 1.0, 0.0, -0.5), "(o.y + -0.5f)");
        assert_eq!(of(0.5, 0.0, -1.0, 0.0), "(fma(0.5f, o.x, -o.z))");
        assert_eq!(of(0.0, 0.0, 0.0, 0.0), "(0.0f)");
        assert_eq!(of(2.0, 0.0, 0.0, 1e-7), "(fma(2.0f, o.x, 1e-7f))");
    }

    #[test]
    fn parallel_directions_are_the_same() {
        let (a, is_turned) = turned(DVec3::new(0.0, -3.0, 1e-17));
        assert_eq!((a, is_turned), (DVec3::Y, true));
        assert_eq!(turned(DVec3::new(0.0, 2.0, 0.0)), (DVec3::Y, false));
    }
}
