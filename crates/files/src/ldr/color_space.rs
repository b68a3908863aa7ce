//! How the values of a PNG encode light.

use ::exr::math::Vec2;
use ::exr::meta::attribute::Chromaticities;

use super::chunks::Chunks;
use super::curve::Curve;
use crate::Problem;
use crate::primaries;

/// The curve and primaries of stored colors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ColorSpace {
    pub(crate) curve: Curve,
    /// `None` for sRGB's.
    pub(crate) primaries: Option<Chromaticities>,
}

/// The gamma exponents that are decoded; others would not survive 32-bit floats.
const EXPONENTS: std::ops::RangeInclusive<f32> = 0.2..=5.0;

impl ColorSpace {
    pub(crate) const SRGB: Self = Self { curve: Curve::Srgb, primaries: None };

    /// The color space of a PNG: from `cICP`, or else `iCCP`, `sRGB`, `gAMA` with `cHRM` (PNG,
    /// third edition, 4.3). Colors with an ICC profile are decoded as if they were sRGB.
    ///
    /// # Errors
    /// If light is encoded in an unsupported way, such as PQ.
    pub(crate) fn of(chunks: &Chunks) -> Result<Self, Problem> {
        if let Some(&[primaries, curve, matrix, range]) = chunks.get(*b"cICP")
            && curve != UNSPECIFIED
        {
            return Self::numbered(primaries, curve, matrix == 0 && range == 1);
        }
        if chunks.get(*b"iCCP").is_some() || chunks.get(*b"sRGB").is_some() {
            return Ok(Self::SRGB);
        }
        let gamma = chunks.get(*b"gAMA").and_then(|data| scaled(data, 0));
        let exponent = gamma.map(|gamma| 1.0 / gamma).filter(|e| EXPONENTS.contains(e));
        let curve = exponent.map_or(Curve::Srgb, Curve::Power);
        let primaries = chunks.get(*b"cHRM").and_then(chromaticities);
        Ok(Self { curve, primaries }.without_those_of_srgb())
    }

    fn numbered(primaries: u8, curve: u8, is_full_rgb: bool) -> Result<Self, Problem> {
        let curve = match curve {
            _ if !is_full_rgb => return Err(unsupported("stored as video with a narrow range")),
            1 | 6 | 14 | 15 => Curve::Bt709,
            4 => Curve::Power(2.2),
            5 => Curve::Power(2.8),
            8 => Curve::Power(1.0),
            13 => Curve::Srgb,
            16 => return Err(unsupported("encoded by PQ, a curve for HDR displays")),
            18 => return Err(unsupported("encoded by HLG, a curve for HDR displays")),
            other => return Err(unsupported(&format!("encoded by the curve {other} of H.273"))),
        };
        match primaries::numbered(primaries) {
            None if primaries != UNSPECIFIED => {
                Err(unsupported(&format!("of the primaries {primaries} of H.273")))
            }
            found => Ok(Self { curve, primaries: found }.without_those_of_srgb()),
        }
    }

    fn without_those_of_srgb(self) -> Self {
        let primaries = self.primaries.filter(|p| !primaries::are_alike(p, &primaries::SRGB));
        Self { primaries, ..self }
    }
}

/// The number for unspecified in H.273, for curves and primaries.
const UNSPECIFIED: u8 = 2;

fn unsupported(how: &str) -> Problem {
    Problem::Unsupported(format!(
        "is {how} (chunk `cICP`), which is not supported; give it in sRGB or as EXR"
    ))
}

/// A number of `gAMA` or `cHRM`, stored as an integer times 100000.
fn scaled(data: &[u8], index: usize) -> Option<f32> {
    let bytes = data.get(4 * index..4 * index + 4)?.try_into().ok()?;
    Some(u32::from_be_bytes(bytes)).filter(|&v| v > 0).map(|v| v as f32 / 100_000.0)
}

/// Reads the white point, red, green and blue of `cHRM`.
fn chromaticities(data: &[u8]) -> Option<Chromaticities> {
    let point = |i: usize| Some(Vec2(scaled(data, 2 * i)?, scaled(data, 2 * i + 1)?));
    Some(Chromaticities { white: point(0)?, red: point(1)?, green: point(2)?, blue: point(3)? })
}
