//! Tiles delivered on the GPU while a frame is denoised.

use std::time::{Duration, Instant};

use wgdenoise::wgpu::{self, BufferUsages as Usage};
use wgdenoise::{FinishedTile, Image, Inputs, Options, Precision, Progress, Rect};

use crate::support::{denoiser_of, frame, images, same_bits, tiny_kernels};
use wgdenoise_testing::gpu::{context, gpu, read_back};

const SIZE: [u32; 2] = [133, 67];
const PIXEL_BYTES: u64 = 12;

/// An image on the GPU, assembled from tiles.
struct Canvas(wgpu::Buffer);

impl Canvas {
    fn new() -> Self {
        Self(gpu().device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(SIZE[0] * SIZE[1]) * PIXEL_BYTES,
            usage: Usage::COPY_DST | Usage::COPY_SRC,
            mapped_at_creation: false,
        }))
    }

    /// Copies the tile's rows.
    fn add(&self, tile: &FinishedTile<'_>) {
        let mut encoder = gpu().device.create_command_encoder(&Default::default());
        let Rect { begin: [left, top], .. } = tile.rect;
        let [width, height] = tile.rect.size();
        for row in 0..height {
            let from = u64::from(tile.first + row * tile.stride) * PIXEL_BYTES;
            let to = u64::from((top + row) * SIZE[0] + left) * PIXEL_BYTES;
            let bytes = u64::from(width) * PIXEL_BYTES;
            encoder.copy_buffer_to_buffer(tile.buffer, from, &self.0, to, bytes);
        }
        gpu().queue.submit([encoder.finish()]);
    }

    fn image(&self) -> Image {
        let size = self.0.size();
        let bytes = read_back(context(Precision::F32), size, |encoder, buffer| {
            encoder.copy_buffer_to_buffer(&self.0, 0, buffer, 0, size);
        });
        Image::new(SIZE[0], SIZE[1], bytemuck::pod_collect_to_vec(&bytes)).unwrap()
    }
}

#[test]
fn finished_tiles_make_up_the_image() {
    let images = images(SIZE[0], SIZE[1]);
    for panorama in [false, true] {
        for tile in [None, Some(80)] {
            let denoiser = denoiser_of(&tiny_kernels(), &Options::default().tile(tile));
            let (canvas, mut area) = (Canvas::new(), 0);
            let frame = frame(&images, Inputs::ALL).panorama(panorama);
            let mut seen = |step: Progress<'_>| {
                if let Some(tile) = step.tile {
                    canvas.add(&tile);
                    area += tile.rect.size().iter().product::<u32>();
                }
            };
            let denoised = denoiser.denoise_layers(&frame, &mut seen).unwrap();
            assert_eq!(area, SIZE[0] * SIZE[1], "every pixel once");
            same_bits(&canvas.image(), &denoised.color).unwrap();
        }
    }
}

#[test]
fn the_networks_time_rises_tile_by_tile_within_the_whole_time() {
    let images = images(SIZE[0], SIZE[1]);
    let denoiser = denoiser_of(&tiny_kernels(), &Options::default().tile(80));
    let (mut times, begin) = (Vec::new(), Instant::now());
    let mut seen = |step: Progress<'_>| times.push((step.network_time, step.tile.is_some()));
    denoiser.denoise_layers(&frame(&images, Inputs::ALL), &mut seen).unwrap();
    assert!(times.is_sorted_by_key(|step| step.0) && times[0].0 > Duration::ZERO, "{times:?}");
    assert!(times.last().unwrap().0 < begin.elapsed(), "{times:?}");
    let tiles: Vec<_> = times.iter().filter(|step| step.1).map(|step| step.0).collect();
    assert!(tiles.len() > 1 && tiles.is_sorted_by(|a, b| a < b), "each tile takes time: {tiles:?}");
}
