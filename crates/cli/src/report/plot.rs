//! Plots the report: error over time on a logarithmic axis.

use std::error::Error;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::measure::Row;
use super::{Report, labels, table};
use wgdenoise::{Inputs, Precision, Quality};

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn Error>>;

const SIZE: (u32, u32) = (960, 600);
/// Room for the legend next to the axes.
const LEGEND_WIDTH: u32 = 170;
const FONT: &str = "sans-serif";
const FRONT: RGBColor = RGBColor(130, 130, 130);

/// A configuration in the plot.
struct Point<'a> {
    row: &'a Row,
    milliseconds: f64,
    /// In percent of the noisy image's error, or times 100 if that is 0.
    error: f64,
}

/// Draws the report; at least one configuration must have been measured.
pub(super) fn svg(report: &Report) -> Result<String, Box<dyn Error>> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        title(&root, report)?;
        let (chart, legend) =
            root.margin(48, 8, 12, 12).split_horizontally(SIZE.0 - LEGEND_WIDTH - 24);
        draw_points(&root, &chart, &points(report))?;
        draw_legend(&legend, report)?;
        root.present()?;
    }
    Ok(text)
}

fn points(report: &Report) -> Vec<Point<'_>> {
    let point = |row| {
        let measured = Row::measured(row)?;
        let error = table::relative(measured, report.before.l1).unwrap_or(measured.metrics.l1);
        Some(Point { row, milliseconds: 1e3 * measured.median(), error: 100.0 * error })
    };
    report.rows.iter().filter_map(point).collect()
}

fn title(root: &Area<'_>, report: &Report) -> Drawn {
    let Report { noisy, width, height, device, .. } = report;
    let first = format!("Time against error: {noisy}, {width}×{height} pixels");
    root.draw(&Text::new(first, (14, 10), (FONT, 17)))?;
    Ok(root.draw(&Text::new(device.clone(), (14, 32), (FONT, 12)))?)
}

