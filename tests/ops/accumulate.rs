//! The operator against its reference.

use wgdenoise::internals::gpu::kernel::Dispatch;
use wgdenoise::internals::ops::accumulate::{FrameImages, History, accumulate};
use wgdenoise::internals::ops::image::{Element, ImageFormat};
use wgdenoise::internals::ops::tile::{Layout, Tile};
use wgdenoise::internals::reference;
use wgdenoise::wgpu::TextureFormat as Texture;
use wgdenoise::{PassImage, Precision, wgpu};

use crate::image::{binding, view};
use wgdenoise_testing::gpu::{buffer, context, submit};
use wgdenoise_testing::image::{GpuImage, Pixel, cpu_image, quantized};
use wgdenoise_testing::{Random, Tolerance, compare, image_tensor, run_cases};

/// Light is between 0 and 2. Sums of 16 to 27 terms round the differences that agreement is made of
/// by up to 2⁻²¹; over the smallest scale, 0.1, and times the steepest slope of exp(−x²), 0.86, that
/// is 4e-6, and 3e-5 of the eight frames of the history. WGSL allows exp 3 + 2 |x| units in the last
/// place, which is less.
const TOLERANCE: Tolerance = Tolerance { absolute: 6e-5, relative: 0.0 };

const F32: ImageFormat = ImageFormat::Buffer(Element::F32);
const F16: ImageFormat = ImageFormat::Buffer(Element::F16);

/// A format, and its layout in a buffer.
type Stored = (ImageFormat, Layout);

fn texture(format: Texture) -> Stored {
    (ImageFormat::Texture(format), Layout::default())
}

/// A frame of any scene: its denoised light and what is known of its surfaces.
#[derive(Clone)]
pub(crate) struct Frame {
    pub(crate) denoised: Vec<Pixel>,
    pub(crate) motion: Vec<Pixel>,
    pub(crate) albedo: Vec<Pixel>,
    pub(crate) normal: Vec<Pixel>,
    pub(crate) depth: Vec<Pixel>,
}

/// How a frame's images are stored. Those without a format are absent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Formats {
    motion: Stored,
    albedo: Option<Stored>,
    normal: Option<Stored>,
    unorm: bool,
    depth: Option<Stored>,
    output: Stored,
}

impl Formats {
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
        }
    }

    pub(crate) fn light_alone(width: u32) -> Self {
        Self { albedo: None, normal: None, depth: None, ..Self::all(width) }
    }
}

/// Steps of eight bits, whose means of nine are far from the ties of rounding.
fn byte(v: f32) -> f32 {
    (v * 127.0).round()
}

impl Frame {
    /// Smooth enough that frames agree in part: Δ around the scales of agreement.
    fn random(random: &mut Random, [width, height]: [u32; 2]) -> Self {
        let mut pixels = |value: &mut dyn FnMut(&mut Random) -> Pixel| -> Vec<Pixel> {
            (0..width * height).map(|_| value(random)).collect()
        };
        let frame = Self {
            denoised: pixels(&mut |r| [0; 4].map(|_| 1.0 + 0.4 * r.value())),
            motion: pixels(&mut |r| [0; 4].map(|_| 3.0 * r.value())),
            albedo: pixels(&mut |r| [0; 4].map(|_| byte(0.5 + 0.4 * r.value()) * 2.0 / 255.0)),
            normal: pixels(&mut |r| [0; 4].map(|_| byte(0.7 * r.value()) / 127.0)),
            depth: pixels(&mut |r| [10.0 + r.value() + f32::from(r.value() < -0.8) * 1e9; 4]),
        };
        frame.before_a_sky(width)
    }

    /// Nothing is hit in the right third.
    fn before_a_sky(mut self, width: u32) -> Self {
        let rows = self.depth.chunks_exact_mut(width as usize);
        rows.for_each(|row| row[2 * width as usize / 3..].fill([f32::INFINITY; 4]));
        self
    }

