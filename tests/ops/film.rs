//! Sequences of denoised frames of any scene and format, and the GPU's results for them.

use wgdenoise::internals::gpu::kernel::Dispatch;
use wgdenoise::internals::ops::accumulate::{Features, FrameImages, History, accumulate};
use wgdenoise::internals::ops::accumulate_layer::{
    LayerCalls, LayerHistory, LayerImages, accumulate_layer,
};
use wgdenoise::internals::ops::image::{Element, ImageBinding, ImageFormat};
use wgdenoise::internals::ops::tile::{Layout, Tile};
use wgdenoise::wgpu::TextureFormat as Texture;
use wgdenoise::{PassImage, Precision, wgpu};

use crate::image::{binding, view};
use wgdenoise_testing::Random;
use wgdenoise_testing::gpu::{buffer, context, submit};
use wgdenoise_testing::image::{GpuImage, Pixel, quantized};

pub(crate) const F32: ImageFormat = ImageFormat::Buffer(Element::F32);
pub(crate) const F16: ImageFormat = ImageFormat::Buffer(Element::F16);

/// A format, with its layout if it is in a buffer.
pub(crate) type Stored = (ImageFormat, Layout);

pub(crate) fn texture(format: Texture) -> Stored {
    (ImageFormat::Texture(format), Layout::default())
}

/// A frame of any scene: its denoised light and its surfaces' features.
#[derive(Clone)]
pub(crate) struct Frame {
    pub(crate) denoised: Vec<Pixel>,
    pub(crate) motion: Vec<Pixel>,
    pub(crate) albedo: Vec<Pixel>,
    pub(crate) normal: Vec<Pixel>,
    pub(crate) depth: Vec<Pixel>,
    /// Further layers of the denoised light.
    pub(crate) layers: Vec<Vec<Pixel>>,
}

/// The storage formats of a frame's images; those without a format are absent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Formats {
    pub(crate) motion: Stored,
    pub(crate) albedo: Option<Stored>,
    pub(crate) normal: Option<Stored>,
    pub(crate) unorm: bool,
    pub(crate) depth: Option<Stored>,
    pub(crate) output: Stored,
    /// Format of each layer's result.
    pub(crate) layer: Stored,
}

/// Sizes of small images, each with every set of features for [`Formats::with_features`].
pub(crate) fn sizes_and_features() -> impl Iterator<Item = ([u32; 2], u32)> {
    let sizes = [[1, 1], [2, 5], [8, 8], [17, 9]];
    sizes.into_iter().flat_map(|size| (0..8).map(move |set| (size, set)))
}

impl Formats {
    /// [`all`](Self::all), but of albedo, normal and depth only those whose bit is set.
    pub(crate) fn with_features(width: u32, set: u32) -> Self {
        let all = Self::all(width);
        Self {
            albedo: all.albedo.filter(|_| set & 1 != 0),
            normal: all.normal.filter(|_| set & 2 != 0),
            depth: all.depth.filter(|_| set & 4 != 0),
            ..all
        }
    }

    /// All images, in buffers of 32-bit floats without gaps.
    pub(crate) fn all(width: u32) -> Self {
        let packed = |channels| (F32, Layout::packed_channels(width, channels));
        Self {
            motion: packed(2),
            albedo: Some(packed(3)),
            normal: Some(packed(3)),
            unorm: false,
            depth: Some(packed(1)),
            output: packed(4),
            layer: packed(4),
        }
    }

    pub(crate) fn light_alone(width: u32) -> Self {
        Self { albedo: None, normal: None, depth: None, ..Self::all(width) }
    }
}

/// Rounds to 8-bit steps; means of nine are far from rounding ties.
fn byte(v: f32) -> f32 {
    (v * 127.0).round()
}

impl Frame {
    /// A random frame that partly agrees with others: its differences are around the scales of
    /// agreement.
    pub(crate) fn random(random: &mut Random, [width, height]: [u32; 2]) -> Self {
        let mut pixels = |value: &mut dyn FnMut(&mut Random) -> Pixel| -> Vec<Pixel> {
            (0..width * height).map(|_| value(random)).collect()
        };
        let frame = Self {
            denoised: pixels(&mut |r| [0; 4].map(|_| 1.0 + 0.4 * r.value())),
            motion: pixels(&mut |r| [0; 4].map(|_| 3.0 * r.value())),
            albedo: pixels(&mut |r| [0; 4].map(|_| byte(0.5 + 0.4 * r.value()) * 2.0 / 255.0)),
            normal: pixels(&mut |r| [0; 4].map(|_| byte(0.7 * r.value()) / 127.0)),
            depth: pixels(&mut |r| [10.0 + r.value() + f32::from(r.value() < -0.8) * 1e9; 4]),
            layers: Vec::new(),
        };
        frame.before_a_sky(width)
    }

