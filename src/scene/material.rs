//! Surfaces: a BSDF, whether its back exists, and how likely it stops a ray.

use super::fresnel::{average, conductor_reflectance, dielectric_reflectance};
use super::opacity::Opacity;
use super::texture::{MaterialTextures, TextureUse, TexturedFactors};
use glam::DVec3;

/// How a surface scatters light.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// The name in the scene file.
    pub name: String,
    /// The scattering function.
    pub bsdf: Bsdf,
    /// With `false` the back of the surface does not exist: rays pass through it (back-face
    /// culling, glTF's `doubleSided = false`). With `true` both sides scatter alike.
    pub double_sided: bool,
    /// What varies over the surface.
    pub textures: MaterialTextures,
    /// How likely it stops a ray.
    pub opacity: Opacity,
}

impl Material {
    /// Both sides of `bsdf`, without textures, and opaque; its name is in messages and AOVs.
    pub fn new(name: &str, bsdf: Bsdf) -> Self {
        Self {
            name: name.to_owned(),
            bsdf,
            double_sided: true,
            textures: MaterialTextures::default(),
            opacity: Opacity::default(),
        }
    }

    /// All textures that it reads.
    pub fn texture_uses(&self) -> impl Iterator<Item = TextureUse> {
        self.textures.uses().chain(self.opacity.texture)
    }

    /// Whether one of them is read with a mesh's second texture coordinates.
    pub fn reads_second_uvs(&self) -> bool {
        self.texture_uses().any(|used| used.second_uvs)
    }
}

/// The scattering functions of a scene file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bsdf {
    /// Ideal diffuse reflection: `f_r = reflectance / π`.
    Lambert {
        /// Albedo, each channel in [0, 1].
        reflectance: DVec3,
    },
    /// Ideal specular reflection, the same at every angle.
    Mirror {
        /// Reflectance, each channel in [0, 1].
        reflectance: DVec3,
    },
    /// A smooth dielectric: Fresnel's equations divide light into reflected and refracted.
    Dielectric {
        /// Index of refraction inside over that outside.
        ior: f64,
        /// Factor on what passes through the surface, each channel in [0, 1]; through a closed body
        /// light passes twice.
        transmittance: DVec3,
        /// A pane without thickness: nothing is refracted, and what is reflected between its sides
        /// counts.
        thin: bool,
    },
    /// A rough conductor: GGX microfacets with Schlick's Fresnel.
    Conductor {
        /// Reflectance at normal incidence (F₀), each channel in [0, 1].
        reflectance: DVec3,
        /// GGX width α in [0, 1].
        alpha: f64,
    },
    /// A rough conductor: GGX microfacets with Fresnel's equations.
    Metal {
        /// Index of refraction, real part.
        eta: DVec3,
        /// Extinction coefficient.
        k: DVec3,
        /// GGX width α in [0, 1].
        alpha: f64,
    },
    /// A diffuse base under a rough dielectric coat: GGX microfacets with Fresnel's equations.
    Plastic {
        /// Albedo of the base, each channel in [0, 1].
        reflectance: DVec3,
        /// Index of refraction of the coat, at least 1.
        ior: f64,
        /// GGX width α in [0, 1].
        alpha: f64,
    },
    /// glTF 2.0's metallic-roughness model (specification, appendix B).
    MetallicRoughness {
        /// Base colour, linear RGB, each channel in [0, 1].
        base_color: DVec3,
        /// 0 dielectric … 1 metal.
        metallic: f64,
        /// Perceptual roughness in [0, 1]; α = roughness².
        roughness: f64,
        /// Its extensions.
        layer: DielectricLayer,
    },
    /// KHR_materials_pbrSpecularGlossiness: a diffuse base under GGX microfacets with Schlick's
    /// Fresnel.
    SpecularGlossiness {
        /// Albedo of the base before the specular lobe takes its part, each channel in [0, 1].
        diffuse: DVec3,
        /// Reflectance at normal incidence (F₀), each channel in [0, 1].
        specular: DVec3,
        /// In [0, 1]; α = (1 − glossiness)².
        glossiness: f64,
        /// Whether a texture varies the glossiness: then the lobe is nowhere a mirror.
        textured: bool,
    },
    /// KHR_materials_unlit: it shows its colour whatever lights there are, and lights nothing.
    Unlit {
        /// Radiance, linear RGB, each channel in [0, 1].
        color: DVec3,
    },
}

