//! Lost devices, large images, small bindings, empty scenes: HARD CASES P4, P5, P6, L3, I4.

use crate::support::hard_cases::{Measured, survive};
use crate::support::{context, floor_pixel, point_light, prepared, scene, take};
use direkt::error::{Error, GpuError};
use direkt::low_level::gpu::Context;
use direkt::low_level::gpu::context::adapters;
use direkt::low_level::prepare::Prepared;
use direkt::low_level::render::{
    Film, RayCounts, Session, render_keeping_image, render_through_losses,
};
use direkt::scene::{FilmSize, Geometry, Sampler};
use glam::DVec3;

/// The floor under a point light: every pixel is the same.
fn floor(width: u32, height: u32) -> Prepared {
    let mut scene = floor_pixel();
    scene
        .lights
        .push(point_light(DVec3::new(0.0, 0.0, 2.0), 100.0));
    scene.film = FilmSize { width, height };
    prepared(scene)
}

/// A device is destroyed in the middle of the first block, again before anything is saved in the
/// second, and in the third.
#[test]
fn a_render_outlives_its_devices() {
    const SPP: u64 = 640;
    let mut cornell = scene("scenes/cornell.toml");
    cornell.render.estimator.sampler = Sampler::Sobol;
    cornell.film = FilmSize {
        width: 40,
        height: 30,
    };
    let prepared = prepared(cornell);
    let context = context();
    let new = |context| Session::new(context, &prepared, prepared.film, 0).unwrap();
    let mut unbroken = new(context);
    take(&mut unbroken, SPP);
    let expected = unbroken.snapshot().unwrap();

    let mut destroyed_at = vec![(600, true), (300, false), (100, true)];
    let mut told = Vec::new();
    let open = || Context::new(None);
    let work = |session: &mut Session<'_>| -> Result<(Film, RayCounts), Error> {
        while session.samples() < SPP {
            session.pass(20.min(SPP - session.samples()), || false)?;
            if let Some((_, saved)) = destroyed_at.pop_if(|(at, _)| session.samples() >= *at) {
                if saved {
                    session.save()?;
                }
                session.context().device.destroy();
            }
        }
        Ok(session.snapshot()?)
    };
    let found = render_through_losses(open, &prepared, work, |error, samples| {
        assert!(matches!(error, GpuError::Lost { .. }), "{error}");
        told.push(samples);
    })
    .unwrap();
    assert_eq!(told, [100, 256, 612]);
    assert!(destroyed_at.is_empty());
    assert_eq!(found.1, expected.1);

    let mut anew = new(context);
    take(&mut anew, SPP - 612);
    let differ = |film: &Film| {
        let pixels = film.pixels.iter().zip(&expected.0.pixels);
        pixels.filter(|(a, b)| a != b).count() as f64
    };
    survive(
        context,
        Measured {
            entry: "P6",
            case: "a device lost three times within 640 samples per pixel",
            figure: "pixels that are not bit for bit those of an unbroken render",
            bound: 0.0,
            textbook: "the rest of the samples on the next device",
            naive: differ(&anew.snapshot().unwrap().0),
            ours: differ(&found.0),
        },
    );
}

/// Devices that are lost without a sample between them are given up.
#[test]
fn a_device_that_is_lost_again_and_again_is_an_error() {
    let prepared = floor(8, 8);
    let mut opened = 0;
    let open = || {
        opened += 1;
        Context::new(None)
    };
    let work = |session: &mut Session<'_>| -> Result<(), Error> {
        session.context().device.destroy();
        session.pass(1, || false)?;
        Ok(())
    };
    let error = render_through_losses(open, &prepared, work, |_, _| ()).unwrap_err();
    assert!(error.to_string().contains("the device was lost"), "{error}");
    assert_eq!((opened, error.exit_code()), (3, 1));
}

/// What was rendered before a device was given up is the image of those samples.
#[test]
fn a_render_that_fails_keeps_its_image() {
    let prepared = floor(8, 8);
    let work = |session: &mut Session<'_>| -> Result<(), Error> {
        while session.samples() < 300 {
            session.pass(300 - session.samples(), || false)?;
        }
        session.context().device.destroy();
        session.pass(1, || false)?;
        Ok(())
    };
    let failed = render_keeping_image(|| Context::new(None), &prepared, work, |_, _| ());
    let failure = failed.unwrap_err();
    assert_eq!(failure.error.exit_code(), 1);
    let (film, rays) = *failure.image.unwrap();
    // One block is on the host; 44 samples were on the device.
    assert_eq!((film.sample_range(), rays.camera), ((256, 256), 256 * 64));
    let context = context();
    let mut right = Session::new(context, &prepared, prepared.film, 0).unwrap();
    take(&mut right, 256);
    assert_eq!(film.pixels, right.snapshot().unwrap().0.pixels);

    let never = |_: &mut Session<'_>| -> Result<(), Error> { unreachable!("there is no device") };
    let none = || Err(GpuError::NoAdapter);
    let failed = render_keeping_image(none, &prepared, never, |_, _| ());
    assert!(failed.unwrap_err().image.is_none());
}

