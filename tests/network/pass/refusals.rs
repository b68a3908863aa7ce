//! Anything a pass cannot use is an error from `pass()` that explains what to change, never a panic
//! in the caller's frame. The test device panics on any validation error.

use wgdenoise::wgpu::{self, BufferUsages, TextureFormat as Texture, TextureUsages};
use wgdenoise::{
    Denoiser, Element, InputScale, Layout, NormalEncoding, Options, PassDescriptor, PassImage,
    PassLayer,
};

use crate::support::denoiser;
use wgdenoise_testing::gpu::gpu;
use wgdenoise_testing::image::descriptor;

const ALL: TextureUsages = TextureUsages::TEXTURE_BINDING.union(TextureUsages::STORAGE_BINDING);

fn texture(format: Texture, usage: TextureUsages) -> wgpu::Texture {
    gpu().device.create_texture(&descriptor([4, 4], format, usage))
}

fn storage(size: u64, usage: BufferUsages) -> wgpu::Buffer {
    let descriptor = wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
    gpu().device.create_buffer(&descriptor)
}

/// Valid images of 4×4 pixels.
struct Fitting {
    denoiser: Denoiser,
    color: wgpu::Texture,
    output: wgpu::Texture,
}

impl Fitting {
    fn new() -> Self {
        let [color, output] = [(); 2].map(|()| texture(Texture::Rgba16Float, ALL));
        Self { denoiser: denoiser(&Options::default()), color, output }
    }

    fn descriptor(&self) -> PassDescriptor<'_> {
        let [color, output] = [&self.color, &self.output].map(PassImage::Texture);
        PassDescriptor::new(4, 4, color, output)
    }

    #[track_caller]
    fn refuses(&self, descriptor: &PassDescriptor<'_>, words: &[&str]) {
        let error = self.denoiser.pass(descriptor).expect_err("it should be refused").to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    }
}

#[test]
fn the_images_of_these_tests_fit() {
    let fitting = Fitting::new();
    fitting.denoiser.pass(&fitting.descriptor()).unwrap();
}

