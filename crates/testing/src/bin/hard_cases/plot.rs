//! Plots the growth of the rounding error as SVG.

use std::error::Error;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use wgdenoise::{Image, Precision, Weights};

use crate::Result;
use wgdenoise_testing::hard_cases::growth::{self, Growth, inputs_to_grow, rounding};

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = std::result::Result<(), Box<dyn Error>>;

const SIZE: (u32, u32) = (960, 540);
const FONT: &str = "sans-serif";
/// One color per input. Curves of 16-bit tensors lie above those of 32-bit ones.
const COLORS: [RGBColor; 3] = [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115)];

/// A curve of the plot.
struct Line {
    name: &'static str,
    color: RGBColor,
    growth: Growth,
}

/// Plots the growth for these weights.
pub(crate) fn growth(weights: &Weights) -> Result<String> {
    let inputs = inputs_to_grow();
    let line = |precision| {
        move |((name, image), color): (&(&'static str, Image), RGBColor)| Line {
            name,
            color,
            growth: growth::growth(weights, image, precision),
        }
    };
    let lines = |precision| inputs.iter().zip(COLORS).map(line(precision));
    let lines: Vec<_> = lines(Precision::F16).chain(lines(Precision::F32)).collect();
    let mut text = String::new();
    draw(&mut text, &lines).map_err(|error| error.to_string())?;
    Ok(text)
}

fn draw(text: &mut String, lines: &[Line]) -> Drawn {
    let root = SVGBackend::with_string(text, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let layers = lines[0].growth.len();
    let mut chart = ChartBuilder::on(&root)
        .margin(14)
        .x_label_area_size(96)
        .y_label_area_size(64)
        .build_cartesian_2d(0.0..layers as f64 - 1.0, (1e-8..1e-1).log_scale())?;
    let error = |error: &f64| format!("{error:.0e}");
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_labels(layers)
        .x_label_formatter(&|_| String::new())
        .y_label_style((FONT, 12))
        .y_desc("relative error")
        .y_label_formatter(&error)
        .draw()?;
    for precision in [Precision::F16, Precision::F32] {
        let walk = |i: usize| (i as f64, ((i + 1) as f64).sqrt() * rounding(precision));
        chart.draw_series((0..layers).map(|i| Circle::new(walk(i), 1, BLACK.filled())))?;
        let name = Text::new(format!("{precision:?}"), walk(layers - 2), (FONT, 16));
        chart.draw_series([name])?;
    }
    for line in lines {
        // A logarithmic axis cannot show an error of 0.
        let errors = line.growth.iter().enumerate().filter(|(_, (_, error))| *error > 0.0);
        let places: Vec<_> = errors.map(|(i, (_, error))| (i as f64, *error)).collect();
        chart.draw_series([PathElement::new(places, line.color.stroke_width(2))])?;
    }
    let below: Vec<_> = (0..layers).map(|i| chart.backend_coord(&(i as f64, 1e-8))).collect();
    name_layers(&root, lines, &below)?;
    name_lines(&root, lines)?;
    Ok(root.present()?)
}

/// Draws the layers' names below the axis, rotated to fit.
fn name_layers(root: &Area<'_>, lines: &[Line], below: &[(i32, i32)]) -> Drawn {
    let style = (FONT, 12).into_font().transform(FontTransform::Rotate90).into_text_style(root);
    let style = style.pos(Pos::new(HPos::Left, VPos::Center));
    for ((layer, _), (x, y)) in lines[0].growth.iter().zip(below) {
        root.draw(&Text::new(layer.clone(), (*x, y + 8), style.clone()))?;
    }
    Ok(())
}

fn name_lines(root: &Area<'_>, lines: &[Line]) -> Drawn {
    for (i, line) in lines[..COLORS.len()].iter().enumerate() {
        let x = 100 + 220 * i as i32;
        root.draw(&PathElement::new(vec![(x, 28), (x + 30, 28)], line.color.stroke_width(2)))?;
        root.draw(&Text::new(line.name, (x + 38, 21), (FONT, 14)))?;
    }
    Ok(())
}
