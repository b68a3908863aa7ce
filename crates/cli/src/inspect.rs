//! Commands that look at files and adapters without denoising: `info`, `preview`, `compare` and
//! `devices`.

use std::fmt::Write as _;

use serde_json::{Value, json};

use crate::console::{Console, print, print_json};
use crate::denoise::other_colors;
use crate::failure::{Failure, shown};
use crate::plan::prepare_output;
use crate::request::{Compare, Info, Preview};
use wgdenoise::wgpu::AdapterInfo;
use wgdenoise::{Gpu, Inputs, Quality, Weights};
use wgdenoise_files::{
    Description, FileError, Identity, LayerInfo, Picture, Problem, ViewInfo, comparison, escaped,
};
use wgdenoise_metrics::Metrics;

/// Prints a file's layers, which of them are used, its size and the cost.
pub(crate) fn info(request: &Info) -> Result<(), Failure> {
    let file = Description::of(&request.input, &request.layers)?;
    let costs = costs(&file)?;
    if request.json {
        print_json(&info_json(&file, &costs))
    } else {
        print(&info_text(&file, &costs))
    }
}

/// Cost for each quality, in billions of floating-point operations for all views together.
fn costs(file: &Description) -> Result<Vec<(&'static str, f64)>, Failure> {
    let cost = |quality: Quality| {
        let weights = Weights::builtin(quality)?;
        let of_view = |view: &ViewInfo| {
            let given = Inputs { albedo: view.albedo.is_some(), normal: view.normal.is_some() };
            let read = given.intersection(weights.metadata().inputs);
            let pixels = f64::from(view.width) * f64::from(view.height);
            Ok::<_, Failure>(2.0 * weights.macs_per_pixel_for(read)? * pixels / 1e9)
        };
        let views = file.views.iter().flatten();
        let costs = views.map(of_view).collect::<Result<Vec<_>, _>>()?;
        Ok((quality.name(), costs.into_iter().fold(0.0, |sum, cost| sum + cost)))
    };
    Quality::ALL.into_iter().map(cost).collect()
}

fn info_text(file: &Description, costs: &[(&str, f64)]) -> String {
    let mut lines = vec![format!("{}, {}×{} pixels", file.format, file.width, file.height)];
    lines.extend(file.layers.iter().map(layer_line));
    match &file.views {
        Ok(views) => {
            lines.extend(views.iter().flat_map(view_lines));
            lines.push(cost_line(costs));
        }
        Err(problem) => lines.push(refusal(problem)),
    }
    lines.join("\n")
}

fn cost_line(costs: &[(&str, f64)]) -> String {
    let costs: Vec<_> =
        costs.iter().map(|(name, gflop)| format!("{name} {}", amount(*gflop))).collect();
    format!("cost in GFLOP: {}", costs.join(", "))
}

/// Formats one decimal, or two significant digits of a positive value below 1.
fn amount(value: f64) -> String {
    let decimals = if value < 1.0 { 1.0 - value.log10().floor() } else { 1.0 };
    format!("{value:.*}", decimals as usize)
}

/// Lists what is denoised in a view and why, then what else could be, and what could not.
fn view_lines(view: &ViewInfo) -> Vec<String> {
    let Some(selection) = &view.selection else {
        let alpha = view.alpha.as_ref().map(|_| "alpha from the pixels".to_string());
        return [FROM_PIXELS.into()].into_iter().chain(alpha).collect();
    };
    let mut lines: Vec<_> =
        view.name.iter().map(|name| format!("view `{}`:", escaped(name))).collect();
    lines.extend(selection.explanation.iter().chain(&selection.left_out).cloned());
    lines.extend(other_colors(selection));
    let light = view.light.iter().map(|(layer, _)| quoted(layer));
    lines.extend(listed("--layers auto also denoises ", light));
    let data = view.data.iter().map(|(layer, what)| format!("{} ({what})", quoted(layer)));
    lines.extend(listed("not light, so --layers refuses ", data));
    lines
}