    /// Adds layers of light in [−1, 1).
    pub(crate) fn with_layers(mut self, random: &mut Random, count: usize) -> Self {
        let pixels = self.denoised.len();
        let mut layer = || (0..pixels).map(|_| [0; 4].map(|_| random.value())).collect();
        self.layers = (0..count).map(|_| layer()).collect();
        self
    }

    /// Makes rays hit nothing in the right third.
    fn before_a_sky(mut self, width: u32) -> Self {
        let rows = self.depth.chunks_exact_mut(width as usize);
        rows.for_each(|row| row[2 * width as usize / 3..].fill([f32::INFINITY; 4]));
        self
    }

    /// Adds pixels that no renderer should store, but some do.
    pub(crate) fn with_broken_pixels(mut self) -> Self {
        let broken = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30];
        for (i, v) in broken.into_iter().enumerate() {
            self.motion[3 * i][0] = v;
            self.motion[3 * i + 1][1] = v;
            self.depth[2 * i + 9] = [v.min(1e12); 4];
        }
        self.depth[4] = [0.0; 4];
        self.depth[30] = [-1.0; 4];
        self
    }

    /// The frame after rounding to the formats.
    pub(crate) fn stored(&self, formats: &Formats) -> Self {
        let of = |pixels: &[Pixel], stored: Option<Stored>| {
            stored.map_or(Vec::new(), |(format, _)| quantized(pixels, format))
        };
        let normal = of(&formats.encoded(&self.normal), formats.normal);
        Self {
            denoised: self.denoised.clone(),
            motion: of(&self.motion, Some(formats.motion)),
            albedo: of(&self.albedo, formats.albedo),
            normal: if formats.unorm { decoded(&normal) } else { normal },
            depth: of(&self.depth, formats.depth),
            layers: self.layers.clone(),
        }
    }
}

impl Formats {
    fn encoded(&self, normals: &[Pixel]) -> Vec<Pixel> {
        let encode = |normal: &Pixel| normal.map(|v| if self.unorm { 0.5 * v + 0.5 } else { v });
        normals.iter().map(encode).collect()
    }
}

fn decoded(normals: &[Pixel]) -> Vec<Pixel> {
    normals.iter().map(|normal| normal.map(|v| 2.0 * v - 1.0)).collect()
}

/// A sequence of frames on the GPU, with the histories between frames.
pub(crate) struct Sequence {
    size: [u32; 2],
    formats: Formats,
    input_scale: f32,
    histories: Option<(History, Vec<LayerHistory>)>,
}

impl Sequence {
    pub(crate) fn new(size: [u32; 2], formats: Formats, input_scale: f32) -> Self {
        Self { size, formats, input_scale, histories: None }
    }

    /// The result of the next frame.
    pub(crate) fn next(&mut self, frame: &Frame) -> Vec<Pixel> {
        self.next_with_layers(frame).swap_remove(0)
    }

    /// The result of the next frame, and that of each layer.
    pub(crate) fn next_with_layers(&mut self, frame: &Frame) -> Vec<Vec<Pixel>> {
        let (size, Formats { output, layer, .. }) = (self.size, self.formats);
        let gpu = |pixels: &[Pixel], (format, layout)| GpuImage::new(pixels, size, format, layout);
        let motion = gpu(&frame.motion, self.formats.motion);
        let albedo = self.formats.albedo.map(|stored| gpu(&frame.albedo, stored));
        let normals = self.formats.encoded(&frame.normal);
        let normal = self.formats.normal.map(|stored| gpu(&normals, stored));
        let depth = self.formats.depth.map(|stored| gpu(&frame.depth, stored));
        let denoised = gpu(&frame.denoised, texture(Texture::Rgba32Float));
        let empty = vec![[-1.5; 4]; frame.motion.len()];
        let outputs = [output].into_iter().chain(frame.layers.iter().map(|_| layer));
        let outputs: Vec<_> = outputs.map(|stored| gpu(&empty, stored)).collect();
        let features =
            [&albedo, &normal, &depth].map(|image| image.as_ref().map(GpuImage::as_pass));
        let features = features.map(Bound::new);
        let [motion, denoised] =
            [&motion, &denoised].map(|image| Bound::new(Some(image.as_pass())));
        let bound: Vec<_> = outputs.iter().map(|image| Bound::new(Some(image.as_pass()))).collect();
        self.run(frame, [&motion, &denoised], &features, &bound);
        assert!(outputs.iter().all(GpuImage::gaps_are_untouched), "a gap was written to");
        outputs.iter().map(|output| output.read(|_| {})).collect()
    }

