//! How to render: the table `[render]` of a scene file, of which every key also has a flag.

use super::aov::{Aov, Aovs};
use super::choice::choice;
use super::error_metric::ErrorMetric;
use super::sampler::Sampler;
use super::shadow_rays::{ShadowPattern, ShadowRays};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

choice! {
    /// How directions are chosen (DESIGN: *strategy*). All estimate the same integral.
    pub enum Strategy {
        /// Uniformly over the hemisphere. With this and the next two, lights without a surface are
        /// sampled directly, as nothing else reaches them.
        UniformHemisphere,
        /// In proportion to the cosine.
        CosineHemisphere,
        /// In proportion to the BSDF.
        Bsdf,
        /// Uniformly on the surface of a chosen light.
        LightArea,
        /// Uniformly over the solid angle in which a chosen light is seen.
        LightSolidAngle,
        /// Uniformly over that solid angle projected onto the surface; for spheres and disks as
        /// `light-solid-angle`.
        LightProjectedSolidAngle,
        /// By lights and by the BSDF, weighted by the balance heuristic (Veach 1997, eq. 9.11).
        MisBalance,
        /// By lights and by the BSDF, weighted by the power heuristic (Veach 1997, eq. 9.26, β =
        /// 2).
        #[default]
        MisPower,
    }
}

/// How directions are sampled without regard to lights.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DirectionSampling {
    /// Uniformly over the hemisphere.
    UniformHemisphere,
    /// In proportion to the cosine.
    CosineHemisphere,
    /// In proportion to the BSDF.
    Bsdf,
}

/// How samples of directions and samples of lights are weighted where both are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Heuristic {
    /// In proportion to their densities (Veach 1997, eq. 9.11).
    Balance,
    /// In proportion to the squares of their densities (Veach 1997, eq. 9.26, β = 2).
    Power,
}

/// What a strategy combines: its name stands for these.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Techniques {
    /// Sampling of directions; `None` where lights alone are sampled.
    pub directions: Option<DirectionSampling>,
    /// Sampling of points on lights with a surface; `None` where these are not sampled.
    pub lights: Option<LightSampling>,
    /// The weights, where there are both.
    pub heuristic: Option<Heuristic>,
}

impl Strategy {
    /// What it combines, where points on lights are sampled by `light_sampling` if it does not say.
    pub fn techniques(self, light_sampling: LightSampling) -> Techniques {
        let directions = |sampling| (Some(sampling), None, None);
        let lights = |sampling| (None, Some(sampling), None);
        let both = |heuristic| {
            let bsdf = Some(DirectionSampling::Bsdf);
            (bsdf, Some(light_sampling), Some(heuristic))
        };
        let (directions, lights, heuristic) = match self {
            Self::UniformHemisphere => directions(DirectionSampling::UniformHemisphere),
            Self::CosineHemisphere => directions(DirectionSampling::CosineHemisphere),
            Self::Bsdf => directions(DirectionSampling::Bsdf),
            Self::LightArea => lights(LightSampling::Area),
            Self::LightSolidAngle => lights(LightSampling::SolidAngle),
            Self::LightProjectedSolidAngle => lights(LightSampling::ProjectedSolidAngle),
            Self::MisBalance => both(Heuristic::Balance),
            Self::MisPower => both(Heuristic::Power),
        };
        Techniques {
            directions,
            lights,
            heuristic,
        }
    }

    /// Whether lights with a surface and the environment are sampled.
    pub fn samples_lights(self) -> bool {
        self.techniques(LightSampling::default()).lights.is_some()
    }

    /// Whether both are done, and weighted so that each may leave out what the other finds.
    pub fn is_mis(self) -> bool {
        let techniques = self.techniques(LightSampling::default());
        techniques.heuristic.is_some()
    }
}

