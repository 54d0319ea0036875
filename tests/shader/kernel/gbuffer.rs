//! `shaders/kernel/gbuffer.wesl` and `shaders/kernel/features.wesl`: images of both are in
//! `tests/render/aov.rs`.

use crate::support::shader::{Function, call_in};
use crate::support::{context, floor_pixel, prepared};
use direkt::low_level::reference::Twin;
use direkt::low_level::reference::kernel::gbuffer::{MIDDLE, surface_at_film};
use direkt::low_level::reference::scene::opacity::Crossings;

#[test]
fn the_middle_of_a_pixel_sees_what_the_twins_does() {
    let scene = floor_pixel();
    let (film, seed) = (scene.film, scene.render.seed);
    let prepared = prepared(scene);
    let function = Function {
        imports: "import package::kernel::gbuffer::surface_of_pixel;",
        body: "let s = surface_of_pixel(vec2u(0u));
               out_vec3f(0u, s.position); out_u32(3u, s.primitive); out_vec3f(4u, s.normal);",
        outputs: 7,
        ..Function::default()
    };
    let answers = call_in(context(), &prepared, &function, &[], 1);
    let twin = Twin::new(&prepared, film, seed, None);
    let world = twin.direct().world();
    let seen = surface_at_film(world, film, MIDDLE, Crossings::OPAQUE).unwrap();
    assert!(answers.vec3(0).next().unwrap().distance(seen.position) < 1e-6);
    assert_eq!(answers.u32(3).next().unwrap(), seen.primitive);
    assert!(answers.vec3(4).next().unwrap().distance(seen.normal) < 1e-6);
}
