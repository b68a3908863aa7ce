//! The `wgdenoise` command can read the path tracer's files.

use wgdenoise_files::{LayerChoice, Picture};

use path_tracer::exr::{ALBEDO, COLOR, NORMAL, write};

/// A different value in every pixel, channel and layer.
fn pixels(layer: u8) -> Vec<[f32; 4]> {
    let at = |i: u8| std::array::from_fn(|c| f32::from(layer) + f32::from(i * 4 + c as u8) / 256.0);
    (0..6).map(at).collect()
}

fn rgb(pixels: &[[f32; 4]]) -> Vec<[f32; 3]> {
    pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect()
}

#[test]
fn the_command_line_finds_all_layers_by_their_names() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("layers.exr");
    let [color, albedo, normal] = [0, 1, 2].map(pixels);
    let layers = [
        (COLOR.0, COLOR.1, &color[..]),
        (ALBEDO.0, ALBEDO.1, &albedo),
        (NORMAL.0, NORMAL.1, &normal),
    ];
    write(&path, [3, 2], &layers).expect("the file is written");
    let picture = Picture::open(&path, &LayerChoice::default()).expect("the file is read");
    let picture = picture.first();
    assert_eq!(picture.color().size(), (3, 2));
    assert_eq!(picture.color().pixels(), rgb(&color));
    assert_eq!(picture.albedo().expect("an albedo").pixels(), rgb(&albedo));
    assert_eq!(picture.normal().expect("a normal").pixels(), rgb(&normal));
}

#[test]
fn a_folder_that_is_not_there_is_named() {
    let path = std::path::Path::new("no/such/folder/picture.exr");
    let error = write(path, [3, 2], &[(COLOR.0, COLOR.1, &pixels(0))]).unwrap_err();
    assert!(error.to_string().contains("no/such/folder"), "{error}");
}