/// Joins items after `start`, only the first of many; `None` if there are none.
fn listed(start: &str, items: impl ExactSizeIterator<Item = String>) -> Option<String> {
    let more = items.len().saturating_sub(MOST_LISTED);
    let end = if more > 0 { format!(" and {more} more") } else { String::new() };
    let items: Vec<_> = items.take(MOST_LISTED).collect();
    (!items.is_empty()).then(|| format!("{start}{}{end}", items.join(", ")))
}

/// Most layers on one line.
const MOST_LISTED: usize = 20;

fn quoted(name: &str) -> String {
    format!("`{}`", escaped(name))
}

const FROM_PIXELS: &str = "color from the pixels, decoded to linear light";

/// Why the file cannot be denoised.
fn refusal(problem: &Problem) -> String {
    let advice = match problem {
        Problem::AmbiguousColor(_) => "; name one with --color",
        _ => "",
    };
    format!("cannot be denoised: it {problem}{advice}")
}

fn layer_line(layer: &LayerInfo) -> String {
    let channel = |(name, kind): &(String, &str)| format!("{}:{kind}", escaped(name));
    let channels: Vec<_> = layer.channels.iter().map(channel).collect();
    format!("  {} [{}] {}", escaped(&layer.name), channels.join(" "), layer.storage)
}

fn info_json(file: &Description, costs: &[(&str, f64)]) -> Value {
    let layer = |l: &LayerInfo| {
        let channels: Vec<_> =
            l.channels.iter().map(|(name, kind)| json!({"name": name, "type": kind})).collect();
        json!({
            "name": l.name,
            "part": l.part,
            "view": l.view,
            "channels": channels,
            "storage": l.storage,
        })
    };
    let layers: Vec<Value> = file.layers.iter().map(layer).collect();
    let costs: serde_json::Map<_, _> =
        costs.iter().map(|(name, gflop)| ((*name).to_string(), json!(gflop))).collect();
    let views: Vec<_> = file.views.iter().flatten().map(view_json).collect();
    let choice = match &file.views {
        Ok(views) => views[0]
            .selection
            .as_ref()
            .map_or(FROM_PIXELS.into(), |selection| selection.explanation.join("; ")),
        Err(problem) => refusal(problem),
    };
    // The first view's keys also serve as the file's.
    let first = |key: &str| views.first().map_or(&Value::Null, |view| &view[key]);
    json!({
        "format": file.format,
        "width": file.width,
        "height": file.height,
        "layers": layers,
        "color": first("color"),
        "target": first("target"),
        "albedo": first("albedo"),
        "normal": first("normal"),
        "choice": choice,
        "views": views,
        "gflop": costs,
    })
}

fn view_json(view: &ViewInfo) -> Value {
    let selection = view.selection.as_ref();
    let light: Vec<_> = view.light.iter().map(|(layer, _)| layer).collect();
    let data: serde_json::Map<_, _> =
        view.data.iter().map(|(layer, what)| (layer.clone(), json!(what))).collect();
    json!({
        "name": view.name,
        "width": view.width,
        "height": view.height,
        "color": selection.map(|s| &s.color),
        "target": selection.map(|s| &s.target),
        "albedo": view.albedo,
        "normal": view.normal,
        "alpha": view.alpha,
        "layers": selection.map(|s| &s.layers),
        "light": light,
        "data": data,
        "reasons": selection.map(|s| &s.explanation),
        "notices": selection.map(|s| &s.left_out),
    })
}

