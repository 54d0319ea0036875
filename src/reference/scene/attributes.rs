//! What primitives carry beside their geometry; see `shaders/scene/attributes.wesl`.

use super::fetch::{Primitive, World};
use crate::accel::PrimitiveGeometry;
use crate::reference::core::octahedral::from_octahedral;
use crate::scene::TextureUse;
pub use crate::scene::texture::interpolate_uv;
use crate::scene::texture::{disk_uv, rectangle_uv};
use glam::{DVec2, DVec3, DVec4};

/// Unit normals at a triangle's vertices.
pub type VertexNormals = [DVec3; 3];

/// Texture coordinates at a planar primitive's points a, a + u and a + v.
pub type VertexUvs = [DVec2; 3];

/// Colours at a triangle's vertices: linear red, green, blue, and alpha.
pub type VertexColors = [DVec4; 3];

fn pair([x, y]: [f32; 2]) -> DVec2 {
    DVec2::new(x.into(), y.into())
}

/// The vertex normals of `p`, which has them.
pub fn fetch_normals(world: &World<'_>, p: &Primitive) -> VertexNormals {
    let normal = |n| from_octahedral(pair(n)).normalize();
    world
        .prepared
        .data
        .attributes
        .normals(&p.attributed)
        .map(normal)
}

/// The texture coordinates of `p`, which has them.
pub fn fetch_uvs(world: &World<'_>, p: &Primitive) -> VertexUvs {
    let corners = [DVec2::ZERO, DVec2::X, DVec2::Y];
    match p.geometry {
        PrimitiveGeometry::Rectangle { .. } => corners.map(rectangle_uv),
        PrimitiveGeometry::Disk { .. } => corners.map(disk_uv),
        _ => world.prepared.data.attributes.uvs(&p.attributed).map(pair),
    }
}

/// The texture coordinates of `p` that `texture` is read with.
pub fn uvs_of(world: &World<'_>, p: &Primitive, texture: &TextureUse) -> VertexUvs {
    if texture.second_uvs {
        let attributes = &world.prepared.data.attributes;
        attributes.second_uvs(&p.attributed).map(pair)
    } else {
        fetch_uvs(world, p)
    }
}

/// The vertex colours of `p`, which has them.
pub fn fetch_colors(world: &World<'_>, p: &Primitive) -> VertexColors {
    let colors = world.prepared.data.attributes.colors(&p.attributed);
    colors.map(|c| DVec4::from_array(c.map(f64::from)))
}

/// The colour of the point `st`.
pub fn interpolate_color(c: &VertexColors, st: DVec2) -> DVec4 {
    let color = c[0] + st.x * (c[1] - c[0]) + st.y * (c[2] - c[0]);
    color.clamp(DVec4::ZERO, DVec4::ONE)
}

/// The unit normal between those of the vertices, on the side of the primitive's own normal; that
/// itself where they cancel.
pub fn interpolate_normal(n: &VertexNormals, st: DVec2, own: DVec3) -> DVec3 {
    let sum = (1.0 - st.x - st.y) * n[0] + st.x * n[1] + st.y * n[2];
    if sum.length_squared() < 1e-12 {
        return own;
    }
    let normal = sum.normalize();
    if normal.dot(own) >= 0.0 {
        normal
    } else {
        -normal
    }
}

/// What lifts the point a + s·u + t·v of a flat triangle to the smooth surface that its vertex
/// normals suggest, `side` = 1 or −1 that on which it is seen (Hanika 2021, "Hacking the Shadow
/// Terminator").
pub fn terminator_offset(n: &VertexNormals, st: DVec2, u: DVec3, v: DVec3, side: f64) -> DVec3 {
    let from_a = st.x * u + st.y * v;
    let weights = [1.0 - st.x - st.y, st.x, st.y];
    let from_vertices = [from_a, from_a - u, from_a - v];
    let planes = n.iter().zip(weights).zip(from_vertices);
    planes
        .map(|((&n, weight), from)| {
            let n = side * n;
            -weight * from.dot(n).min(0.0) * n
        })
        .sum()
}

/// The normal that a normal map's value `mapped` means: x along growing u, y along falling v, z
/// along `normal`. That itself where the texture coordinates span no area.
pub fn map_normal(mapped: DVec3, uvs: &VertexUvs, u: DVec3, v: DVec3, normal: DVec3) -> DVec3 {
    let (du, dv) = (uvs[1] - uvs[0], uvs[2] - uvs[0]);
    let determinant = du.perp_dot(dv);
    let side = if determinant > 0.0 { 1.0 } else { -1.0 };
    let along_u = side * (u * dv.y - v * du.y);
    let tangent = along_u - normal * normal.dot(along_u);
    if tangent.length_squared() < 1e-30 || determinant.abs() <= 0.0 {
        return normal;
    }
    let x = tangent.normalize();
    let y = -side * normal.cross(x);
    let sum = mapped.x * x + mapped.y * y + mapped.z * normal;
    if sum.length_squared() < 1e-12 {
        return normal;
    }
    sum.normalize()
}

/// Unit tangents at a triangle's vertices, each with its sense.
pub type VertexTangents = [DVec4; 3];

/// The tangents of `p`, which has them.
pub fn fetch_tangents(world: &World<'_>, p: &Primitive) -> VertexTangents {
    let tangents = world.prepared.data.attributes.tangents(&p.attributed);
    tangents.map(|t| DVec4::from_array(t.map(f64::from)))
}

/// The normal that a normal map's value `mapped` means at `st` where the vertices have the tangents
/// `t`.
pub fn map_normal_along(mapped: DVec3, t: &VertexTangents, st: DVec2, normal: DVec3) -> DVec3 {
    let given = (1.0 - st.x - st.y) * t[0] + st.x * t[1] + st.y * t[2];
    let tangent = given.truncate() - normal * normal.dot(given.truncate());
    if tangent.length_squared() < 1e-12 {
        return normal;
    }
    let x = tangent.normalize();
    let sense = if given.w > 0.0 { 1.0 } else { -1.0 };
    let y = sense * normal.cross(x);
    let sum = mapped.x * x + mapped.y * y + mapped.z * normal;
    if sum.length_squared() < 1e-12 {
        return normal;
    }
    sum.normalize()
}

/// Smallest cosine between a shading normal and the direction to the viewer.
pub const MIN_VIEW_COS: f64 = 0.01;

/// A shading normal turned towards the viewer as far as it has to be to be seen.
pub fn seen_normal(normal: DVec3, wo: DVec3) -> DVec3 {
    (normal + wo * (MIN_VIEW_COS - normal.dot(wo)).max(0.0)).normalize()
}
