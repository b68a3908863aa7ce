use crate::support::{Folder, data};

#[test]
fn help_tells_the_exit_codes() {
    let run = Folder::new().run(&["--help"]);
    assert_eq!(run.code, 0);
    for word in ["Exit codes:", "3  no usable adapter", "info", "devices", "compare", "bench"] {
        assert!(run.stdout.contains(word), "no `{word}` in {run:?}");
    }
    for word in ["Advanced layer", "Advanced device", "--in-place", "completions", "--timeout"] {
        assert!(run.stdout.contains(word), "no `{word}` in {run:?}");
    }
}

#[test]
fn help_is_a_command_that_takes_another() {
    let folder = Folder::new();
    for (args, usage) in [
        (&["help"][..], "Usage: wgdenoise [OPTIONS] <IN>... <OUT>"),
        (&["help", "info"], "Usage: wgdenoise info [OPTIONS] <IN>"),
    ] {
        let run = folder.run(args);
        assert!(run.code == 0 && run.stdout.contains(usage), "{run:?}");
    }
    folder.run(&["render"]).assert_failed(2, &["`render` is neither a file nor a command"]);
}

/// By default, clap puts a default in a paragraph of its own.
#[test]
fn defaults_stand_in_the_line_of_their_flag() {
    let folder = Folder::new();
    for command in ["preview", "bench", "profile", "report"] {
        let run = folder.run(&[command, "--help"]);
        let alone = |line: &str| line.trim_start().starts_with("[default");
        assert!(run.stdout.contains("[default: ") && !run.stdout.lines().any(alone), "{run:?}");
    }
}

#[test]
fn the_short_help_fits_a_screen_and_has_what_is_used_every_day() {
    let run = Folder::new().run(&["-h"]);
    assert_eq!(run.code, 0);
    let lines: Vec<_> = run.stdout.lines().collect();
    assert!(lines.len() <= 26, "{} lines: {}", lines.len(), run.stdout);
    assert!(lines.iter().all(|line| line.chars().count() <= 80), "{}", run.stdout);
    for word in ["<IN>... <OUT>", "info", "preview", "--quality", "--frames", "--force", "--quiet"]
    {
        assert!(run.stdout.contains(word), "no `{word}` in {}", run.stdout);
    }
    for word in ["Advanced", "completions", "--kernels", "--timeout"] {
        assert!(!run.stdout.contains(word), "`{word}` in {}", run.stdout);
    }
}

#[test]
fn completions_and_the_manual_page_know_every_command() {
    let folder = Folder::new();
    for (args, begin) in [
        (&["completions", "bash"][..], "_wgdenoise()"),
        (&["completions", "zsh"], "#compdef wgdenoise"),
        (&["completions", "fish"], "# Print an optspec"),
        (&["man"], ".ie"),
    ] {
        let run = folder.run(args);
        assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{args:?}");
        assert!(run.stdout.starts_with(begin), "{args:?}: {}", &run.stdout[..60]);
        for command in ["preview", "compare", "report"] {
            assert!(run.stdout.contains(command), "no {command} of {args:?}");
        }
    }
    let page = folder.run(&["man", "report"]);
    assert_eq!(page.code, 0);
    assert!(page.stdout.contains("wgdenoise report") && page.stdout.contains("runs"), "{page:?}");
    folder.run(&["man", "nothing"]).assert_failed(2, &["nothing: no such command"]);
}

#[test]
fn a_misspelled_command_is_answered_with_the_command() {
    let folder = Folder::new();
    let (a, b) = (folder.copy("plain_rgb.exr"), folder.copy("karma_like.exr"));
    let files = [a.to_str().unwrap(), b.to_str().unwrap()];
    for (word, command) in [("compar", "compare"), ("infoo", "info")] {
        let run = folder.run(&[&[word], &files[..]].concat());
        run.assert_failed(2, &[&format!("did you mean `wgdenoise {command}`?")]);
        assert!(!run.stderr.contains("--force"), "{run:?}");
    }
}

#[test]
fn a_number_without_a_unit_is_refused_with_the_right_form() {
    let folder = Folder::new();
    for (flag, bare, right) in [
        ("--timeout", "60", "write 60s or 60ms"),
        ("--budget", "40", "write 40s or 40ms"),
        ("--memory", "2", "write 2MiB or 2GiB"),
    ] {
        let run = folder.run(&["a.exr", "b.exr", flag, bare]);
        assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{run:?}");
        assert!(run.stderr.contains(right), "{run:?}");
    }
}

#[test]
fn info_shows_layers_the_choice_and_the_cost() {
    let folder = Folder::new();
    folder.copy("blender5_parts.exr");
    let text = folder.run(&["info", "blender5_parts.exr"]);
    assert_eq!(text.code, 0, "{text:?}");
    for word in ["EXR with", "ViewLayer.Denoising Normal [", "written to", "cost in GFLOP"] {
        assert!(text.stdout.contains(word), "no `{word}` in {text:?}");
    }
    let json = folder.run(&["info", "blender5_parts.exr", "--json"]).json();
    assert_eq!(json["color"], "ViewLayer.Noisy Image");
    assert_eq!(json["target"], "ViewLayer.Combined");
    assert_eq!(json["normal"], "ViewLayer.Denoising Normal");
    let (fast, high) = (json["gflop"]["fast"].as_f64(), json["gflop"]["high"].as_f64());
    assert!(fast.unwrap() > 0.0 && fast < high, "{json}");
    let layers = json["layers"].as_array().unwrap();
    assert!(layers.iter().any(|l| l["channels"][0]["type"] == "float"), "{json}");
}