/// What glTF's extensions say of the dielectric in the metallic-roughness model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DielectricLayer {
    /// KHR_materials_ior: index of refraction, at least 1, or 0 for a reflectance of 1.
    pub ior: f64,
    /// KHR_materials_specular: factor on its reflectance, in [0, 1].
    pub specular: f64,
    /// KHR_materials_specular: factor on its reflectance at normal incidence, not negative.
    pub specular_color: DVec3,
    /// KHR_materials_transmission: the part of what enters that passes through instead of being
    /// scattered, in [0, 1].
    pub transmission: f64,
    /// Whether what passes through is not refracted: there is no KHR_materials_volume, or its
    /// thickness is 0.
    pub thin: bool,
    /// Whether a texture makes metal of parts of the glass: a point is metal where metallic is at
    /// least 1/2, else glass without metal.
    pub metal_mask: bool,
}

impl Default for DielectricLayer {
    fn default() -> Self {
        Self {
            ior: 1.5,
            specular: 1.0,
            specular_color: DVec3::ONE,
            transmission: 0.0,
            thin: true,
            metal_mask: false,
        }
    }
}

/// What every BSDF comes down to: a diffuse base under a specular lobe, and what passes through.
///
/// With Schlick's `F` this is glTF's `f_r = (1 − F(ω_i·h)) diffuse/π + F·D·V`, GGX `D` and
/// height-correlated Smith `V`. Under a dielectric's lobe the base is lit through the coat both
/// ways, `(1 − F(θ_i)) (1 − F(θ_o))/(1 − F̄) diffuse/π` with F̄ the lobe's average: reciprocal, and
/// a smooth coat over a white base reflects all light (Kelemen & Szirmay-Kalos 2001 with the smooth
/// coat's albedo, F itself). Without `specular` only `diffuse/π` remains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BsdfParameters {
    /// Albedo of the diffuse base.
    pub diffuse: DVec3,
    /// The specular lobe, where there is one.
    pub specular: Option<SpecularLobe>,
    /// What passes through, where something does.
    pub transmission: Option<Transmission>,
    /// Whether `diffuse` is what the surface shows, and it scatters nothing.
    pub unlit: bool,
}

/// Parameters of the specular lobe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpecularLobe {
    /// What its facets reflect.
    pub fresnel: Fresnel,
    /// GGX width; 0: a mirror.
    pub alpha: f64,
    /// F̄ = 2∫F(μ)μ dμ, μ the cosine: what it reflects of light from everywhere, were it smooth.
    pub average: DVec3,
    /// Whether light that meets several facets counts; see
    /// [`EstimatorSettings::energy_compensation`].
    ///
    /// [`EstimatorSettings::energy_compensation`]: super::EstimatorSettings::energy_compensation
    pub compensated: bool,
}

/// Reflectance of a smooth surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fresnel {
    /// The same at every angle.
    Constant(DVec3),
    /// Schlick's: from `f0` at normal incidence to `f90` at grazing.
    Schlick {
        /// At normal incidence.
        f0: DVec3,
        /// At grazing incidence.
        f90: f64,
    },
    /// Fresnel's equations for a dielectric.
    Dielectric {
        /// Index of refraction inside over that outside.
        ior: f64,
    },
    /// Fresnel's equations for a conductor.
    Conductor {
        /// Index of refraction, real part.
        eta: DVec3,
        /// Extinction coefficient.
        k: DVec3,
    },
}

/// Light that passes through a smooth dielectric's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transmission {
    /// Factor on it.
    pub transmittance: DVec3,
    /// Index of refraction inside over that outside.
    pub ior: f64,
    /// Whether nothing is refracted; see [`Bsdf::Dielectric`].
    pub thin: bool,
}

