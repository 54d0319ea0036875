//! Colours of other primaries, converted to those of ITU-R BT.709, which everything here is in.

use glam::{DMat3, DVec2, DVec3};

/// Chromaticities (CIE 1931 x, y) of the primaries and of white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Primaries {
    pub(super) red: DVec2,
    pub(super) green: DVec2,
    pub(super) blue: DVec2,
    pub(super) white: DVec2,
}

/// Those of ITU-R BT.709, with white D65.
pub(super) const REC709: Primaries = Primaries {
    red: DVec2::new(0.64, 0.33),
    green: DVec2::new(0.30, 0.60),
    blue: DVec2::new(0.15, 0.06),
    white: DVec2::new(0.3127, 0.3290),
};

/// Those of a file that holds CIE XYZ itself.
pub(super) const XYZ: Primaries = Primaries {
    red: DVec2::new(1.0, 0.0),
    green: DVec2::new(0.0, 1.0),
    blue: DVec2::new(0.0, 0.0),
    white: DVec2::new(1.0 / 3.0, 1.0 / 3.0),
};

/// Difference up to which chromaticities are the same: files round them to three digits.
const SAME: f64 = 2e-3;

impl Primaries {
    /// Whether these are `other` but for rounding.
    pub(super) fn are(&self, other: &Self) -> bool {
        let same = |a: DVec2, b: DVec2| (a - b).abs().max_element() < SAME;
        same(self.red, other.red)
            && same(self.green, other.green)
            && same(self.blue, other.blue)
            && same(self.white, other.white)
    }

    /// From colours of these primaries to CIE XYZ, white of luminance 1; `None` where there is no
    /// such map.
    pub(super) fn to_xyz(self) -> Option<DMat3> {
        let point = |c: DVec2| DVec3::new(c.x, c.y, 1.0 - c.x - c.y);
        let columns = DMat3::from_cols(point(self.red), point(self.green), point(self.blue));
        let white = point(self.white) / self.white.y;
        let invertible = columns.determinant().abs() > 1e-9;
        let scales = columns.inverse() * white;
        (invertible && scales.is_finite()).then(|| columns * DMat3::from_diagonal(scales))
    }

    /// From linear colours of these primaries to linear ones of BT.709; `None` where there is no
    /// such map. White stays white (Bradford's adaptation, Lam 1985); what is CIE XYZ is not
    /// adapted.
    pub(super) fn to_rec709(self) -> Option<DMat3> {
        let to_xyz = self.to_xyz()?;
        let from_xyz = REC709.to_xyz()?.inverse();
        if self.are(&XYZ) {
            return Some(from_xyz);
        }
        let white =
            |p: &Self| DVec3::new(p.white.x, p.white.y, 1.0 - p.white.x - p.white.y) / p.white.y;
        let cones = DMat3::from_cols(
            DVec3::new(0.8951, -0.7502, 0.0389),
            DVec3::new(0.2664, 1.7135, -0.0685),
            DVec3::new(-0.1614, 0.0367, 1.0296),
        );
        let ratio = (cones * white(&REC709)) / (cones * white(&self));
        let adapted = cones.inverse() * DMat3::from_diagonal(ratio) * cones;
        let map = from_xyz * adapted * to_xyz;
        map.is_finite().then_some(map)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: DVec3, b: DVec3, tolerance: f64) -> bool {
        (a - b).abs().max_element() < tolerance
    }

    /// The published matrices: IEC 61966-2-1 of XYZ, SMPTE EG 432-1's P3 with white D65.
    #[test]
    fn maps_are_those_of_the_standards() {
        let from_xyz = XYZ.to_rec709().expect("a map");
        assert!(close(
            from_xyz.x_axis,
            DVec3::new(3.2406, -0.9689, 0.0557),
            6e-4
        ));
        assert!(close(
            from_xyz * DVec3::new(0.9505, 1.0, 1.089),
            DVec3::ONE,
            1e-3
        ));
        let p3 = Primaries {
            red: DVec2::new(0.68, 0.32),
            green: DVec2::new(0.265, 0.69),
            ..REC709
        };
        let from_p3 = p3.to_rec709().expect("a map");
        assert!(close(
            from_p3.x_axis,
            DVec3::new(1.2249, -0.0420, -0.0196),
            2e-4
        ));
    }

    #[test]
    fn white_stays_white() {
        let warm = Primaries {
            white: DVec2::new(0.345, 0.358),
            ..REC709
        };
        let map = warm.to_rec709().expect("a map");
        assert!(close(map * DVec3::ONE, DVec3::ONE, 1e-9));
        let same = REC709.to_rec709().expect("a map");
        assert!(close(same.x_axis, DVec3::X, 1e-12));
    }

    #[test]
    fn primaries_on_a_line_have_no_map() {
        let line = Primaries {
            blue: DVec2::new(0.47, 0.465),
            ..REC709
        };
        assert_eq!(line.to_xyz(), None);
    }
}