choice! {
    /// How a point of a light with a surface is chosen by the strategies `mis-balance` and
    /// `mis-power`.
    pub enum LightSampling {
        /// Uniformly over its area.
        Area,
        /// Uniformly over the solid angle in which it is seen.
        #[default]
        SolidAngle,
        /// Uniformly over that solid angle projected onto the surface; spheres and disks over their
        /// solid angle.
        ProjectedSolidAngle,
    }
}

choice! {
    /// How one of several lights is chosen.
    pub enum LightSelection {
        /// Where there are few, none is: every light gets shadow rays of its own. Of many one is
        /// chosen by the light tree.
        #[default]
        Auto,
        /// All with the same probability.
        Uniform,
        /// In proportion to emitted power.
        Power,
        /// In proportion to an estimate of what a light may contribute to the surface, by a tree
        /// over the lights (Conty Estevez & Kulla 2018): for many lights.
        Tree,
        /// None is chosen: every light gets shadow rays of its own.
        All,
    }
}

/// Largest [`max_specular_depth`](EstimatorSettings::max_specular_depth).
pub const MAX_SPECULAR_DEPTH: u32 = 64;

/// Defines the table `[render]` once: its parts as structs, the flags that override the first of
/// them, and the table as files spell it, flat. The first paragraph of a field's comment is also
/// the help of its flag.
macro_rules! render_table {
    (
        $(#[$of_estimator:meta])* struct $Estimator:ident, flags $Flags:ident {
            $($(#[doc = $e_doc:literal])* $(#[schemars $schema:tt])? #[flag($($flag:tt)*)] $e:ident: $E:ty = $e_default:expr,)*
        }
        $(#[$of_stop:meta])* struct $Stop:ident {
            $($(#[doc = $s_doc:literal])* $s:ident: $S:ty = $s_default:expr,)*
        }
    ) => {
        $(#[$of_estimator])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
        pub struct $Estimator {
            $($(#[doc = $e_doc])* pub $e: $E,)*
        }

        impl Default for $Estimator {
            fn default() -> Self {
                Self { $($e: $e_default,)* }
            }
        }

        impl $Estimator {
            /// Its settings by their names in scene files, as these spell them.
            pub fn entries(&self) -> Vec<(&'static str, String)> {
                vec![$((stringify!($e), self.$e.to_string()),)*]
            }
        }

        /// Flags that override
        #[doc = concat!("[`", stringify!($Estimator), "`].")]
        #[cfg(feature = "clap")]
        #[derive(Debug, Clone, Default, clap::Args)]
        pub struct $Flags {
            $($(#[doc = $e_doc])* #[arg(long, long_help = None::<&'static str>, $($flag)*)] pub $e: Option<$E>,)*
        }

        #[cfg(feature = "clap")]
        impl $Flags {
            /// Sets what is given.
            pub fn apply(&self, settings: &mut $Estimator) {
                $(settings.$e = self.$e.unwrap_or(settings.$e);)*
            }
        }

        $(#[$of_stop])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $Stop {
            $($(#[doc = $s_doc])* pub $s: $S,)*
        }

        impl Default for $Stop {
            fn default() -> Self {
                Self { $($s: $s_default,)* }
            }
        }

        /// How to render.
        #[derive(Debug, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub(super) struct RenderTable {
            $($(#[doc = $e_doc])* $(#[schemars $schema])? $e: $E,)*
            $($(#[doc = $s_doc])* $s: $S,)*
            /// Seed of the random numbers.
            seed: u32,
            /// Images beside radiance, which an EXR holds as further channels.
            #[schemars(with = "Vec<Aov>")]
            aovs: Aovs,
        }

        impl Default for RenderTable {
            fn default() -> Self {
                let RenderSettings { estimator, stop, seed, aovs } = RenderSettings::default();
                Self { $($e: estimator.$e,)* $($s: stop.$s,)* seed, aovs }
            }
        }

        impl From<RenderTable> for RenderSettings {
            fn from(table: RenderTable) -> Self {
                Self {
                    estimator: $Estimator { $($e: table.$e,)* },
                    stop: $Stop { $($s: table.$s,)* },
                    seed: table.seed,
                    aovs: table.aovs,
                }
            }
        }
    };
}

render_table! {
    /// How direct lighting is estimated.
    struct EstimatorSettings, flags EstimatorFlags {
        /// How directions are chosen
        #[flag(value_enum)]
        strategy: Strategy = Strategy::default(),
        /// How one of several lights is chosen
        #[flag(value_enum)]
        light_selection: LightSelection = LightSelection::default(),
        /// How a point of a chosen light is chosen by the MIS strategies
        ///
        /// The other strategies say it themselves.
        #[flag(value_enum)]
        light_sampling: LightSampling = LightSampling::default(),
        /// Whether the MIS strategies sample of an environment map only what is brighter than its
        /// mean
        ///
        /// The rest is left to BSDF sampling (Karlík et al. 2019). Less noise under a sun in a
        /// broad sky; more where the sun is hidden and only the sky shines. The other strategies do
        /// not depend on it.
        #[flag(value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true")]
        mis_compensation: bool = false,
        /// Shadow rays per camera ray, `auto` or 1 to 1024; with light selection `all` per light
        ///
        /// `auto` is one, or four where a few pixels tell that these are sooner at the same error.
        #[flag(value_name = "N")]
        shadow_rays: ShadowRays = ShadowRays::default(),
        /// Where on the lights the points of a camera ray's shadow rays lie
        #[flag(value_enum)]
        shadow_pattern: ShadowPattern = ShadowPattern::default(),
        /// Whether light counts that rough metals reflect after it has met several of their facets
        ///
        /// By Kulla & Conty (2017). Without, as in glTF's model and in most renderers' GGX, a white
        /// metal of width 1 loses up to 69 % of the light.
        #[flag(value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true")]
        energy_compensation: bool = false,
        /// Mirrors and panes of glass, one behind the other, in which direct lighting is seen, 0 to
        /// 64
        ///
        /// What lies deeper is black. A closed body of glass is two of them, and each reflection in
        /// its inside one more.
        #[schemars(range(min = 0, max = 64))]
        #[flag(value_name = "N", value_parser = clap::value_parser!(u32).range(0..=i64::from(MAX_SPECULAR_DEPTH)))]
        max_specular_depth: u32 = 8,
        /// Whether the kernel is compiled for a small scene, or a few large primitives, alone
        ///
        /// They, materials and lights stand in the shader then and are not loaded, which is several
        /// times as fast in software. Images differ in their last digits.
        #[flag(value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true")]
        specialize: bool = true,
        /// How random numbers are made
        #[flag(value_enum)]
        sampler: Sampler = Sampler::default(),
        /// Whether pixels take more samples where the error is large and fewer where it is small
        ///
        /// [`StopSettings::spp`] on average. A pilot of eight samples per pixel, which are no part
        /// of the image, says where that is.
        #[flag(value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true")]
        adaptive: bool = true,
    }

    /// When a render ends: at the first of these.
    struct StopSettings {
        /// Samples per pixel, at least 1.
        spp: u64 = 64,
        /// Seconds of rendering after which it ends, even with fewer samples; none: `spp` alone
        /// decides.
        time: Option<f64> = None,
        /// Error of the image, √NMSE or √relMSE as `error_metric` says, at which it ends; none:
        /// other settings decide.
        error: Option<f64> = None,
        /// What `error` is measured in.
        error_metric: ErrorMetric = ErrorMetric::default(),
        /// Confidence with which the image's error has to be below `error`, between 0 and 1.
        confidence: f64 = 0.95,
    }
}

impl EstimatorSettings {
    /// What the strategy combines.
    pub fn techniques(&self) -> Techniques {
        self.strategy.techniques(self.light_sampling)
    }
}

/// How to render: the estimator, when it stops, and what is written.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RenderSettings {
    /// How direct lighting is estimated.
    pub estimator: EstimatorSettings,
    /// When to stop.
    pub stop: StopSettings,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Images beside radiance, which an EXR holds as further channels.
    pub aovs: Aovs,
}
