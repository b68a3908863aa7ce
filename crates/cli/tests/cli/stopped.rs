//! Stopping runs, and continuing stopped ones.

use std::fs;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::support::{Folder, Run, WEIGHTS, data};

/// A folder with frames 1 to 60, which take a while, and a folder for the results.
fn animation() -> Folder {
    let folder = Folder::new();
    for frame in 1..=FRAMES {
        fs::copy(data("blender5_parts.exr"), folder.path(&format!("b.{frame:02}.exr"))).unwrap();
    }
    fs::create_dir(folder.path("out")).unwrap();
    folder
}

const FRAMES: usize = 60;

fn results(folder: &Folder) -> Vec<String> {
    let entries = fs::read_dir(folder.path("out")).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Waits until `is_time`, then sends a signal.
fn stop(mut child: Child, signal: &str, is_time: impl Fn(u32) -> bool) -> Run {
    let (id, start) = (child.id(), Instant::now());
    while !is_time(id) {
        assert!(start.elapsed() < Duration::from_mins(2), "nothing happens");
        assert!(child.try_wait().unwrap().is_none(), "it ended before it was stopped");
        std::thread::sleep(Duration::from_millis(2));
    }
    let kill = Command::new("kill").args(["-s", signal, &id.to_string()]).status().unwrap();
    assert!(kill.success());
    Run::of(&child.wait_with_output().unwrap())
}

#[test]
fn a_stopped_sequence_leaves_whole_results_and_goes_on_later() {
    let folder = animation();
    let all = ["b.##.exr", "out", "--weights", WEIGHTS];
    let mut command = folder.command(&all);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let run = stop(child, "INT", |_| results(&folder).len() > 2);
    assert_eq!((run.code, run.stdout.as_str()), (130, ""), "{run:?}");
    let last = run.stderr.lines().last().unwrap();
    assert!(last.starts_with("wgdenoise: stopped after "), "{run:?}");
    assert!(last.ends_with(" of 60 images; give --skip-existing to resume"), "{run:?}");

    let written = results(&folder);
    assert!(written.len() < FRAMES && written.iter().all(|name| name.starts_with("b.")));
    let modified =
        |name: &String| fs::metadata(folder.path("out").join(name)).unwrap().modified().unwrap();
    let before: Vec<_> = written.iter().map(modified).collect();
    let run = folder.run(&[&all[..], &["--skip-existing"]].concat());
    run.assert_done();
    let rest = FRAMES - written.len();
    let wrote = format!("wgdenoise: wrote {rest} images in ");
    let skipped = format!("; skipped {} images whose outputs exist", written.len());
    let last = run.stderr.lines().last().unwrap();
    assert!(last.starts_with(&wrote) && last.ends_with(&skipped), "{run:?}");
    assert_eq!(written.iter().map(modified).collect::<Vec<_>>(), before);
    let bytes = results(&folder).into_iter().map(|n| fs::read(folder.path("out").join(n)).unwrap());
    let mut bytes: Vec<_> = bytes.collect();
    assert_eq!(bytes.len(), FRAMES);
    bytes.dedup();
    assert_eq!(bytes.len(), 1);

    let run = folder.run(&[&all[..], &["--skip-existing"]].concat());
    run.assert_done();
    let done = "wgdenoise: nothing to do: skipped 60 images whose outputs exist\n";
    assert_eq!(run.stderr, done);
    for other in ["--force", "--in-place"] {
        let run = folder.run(&[&all[..], &["--skip-existing", other]].concat());
        assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{run:?}");
    }
}

#[test]
fn a_stopped_run_that_replaces_files_does_not_advise_to_skip_them() {
    let folder = animation();
    let mut command = folder.command(&["b.##.exr", "--in-place", "--weights", WEIGHTS]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let before = fs::read(folder.path("b.01.exr")).unwrap();
    let run = stop(child, "INT", |_| fs::read(folder.path("b.02.exr")).unwrap() != before);
    let last = run.stderr.lines().last().unwrap();
    assert!(last.ends_with(" of 60 images; the other files are unchanged"), "{run:?}");
    assert!(fs::read(folder.path("b.60.exr")).unwrap() == before);
}

/// Whether a process catches SIGINT, the second bit of its signal mask.
fn is_ready(id: u32) -> bool {
    let status = fs::read_to_string(format!("/proc/{id}/status")).unwrap();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
    let threads = fs::read_dir(format!("/proc/{id}/task")).unwrap().count();
    u64::from_str_radix(mask.trim(), 16).unwrap() & 2 != 0 && threads > 2
}

/// The program waits for the end of its input.
#[test]
fn a_stop_before_the_first_result_leaves_nothing_and_has_the_code_of_its_signal() {
    for (signal, code) in [("INT", 130), ("TERM", 143)] {
        let folder = Folder::new();
        let mut command = folder.command(&["-", "out.exr", "-q", "--weights", WEIGHTS]);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let stdin = child.stdin.take();
        let run = stop(child, signal, is_ready);
        let says = "wgdenoise: stopped before an image was written\n";
        assert_eq!((run.code, run.stderr.as_str()), (code, says), "{run:?}");
        assert!(folder.names().is_empty());
        drop(stdin);
    }
}

#[test]
fn two_runs_that_skip_what_exists_share_a_folder() {
    let folder = animation();
    let words = ["b.##.exr", "out", "--weights", WEIGHTS, "--skip-existing", "--frames", "1-12"];
    let start = || {
        let mut command = folder.command(&words);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    };
    for child in [start(), start()] {
        Run::of(&child.wait_with_output().unwrap()).assert_done();
    }
    assert_eq!(results(&folder).len(), 12);
}