/// Writes a layer as PNG or JPEG.
pub(crate) fn preview(request: &Preview, console: &Console) -> Result<(), Failure> {
    let Preview { input, output, writing, .. } = request;
    let of_file = |error: FileError| Failure::of_file(&error, "--layer");
    if Identity::of(input) == Identity::of(output) {
        return Err(Failure::of(output, "is also the input; give another OUT"));
    }
    wgdenoise_files::Preview::format(output).map_err(|error| Failure::Usage(error.to_string()))?;
    let layer = request.layer.as_deref();
    let preview = wgdenoise_files::Preview::open(input, layer, request.limits).map_err(of_file)?;
    prepare_output(output, writing.force, *writing)?;
    let name = preview.layer().map(|layer| format!("`{}` as ", escaped(layer)));
    let notices = preview.save(output, request.exposure, writing.force).map_err(of_file)?;
    for notice in &notices {
        console.notice(notice);
    }
    console.notice(&format!("wrote {}{}", name.unwrap_or_default(), shown(output)));
    Ok(())
}

/// Prints the metrics of an image against its reference.
pub(crate) fn compare(request: &Compare, console: &Console) -> Result<(), Failure> {
    let image = Picture::open(&request.image, &request.layers)?;
    let reference = Picture::open(&request.reference, &request.layers)?;
    let metrics = wgdenoise_metrics::compare(image.first().color(), reference.first().color())?;
    for difference in comparison::differences(&image, &reference) {
        console.notice(&difference);
    }
    if request.json { print_json(&metrics_json(&metrics)) } else { print(&metrics_text(&metrics)) }
}

fn metrics_text(m: &Metrics) -> String {
    let mut text = format!(
        "L1      {:.6}\nPSNR    {:.3} dB\nSSIM    {:.6}\nrelMSE  {:.6}\nSMAPE   {:.6}",
        m.l1, m.psnr, m.ssim, m.relmse, m.smape
    );
    for notice in bad_pixels(m) {
        let _ = write!(text, "\n{notice}");
    }
    text
}

/// Sentences on pixels that are not numbers, in the image and in its reference.
pub(crate) fn bad_pixels(m: &Metrics) -> impl Iterator<Item = String> {
    let all = [("", m.bad), (" of the reference", m.bad_reference)];
    let sentence = |(of, count)| format!("{count} pixels{of} are NaN or infinite and count as 0");
    all.into_iter().filter(|(_, count)| *count > 0).map(sentence)
}

fn metrics_json(m: &Metrics) -> Value {
    json!({
        "l1": m.l1,
        "psnr": m.psnr,
        "ssim": m.ssim,
        "relmse": m.relmse,
        "smape": m.smape,
        "bad": m.bad,
        "bad_reference": m.bad_reference,
    })
}

/// Lists the adapters in the order in which `--adapter` counts them.
pub(crate) fn devices(json: bool) -> Result<(), Failure> {
    let adapters = Gpu::list();
    if adapters.is_empty() {
        // The engine's own message says how to get one.
        Gpu::open(None)?;
    }
    let adapters = adapters.iter().enumerate();
    if json {
        return print_json(&adapters.map(|(i, adapter)| adapter_json(i, adapter)).collect());
    }
    print(&adapters.map(|(i, adapter)| adapter_line(i, adapter)).collect::<Vec<_>>().join("\n"))
}

fn adapter_line(index: usize, adapter: &AdapterInfo) -> String {
    format!(
        "{index}: {} ({:?}, {:?}, {} {})",
        adapter.name, adapter.device_type, adapter.backend, adapter.driver, adapter.driver_info
    )
}

fn adapter_json(index: usize, adapter: &AdapterInfo) -> Value {
    json!({
        "index": index,
        "name": adapter.name,
        "type": format!("{:?}", adapter.device_type),
        "backend": format!("{:?}", adapter.backend),
        "driver": adapter.driver,
        "driver_info": adapter.driver_info,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_amount_has_two_significant_digits() {
        for (value, text) in
            [(0.0312, "0.031"), (0.5, "0.50"), (1.0, "1.0"), (12.34, "12.3"), (4321.0, "4321.0")]
        {
            assert_eq!(amount(value), text);
        }
    }
}
