use serde_json::Value;

use crate::support::{Folder, Run};

/// A small render and its reference.
const FILES: [&str; 2] = ["karma_like.exr", "blender4_single_part.exr"];

fn report(folder: &Folder, args: &[&str]) -> Run {
    for file in FILES {
        folder.copy(file);
    }
    folder.run(&[&["report"], &FILES[..], args].concat())
}

fn rows(json: &Value) -> &[Value] {
    json["configurations"].as_array().unwrap()
}

fn name(row: &Value) -> String {
    format!("{} {}", row["quality"].as_str().unwrap(), row["precision"].as_str().unwrap())
}

#[test]
fn every_configuration_is_measured_and_drawn() {
    let folder = Folder::new();
    let run = report(&folder, &["--runs", "2", "--out", "new/folder"]);
    let wrote = "wgdenoise: wrote report.md, report.json and report.svg to new/folder\n";
    assert_eq!((run.code, run.stderr.as_str()), (0, wrote), "{run:?}");
    let read = |name: &str| std::fs::read_to_string(folder.path("new/folder").join(name)).unwrap();
    let json: Value = serde_json::from_str(&read("report.json")).unwrap();
    assert_eq!((rows(&json).len(), json["width"].as_u64()), (18, Some(40)), "{json}");
    for row in rows(&json) {
        assert_eq!(row["seconds"].as_array().unwrap().len(), 2, "{row}");
        let cell = format!("| {} | ", name(row).replace(' ', " | "));
        assert_eq!(run.stdout.matches(&cell).count(), 3, "no `{cell}` in {}", run.stdout);
        let relative = row["l1"].as_f64().unwrap() / json["noisy_l1"].as_f64().unwrap();
        assert_eq!(row["l1_of_noisy"].as_f64(), Some(relative), "{row}");
    }
    let front = rows(&json).iter().filter(|row| row["front"] == true).count();
    assert_eq!(run.stdout.matches("| yes |").count(), front);
    assert!(front > 0 && read("report.md").starts_with(&run.stdout), "{}", read("report.md"));
    let plot = read("report.svg");
    // The legend has three circles, and nine configurations have circles too, each at least twice.
    assert!(plot.trim_end().ends_with("</svg>") && plot.matches("<circle").count() >= 24);
    for text in ["karma_like.exr, 40×30", "balanced", "color, albedo, normal", "milliseconds"] {
        assert!(plot.contains(text), "no `{text}` in {plot}");
    }
}

#[test]
fn the_errors_are_those_that_compare_finds() {
    let folder = Folder::new();
    let json = report(&folder, &["--runs", "1", "--no-aux", "--json"]).json();
    assert_eq!(rows(&json).len(), 6, "{json}");
    let compare = |image: &str| folder.run(&["compare", image, FILES[1], "--json"]).json();
    assert_eq!(compare(FILES[0])["l1"], json["noisy_l1"]);
    for row in [&rows(&json)[0], &rows(&json)[3]] {
        let (quality, precision) = (&row["quality"], &row["precision"]);
        let denoise = [FILES[0], "out.png", "--no-aux", "--force", "-q"];
        let chosen =
            ["--quality", quality.as_str().unwrap(), "--precision", precision.as_str().unwrap()];
        folder.run(&[&denoise[..], &chosen].concat()).assert_done();
        // The 8-bit output differs by at most half a step.
        let found = compare("out.png")["l1"].as_f64().unwrap();
        assert!((found - row["l1"].as_f64().unwrap()).abs() < 0.5 / 255.0, "{row}: {found}");
    }
}

#[test]
fn a_configuration_that_fails_is_a_row_with_the_reason() {
    let folder = Folder::new();
    // At this size, 1 MiB holds the tensors of all but one configuration.
    let picture = image::RgbImage::from_fn(64, 40, |x, y| image::Rgb([x as u8, y as u8, 90]));
    picture.save(folder.path("picture.png")).unwrap();
    let files = ["report", "picture.png", "picture.png"];
    let args = ["--runs", "1", "--no-aux", "--memory", "1MiB"];
    let report = |more: &[&str]| folder.run(&[&files[..], &args, more].concat());
    let json = report(&["--json"]).json();
    let failed: Vec<_> = rows(&json).iter().filter(|row| row["error"].is_string()).collect();
    assert_eq!((rows(&json).len(), failed.len()), (6, 1), "{json}");
    assert_eq!((name(failed[0]).as_str(), &failed[0]["front"]), ("high f32", &false.into()));
    let error = failed[0]["error"].as_str().unwrap();
    assert!(error.contains("the memory budget is 1 MiB"), "{error}");
    let text = report(&[]).stdout;
    assert!(text.contains("| high | f32 | color | failed: memory: a tile needs"), "{text}");
}

#[test]
fn nothing_measured_is_a_failure() {
    let folder = Folder::new();
    let run = report(&folder, &["--tile", "16", "--out", "report", "--no-aux"]);
    assert_eq!((run.code, run.stdout.matches("failed: ").count()), (1, 6), "{run:?}");
    assert!(run.stderr.contains("nothing could be measured"), "{run:?}");
}

#[test]
fn files_that_do_not_match_are_one_sentence() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    folder.copy("karma_like.exr");
    let report = |files: [&str; 2]| folder.run(&[&["report"], &files[..]].concat());
    report(["karma_like.exr", "plain_rgb.exr"]).assert_failed(1, &["40×30", "37×23"]);
    report(["karma_like.exr", "nowhere.exr"]).assert_failed(1, &["nowhere.exr: cannot be read"]);
    report(["nowhere.exr", "karma_like.exr"]).assert_failed(1, &["nowhere.exr: cannot be read"]);
}

#[test]
fn a_report_that_exists_is_kept_unless_forced() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("out")).unwrap();
    std::fs::write(folder.path("out/report.svg"), "old").unwrap();
    let args = ["--runs", "1", "--no-aux", "--out", "out"];
    report(&folder, &args).assert_failed(1, &["report.svg: already exists", "--force"]);
    assert_eq!(std::fs::read_to_string(folder.path("out/report.svg")).unwrap(), "old");
    assert_eq!(report(&folder, &[&args[..], &["--force"]].concat()).code, 0);
    assert!(std::fs::read_to_string(folder.path("out/report.svg")).unwrap().contains("<svg"));
    report(&folder, &["--out", FILES[0]]).assert_failed(1, &["karma_like.exr: cannot be"]);
}

#[test]
fn bench_and_report_keep_their_flags_apart() {
    let folder = Folder::new();
    for args in [
        &["report", "a.exr"][..],
        &["report", "a.exr", "b.exr", "--quality", "fast"],
        &["report", "a.exr", "b.exr", "--precision", "f32"],
        &["report", "a.exr", "b.exr", "--width", "64"],
        &["bench", "--report", "a.exr", "b.exr"],
        &["bench", "--out", "folder"],
        &["bench", "--albedo", "a.exr"],
    ] {
        let run = folder.run(args);
        assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{args:?}: {run:?}");
    }
}