fn draw_points(root: &Area<'_>, area: &Area<'_>, points: &[Point<'_>]) -> Drawn {
    let x = padded(points.iter().map(|p| p.milliseconds.ln()));
    let (x, y) = (x.start.exp()..x.end.exp(), padded(points.iter().map(|p| p.error)));
    let ticks = ticks(&x);
    let mut chart = ChartBuilder::on(area)
        .x_label_area_size(44)
        .y_label_area_size(58)
        .build_cartesian_2d(x.log_scale().with_key_points(ticks), y)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_desc("milliseconds per frame (logarithmic)")
        .y_desc("L1, % of the noisy image's")
        .x_label_formatter(&|ms| format!("{ms}"))
        .y_label_formatter(&|percent| format!("{percent}"))
        .axis_desc_style((FONT, 14))
        .label_style((FONT, 12))
        .draw()?;
    let place = |p: &Point<'_>| chart.backend_coord(&(p.milliseconds, p.error));
    let mut front: Vec<_> = points.iter().filter(|p| p.row.front).collect();
    front.sort_by(|a, b| a.milliseconds.total_cmp(&b.milliseconds));
    let line: Vec<_> = front.iter().map(|p| place(p)).collect();
    root.draw(&PathElement::new(line, FRONT.stroke_width(1)))?;
    let places: Vec<_> = points.iter().map(place).collect();
    for (point, &at) in points.iter().zip(&places) {
        Marker::of(point.row).draw(root, at)?;
    }
    let named: Vec<_> = front.iter().map(|p| (place(p), label(p.row))).collect();
    for (text, at) in labels::placed(&named, &places, &chart.plotting_area().get_pixel_range()) {
        let style = (FONT, labels::HEIGHT).into_text_style(root);
        root.draw(&Text::new(text, at, style.pos(Pos::new(HPos::Left, VPos::Top))))?;
    }
    Ok(())
}

fn label(row: &Row) -> String {
    format!("{} {}", row.quality.name(), table::precision(row.precision))
}

/// The range of the values, with a margin of a tenth.
fn padded(values: impl Iterator<Item = f64> + Clone) -> Range<f64> {
    let least = values.clone().fold(f64::INFINITY, f64::min);
    let most = values.fold(f64::NEG_INFINITY, f64::max);
    let margin = if most > least { 0.1 * (most - least) } else { 0.1 * most.abs().max(0.1) };
    least - margin..most + margin
}

/// Round numbers for a logarithmic axis: 1, 2, 5 and so on, or more if these are too few.
fn ticks(range: &Range<f64>) -> Vec<f64> {
    let of = |digits: &[u8]| -> Vec<f64> {
        let tick = |exponent: i32| {
            // Parsing makes a tick exactly equal to the number in its label.
            let parse = move |digit: &u8| format!("{digit}e{exponent}").parse().ok();
            digits.iter().filter_map(parse)
        };
        (-7..12).flat_map(tick).filter(|t| range.contains(t)).collect()
    };
    let coarse = of(&[10, 20, 50]);
    if coarse.len() > 2 { coarse } else { of(&[10, 12, 15, 20, 25, 30, 40, 50, 60, 70, 80]) }
}

fn draw_legend(area: &Area<'_>, report: &Report) -> Drawn {
    let first = &report.rows[0];
    let alike = |row: &&Row| (row.quality, row.precision) == (first.quality, first.precision);
    let sets: Vec<Inputs> = report.rows.iter().filter(alike).map(|row| row.inputs).collect();
    let mut y = 24;
    for (marker, text) in Marker::legend(&sets) {
        marker.draw(area, (14, y))?;
        area.draw(&Text::new(text, (28, y - 6), (FONT, 13)))?;
        y += 22;
    }
    area.draw(&PathElement::new(vec![(4, y), (24, y)], FRONT.stroke_width(1)))?;
    for line in ["front: none is both", "faster and closer"] {
        area.draw(&Text::new(line, (28, y - 6), (FONT, 13)))?;
        y += 16;
    }
    Ok(())
}

/// A marker: color shows the tier, shape the precision, and filling the inputs.
struct Marker {
    quality: Option<Quality>,
    precision: Precision,
    inputs: Inputs,
}

const RADIUS: i32 = 5;
const GRAY: RGBColor = RGBColor(90, 90, 90);

impl Marker {
    fn of(row: &Row) -> Self {
        Self { quality: Some(row.quality), precision: row.precision, inputs: row.inputs }
    }

    /// The legend's markers and their texts.
    fn legend(sets: &[Inputs]) -> Vec<(Self, String)> {
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

    fn draw(&self, area: &Area<'_>, at: (i32, i32)) -> Drawn {
        let color = self.quality.map_or(GRAY, color);
        self.shape(area, at, RADIUS, WHITE.filled())?;
        match (self.inputs.albedo, self.inputs.normal) {
            (true, true) => self.shape(area, at, RADIUS, color.filled())?,
            (false, false) => {}
            _ => self.shape(area, at, RADIUS / 2, color.filled())?,
        }
        self.shape(area, at, RADIUS, color.stroke_width(2))
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

/// Colors that color-blind readers can tell apart too (Okabe and Ito 2008).
fn color(quality: Quality) -> RGBColor {
    match quality {
        Quality::Fast => RGBColor(0, 158, 115),
        Quality::Balanced => RGBColor(0, 114, 178),
        Quality::High => RGBColor(213, 94, 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgdenoise_metrics::Metrics;

    fn report(noisy: &str, l1: f64, rows: Vec<Row>) -> Report {
        let before =
            Metrics { l1, psnr: 9.0, ssim: 0.5, relmse: 1.0, smape: 0.5, bad: 0, bad_reference: 0 };
        let [noisy, reference, device] = [noisy, "reference", "device"].map(String::from);
        Report { noisy, reference, width: 4, height: 3, device, runs: 1, before, rows }
    }

    #[test]
    fn names_are_escaped_and_failures_left_out() {
        let rows = vec![Row::made_up(Err("failed")), Row::made_up(Ok((0.5, 0.02)))];
        let plot = svg(&report("<a & \"b\">.exr", 0.1, rows)).unwrap();
        assert!(plot.contains("&lt;a &amp; &quot;b&quot;&gt;.exr, 4×3"), "{plot}");
    }

    #[test]
    fn one_point_and_a_noisy_image_without_error_can_be_drawn() {
        for (time, l1) in [(1e-6, 0.0), (1e-3, 0.1), (1e4, 1.0)] {
            let plot = svg(&report("a", 0.0, vec![Row::made_up(Ok((time, l1)))])).unwrap();
            assert!(!plot.contains("NaN") && !plot.contains("inf"), "{plot}");
        }
    }

    #[test]
    fn an_axis_has_three_round_numbers_or_more() {
        assert_eq!(ticks(&(0.9..21.0)), [1.0, 2.0, 5.0, 10.0, 20.0]);
        assert_eq!(ticks(&(18.0..41.0)), [20.0, 25.0, 30.0, 40.0]);
    }
}