#[test]
fn textures_of_a_wrong_format_or_usage_are_refused() {
    let fitting = Fitting::new();
    let fine = fitting.descriptor();
    let bytes = texture(Texture::Rgba8Unorm, TextureUsages::TEXTURE_BINDING);
    let signed = texture(Texture::Rgba8Snorm, TextureUsages::TEXTURE_BINDING);
    let [bytes, signed] = [&bytes, &signed].map(PassImage::Texture);
    let unread = texture(Texture::Rgba16Float, TextureUsages::STORAGE_BINDING);
    let unwritten = texture(Texture::Rgba16Float, TextureUsages::TEXTURE_BINDING);
    let [unread, unwritten] = [&unread, &unwritten].map(PassImage::Texture);
    let cases: [(PassDescriptor<'_>, &[&str]); 8] = [
        (fine.color(bytes), &["color", "Rgba8Unorm", "Rgba16Float or"]),
        (fine.output(bytes), &["output", "Rgba8Unorm", "Rgba32Float"]),
        (fine.albedo(signed), &["albedo", "Rgba8Snorm"]),
        (fine.normal(bytes), &["normal", "NormalEncoding::Unorm"]),
        (
            fine.normal(signed).normal_encoding(NormalEncoding::Unorm),
            &["normal", "Rgba8Snorm", "Rgb10a2Unorm"],
        ),
        (fine.color(unread), &["color", "TEXTURE_BINDING"]),
        (fine.albedo(unread), &["albedo", "TEXTURE_BINDING"]),
        (fine.output(unwritten), &["output", "STORAGE_BINDING"]),
    ];
    for (descriptor, words) in cases {
        fitting.refuses(&descriptor, words);
    }
}

#[test]
fn textures_of_another_size_or_shape_are_refused() {
    let fitting = Fitting::new();
    let fine = fitting.descriptor();
    let float = descriptor([4, 4], Texture::Rgba16Float, ALL);
    let wide = wgpu::Extent3d { width: 5, ..float.size };
    let wide = wgpu::TextureDescriptor { size: wide, ..float.clone() };
    let solid = wgpu::TextureDescriptor { dimension: wgpu::TextureDimension::D3, ..float.clone() };
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::RENDER_ATTACHMENT;
    let samples = wgpu::TextureDescriptor { sample_count: 4, usage, ..float };
    for (descriptor, word) in
        [(wide, "5×4 pixels, but the pass is 4×4"), (solid, "D3"), (samples, "4 samples a pixel")]
    {
        let texture = gpu().device.create_texture(&descriptor);
        let color = PassImage::Texture(&texture);
        fitting.refuses(&fine.color(color), &["color", word]);
    }
    for (width, word) in [(0, "at least 1"), (70_000, "at most 65536")] {
        let mut sized = fine;
        sized.width = width;
        fitting.refuses(&sized, &[word]);
    }
}

#[test]
fn buffers_that_do_not_fit_are_refused() {
    let fitting = Fitting::new();
    let fine = fitting.descriptor();
    let [enough, short] = [192, 188].map(|size| storage(size, BufferUsages::STORAGE));
    let unusable = storage(192, BufferUsages::COPY_DST);
    let f32 = |buffer, layout| PassImage::Buffer { buffer, element: Element::F32, layout };
    let halves = PassImage::Buffer {
        buffer: &enough,
        element: Element::F16,
        layout: Layout::new(50, 12, 3),
    };
    let rgb = Layout::packed(4);
    let cases = [
        (f32(&short, rgb), "needs a buffer of 192 bytes, found 188"),
        (f32(&enough, Layout::packed_rgba(4)), "needs a buffer of 256 bytes, found 192"),
        (halves, "needs a buffer of 196 bytes, found 192"),
        (f32(&unusable, rgb), "STORAGE"),
        (f32(&enough, Layout::new(0, 11, 3)), "overlap"),
        (f32(&enough, Layout::new(0, 14, 4)), "overlap"),
        (f32(&enough, Layout::new(0, 12, 2)), "overlap"),
        (f32(&enough, Layout::new(0, 12, 3).with_alpha()), "overlap"),
        (f32(&enough, Layout::new(0, u32::MAX, 3)), "kernels count to"),
    ];
    for (image, word) in cases {
        fitting.refuses(&fine.color(image), &["color", word]);
        fitting.refuses(&fine.output(image), &["output", word]);
    }
}

#[test]
fn motion_and_depth_that_no_pass_can_read_are_refused() {
    let fitting = Fitting::new();
    let fine = fitting.descriptor();
    let [motion, wide, depth, half] =
        [Texture::Rg16Float, Texture::Rgba32Float, Texture::R32Float, Texture::R16Float]
            .map(|format| texture(format, TextureUsages::TEXTURE_BINDING));
    let [motion, wide, depth, half] = [&motion, &wide, &depth, &half].map(PassImage::Texture);
    for (motion, depth) in [(motion, depth), (wide, half)] {
        fitting.denoiser.pass(&fine.motion(motion).depth(depth)).unwrap();
    }
    let buffer = storage(128, BufferUsages::STORAGE);
    let of = |layout| PassImage::Buffer { buffer: &buffer, element: Element::F32, layout };
    let two = |width, channels| of(Layout::packed_channels(width, channels));
    fitting.denoiser.pass(&fine.motion(two(4, 2)).depth(two(4, 1))).unwrap();
    let with = fine.motion(motion);
    let cases: [(PassDescriptor<'_>, &[&str]); 9] = [
        (fine.depth(depth), &["depth", "needs motion", "leave out depth"]),
        (fine.motion(depth), &["motion", "R32Float", "Rg16Float, Rg32Float"]),
        (with.depth(motion), &["depth", "Rg16Float", "R16Float or R32Float"]),
        (fine.motion(two(4, 1)), &["motion needs 2 to 4 channels", "has 1"]),
        (with.depth(of(Layout::default())), &["depth needs 1 to 4 channels", "has 0"]),
        (fine.color(two(4, 2)), &["color needs 3 to 4 channels", "has 2"]),
        (fine.motion(two(4, 3)), &["motion", "needs a buffer of 192 bytes, found 128"]),
        (fine.motion(of(Layout::new(0, 8, 1).with_channels(2))), &["motion", "overlap"]),
        (fine.motion(of(Layout::new(2, 8, 2).with_channels(2))), &["motion", "136 bytes"]),
    ];
    for (descriptor, words) in cases {
        fitting.refuses(&descriptor, words);
    }
    let layers = [PassLayer::new(fine.color, wide)];
    fitting.refuses(&with.layers(&layers), &["output of layer 0"]);
    let descriptor = descriptor([5, 4], Texture::Rg16Float, TextureUsages::TEXTURE_BINDING);
    let large = gpu().device.create_texture(&descriptor);
    fitting.refuses(&fine.motion(PassImage::Texture(&large)), &["motion", "5×4 pixels"]);
}

#[test]
fn rows_may_end_with_their_last_pixel() {
    let fitting = Fitting::new();
    let buffer = storage(256, BufferUsages::STORAGE);
    let layout = Layout::new(0, 15, 4);
    let color = PassImage::Buffer { buffer: &buffer, element: Element::F32, layout };
    fitting.denoiser.pass(&fitting.descriptor().color(color)).unwrap();
}

#[test]
fn an_output_in_place_of_an_input_needs_a_copy() {
    let fitting = Fitting::new();
    let fine = fitting.descriptor();
    let buffer = storage(192, BufferUsages::STORAGE);
    let layout = Layout::packed(4);
    let buffer = PassImage::Buffer { buffer: &buffer, element: Element::F32, layout };
    for image in [fine.output, buffer] {
        let words = ["COPY_SRC", "albedo and an output"];
        let descriptor = fine.albedo(image).output(image);
        fitting.refuses(&descriptor, &words);
    }
}

#[test]
fn an_input_scale_that_is_none_is_refused() {
    let fitting = Fitting::new();
    let fine = fitting.descriptor();
    for value in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let input_scale = InputScale::Value(value);
        fitting.refuses(&fine.input_scale(input_scale), &["input scale"]);
    }
    let (none, unusable) = (storage(0, BufferUsages::STORAGE), storage(4, BufferUsages::UNIFORM));
    for (buffer, word) in [(&none, "0 bytes"), (&unusable, "STORAGE")] {
        let input_scale = InputScale::Buffer(buffer);
        fitting.refuses(&fine.input_scale(input_scale), &["input scale", word]);
    }
    let shared = storage(256, BufferUsages::STORAGE);
    let layout = Layout::packed(4);
    let output = PassImage::Buffer { buffer: &shared, element: Element::F32, layout };
    let input_scale = InputScale::Buffer(&shared);
    fitting.refuses(&fine.output(output).input_scale(input_scale), &["a buffer of its own"]);
}

#[test]
fn images_of_another_device_are_refused() {
    let fitting = Fitting::new();
    let fine = fitting.descriptor();
    let request = gpu().adapter.request_device(&wgpu::DeviceDescriptor::default());
    let (other, _) = pollster::block_on(request).expect("the adapter gives a second device");
    let texture = other.create_texture(&descriptor([4, 4], Texture::Rgba16Float, ALL));
    let buffer = other.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 192,
        usage: BufferUsages::STORAGE,
        mapped_at_creation: false,
    });
    let layout = Layout::packed(4);
    let images = [
        PassImage::Texture(&texture),
        PassImage::Buffer { buffer: &buffer, element: Element::F32, layout },
    ];
    for image in images {
        let words = ["another device", "Denoiser::new"];
        fitting.refuses(&fine.color(image), &words);
        fitting.refuses(&fine.normal(image), &words);
        fitting.refuses(&fine.output(image), &words);
    }
    let input_scale = InputScale::Buffer(&buffer);
    fitting.refuses(&fine.input_scale(input_scale), &["input scale", "another device"]);
}

#[test]
fn destroyed_images_are_refused() {
    let fitting = Fitting::new();
    let (texture, buffer) =
        (texture(Texture::Rgba16Float, ALL), storage(192, BufferUsages::STORAGE));
    texture.destroy();
    buffer.destroy();
    let layout = Layout::packed(4);
    let buffer = PassImage::Buffer { buffer: &buffer, element: Element::F32, layout };
    for color in [PassImage::Texture(&texture), buffer] {
        fitting.refuses(&fitting.descriptor().color(color), &["color", "destroyed"]);
    }
}
