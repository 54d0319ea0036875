//! Lenses, projections and pixel filters that are refused, each with its field.

use super::files::refused;

#[track_caller]
fn says(message: String, expected: &str) {
    assert_eq!(message, format!("DIR/scene.toml: {expected}"));
}

#[test]
fn pixel_filters() {
    for (film, problem) in [
        (
            "filter = \"sinc\"",
            "film.filter: unknown value `sinc` (line 2); expected `box`, `tent`, `gaussian`, `blackman-harris`",
        ),
        (
            "filter_radius = 0",
            "film.filter_radius: is 0; expected pixels, above 0 and up to 32768",
        ),
        (
            "filter_stddev = 1",
            "film.filter_stddev: is given for the filter \"box\", which has none; expected filter = \"gaussian\"",
        ),
        (
            "filter = \"gaussian\"\nfilter_stddev = -1",
            "film.filter_stddev: is -1, of a filter of radius 1.5; expected pixels, from a thousandth of the radius to a thousand times it",
        ),
    ] {
        says(refused(&format!("[film]\n{film}\n")), problem);
    }
}

#[test]
fn lenses_and_orthographic_cameras() {
    let view = "[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n";
    let by_matrix = "[camera]\nmatrix = [[1,0,0,0],[0,1,0,0],[0,0,1,5],[0,0,0,1]]\nfov = 40\n";
    let shape = "[[shapes]]\ntype = \"sphere\"\nradius = 1\ncenter = [0, 0, 0]\n";
    for (camera, problem) in [
        (
            format!("{view}fov = 40\nlens_radius = -0.1\n"),
            "camera.lens_radius: is -0.1; expected a length, not negative; 0 is a pinhole",
        ),
        (
            format!("{view}fov = 40\nlens_radius = nan\n"),
            "camera.lens_radius: is nan (line 5); expected a finite number",
        ),
        (
            format!("{view}fov = 40\nfocus_distance = 0\n"),
            "camera.focus_distance: is 0; expected the distance of the plane that is sharp, above 0",
        ),
        (
            format!("{by_matrix}lens_radius = 0.1\n"),
            "camera.focus_distance: is missing, and there is no `target` that could be sharp; expected the distance from the eye, along the viewing direction, of the plane that is sharp",
        ),
        (
            format!("{view}fov = 40\nlens_radius = 1e19\n{shape}"),
            "camera.lens_radius: is 1e19 times the scene's size; expected at most 1e18 times",
        ),
        (
            format!("{view}fov = 40\nlens_radius = 1\nfocus_distance = 1e-30\n{shape}"),
            "camera.focus_distance: is 1e-30 times the scene's size; expected 1e-18 to 1e18 times",
        ),
        (
            format!("{view}type = \"fisheye\"\n"),
            "camera.type: unknown value `fisheye` (line 4); expected `perspective` or `orthographic`",
        ),
        (
            format!("{view}type = \"orthographic\"\n"),
            "camera: missing key `height`; expected the height of what is seen, above 0",
        ),
        (
            format!("{view}type = \"orthographic\"\nheight = 0\n"),
            "camera.height: is 0; expected the height of what is seen, above 0",
        ),
        (
            format!("{view}type = \"orthographic\"\nheight = 1\nfov = 40\n"),
            "camera.fov: is given for a camera of type \"orthographic\", which has none; expected `height`",
        ),
    ] {
        says(refused(&camera), problem);
    }
}