impl SpecularLobe {
    /// A lobe of width `alpha`; one below [`Bsdf::MIN_ALPHA`] is a mirror.
    pub fn new(fresnel: Fresnel, alpha: f64) -> Self {
        let average = match fresnel {
            Fresnel::Constant(reflectance) => reflectance,
            // 2∫(1 − μ)⁵μ dμ = 1/21.
            Fresnel::Schlick { f0, f90 } => f0 + (DVec3::splat(f90) - f0) / 21.0,
            Fresnel::Dielectric { ior } => {
                DVec3::splat(average(|cos| dielectric_reflectance(cos, ior)))
            }
            Fresnel::Conductor { eta, k } => DVec3::from_array(std::array::from_fn(|c| {
                average(|cos| conductor_reflectance(cos, eta[c], k[c]))
            })),
        };
        let smooth = alpha < Bsdf::MIN_ALPHA;
        Self {
            fresnel,
            alpha: if smooth { 0.0 } else { alpha },
            average,
            compensated: false,
        }
    }
}

impl BsdfParameters {
    /// Whether camera rays go on here: the lobe is a mirror, or something passes through.
    pub fn is_specular(&self) -> bool {
        self.specular.is_some_and(|lobe| lobe.alpha <= 0.0) || self.transmission.is_some()
    }
}

impl Bsdf {
    /// Smallest GGX width that is simulated as one; a narrower lobe is a mirror, in which camera
    /// rays go on.
    pub const MIN_ALPHA: f64 = 1e-4;

    /// Multiplies the reflectance, the base colour or what passes through. A metal of a given index
    /// has no colour beside it.
    pub fn scale_color(&mut self, factor: DVec3) {
        match self {
            Self::Lambert { reflectance: color }
            | Self::Mirror { reflectance: color }
            | Self::Conductor {
                reflectance: color, ..
            }
            | Self::Plastic {
                reflectance: color, ..
            }
            | Self::Dielectric {
                transmittance: color,
                ..
            }
            | Self::MetallicRoughness {
                base_color: color, ..
            }
            | Self::SpecularGlossiness { diffuse: color, .. }
            | Self::Unlit { color } => *color *= factor,
            Self::Metal { .. } => {}
        }
    }

    /// Multiplies metallic and roughness of glTF's model.
    pub fn scale_metallic_roughness(&mut self, on_metallic: f64, on_roughness: f64) {
        if let Self::MetallicRoughness {
            metallic,
            roughness,
            ..
        } = self
        {
            *metallic *= on_metallic;
            *roughness *= on_roughness;
        }
    }

    /// Multiplies reflectance at normal incidence and glossiness of the specular-glossiness model.
    pub fn scale_specular_glossiness(&mut self, on_specular: DVec3, on_glossiness: f64) {
        if let Self::SpecularGlossiness {
            specular,
            glossiness,
            ..
        } = self
        {
            *specular *= on_specular;
            *glossiness *= on_glossiness;
        }
    }

    /// Whether it is glass of which a texture makes metal in parts.
    pub fn is_masked(&self) -> bool {
        matches!(self, Self::MetallicRoughness { layer, .. } if layer.metal_mask)
    }

    /// The lobes where the material's textures say `factors`; `own` are those without. No texture
    /// makes a mirror of a rough surface.
    pub fn textured_parameters(
        &self,
        own: &BsdfParameters,
        factors: &TexturedFactors,
    ) -> BsdfParameters {
        let mut textured = *self;
        textured.scale_color(factors.color);
        textured.scale_specular_glossiness(factors.specular, factors.glossiness);
        let masked = self.is_masked();
        if own.transmission.is_none() || masked {
            textured.scale_metallic_roughness(factors.metallic, factors.roughness);
        }
        let mut is_rough = !own.is_specular();
        if let Self::MetallicRoughness {
            metallic, layer, ..
        } = &mut textured
            && masked
        {
            is_rough = *metallic >= 0.5;
            *metallic = if is_rough { 1.0 } else { 0.0 };
            layer.metal_mask = false;
        }
        if let Self::MetallicRoughness { roughness, .. } = &mut textured
            && is_rough
        {
            *roughness = roughness.max(Self::MIN_ALPHA.sqrt() * (1.0 + f64::EPSILON));
        }
        textured.parameters()
    }

