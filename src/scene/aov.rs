//! Which images are made beside radiance: AOVs (arbitrary output variables).

use super::choice::choice;
use serde::{Deserialize, Serialize};

choice! {
    /// An image beside radiance, or all of them; `docs/aov.md` says what each holds.
    pub enum Aov {
        /// All that follow.
        #[default]
        All,
        /// Reflectance where camera paths end, averaged: for denoisers.
        Albedo,
        /// Shading normal where camera paths end, averaged: for denoisers.
        ShadingNormal,
        /// Normal of the surface in the middle of the pixel, without interpolation and normal maps.
        GeometricNormal,
        /// Distance of the surface in the middle of the pixel, along the viewing direction.
        Depth,
        /// Point of that surface, world space.
        Position,
        /// Number of its material, from 1.
        MaterialId,
        /// Number of its shape, from 1.
        ObjectId,
        /// The image's light, group by group.
        LightGroups,
        /// Finite samples of the pixel.
        SampleCount,
    }
}

impl Aov {
    /// All but [`All`](Self::All), which stands for them.
    pub const EACH: [Self; 9] = [
        Self::Albedo,
        Self::ShadingNormal,
        Self::GeometricNormal,
        Self::Depth,
        Self::Position,
        Self::MaterialId,
        Self::ObjectId,
        Self::LightGroups,
        Self::SampleCount,
    ];
}

/// A set of AOVs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(from = "Vec<Aov>", into = "Vec<Aov>")]
pub struct Aovs(u32);

impl Aovs {
    /// Whether `aov` is asked for.
    pub fn contains(self, aov: Aov) -> bool {
        self.0 & 1 << aov as u32 != 0
    }

    /// Whether one of `aovs` is.
    pub fn any(self, aovs: &[Aov]) -> bool {
        aovs.iter().any(|&aov| self.contains(aov))
    }

    /// Whether none is.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Those that are asked for, in the order of [`Aov::EACH`].
    pub fn iter(self) -> impl Iterator<Item = Aov> {
        Aov::EACH.into_iter().filter(move |&aov| self.contains(aov))
    }

    /// Whether what a denoiser asks for has to be rendered.
    pub fn has_features(self) -> bool {
        self.any(&[Aov::Albedo, Aov::ShadingNormal])
    }

    /// Whether something of the surface in the middle of each pixel is asked for.
    pub fn has_gbuffer(self) -> bool {
        self.any(&[
            Aov::GeometricNormal,
            Aov::Depth,
            Aov::Position,
            Aov::MaterialId,
            Aov::ObjectId,
        ])
    }
}

impl FromIterator<Aov> for Aovs {
    fn from_iter<T: IntoIterator<Item = Aov>>(aovs: T) -> Self {
        let bit = |aov: Aov| 1 << aov as u32;
        let all = Aov::EACH.iter().fold(0, |set, &aov| set | bit(aov));
        let asked = aovs.into_iter().map(|aov| match aov {
            Aov::All => all,
            aov => bit(aov),
        });
        Self(asked.fold(0, |set, bits| set | bits))
    }
}

impl From<Vec<Aov>> for Aovs {
    fn from(aovs: Vec<Aov>) -> Self {
        aovs.into_iter().collect()
    }
}

impl From<Aovs> for Vec<Aov> {
    fn from(aovs: Aovs) -> Self {
        aovs.iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_names_every_other() {
        let all: Aovs = [Aov::All].into_iter().collect();
        assert_eq!(all.iter().collect::<Vec<_>>(), Aov::EACH);
        let two: Aovs = [Aov::Depth, Aov::Albedo, Aov::Depth].into_iter().collect();
        assert_eq!(two.iter().collect::<Vec<_>>(), [Aov::Albedo, Aov::Depth]);
        assert!(two.has_features() && two.has_gbuffer() && !two.contains(Aov::LightGroups));
        assert!(Aovs::default().is_empty());
    }
}