    fn run(
        &mut self,
        frame: &Frame,
        [motion, denoised]: [&Bound<'_>; 2],
        features: &[Bound<'_>; 3],
        outputs: &[Bound<'_>],
    ) {
        let context = context(Precision::F32);
        let layout = |bound: &Bound<'_>| bound.layout();
        let [albedo, normal, depth] = features;
        let tile = Tile {
            image_size: self.size,
            motion: layout(motion),
            albedo: layout(albedo),
            normal: layout(normal),
            depth: layout(depth),
            ..Tile::default()
        };
        let tiles = outputs.iter().map(|output| Tile { output: layout(output), ..tile });
        let tiles: Vec<_> = tiles.map(|tile| buffer(context, bytemuck::bytes_of(&tile))).collect();
        let images = FrameImages {
            tile: &tiles[0],
            denoised: denoised.view.as_ref().expect("it is a texture"),
            motion: motion.binding().expect("there is motion"),
            albedo: albedo.binding(),
            normal: normal.binding(),
            unorm_normal: self.formats.unorm,
            depth: depth.binding(),
            input_scale: &buffer(context, bytemuck::bytes_of(&self.input_scale)),
            output: outputs[0].binding().expect("there is an output"),
        };
        let size = self.size;
        let (history, layers) = self.histories(frame);
        let call = accumulate(context, size, &images, history);
        let calls =
            layers.iter().zip(&tiles[1..]).zip(&outputs[1..]).map(|((own, tile), output)| {
                let output = output.binding().expect("there is an output");
                let images = LayerImages { tile, motion: images.motion, output };
                accumulate_layer(context, size, &images, own, history)
            });
        let calls: Vec<_> = calls.collect();
        for (history, pixels) in layers.iter().zip(&frame.layers) {
            let ImageBinding::Buffer { buffer, .. } = history.denoised() else { unreachable!() };
            context.queue.write_buffer(buffer, 0, bytemuck::cast_slice(pixels));
        }
        submit_frame(&call, &calls, (history, layers));
    }

    /// The last frame's histories, or new ones.
    fn histories(&mut self, frame: &Frame) -> &(History, Vec<LayerHistory>) {
        let device = &context(Precision::F32).device;
        let pixels = self.size.into_iter().map(u64::from).product();
        let Formats { albedo, normal, depth, .. } = self.formats;
        let features =
            Features { albedo: albedo.is_some(), normal: normal.is_some(), depth: depth.is_some() };
        self.histories.get_or_insert_with(|| {
            let layers = frame.layers.iter().map(|_| LayerHistory::new(device, pixels));
            let layers: Vec<_> = layers.collect();
            (History::new(device, pixels, features, !layers.is_empty()), layers)
        })
    }
}

fn submit_frame(
    call: &Dispatch,
    layers: &[LayerCalls],
    (history, histories): (&History, &[LayerHistory]),
) {
    let context = context(Precision::F32);
    submit(context, |pass| {
        for layer in layers {
            layer.soften.record_at(pass, 0);
        }
        call.record_at(pass, 0);
        for layer in layers {
            layer.average.record_at(pass, 0);
        }
    });
    let mut encoder = context.device.create_command_encoder(&Default::default());
    history.advance(&mut encoder);
    for history in histories {
        history.advance(&mut encoder);
    }
    context.queue.submit([encoder.finish()]);
}

/// An optional image, with its view if it is a texture.
struct Bound<'a> {
    image: Option<PassImage<'a>>,
    view: Option<wgpu::TextureView>,
}

impl<'a> Bound<'a> {
    fn new(image: Option<PassImage<'a>>) -> Self {
        Self { image, view: image.as_ref().and_then(view) }
    }

    fn binding(&'a self) -> Option<ImageBinding<'a>> {
        self.image.as_ref().map(|image| binding(image, self.view.as_ref()))
    }

    fn layout(&self) -> Layout {
        match self.image {
            Some(PassImage::Buffer { layout, .. }) => layout,
            _ => Layout::default(),
        }
    }
}
