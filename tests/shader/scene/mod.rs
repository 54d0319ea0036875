//! One file per file of `shaders/scene/`.

mod attributes;
mod bindings;
mod fetch;
mod opacity;
mod specialize;
mod surface;
mod texture;
mod trace;

use crate::support::every_kind::{constant_environment, every_kind};
use crate::support::prepared_for;
use direkt::low_level::prepare::Prepared;
use direkt::scene::{LightSelection, Scene, Strategy};

/// `scene` with everything compiled in that it calls for.
fn prepared(scene: Scene) -> Prepared {
    prepared_for(scene, Strategy::MisPower, LightSelection::Power)
}

/// Every kind of primitive, material and light.
fn every() -> Prepared {
    prepared(every_kind(constant_environment()))
}