/// Pixels of an image of `size` that have not exactly `samples` samples or not the floor's
/// radiance.
fn wrong_pixels(context: &Context, (width, height): (u32, u32), samples: u64) -> usize {
    let prepared = floor(width, height);
    let mut session = Session::new(context, &prepared, prepared.film, 0).unwrap();
    take(&mut session, samples);
    let (film, _) = session.snapshot().unwrap();
    assert_eq!(film.pixels.len(), (width * height) as usize);
    let right = |mean: f64| (mean / 3.978_873_577 - 1.0).abs() < 1e-3;
    let pixels = film.pixels.iter();
    pixels
        .filter(|p| p.samples != samples || !right(p.mean[0]))
        .count()
}

fn default_limits() -> Context {
    Context::open_with(&adapters()[0], wgpu::Limits::default()).unwrap()
}

#[test]
fn large_images_fit_the_least_limits() {
    let context = &default_limits();
    let sizes = [(16_384, 16), (3840, 2160), (4096, 2160)];
    let wrong: usize = sizes
        .map(|size| wrong_pixels(context, size, 1))
        .iter()
        .sum();
    // What an unbroken image gives: the same in regions of any size.
    let mut cornell = scene("scenes/cornell.toml");
    cornell.film = FilmSize {
        width: 600,
        height: 40,
    };
    let prepared = prepared(cornell);
    let film = |tiles| {
        let size = prepared.film;
        let mut session = Session::in_regions(context, &prepared, size, 0, tiles).unwrap();
        take(&mut session, 3);
        session.snapshot().unwrap()
    };
    let whole = film(1 << 14);
    for tiles in [1, 7, 375 / 2] {
        assert_eq!(film(tiles), whole, "{tiles} tiles in a region");
    }
    let largest = floor(4096, 2160);
    let in_one = Session::in_regions(context, &largest, largest.film, 0, u32::MAX);
    survive(
        context,
        Measured {
            entry: "P4",
            case: "16384 × 16, 3840 × 2160 and 4096 × 2160 pixels on WebGPU's default limits",
            figure: "pixels without their sample",
            bound: 0.0,
            textbook: "all pixels in one buffer",
            naive: in_one.map_or(4096.0 * 2160.0, |_| 0.0),
            ours: wrong as f64,
        },
    );
}

#[test]
fn every_pixel_has_an_invocation() {
    let context = &default_limits();
    let sizes = [(1, 1), (63, 65), (2048, 2048)];
    let wrong: usize = sizes
        .map(|size| wrong_pixels(context, size, 1))
        .iter()
        .sum();
    let groups = context.limits.max_compute_workgroups_per_dimension;
    survive(
        context,
        Measured {
            entry: "P5",
            case: "1 × 1, 63 × 65 and 2048 × 2048 pixels",
            figure: "pixels without their sample",
            bound: 0.0,
            textbook: "one dispatch of 64 invocations per group, one-dimensional",
            naive: f64::from((2048_u32 * 2048).saturating_sub(64 * groups)),
            ours: wrong as f64,
        },
    );
}

#[test]
fn a_scene_that_does_not_fit_a_binding_is_refused_by_name() {
    let limits = wgpu::Limits {
        max_storage_buffer_binding_size: 1 << 20,
        ..wgpu::Limits::default()
    };
    let context = &Context::open_with(&adapters()[0], limits).unwrap();
    let mut scene = floor_pixel();
    let Geometry::Rectangle { corner, u, v } = scene.shapes[0].geometry else {
        panic!("the floor is a rectangle");
    };
    for i in 0..30_000 {
        let mut shape = scene.shapes[0].clone();
        shape.geometry = Geometry::Rectangle {
            corner: corner - DVec3::Z * f64::from(i + 1) * 1e-4,
            u,
            v,
        };
        scene.shapes.push(shape);
    }
    let prepared = prepared(scene);
    let error = Session::new(context, &prepared, prepared.film, 0).unwrap_err();
    let GpuError::TooLarge {
        what,
        needed,
        limit,
        ..
    } = &error
    else {
        panic!("{error}");
    };
    assert!(!what.is_empty() && *limit == 1 << 20, "{error}");
    survive(
        context,
        Measured {
            entry: "L3",
            case: "30,001 rectangles on an adapter that binds 1 MiB",
            figure: "bytes bound in one buffer",
            bound: *limit as f64,
            textbook: "a buffer as large as the scene",
            naive: *needed as f64,
            ours: 0.0,
        },
    );
}
