//! Frames whose left and right edges join.

use wgdenoise::internals::plan::halo::halo;
use wgdenoise::{Image, Inputs, KernelSet, Options, Precision};

use crate::support::{
    denoiser_of, frame, images, same_bits, tiny, tiny_demodulation, tiny_kernels,
};

/// A multiple of the networks' alignment, so that rotation does not shift pooling windows.
const SIZE: [u32; 2] = [96, 40];

/// The image rotated by some columns.
fn turned(image: &Image, columns: usize) -> Image {
    let mut image = image.clone();
    let width = image.width() as usize;
    image.pixels_mut().chunks_exact_mut(width).for_each(|row| row.rotate_left(columns));
    image
}

#[test]
fn a_turned_panorama_becomes_the_turned_result() {
    for weights in [tiny(), tiny_kernels(), tiny_demodulation()] {
        let options = Options::default().kernels(KernelSet::Tiled).precision(Precision::F32);
        let denoiser = denoiser_of(&weights, &options);
        let images = images(SIZE[0], SIZE[1]);
        let turned_images = images.each_ref().map(|image| turned(image, 48));
        let denoise = |images: &[Image; 3], panorama| {
            let frame = frame(images, Inputs::ALL).panorama(panorama);
            let result = denoiser.denoise(&frame).expect("the frame is fine");
            assert!(denoiser.verify(&frame, &result).expect("it is right").is_some());
            result
        };
        let expected = turned(&denoise(&images, true), 48);
        same_bits(&denoise(&turned_images, true), &expected).unwrap();
        // Without `panorama`, the result differs.
        same_bits(&denoise(&turned_images, false), &expected).unwrap_err();
    }
}

#[test]
fn alpha_is_settled_across_the_seam() {
    let denoiser = denoiser_of(&tiny_kernels(), &Options::default().precision(Precision::F32));
    let images = images(SIZE[0], SIZE[1]);
    let turned_images = images.each_ref().map(|image| turned(image, 48));
    // Clear on one side of the seam, noisy on the other.
    let alpha: Vec<_> = images[1].pixels().iter().map(|pixel| pixel[0].min(1.0)).collect();
    let alpha: Vec<_> =
        (0..).zip(alpha).map(|(i, a)| if i % SIZE[0] < 48 { 1.0 } else { a }).collect();
    let mut turned_alpha = alpha.clone();
    turned_alpha.chunks_exact_mut(SIZE[0] as usize).for_each(|row| row.rotate_left(48));
    let denoise = |images: &[Image; 3], alpha: &[f32]| {
        let frame = frame(images, Inputs::ALL).panorama(true).alpha(Some(alpha));
        let found = denoiser.denoise_layers(&frame, &mut |_| {}).expect("the frame is fine");
        assert!(denoiser.verify(&frame, &found.color).expect("it is right").is_some());
        (found.color, found.alpha.expect("the frame has alpha"))
    };
    let (color, mut found_alpha) = denoise(&images, &alpha);
    found_alpha.chunks_exact_mut(SIZE[0] as usize).for_each(|row| row.rotate_left(48));
    let (turned_color, turned_alpha) = denoise(&turned_images, &turned_alpha);
    same_bits(&turned_color, &turned(&color, 48)).unwrap();
    assert_eq!(turned_alpha, found_alpha);
}

#[test]
fn a_panorama_is_as_much_larger_as_its_pixels_see_beyond_both_edges() {
    let (weights, images) = (tiny_kernels(), images(SIZE[0], SIZE[1]));
    let denoiser = denoiser_of(&weights, &Options::default());
    let columns = halo(weights.network()).next_multiple_of(16);
    let size = |panorama| {
        denoiser.size_with_columns(&frame(&images, Inputs::ALL).panorama(panorama)).unwrap()
    };
    assert_eq!(size(true), (SIZE[0] + 2 * columns, SIZE[1]));
    assert_eq!(size(false), (SIZE[0], SIZE[1]));
}
