//! Pixel density, which also tells the pixels' shape.

use image::codecs::jpeg::{PixelDensity, PixelDensityUnit};

const METERS_PER_INCH: f64 = 0.0254;

/// Pixels per meter, or per unknown unit, along both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Density {
    x: f64,
    y: f64,
    is_metric: bool,
}

impl Density {
    /// Reads a chunk `pHYs` (PNG, third edition, 11.3.4.3).
    pub(crate) fn of_png(data: &[u8]) -> Option<Self> {
        let (x, rest) = data.split_first_chunk()?;
        let (y, unit) = rest.split_first_chunk()?;
        let [x, y] = [x, y].map(|bytes| f64::from(u32::from_be_bytes(*bytes)));
        (x > 0.0 && y > 0.0).then_some(Self { x, y, is_metric: unit == [1] })
    }

    /// Reads a JFIF header (ITU-T T.871, 10.1) from its unit on; `None` if it says nothing.
    pub(crate) fn of_jfif(data: &[u8]) -> Option<Self> {
        let &[unit, a, b, c, d, ..] = data else { return None };
        let [x, y] = [[a, b], [c, d]].map(|bytes| f64::from(u16::from_be_bytes(bytes)));
        let per_meter = match unit {
            1 => 1.0 / METERS_PER_INCH,
            2 => 100.0,
            _ => 1.0,
        };
        let density = Self { x: x * per_meter, y: y * per_meter, is_metric: unit > 0 };
        (x > 0.0 && y > 0.0 && (unit > 0 || x != y)).then_some(density)
    }

    /// The density of pixels `aspect` times as wide as high; `None` if they are square.
    pub(crate) fn of_aspect(aspect: f32) -> Option<Self> {
        let y = 1000.0 * f64::from(aspect);
        (aspect != 1.0).then_some(Self { x: 1000.0, y, is_metric: false })
    }

    /// Pixel width over height; 1 if the ratio makes no sense.
    pub(crate) fn aspect(self) -> f32 {
        let aspect = (self.y / self.x) as f32;
        if is_storable(aspect) { aspect } else { 1.0 }
    }

    /// The density of the picture turned on its side.
    pub(crate) fn turned(self) -> Self {
        Self { x: self.y, y: self.x, ..self }
    }

    /// The data of a `pHYs` chunk.
    pub(crate) fn png(self) -> Vec<u8> {
        let [x, y] = [self.x, self.y].map(|count| (count.round() as u32).to_be_bytes());
        [&x[..], &y, &[self.is_metric.into()]].concat()
    }

    /// The density per inch or per centimeter, whichever gives whole numbers; without a unit if
    /// neither does.
    pub(crate) fn jfif(self) -> PixelDensity {
        let per = |meters: f64| [self.x, self.y].map(|count| count * meters);
        let is_whole = |counts: &[f64; 2]| counts.iter().all(|v| (v - v.round()).abs() < 0.01);
        let fits = |counts: &[f64; 2]| counts.iter().all(|v| (0.5..65535.5).contains(v));
        let (inch, centimeter) = (per(METERS_PER_INCH), per(0.01));
        let (counts, unit) = match self.is_metric {
            true if is_whole(&centimeter) && !is_whole(&inch) && fits(&centimeter) => {
                (centimeter, PixelDensityUnit::Centimeters)
            }
            true if fits(&inch) => (inch, PixelDensityUnit::Inches),
            false if fits(&per(1.0)) => (per(1.0), PixelDensityUnit::PixelAspectRatio),
            _ => {
                let shape = [1000.0, 1000.0 * f64::from(self.aspect())];
                (shape, PixelDensityUnit::PixelAspectRatio)
            }
        };
        let [x, y] = counts.map(|count| count.round() as u16);
        PixelDensity { density: (x, y), unit }
    }
}

/// Whether a density can store this ratio of pixel width to height.
pub(crate) fn is_storable(aspect: f32) -> bool {
    (0.02..=60.0).contains(&aspect)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn jfif(unit: u8, x: u16, y: u16) -> Vec<u8> {
        [&[unit][..], &x.to_be_bytes(), &y.to_be_bytes()].concat()
    }

    #[test]
    fn a_jpegs_density_survives_and_means_the_same_in_a_png() {
        for (unit, x, y) in [(1, 72, 72), (1, 300, 150), (2, 118, 118), (0, 3, 2), (1, 65535, 1)] {
            let density = Density::of_jfif(&jfif(unit, x, y)).unwrap();
            let again = density.jfif();
            let found = match again.unit {
                PixelDensityUnit::PixelAspectRatio => 0,
                PixelDensityUnit::Inches => 1,
                PixelDensityUnit::Centimeters => 2,
            };
            assert_eq!((found, again.density), (unit, (x, y)));
            let png = Density::of_png(&density.png()).unwrap();
            assert!((png.aspect() / density.aspect() - 1.0).abs() < 1e-3, "{png:?} {density:?}");
        }
        assert_eq!(Density::of_jfif(&jfif(0, 1, 1)), None);
        let dpi = Density::of_jfif(&jfif(1, 300, 300)).unwrap().png();
        assert_eq!(dpi, [0, 0, 0x2e, 0x23, 0, 0, 0x2e, 0x23, 1], "11811 per meter");
        assert_eq!(Density::of_png(&dpi).unwrap().jfif(), PixelDensity::dpi(300));
    }

    #[test]
    fn a_shape_survives_and_nonsense_is_square() {
        for aspect in [0.02, 0.5, 1.333, 2.0, 50.0] {
            let density = Density::of_aspect(aspect).unwrap();
            assert!((density.aspect() - aspect).abs() < 1e-3, "{aspect}");
            assert!((density.turned().aspect() * aspect - 1.0).abs() < 1e-3, "{aspect}");
        }
        assert_eq!(Density::of_aspect(1.0), None);
        for nonsense in [&[0; 9][..], &[0; 3], &[]] {
            assert_eq!(Density::of_png(nonsense), None, "{nonsense:?}");
        }
        let extreme = Density::of_png(&[0, 0, 0, 1, 0xff, 0xff, 0xff, 0xff, 1]).unwrap();
        assert_eq!((extreme.aspect(), extreme.jfif().density), (1.0, (1000, 1000)));
    }
}
