//! What a ray can meet and a light sample can choose.

use crate::accel::{Attributed, PrimitiveGeometry};
use crate::effects::Effect;
use crate::emitters::Emitter;
use crate::prepare::Prepared;
use crate::reference::core::bvh::Bvh;
use crate::scene::MaterialId;
use crate::scene::material::BsdfParameters;

/// A primitive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Primitive {
    /// Geometry, normalised space.
    pub geometry: PrimitiveGeometry,
    /// How it scatters, unless textures vary that.
    pub material: BsdfParameters,
    /// Its material, with the textures.
    pub material_id: MaterialId,
    /// Which attributes it has.
    pub attributed: Attributed,
    /// Whether rays pass through its back.
    pub one_sided: bool,
    /// Index of its light.
    pub light: Option<u32>,
}

/// The scene in f64, unrounded, with a hierarchy of its own. Primitives and lights are numbered as
/// on the GPU.
#[derive(Debug)]
pub struct World<'a> {
    /// What was prepared for the GPU as well: lights, their probabilities, the normalisation.
    pub prepared: &'a Prepared,
    /// Primitives.
    pub primitives: Vec<Primitive>,
    /// The hierarchy over them.
    pub bvh: Bvh,
    /// The group of lights that alone shines; none where all do.
    pub light_group: Option<u32>,
}

impl<'a> World<'a> {
    /// The scene of `prepared`.
    pub fn new(prepared: &'a Prepared) -> Self {
        let materials = prepared.data.scene.materials.iter();
        let compensated = prepared.effects.contains(Effect::EnergyCompensation);
        let parameters = materials.map(|m| {
            let mut parameters = m.bsdf.parameters();
            if let Some(lobe) = &mut parameters.specular {
                lobe.compensated = compensated;
            }
            parameters
        });
        let parameters: Vec<_> = parameters.collect();
        let mut primitives: Vec<Primitive> = prepared
            .data
            .primitives
            .iter()
            .zip(&prepared.data.attributes.of_primitive)
            .map(|(p, &attributed)| {
                let material = &prepared.data.scene.materials[p.material.index()];
                Primitive {
                    geometry: p.geometry,
                    material: parameters[p.material.index()],
                    material_id: p.material,
                    attributed,
                    one_sided: !material.double_sided,
                    light: None,
                }
            })
            .collect();
        for (index, emitter) in prepared.emitters.lights.iter().enumerate() {
            if let Emitter::Area { primitive, .. } = emitter {
                primitives[*primitive as usize].light = Some(index as u32);
            }
        }
        let boxes: Vec<_> = primitives.iter().map(|p| p.geometry.bounds()).collect();
        Self {
            prepared,
            bvh: Bvh::new(&boxes),
            primitives,
            light_group: None,
        }
    }

    /// Whether light `index` shines.
    pub fn shines(&self, index: usize) -> bool {
        let groups = &self.prepared.emitters.groups;
        let group = self.light_group;
        group.is_none_or(|group| groups.of_light(index) == group)
    }

    /// Name of the shape that primitive `index` is a part of.
    pub fn name_of(&self, index: usize) -> String {
        let shape = self.prepared.data.primitives[index].shape;
        self.prepared.data.scene.shapes[shape.index()].name.clone()
    }

    /// Whether primitive `index` is shaded with other normals than its own.
    pub fn has_shading_normals(&self, index: usize) -> bool {
        let p = &self.primitives[index];
        let material = &self.prepared.data.scene.materials[p.material_id.index()];
        p.attributed.normals || (p.attributed.uvs && material.textures.normal.is_some())
    }
}
