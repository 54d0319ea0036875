//! `shaders/kernel/direct.wesl`: which pixel an invocation works on. Its estimator is tested in
//! `tests/render/`.

use crate::support::floor_pixel;
use crate::support::shader::{Function, call_in};
use crate::support::{context, prepared_for};
use direkt::low_level::gpu::layout::{TILE, TILE_PIXELS, lane_pixel};
use direkt::scene::{FilmSize, LightSelection, Strategy};

/// Every pixel once, in tiles of 8 × 8, and nothing else within the image.
#[test]
fn tiles_cover_every_pixel_once() {
    let context = context();
    for (width, height) in [(1, 1), (63, 65), (8, 8), (9, 1), (1, 300), (640, 7)] {
        let mut scene = floor_pixel();
        scene.film = FilmSize { width, height };
        let prepared = prepared_for(scene, Strategy::MisPower, LightSelection::Power);
        let function = Function {
            imports: "import package::kernel::direct::pixel_of;",
            body: "let p = pixel_of(item / 64u, item % 64u); out_u32(0u, p.x); out_u32(1u, p.y);",
            outputs: 2,
            ..Function::default()
        };
        let tiles = width.div_ceil(TILE) * height.div_ceil(TILE);
        let count = (tiles * TILE_PIXELS) as usize;
        let answers = call_in(context, &prepared, &function, &[], count);
        let mut times = vec![0_u32; (width * height) as usize];
        for (item, (x, y)) in (0..).zip(answers.u32(0).zip(answers.u32(1))) {
            let (dx, dy) = lane_pixel(item % TILE_PIXELS);
            assert_eq!((x % TILE, y % TILE), (dx, dy), "lane {item}");
            if x < width && y < height {
                times[(y * width + x) as usize] += 1;
            }
        }
        assert!(
            times.iter().all(|&n| n == 1),
            "{width} x {height}: {times:?}"
        );
    }
}
