//! Drivers that fail, simulated by the Vulkan layer in `layer.rs`.

use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;

use exr::prelude::*;

use crate::support::{Folder, Run, WEIGHTS};

/// The folder with the compiled layer and its manifest.
fn layer() -> &'static Path {
    static LAYER: OnceLock<tempfile::TempDir> = OnceLock::new();
    LAYER.get_or_init(|| compiled().expect("rustc compiles the layer")).path()
}

fn compiled() -> std::io::Result<tempfile::TempDir> {
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR"))?;
    let library = folder.path().join("liblayer.so");
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cli/faults/layer.rs");
    let rustc = Command::new("rustc")
        .args(["--edition=2024", "--crate-type=cdylib", "-Dwarnings", source, "-o"])
        .arg(&library)
        .status()?;
    assert!(rustc.success(), "{rustc}");
    let manifest = serde_json::json!({ "file_format_version": "1.2.0", "layer": {
        "name": "VK_LAYER_WGDENOISE_faults", "type": "GLOBAL", "library_path": library,
        "api_version": "1.3.0", "implementation_version": "1", "description": "what breaks" } });
    std::fs::write(folder.path().join("layer.json"), manifest.to_string())?;
    Ok(folder)
}

/// Denoises `noisy.exr` on a driver with this fault, using the kernels that compile fastest.
fn denoise(folder: &Folder, fault: &str, args: &[&str]) -> Run {
    let weights = ["--weights", WEIGHTS, "--kernels", "tiled"];
    let mut command = folder.command(&[&["noisy.exr", "out.exr"], &weights[..]].concat());
    command.env("VK_LAYER_PATH", layer()).env("VK_INSTANCE_LAYERS", "VK_LAYER_WGDENOISE_faults");
    command.env("FAULT", fault);
    Run::of(&command.args(args).output().unwrap())
}

/// A folder with `noisy.exr`, noise of this size.
fn noise(width: usize, height: usize) -> Folder {
    let folder = Folder::new();
    let value = |at: Vec2<usize>, c: usize| {
        let hash = (at.x() * 7919 + at.y() * 104_729 + c * 1_299_709).wrapping_mul(2_654_435_761);
        0.2 + (hash >> 8 & 0xff) as f32 / 1000.0
    };
    let pixel = |at| (value(at, 0), value(at, 1), value(at, 2));
    let path = folder.path("noisy.exr");
    Image::from_channels((width, height), SpecificChannels::rgb(pixel))
        .write()
        .to_file(path)
        .unwrap();
    folder
}

/// Reduces memory from the planned amount to less than any tile needs.
#[test]
fn the_less_memory_the_smaller_the_tiles_and_then_one_sentence() {
    let folder = noise(576, 432);
    denoise(&folder, "none", &["-q", "--precision", "f32"]).assert_done();
    let whole = std::fs::read(folder.path("out.exr")).unwrap();
    let (mut halved, mut failed) = (0, 0);
    for mib in [64, 48, 24, 4, 2] {
        std::fs::remove_file(folder.path("out.exr")).unwrap_or_default();
        let run = denoise(&folder, &format!("memory {}", mib << 20), &["--precision", "f32"]);
        if run.code == 0 {
            assert_eq!(std::fs::read(folder.path("out.exr")).unwrap(), whole, "{mib} MiB");
            halved += run.stderr.matches("ran out of memory with tiles of").count();
        } else {
            let last = run.stderr.lines().last().unwrap_or_default();
            assert!(last.starts_with("wgdenoise: error: ") && last.contains("emory"), "{run:?}");
            assert_eq!(folder.names(), ["noisy.exr"]);
            failed += 1;
        }
    }
    assert!(halved > 2 && failed > 0, "halved {halved} times, failed {failed} times");
}

#[test]
fn a_device_that_is_lost_is_one_sentence_and_leaves_no_file() {
    let folder = noise(64, 64);
    for fault in ["lost 1", "lost 2"] {
        let run = denoise(&folder, fault, &["-q"]);
        run.assert_failed(4, &["the device was lost", "open it again"]);
        assert_eq!(folder.names(), ["noisy.exr"], "{fault}");
    }
}

#[test]
fn a_device_that_hangs_is_one_sentence_and_the_program_ends() {
    let folder = noise(64, 64);
    for fault in ["hang 1", "hang 5"] {
        let run = denoise(&folder, fault, &["-q", "--timeout", "2s"]);
        run.assert_failed(4, &["no answer from", "within 2s", "it hangs"]);
        assert_eq!(folder.names(), ["noisy.exr"], "{fault}");
    }
}

#[test]
fn work_beyond_the_timeout_is_not_waited_for() {
    let folder = noise(512, 512);
    denoise(&folder, "none", &["-q", "--timeout", "10us"]).assert_failed(4, &["within 10µs"]);
    assert_eq!(folder.names(), ["noisy.exr"]);
}

/// Skips a dispatch of the exposure, and some of the network.
#[test]
fn wrong_results_are_found_and_not_written() {
    let folder = noise(64, 64);
    for dispatch in [1, 6, 7, 9] {
        let run = denoise(&folder, &format!("wrong {dispatch}"), &["-q", "--verify"]);
        run.assert_failed(
            4,
            &["differs from the CPU reference", "wrong results", "another adapter"],
        );
        assert_eq!(folder.names(), ["noisy.exr"], "{dispatch}");
    }
    denoise(&folder, "wrong 7", &["-q"]).assert_done();
}

#[test]
fn right_results_are_verified() {
    let folder = noise(64, 64);
    let run = denoise(&folder, "none", &["--verify"]);
    run.assert_done();
    assert!(run.stderr.contains("verified 16×16 pixels at ("), "{run:?}");
}
