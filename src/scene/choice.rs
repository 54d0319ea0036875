//! Settings that are one of a few named choices.

/// Defines an enum whose variants have one name, in kebab-case, in scene files, on the command
/// line, in JSON and in print.
macro_rules! choice {
    ($(#[$meta:meta])* pub enum $name:ident { $($(#[$of_variant:meta])* $variant:ident,)* }) => {
        $(#[$meta])*
        #[derive(
            Debug,
            Clone,
            Copy,
            PartialEq,
            Eq,
            Hash,
            Default,
            serde::Serialize,
            serde::Deserialize,
            schemars::JsonSchema,
            strum::Display,
            strum::EnumMessage,
            strum::VariantArray,
        )]
        #[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
        #[serde(rename_all = "kebab-case")]
        #[strum(serialize_all = "kebab-case")]
        pub enum $name { $($(#[$of_variant])* $variant,)* }
    };
}

pub(super) use choice;