    /// The GGX width of the metal in glass of which a texture makes metal in parts, before
    /// textures.
    pub fn masked_alpha(&self) -> Option<f64> {
        match self {
            Self::MetallicRoughness {
                roughness, layer, ..
            } if layer.metal_mask => Some((roughness * roughness).max(Self::MIN_ALPHA)),
            _ => None,
        }
    }

    /// The lobes this BSDF comes down to.
    pub fn parameters(&self) -> BsdfParameters {
        let reflects = |diffuse, fresnel, alpha| BsdfParameters {
            diffuse,
            specular: Some(SpecularLobe::new(fresnel, alpha)),
            transmission: None,
            unlit: false,
        };
        let matte = |diffuse, unlit| BsdfParameters {
            diffuse,
            specular: None,
            transmission: None,
            unlit,
        };
        match *self {
            Self::Lambert { reflectance } => matte(reflectance, false),
            Self::Unlit { color } => matte(color, true),
            Self::SpecularGlossiness {
                diffuse,
                specular,
                glossiness,
                textured,
            } => {
                let (f0, f90) = (specular, 1.0);
                let narrowest = if textured { Self::MIN_ALPHA } else { 0.0 };
                let alpha = (1.0 - glossiness).powi(2).max(narrowest);
                let left = 1.0 - specular.max_element();
                reflects(diffuse * left, Fresnel::Schlick { f0, f90 }, alpha)
            }
            Self::Mirror { reflectance } => {
                reflects(DVec3::ZERO, Fresnel::Constant(reflectance), 0.0)
            }
            Self::Dielectric {
                ior,
                transmittance,
                thin,
            } => BsdfParameters {
                transmission: Some(Transmission {
                    transmittance,
                    ior,
                    thin,
                }),
                ..reflects(DVec3::ZERO, Fresnel::Dielectric { ior }, 0.0)
            },
            Self::Conductor { reflectance, alpha } => {
                let (f0, f90) = (reflectance, 1.0);
                reflects(DVec3::ZERO, Fresnel::Schlick { f0, f90 }, alpha)
            }
            Self::Metal { eta, k, alpha } => {
                reflects(DVec3::ZERO, Fresnel::Conductor { eta, k }, alpha)
            }
            Self::Plastic {
                reflectance,
                ior,
                alpha,
            } => reflects(reflectance, Fresnel::Dielectric { ior }, alpha),
            Self::MetallicRoughness {
                base_color,
                metallic,
                roughness,
                layer,
            } => layer.parameters(base_color, metallic, roughness * roughness),
        }
    }
}

impl DielectricLayer {
    /// Reflectance at normal incidence.
    pub fn f0(&self) -> DVec3 {
        let normal = ((self.ior - 1.0) / (self.ior + 1.0)).powi(2);
        (normal * self.specular_color).min(DVec3::ONE) * self.specular
    }

    /// The model under these extensions. Where something passes through, the surface is a smooth
    /// dielectric: the metal's part, the roughness and the factors of KHR_materials_specular do not
    /// count.
    fn parameters(&self, base_color: DVec3, metallic: f64, alpha: f64) -> BsdfParameters {
        let dielectric = if self.metal_mask { 1.0 } else { 1.0 - metallic };
        let through = self.transmission * dielectric;
        if through > 0.0 {
            return BsdfParameters {
                diffuse: base_color * (dielectric - through),
                specular: Some(SpecularLobe::new(
                    Fresnel::Dielectric { ior: self.ior },
                    0.0,
                )),
                transmission: Some(Transmission {
                    transmittance: base_color * through,
                    ior: self.ior,
                    thin: self.thin,
                }),
                unlit: false,
            };
        }
        let fresnel = Fresnel::Schlick {
            f0: self.f0().lerp(base_color, metallic),
            f90: self.specular * dielectric + metallic,
        };
        BsdfParameters {
            diffuse: base_color * dielectric,
            specular: Some(SpecularLobe::new(fresnel, alpha)),
            transmission: None,
            unlit: false,
        }
    }
}
