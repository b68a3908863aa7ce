//! Runs only on Linux, where an environment variable relocates the cache.
#![cfg(target_os = "linux")]

use exr::meta::attribute::EnvironmentMap;
use exr::prelude::{IntegerBounds, WritableImage};
use serde_json::{Value, json};

use crate::support::{Folder, Run, data, read_exr};

/// Runs with a cache inside the folder.
fn run(folder: &Folder, args: &[&str]) -> Run {
    run_on(folder, "plain_rgb.exr", args)
}

fn run_on(folder: &Folder, image: &str, args: &[&str]) -> Run {
    let mut command = folder.command(&[&[image, "out.exr", "--force"], args].concat());
    Run::of(&command.env("XDG_CACHE_HOME", folder.path("cache")).output().unwrap())
}

/// Predictions for the 37×23 image in its 48×32 tile: 1.5, 3.1 and 4.6 ms.
fn made_up() -> Value {
    let cost = |ns: f64| json!({"fixed": 0.0, "per_pixel": ns * 1e-9});
    json!({"date": "2001-02-03", "fast": cost(1e3), "balanced": cost(2e3), "high": cost(3e3)})
}

/// All cases share one measurement, which takes a CPU driver half a minute.
#[test]
fn a_budget_chooses_the_weights_by_what_was_measured_once() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    let cache = folder.path("cache/wgdenoise/calibrations.json");

    let first = run(&folder, &["--budget", "1us"]);
    first.assert_done();
    for word in
        ["kept for the next run", "fast: predicted", "no weights meet 0.00 ms, so the fastest"]
    {
        assert!(first.stderr.contains(word), "no `{word}` in {first:?}");
    }
    let mut kept: Value = serde_json::from_slice(&std::fs::read(&cache).unwrap()).unwrap();
    let entries = kept.as_object_mut().unwrap();
    assert_eq!(entries.len(), 1, "{entries:?}");
    let (key, entry) = entries.iter_mut().next().unwrap();
    assert!(key.contains("; F16; ") && key.ends_with(env!("CARGO_PKG_VERSION")), "{key}");
    let slope = |name: &str| entry[name]["per_pixel"].as_f64().unwrap();
    assert!(0.0 < slope("fast") && slope("fast") < slope("high"), "{entry}");

    *entry = made_up();
    std::fs::write(&cache, kept.to_string()).unwrap();
    for (budget, said) in [
        ("4.7ms", "high: predicted 4.61 ms of 4.70 ms on "),
        ("4.5ms", "balanced: predicted 3.07 ms of 4.50 ms on "),
        // Without the tile's margin, `balanced` would take 1.70 ms, within the budget.
        ("2.5ms", "fast: predicted 1.54 ms of 2.50 ms on "),
        ("1ms", "fast: predicted 1.54 ms; no weights meet 1.00 ms, so the fastest is used on "),
    ] {
        let run = run(&folder, &["--budget", budget]);
        run.assert_done();
        let (count, known) = (run.stderr.lines().count(), "(calibrated 2001-02-03)");
        assert!(count == 3 && run.stderr.contains(said) && run.stderr.contains(known), "{run:?}");
    }
    // At this size, only the smaller networks' tensors fit in 1800 KiB.
    image::RgbImage::new(128, 64).save(folder.path("large.png")).unwrap();
    let large = run_on(&folder, "large.png", &["--budget", "9999ms", "--memory", "1800KiB"]);
    large.assert_done();
    assert!(large.stderr.contains("balanced: predicted"), "{large:?}");
    let quiet = run(&folder, &["--budget", "4.7ms", "-q"]);
    assert_eq!((quiet.code, quiet.stderr.as_str()), (0, ""));
    panorama(&folder);
}

/// With 128 columns repeated on each side, the tile is 304×32.
fn panorama(folder: &Folder) {
    let mut image = read_exr(&data("plain_rgb.exr"));
    let layer = &mut image.layer_data[0];
    layer.attributes.environment_map = Some(EnvironmentMap::LatitudeLongitude);
    image.attributes.display_window =
        IntegerBounds::new(layer.attributes.layer_position, layer.size);
    image.write().to_file(folder.path("sky.exr")).unwrap();
    let run = run_on(folder, "sky.exr", &["--budget", "10ms", "-v"]);
    run.assert_done();
    for said in ["fast: predicted 9.73 ms of 10 ms", "37×23 pixels and 256 repeated columns in 1"]
    {
        assert!(run.stderr.contains(said), "no `{said}` in {run:?}");
    }
}

#[test]
fn a_budget_excludes_other_choices_of_weights() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    for args in [
        &["--budget", "0ms"][..],
        &["--budget", "40"],
        &["--budget", "soon"],
        &["--budget", "40ms", "--quality", "fast"],
        &["--budget", "40ms", "--weights", crate::support::WEIGHTS],
        &["--recalibrate"],
    ] {
        let run = run(&folder, args);
        assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{args:?}: {run:?}");
    }
    assert_eq!(folder.names(), ["plain_rgb.exr"]);
}
