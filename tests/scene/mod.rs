//! Scene files: what they mean, and how bad ones are refused.

mod bad_cameras;
mod bad_gltf;
mod bad_toml;
mod broken_files;
mod builder;
mod exr_layers;
mod files;
mod fuzz;
mod gltf;
mod gltf_accessors;
mod gltf_containers;
mod gltf_models;
mod gltf_nodes;
mod gltf_poses;
mod image_formats;
mod light_groups;
mod material_libraries;
mod mesh_text;
mod meshes;
mod opacity;
mod radiance;
mod repository;
mod shadow_rays;
mod textures;
mod toml;
mod vertex_colors;
