//! What the window shows, as a picture in screen values at one pixel per image pixel.

use wgdenoise::Image;

use crate::gpu::screen::Kind;
use crate::state::looking::{Layout, Looking};
use crate::state::tone::{Tone, srgb};

/// Screen values, row by row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pixels {
    pub(crate) size: [u32; 2],
    pub(crate) rgb: Vec<[u8; 3]>,
}

/// An image, and how it is shown.
#[derive(Clone, Copy)]
pub(crate) struct Side<'a> {
    pub(crate) kind: Kind,
    pub(crate) image: &'a Image,
    /// The image that a difference subtracts.
    pub(crate) subtracted: &'a Image,
}

/// Renders one image, or two in the window's layout. All images have the same size.
pub(crate) fn picture([left, right]: [Side<'_>; 2], looking: &Looking, tone: Tone) -> Pixels {
    let [width, height]: [u32; 2] = right.image.size().into();
    let columns = if looking.layout == Layout::SideBySide { 2 * width } else { width };
    let line = (looking.split * width as f32) as u32;
    let pixel = |x: u32, y: u32| {
        let (side, x) = match looking.layout {
            Layout::Single => (&right, x),
            Layout::Split if x == line => return [255; 3],
            Layout::Split => (if x < line { &left } else { &right }, x),
            Layout::SideBySide => (if x < width { &left } else { &right }, x % width),
        };
        side.color((y * width + x) as usize, looking, tone).map(|v| (v * 255.0).round() as u8)
    };
    let places = (0..height).flat_map(|y| (0..columns).map(move |x| (x, y)));
    Pixels { size: [columns, height], rgb: places.map(|(x, y)| pixel(x, y)).collect() }
}

impl Side<'_> {
    /// The screen values of a pixel, as the shader computes them.
    fn color(&self, index: usize, looking: &Looking, tone: Tone) -> [f32; 3] {
        let value = self.image.pixels()[index];
        if value.iter().any(|v| !v.is_finite()) {
            return [1.0, 0.0, 1.0];
        }
        match self.kind {
            Kind::Surface => value.map(srgb),
            Kind::Direction => value.map(|v| (0.5 * v + 0.5).clamp(0.0, 1.0)),
            Kind::Difference => {
                let other = self.subtracted.pixels()[index];
                let gain = tone.gain() * looking.amplification;
                [0, 1, 2].map(|channel| srgb((value[channel] - other[channel]).abs() * gain))
            }
            Kind::Light => tone.screen(value),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pictured(layout: Layout, kind: Kind) -> Pixels {
        let (dark, light) = (filled(0.0), filled(1.0));
        let side = |kind, image| Side { kind, image, subtracted: &dark };
        let looking = Looking { layout, amplification: 1.0, ..Looking::default() };
        picture([side(Kind::Light, &dark), side(kind, &light)], &looking, Tone::default())
    }

    fn filled(v: f32) -> Image {
        Image::filled(8, 2, [v; 3]).unwrap()
    }

    #[test]
    fn layouts_place_both_images() {
        let single = pictured(Layout::Single, Kind::Light);
        assert!(single.size == [8, 2] && single.rgb.iter().all(|p| *p == [255; 3]));
        let split = pictured(Layout::Split, Kind::Light);
        assert_eq!([split.rgb[3], split.rgb[4], split.rgb[5]], [[0; 3], [255; 3], [255; 3]]);
        let both = pictured(Layout::SideBySide, Kind::Light);
        assert_eq!((both.size, both.rgb[7], both.rgb[8]), ([16, 2], [0; 3], [255; 3]));
    }

    #[test]
    fn a_difference_is_taken_from_the_other_image() {
        let same = pictured(Layout::Single, Kind::Difference);
        assert!(same.rgb.iter().all(|p| *p == [255; 3]), "1 − 0");
        let normal = pictured(Layout::Single, Kind::Direction);
        assert_eq!(normal.rgb[0], [255; 3]);
    }
}
