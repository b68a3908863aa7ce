//! Outputs that overwrite an input.

use wgdenoise::wgpu::TextureFormat as Texture;
use wgdenoise::{Element, ImageFormat, Inputs, Layout, Options};

use super::{F32, Scene};
use crate::support::{denoiser, frame, images};
use wgdenoise_testing::image::GpuImage;
use wgdenoise_testing::run_cases;

fn formats() -> [(ImageFormat, Layout); 4] {
    [
        (ImageFormat::Texture(Texture::Rgba16Float), Layout::default()),
        (ImageFormat::Texture(Texture::Rgba32Float), Layout::default()),
        (F32, Layout::new(301, 371, 4)),
        (ImageFormat::Buffer(Element::F16), Layout::packed(90)),
    ]
}

#[test]
fn the_output_may_be_the_color_itself() {
    run_cases(formats(), |&case| check(case, |scene| &scene.color));
}

#[test]
fn the_output_may_be_the_albedo() {
    run_cases(formats(), |&case| check(case, |scene| scene.albedo.as_ref().expect("it is there")));
}

/// Uses tiles, so that one tile would read what another has overwritten.
fn check(
    (format, layout): (ImageFormat, Layout),
    place: fn(&Scene) -> &GpuImage,
) -> Result<(), String> {
    let images = images(90, 70);
    let denoiser = denoiser(&Options::default().tile(80));
    let scene = Scene::new(&frame(&images, Inputs::ALL), format, layout);
    let expected = scene.run(&denoiser);
    let descriptor = scene.descriptor().output(place(&scene).as_pass());
    let pass = denoiser.pass(&descriptor).map_err(|error| error.to_string())?;
    let found = place(&scene).read(|encoder| pass.encode(encoder));
    if bits(&found) == bits(&expected) { Ok(()) } else { Err("the result differs".into()) }
}

/// The second frame denoises the output of the first.
#[test]
fn a_pass_in_place_reads_what_stands_there_in_each_frame() {
    let images = images(90, 70);
    let denoiser = denoiser(&Options::default());
    let scene = Scene::new(&frame(&images, Inputs::ALL), F32, Layout::packed(90));
    let descriptor = scene.descriptor().output(scene.color.as_pass());
    let pass = denoiser.pass(&descriptor).unwrap();
    let once = scene.color.read(|encoder| pass.encode(encoder));
    let twice = scene.color.read(|encoder| pass.encode(encoder));
    let again = Scene::new(&frame(&images, Inputs::ALL), F32, Layout::packed(90));
    let both = denoiser
        .pass(&again.descriptor().output(again.color.as_pass()))
        .map(|pass| again.color.read(|encoder| (0..2).for_each(|_| pass.encode(encoder))))
        .unwrap();
    assert_ne!(bits(&once), bits(&twice), "the second frame changed nothing");
    assert_eq!(bits(&twice), bits(&both));
}

fn bits(pixels: &[[f32; 4]]) -> Vec<[u32; 3]> {
    pixels.iter().map(|&[r, g, b, _]| [r, g, b].map(f32::to_bits)).collect()
}
