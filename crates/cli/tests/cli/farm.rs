//! The job template of `docs/farm.md`: runs its command as a farm's workers do.

use std::collections::BTreeSet;
use std::fs;

use crate::support::{Folder, WEIGHTS, data};

const TEMPLATE: &str = include_str!("../../../../docs/farm/wgdenoise.openjd.yaml");

/// The arguments of the template's command, with its parameters replaced by these values.
fn arguments(values: &[(&str, &str)]) -> Vec<String> {
    let lines = TEMPLATE.lines().skip_while(|line| line.trim() != "args:").skip(1);
    let items = lines.map_while(|line| line.trim().strip_prefix("- "));
    let filled = |item: &str| {
        values.iter().fold(item.trim_matches('"').to_string(), |item, (name, value)| {
            item.replace(&format!("{{{{{name}}}}}"), value)
        })
    };
    items.map(filled).collect()
}

#[test]
fn the_command_of_the_job_template_denoises_the_frames_of_a_task_once() {
    let folder = Folder::new();
    for frame in ["-0001", "0000", "0001", "0002"] {
        fs::copy(data("plain_rgb.exr"), folder.path(&format!("b.{frame}.exr"))).unwrap();
    }
    let args = |frames: &str| {
        let values = [
            ("Param.In", "b.####.exr"),
            ("Param.Out", "clean/b.####.exr"),
            ("Task.Param.Frames", frames),
            ("Param.Quality", "fast"),
        ];
        let mut args = arguments(&values);
        assert!(args.iter().all(|arg| !arg.contains("{{")), "{args:?}");
        // The built-in weights would be slow here.
        let quality = args.iter().position(|arg| arg == "--quality=fast").unwrap();
        args[quality] = format!("--weights={WEIGHTS}");
        args
    };
    let run = |frames: &str| {
        let args = args(frames);
        folder.run(&args.iter().map(String::as_str).collect::<Vec<_>>())
    };
    run("-1-0").assert_done();
    let names = || {
        let entries = fs::read_dir(folder.path("clean")).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names.collect::<BTreeSet<_>>()
    };
    assert_eq!(names(), ["b.-0001.exr", "b.0000.exr"].map(String::from).into());
    run("2-2").assert_done();
    assert_eq!(names().len(), 3);
    let again = run("-1-1");
    assert!(again.stderr.contains("; skipped 2 images whose outputs exist"), "{again:?}");
    assert_eq!(names().len(), 4);
}

/// The template uses exactly the parameters that it defines.
#[test]
fn the_job_template_defines_what_it_uses() {
    let defined = TEMPLATE.lines().filter_map(|line| line.strip_prefix("  - name: "));
    let defined: Vec<_> = defined.take_while(|name| *name != "Denoise").collect();
    assert_eq!(defined, ["In", "Out", "Frames", "FramesPerTask", "Quality", "Program"]);
    for name in &defined {
        assert!(TEMPLATE.contains(&format!("{{{{Param.{name}}}}}")), "{name}");
    }
    for used in TEMPLATE.split("{{Param.").skip(1) {
        let name = used.split_once("}}").unwrap().0;
        assert!(defined.contains(&name), "{name}");
    }
    assert!(TEMPLATE.starts_with("specificationVersion: jobtemplate-2023-09\n"));
}
