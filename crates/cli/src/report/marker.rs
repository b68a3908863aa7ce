//! What a point of the plot looks like.

use plotters::prelude::*;

use super::measure::Row;
use super::plot::{Area, Drawn};
use wgdenoise::{Inputs, Precision, Quality};

/// Colour, shape and filling of a marker; grey, a circle or hollow where that says nothing.
pub(super) struct Marker {
    quality: Option<Quality>,
    precision: Precision,
    inputs: Inputs,
}

const RADIUS: i32 = 5;
const GREY: RGBColor = RGBColor(90, 90, 90);

impl Marker {
    pub(super) fn of(row: &Row) -> Self {
        Self { quality: Some(row.quality), precision: row.precision, inputs: row.inputs }
    }

    /// What tells configurations apart, with its text.
    pub(super) fn legend(sets: &[Inputs]) -> Vec<(Self, String)> {
        let (precision, inputs) = (Precision::F16, Inputs::ALL);
        let tier =
            |q: Quality| (Self { quality: Some(q), precision, inputs }, q.name().to_string());
        let shape = |(precision, name): (_, &str)| {
            (Self { quality: None, precision, inputs }, name.to_string())
        };
        let filling =
            |&inputs: &Inputs| (Self { quality: None, precision, inputs }, inputs.to_string());
        let tiers = Quality::ALL.into_iter().map(tier);
        let shapes = [(Precision::F32, "f32"), (Precision::F16, "f16")].into_iter().map(shape);
        tiers.chain(shapes).chain(sets.iter().map(filling)).collect()
    }

    pub(super) fn draw(&self, area: &Area<'_>, at: (i32, i32)) -> Drawn {
        let colour = self.quality.map_or(GREY, colour);
        self.shape(area, at, RADIUS, WHITE.filled())?;
        match (self.inputs.albedo, self.inputs.normal) {
            (true, true) => self.shape(area, at, RADIUS, colour.filled())?,
            (false, false) => {}
            _ => self.shape(area, at, RADIUS / 2, colour.filled())?,
        }
        self.shape(area, at, RADIUS, colour.stroke_width(2))
    }

    fn shape(&self, area: &Area<'_>, (x, y): (i32, i32), r: i32, style: ShapeStyle) -> Drawn {
        match self.precision {
            Precision::F32 => {
                area.draw(&Rectangle::new([(x - r, y - r), (x + r, y + r)], style))?;
            }
            Precision::F16 => area.draw(&Circle::new((x, y), r, style))?,
        }
        Ok(())
    }
}

/// Told apart by all kinds of eyes (Okabe and Ito 2008).
fn colour(quality: Quality) -> RGBColor {
    match quality {
        Quality::Fast => RGBColor(0, 158, 115),
        Quality::Balanced => RGBColor(0, 114, 178),
        Quality::High => RGBColor(213, 94, 0),
    }
}
