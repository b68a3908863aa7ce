//! A pass's images in the form that kernels bind.

use std::num::NonZeroU64;

use super::PassImage;
use crate::ops::image::{Element, ImageBinding};
use crate::ops::tile::Layout;

/// A texture view, or part of a buffer.
#[derive(Clone, Debug)]
pub(super) struct Held {
    place: Place,
    /// Where the pixels lie within the bound range.
    pub(super) layout: Layout,
}

#[derive(Clone, Debug)]
enum Place {
    Buffer { buffer: wgpu::Buffer, element: Element, offset: u64, size: Option<NonZeroU64> },
    Texture(wgpu::TextureView),
}

/// Copies an image before the output overwrites it.
#[derive(Debug)]
pub(super) enum Rescue {
    Buffer { from: wgpu::Buffer, offset: u64, to: wgpu::Buffer },
    Texture { from: wgpu::Texture, to: wgpu::Texture },
}

impl Held {
    /// Prepares a checked image of `size` pixels.
    pub(super) fn new(image: &PassImage<'_>, size: [u32; 2], limits: &wgpu::Limits) -> Self {
        match *image {
            PassImage::Texture(texture) => {
                Self { place: Place::Texture(first_layer(texture)), layout: Layout::default() }
            }
            PassImage::Buffer { buffer, element, layout } => {
                let offset = begin_bytes(element, &layout, limits);
                let size = NonZeroU64::new(end_bytes(element, &layout, size) - offset);
                let mut layout = layout;
                layout.offset -= (offset / u64::from(element.bytes())) as u32;
                let place = Place::Buffer { buffer: buffer.clone(), element, offset, size };
                Self { place, layout }
            }
        }
    }

    /// The same image in memory of its own, and the copy that fills it.
    pub(super) fn rescued(self, device: &wgpu::Device) -> (Self, Rescue) {
        let layout = self.layout;
        let (place, rescue) = match self.place {
            Place::Texture(view) => {
                let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
                let from = view.texture().clone();
                let to = texture(device, [from.width(), from.height()], from.format(), usage);
                (Place::Texture(first_layer(&to)), Rescue::Texture { from, to })
            }
            Place::Buffer { buffer: from, element, offset, size } => {
                let to = device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("image before it is overwritten"),
                    size: size.map_or(0, NonZeroU64::get),
                    usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                });
                let place = Place::Buffer { buffer: to.clone(), element, offset: 0, size };
                (place, Rescue::Buffer { from, offset, to })
            }
        };
        (Self { place, layout }, rescue)
    }

    pub(super) fn binding(&self) -> ImageBinding<'_> {
        match &self.place {
            Place::Texture(view) => ImageBinding::Texture(view),
            &Place::Buffer { ref buffer, element, offset, size } => {
                ImageBinding::Buffer { buffer, element, offset, size }
            }
        }
    }
}

impl Rescue {
    pub(super) fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        match self {
            Self::Buffer { from, offset, to } => {
                encoder.copy_buffer_to_buffer(from, *offset, to, 0, to.size());
            }
            Self::Texture { from, to } => {
                encoder.copy_texture_to_texture(
                    from.as_image_copy(),
                    to.as_image_copy(),
                    to.size(),
                );
            }
        }
    }
}

/// The first bound byte, aligned down to the device's binding alignment.
pub(super) fn begin_bytes(element: Element, layout: &Layout, limits: &wgpu::Limits) -> u64 {
    let alignment = u64::from(limits.min_storage_buffer_offset_alignment);
    let begin = u64::from(layout.offset) * u64::from(element.bytes());
    begin - begin % alignment
}

/// One past the last bound byte, rounded up to a multiple of four.
pub(super) fn end_bytes(element: Element, layout: &Layout, [width, height]: [u32; 2]) -> u64 {
    (layout.elements(width, height) * u64::from(element.bytes())).next_multiple_of(4)
}

pub(super) fn first_layer(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2),
        mip_level_count: Some(1),
        array_layer_count: Some(1),
        ..Default::default()
    })
}

/// A two-dimensional texture.
pub(super) fn texture(
    device: &wgpu::Device,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("image of a pass"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}