#[test]
fn info_of_something_else_has_exit_code_1() {
    let folder = Folder::new();
    std::fs::write(folder.path("x.exr"), "nothing").unwrap();
    folder.run(&["info", "x.exr"]).assert_failed(1, &["x.exr: is not an EXR"]);
}

#[test]
fn devices_lists_what_adapter_chooses_from() {
    let folder = Folder::new();
    let json = folder.run(&["devices", "--json"]).json();
    let first = json[0]["name"].as_str().expect("the tests need an adapter");
    assert_eq!(json[0]["index"], 0);
    let text = folder.run(&["devices"]);
    assert!(text.stdout.starts_with(&format!("0: {first}")), "{text:?}");
    folder.copy("plain_rgb.exr");
    for adapter in ["0", first] {
        let args = ["plain_rgb.exr", "out.exr", "--force", "--adapter", adapter];
        folder.denoise(&args).assert_done();
    }
}

#[test]
fn compare_reads_the_result_and_measures_it() {
    let folder = Folder::new();
    folder.copy("blender5_parts.exr");
    let image = "blender5_parts.exr";
    let same = folder.run(&["compare", image, image, "--json"]).json();
    assert_eq!((same["l1"].as_f64(), same["ssim"].as_f64()), (Some(0.0), Some(1.0)));
    folder.denoise(&[image, "out.exr"]).assert_done();
    let other = folder.run(&["compare", "out.exr", image, "--json"]).json();
    for figure in ["l1", "psnr", "ssim", "relmse", "smape"] {
        assert!(other[figure].as_f64().unwrap().is_finite(), "{other}");
    }
    assert!(other["l1"].as_f64().unwrap() > 0.0, "{other}");
    let text = folder.run(&["compare", "out.exr", image]);
    assert!(text.code == 0 && text.stdout.contains("SSIM"), "{text:?}");
}

/// As passed by a script with an unset variable.
#[test]
fn an_empty_name_is_no_layer() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    for flag in ["--color", "--albedo", "--normal"] {
        let run = folder.denoise(&["plain_rgb.exr", "out.exr", flag, ""]);
        run.assert_failed(1, &["has no layer ``"]);
    }
}

#[test]
fn images_too_large_to_measure_are_refused() {
    let sides = ["--width", "65536", "--height", "65536"];
    for command in ["bench", "profile"] {
        let run = Folder::new().run(&[&[command], &sides[..]].concat());
        run.assert_failed(2, &["make 4294967296 pixels, and at most 268435456 can be measured"]);
    }
}

#[test]
fn images_of_different_sizes_cannot_be_compared() {
    let folder = Folder::new();
    let (a, b) = (data("karma_like.exr"), data("plain_rgb.exr"));
    folder.run(&["compare", a.to_str().unwrap(), b.to_str().unwrap()]).assert_failed(1, &["37×23"]);
}

/// On a device that fails every write, like a full disk or a broken pipe.
#[cfg(target_os = "linux")]
#[test]
fn messages_that_cannot_be_written_do_not_lose_the_result() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let arguments = ["plain_rgb.exr", "out.exr", "-v", "--quality", "fast"];
    let status = folder.command(&arguments).stderr(full).status().unwrap();
    assert!(status.success() && folder.path("out.exr").exists(), "{status}");
}

#[test]
fn bench_reports_what_it_measured() {
    let bench = ["bench", "--width", "64", "--height", "48", "--runs", "3", "--quality", "fast"];
    let json = Folder::new().run(&[&bench[..], &["--json"]].concat()).json();
    assert_eq!(json["seconds"].as_array().unwrap().len(), 3, "{json}");
    assert!(json["median_seconds"].as_f64() > Some(0.0), "{json}");
    assert_eq!((&json["width"], &json["tiles"]), (&64.into(), &1.into()), "{json}");
    let text = Folder::new().run(&bench);
    assert!(text.code == 0 && text.stdout.contains("64×48, tiles: 1"), "{text:?}");
}

#[test]
fn kernels_are_what_the_flag_names() {
    let folder = Folder::new();
    let bench = ["bench", "--width", "32", "--height", "32", "--runs", "1", "--quality", "fast"];
    for (flag, name) in [("plain", "Plain"), ("tiled", "Tiled"), ("half", "Half")] {
        let json = folder.run(&[&bench[..], &["--json", "--kernels", flag]].concat()).json();
        assert_eq!(json["kernels"], name, "{json}");
    }
}

/// Matrix kernels run where the adapter has matrices; elsewhere, one sentence says that it has
/// none.
#[test]
fn matrix_kernels_run_or_are_refused() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    let args = ["plain_rgb.exr", "out.exr", "--kernels", "matrix"];
    let gpu = wgdenoise::Gpu::open(None).expect("the tests need an adapter");
    match wgdenoise::MatrixShape::of(&gpu.adapter, wgdenoise::Precision::F16) {
        Some(shape) => {
            let run = folder.denoise(&[&args[..], &["-v"]].concat());
            run.assert_done();
            let side = shape.side;
            assert!(run.stderr.contains(&format!("kernels Matrix {side}×{side}")), "{run:?}");
        }
        None => folder
            .denoise(&[&args[..], &["-q"]].concat())
            .assert_failed(3, &["no matrices that fit", "choose --kernels auto"]),
    }
}

/// With 128-bit vectors, lavapipe's subgroups of 4 are too small for the simd kernels.
#[test]
fn kernels_that_do_not_run_on_the_adapter_are_one_sentence() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    let mut command = folder.command(&["plain_rgb.exr", "out.exr", "-q", "--kernels", "simd"]);
    let output = command.env("LP_NATIVE_VECTOR_WIDTH", "128").output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(text.contains("the Simd kernels do not run on") && text.lines().count() == 1, "{text}");
    assert_eq!((output.status.code(), folder.path("out.exr").exists()), (Some(3), false));
}
