//! The scale that brings an image to the exposure the network was trained at.
//! `shaders/autoexposure.wgsl` defines it.

use super::image::{ImageBinding, ImageFormat, color_features};
use super::tile::Layout;
use crate::gpu::kernel::{Binding, Context, Dispatch, KernelSpec};
use crate::shader::ShaderRoot;

/// Computes the bins of a band of rows of an image in this format.
#[must_use]
pub fn bins_spec(color: ImageFormat) -> KernelSpec {
    spec(format!("autoexposure_bins {}", color.source_name()), "bins", [8, 8, 1], color)
}

/// Reduces all bins to the scale.
#[must_use]
pub fn reduce_spec(color: ImageFormat) -> KernelSpec {
    spec(format!("autoexposure_reduce {}", color.source_name()), "reduce", [256, 1, 1], color)
}

fn spec(name: String, entry: &'static str, workgroup: [u32; 3], color: ImageFormat) -> KernelSpec {
    KernelSpec {
        name: name.into(),
        source: ShaderRoot::Module("autoexposure"),
        features: color_features(color).into(),
        entry,
        bindings: vec![
            Binding::Uniform { bytes: size_of::<Band>() as u64, dynamic: false },
            color.source_binding(),
            Binding::BufferMut,
            Binding::BufferMut,
        ]
        .into(),
        overrides: &[],
        workgroup,
    }
}

/// Longest side of a bin in pixels, and height of the narrowest band.
pub(crate) const BIN: u32 = 16;

/// The uniform of `autoexposure.wgsl`: a band of rows of an image.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Band {
    /// Size of the whole image in pixels.
    pub image_size: [u32; 2],
    /// Bins of the whole image, per axis.
    pub bins: [u32; 2],
    /// First row of bins of the band.
    pub first_bin_row: u32,
    /// Rows of bins in the band.
    pub bin_rows: u32,
    /// The image row at which the bound buffer begins.
    pub first_row: u32,
    padding: u32,
    /// Layout of the bound buffer.
    pub color: Layout,
}

impl Band {
    /// The whole image as one band.
    #[must_use]
    pub fn whole(width: u32, height: u32, color: Layout) -> Self {
        let bins = [width.div_ceil(BIN), height.div_ceil(BIN)];
        Self { image_size: [width, height], bins, bin_rows: bins[1], color, ..Self::default() }
    }

    /// Splits the image into bands of as many rows of bins as fit into `max_rows` rows of pixels.
    /// `max_rows` must be at least 16.
    #[must_use]
    pub fn split(width: u32, height: u32, max_rows: u32) -> Vec<Self> {
        let whole = Self::whole(width, height, Layout::packed(width));
        let per_band = (max_rows / BIN).max(1) as usize;
        let band = |first: u32| Self {
            first_bin_row: first,
            bin_rows: (whole.bins[1] - first).min(per_band as u32),
            first_row: whole.row_of(first),
            ..whole
        };
        (0..whole.bins[1]).step_by(per_band).map(band).collect()
    }

    /// The image rows covered by the band.
    #[must_use]
    pub fn rows(&self) -> std::ops::Range<u32> {
        self.row_of(self.first_bin_row)..self.row_of(self.first_bin_row + self.bin_rows)
    }

    fn row_of(&self, bin_row: u32) -> u32 {
        let row = u64::from(bin_row) * u64::from(self.image_size[1]) / u64::from(self.bins[1]);
        u32::try_from(row).expect("a row is below the height")
    }

    /// Bytes of the buffer for the bins.
    #[must_use]
    pub fn bin_bytes(&self) -> u64 {
        u64::from(self.bins[0]) * u64::from(self.bins[1]) * 4
    }
}

/// The two calls: one computes a band's bins; after all bands, the other computes the scale.
#[derive(Clone, Debug)]
pub struct Autoexposure {
    /// Computes the bins of the band in the uniform buffer.
    pub bins: Dispatch,
    /// Computes the scale from all bins.
    pub reduce: Dispatch,
}

/// Binds `band` (a uniform of one [`Band`]), `color` and the resulting `input_scale`, one 32-bit
/// float. `shape` is the largest band the uniform will hold.
#[must_use]
pub fn autoexposure(
    context: &Context,
    shape: &Band,
    band: &wgpu::Buffer,
    color: ImageBinding<'_>,
    input_scale: &wgpu::Buffer,
) -> Autoexposure {
    let bins = context.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("autoexposure bins"),
        size: shape.bin_bytes(),
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    });
    let call = |spec: &KernelSpec, invocations: [u32; 3]| {
        let kernel = context.kernel(spec, &[]);
        let [band, bins, scale] = [band, &bins, input_scale].map(wgpu::Buffer::as_entire_binding);
        let resources = [band, color.resource(), bins, scale];
        kernel.dispatch(kernel.bind(&context.device, &resources), invocations)
    };
    Autoexposure {
        bins: call(&bins_spec(color.format()), [shape.bins[0], shape.bin_rows, 1]),
        reduce: call(&reduce_spec(color.format()), [256, 1, 1]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::tiles::MAX_SIDE;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn bands_hold_every_bin_and_every_row_once_and_no_more_rows_than_asked(
            width in 1..=MAX_SIDE, height in 1..=MAX_SIDE, max_rows in BIN..=2 * MAX_SIDE,
        ) {
            let bins = [width.div_ceil(BIN), height.div_ceil(BIN)];
            let (mut next_bin, mut next_row) = (0, 0);
            for band in Band::split(width, height, max_rows) {
                let rows = band.rows();
                prop_assert_eq!((band.first_bin_row, rows.start), (next_bin, next_row));
                prop_assert_eq!(band.first_row, rows.start);
                prop_assert!(band.bin_rows > 0 && !rows.is_empty(), "{:?}", band);
                prop_assert!(rows.len() <= max_rows as usize, "{:?} of {}", rows, max_rows);
                prop_assert!(band.bins == bins, "{:?}", band);
                (next_bin, next_row) = (next_bin + band.bin_rows, rows.end);
            }
            prop_assert_eq!((next_bin, next_row), (bins[1], height));
        }
    }
}