    /// Pixel by pixel what no renderer should store, but some do.
    fn with_broken_pixels(mut self) -> Self {
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

    /// What the formats leave of it.
    fn stored(&self, formats: &Formats) -> Self {
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

/// A sequence of frames on the GPU: its history, from frame to frame.
pub(crate) struct Sequence {
    size: [u32; 2],
    formats: Formats,
    input_scale: f32,
    history: Option<History>,
}

impl Sequence {
    pub(crate) fn new(size: [u32; 2], formats: Formats, input_scale: f32) -> Self {
        Self { size, formats, input_scale, history: None }
    }

    /// The result of the next frame.
    pub(crate) fn next(&mut self, frame: &Frame) -> Vec<Pixel> {
        let (size, Formats { output, .. }) = (self.size, self.formats);
        let gpu = |pixels: &[Pixel], (format, layout)| GpuImage::new(pixels, size, format, layout);
        let motion = gpu(&frame.motion, self.formats.motion);
        let albedo = self.formats.albedo.map(|stored| gpu(&frame.albedo, stored));
        let normals = self.formats.encoded(&frame.normal);
        let normal = self.formats.normal.map(|stored| gpu(&normals, stored));
        let depth = self.formats.depth.map(|stored| gpu(&frame.depth, stored));
        let denoised = gpu(&frame.denoised, texture(Texture::Rgba32Float));
        let output = gpu(&vec![[-1.5; 4]; frame.motion.len()], output);
        let images = [&motion, &denoised, &output].map(|image| Some(image.as_pass()));
        let features =
            [&albedo, &normal, &depth].map(|image| image.as_ref().map(GpuImage::as_pass));
        let [images, features] = [images, features].map(|images| images.map(Bound::new));
        self.run(&images, &features);
        assert!(output.gaps_are_untouched(), "a gap was written to");
        output.read(|_| {})
    }

    fn run(&mut self, images: &[Bound<'_>; 3], features: &[Bound<'_>; 3]) {
        let context = context(Precision::F32);
        let layout = |bound: &Bound<'_>| bound.layout();
        let [motion, denoised, output] = images;
        let [albedo, normal, depth] = features;
        let tile = Tile {
            image_size: self.size,
            motion: layout(motion),
            albedo: layout(albedo),
            normal: layout(normal),
            depth: layout(depth),
            output: layout(output),
            ..Tile::default()
        };
        let images = FrameImages {
            tile: &buffer(context, bytemuck::bytes_of(&tile)),
            denoised: denoised.view.as_ref().expect("it is a texture"),
            motion: motion.binding().expect("there is motion"),
            albedo: albedo.binding(),
            normal: normal.binding(),
            unorm_normal: self.formats.unorm,
            depth: depth.binding(),
            input_scale: &buffer(context, bytemuck::bytes_of(&self.input_scale)),
            output: output.binding().expect("there is an output"),
        };
        let pixels = self.size.into_iter().map(u64::from).product();
        let history = self
            .history
            .get_or_insert_with(|| History::new(&context.device, pixels, images.features()));
        let call = accumulate(context, self.size, &images, history);
        submit_frame(&call, history);
    }
}

fn submit_frame(call: &Dispatch, history: &History) {
    let context = context(Precision::F32);
    submit(context, |pass| call.record_at(pass, 0));
    let mut encoder = context.device.create_command_encoder(&Default::default());
    history.advance(&mut encoder);
    context.queue.submit([encoder.finish()]);
}

/// An image, if there is one, and its view, if it is a texture.
struct Bound<'a> {
    image: Option<PassImage<'a>>,
    view: Option<wgpu::TextureView>,
}

impl<'a> Bound<'a> {
    fn new(image: Option<PassImage<'a>>) -> Self {
        Self { image, view: image.as_ref().and_then(view) }
    }

    fn binding(&'a self) -> Option<wgdenoise::internals::ops::image::ImageBinding<'a>> {
        self.image.as_ref().map(|image| binding(image, self.view.as_ref()))
    }

    fn layout(&self) -> Layout {
        match self.image {
            Some(PassImage::Buffer { layout, .. }) => layout,
            _ => Layout::default(),
        }
    }
}

/// The results of all frames by the reference.
fn expected(
    frames: &[Frame],
    size: [u32; 2],
    formats: &Formats,
    input_scale: f32,
) -> Vec<Vec<[f64; 3]>> {
    let mut history: Option<reference::History> = None;
    let mut results = Vec::new();
    for frame in frames {
        let frame = frame.stored(formats);
        let image = |pixels: &[Pixel]| (!pixels.is_empty()).then(|| cpu_image(pixels, size));
        let (albedo, normal) = (image(&frame.albedo), image(&frame.normal));
        let depth: Vec<_> = frame.depth.iter().map(|pixel| pixel[0]).collect();
        let motion: Vec<_> = frame.motion.iter().map(|&[x, y, ..]| [x, y]).collect();
        let frame = reference::Frame {
            denoised: &cpu_image(&frame.denoised, size),
            motion: &motion,
            albedo: albedo.as_ref(),
            normal: normal.as_ref(),
            depth: formats.depth.map(|_| depth.as_slice()),
            input_scale,
        };
        let next = reference::accumulate(&frame, history.as_ref(), 8.0);
        results.push(next.0.iter().map(|past| past.color).collect());
        history = Some(next);
    }
    results
}

fn check(
    frames: &[Frame],
    size: [u32; 2],
    formats: Formats,
    input_scale: f32,
) -> Result<(), String> {
    let mut sequence = Sequence::new(size, formats, input_scale);
    for (i, (frame, expected)) in
        frames.iter().zip(expected(frames, size, &formats, input_scale)).enumerate()
    {
        let found = sequence.next(frame);
        let pixels: Vec<Pixel> =
            expected.iter().map(|c| [c[0] as f32, c[1] as f32, c[2] as f32, 0.0]).collect();
        let [a, b] = [&found, &pixels].map(|pixels| image_tensor(&cpu_image(pixels, size)));
        compare(&a, &b, tolerance(formats.output.0)).map_err(|e| format!("frame {i}: {e}"))?;
        let alpha = found.iter().zip(&frame.denoised).map(|(a, b)| (a[3] - b[3]).abs());
        let alpha = alpha.fold(0.0, f32::max);
        if alpha > tolerance(formats.output.0).relative * 2.0 {
            return Err(format!("alpha is off by {alpha}"));
        }
    }
    Ok(())
}

/// 16-bit formats round by 2⁻¹¹, and drivers may truncate.
fn tolerance(output: ImageFormat) -> Tolerance {
    match output {
        F16 | ImageFormat::Texture(Texture::Rgba16Float) => {
            Tolerance { relative: 1.0 / 1024.0, ..TOLERANCE }
        }
        _ => TOLERANCE,
    }
}

fn frames(seed: u64, size: [u32; 2], count: usize) -> Vec<Frame> {
    let mut random = Random::new(seed);
    (0..count).map(|_| Frame::random(&mut random, size)).collect()
}

#[test]
fn accumulate_equals_the_reference_in_every_format() {
    let size = [13, 7];
    let all = Formats::all(13);
    let gaps = |format, channels| (format, Layout::new(5, 71, 5).with_channels(channels));
    let motion = [
        gaps(F32, 2),
        gaps(F16, 3),
        texture(Texture::Rg16Float),
        texture(Texture::Rg32Float),
        texture(Texture::Rgba16Float),
        texture(Texture::Rgba32Float),
    ];
    let feature = [gaps(F32, 3), gaps(F16, 3), texture(Texture::Rgba32Float)];
    let depth =
        [gaps(F32, 1), gaps(F16, 2), texture(Texture::R16Float), texture(Texture::R32Float)];
    let outputs =
        [gaps(F32, 4), gaps(F16, 4), texture(Texture::Rgba16Float), texture(Texture::Rgba32Float)];
    let mut cases: Vec<_> = motion.map(|motion| Formats { motion, ..all }).into();
    cases.extend(feature.map(|of| Formats { albedo: Some(of), ..all }));
    cases.extend(feature.map(|of| Formats { normal: Some(of), ..all }));
    cases.extend(depth.map(|of| Formats { depth: Some(of), ..all }));
    cases.extend(outputs.map(|output| Formats { output, ..all }));
    let bytes = Some(texture(Texture::Rgba8Unorm));
    cases.push(Formats { albedo: bytes, ..all });
    cases.push(Formats { normal: Some(texture(Texture::Rgba8Snorm)), ..all });
    cases.push(Formats { normal: Some(texture(Texture::Rgb10a2Unorm)), unorm: true, ..all });
    run_cases(cases, |&formats| check(&frames(3, size, 3), size, formats, 0.5));
}

#[test]
fn accumulate_equals_the_reference_at_any_size_and_without_any_feature() {
    let sizes = [[1, 1], [2, 5], [8, 8], [17, 9]];
    let sets = |size: [u32; 2]| (0..8_u32).map(move |set| (size, set));
    run_cases(sizes.into_iter().flat_map(sets), |&(size, set)| {
        let all = Formats::all(size[0]);
        let formats = Formats {
            albedo: all.albedo.filter(|_| set & 1 != 0),
            normal: all.normal.filter(|_| set & 2 != 0),
            depth: all.depth.filter(|_| set & 4 != 0),
            ..all
        };
        check(&frames(u64::from(set), size, 4), size, formats, 1.0)
    });
}

#[test]
fn what_is_no_number_has_no_history() {
    let size = [13, 7];
    let frames: Vec<_> = frames(9, size, 3).into_iter().map(Frame::with_broken_pixels).collect();
    check(&frames, size, Formats::all(13), 1.0).unwrap();
}
