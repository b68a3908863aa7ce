//! `wgdenoise info`.

use serde_json::{Value, json};

use super::args::InfoArgs;
use super::failure::Failure;
use super::print;
use wgdenoise::{Inputs, Quality, Weights};
use wgdenoise_files::{Description, LayerChoice, LayerInfo};

/// Prints a file's layers, the choice among them, its size and the cost.
pub(super) fn run(args: &InfoArgs) -> Result<(), Failure> {
    let file = Description::of(&args.input, &LayerChoice::from(&args.layers))?;
    let costs = costs(&file)?;
    print(&if args.json { as_json(&file, &costs) } else { as_text(&file, &costs) })
}

/// Billions of floating-point operations per quality.
fn costs(file: &Description) -> Result<Vec<(&'static str, f64)>, Failure> {
    let pixels = f64::from(file.width) * f64::from(file.height);
    let given = Inputs { albedo: file.albedo.is_some(), normal: file.normal.is_some() };
    let cost = |quality: Quality| {
        let weights = Weights::builtin(quality)?;
        let sliced = weights.for_inputs(given.intersection(weights.metadata().inputs))?;
        Ok((quality.name(), 2.0 * sliced.macs_per_pixel() * pixels / 1e9))
    };
    Quality::ALL.into_iter().map(cost).collect()
}

fn as_text(file: &Description, costs: &[(&str, f64)]) -> String {
    let mut lines = vec![format!("{}, {}×{} pixels", file.format, file.width, file.height)];
    lines.extend(file.layers.iter().map(layer_line));
    lines.push(file.choice.clone());
    let costs: Vec<_> = costs.iter().map(|(name, gflop)| format!("{name} {gflop:.1}")).collect();
    lines.push(format!("cost in GFLOP: {}", costs.join(", ")));
    lines.join("\n")
}

fn layer_line(layer: &LayerInfo) -> String {
    let channels: Vec<_> = layer.channels.iter().map(|(n, kind)| format!("{n}:{kind}")).collect();
    format!("  {} [{}] {}", layer.name, channels.join(" "), layer.storage)
}

fn as_json(file: &Description, costs: &[(&str, f64)]) -> String {
    let layer = |l: &LayerInfo| {
        let channels: Vec<_> =
            l.channels.iter().map(|(name, kind)| json!({"name": name, "type": kind})).collect();
        json!({"name": l.name, "part": l.part, "channels": channels, "storage": l.storage})
    };
    let layers: Vec<Value> = file.layers.iter().map(layer).collect();
    let costs: serde_json::Map<_, _> =
        costs.iter().map(|(name, gflop)| ((*name).to_string(), json!(gflop))).collect();
    json!({
        "format": file.format,
        "width": file.width,
        "height": file.height,
        "layers": layers,
        "color": file.color,
        "target": file.target,
        "albedo": file.albedo,
        "normal": file.normal,
        "choice": file.choice,
        "gflop": costs,
    })
    .to_string()
}
