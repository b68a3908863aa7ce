use std::time::Duration;

use super::*;
use wgdenoise_files::frames::Frames;

fn words(line: &str) -> Vec<OsString> {
    line.split_whitespace().map(OsString::from).collect()
}

fn grammar(line: &str) -> Result<Cli, clap::Error> {
    Cli::try_parse_from(line.split_whitespace())
}

/// `wgdenoise help info` prints and ends the process, so this only asks the grammar.
#[test]
fn help_is_a_command_too() {
    let help = grammar("wgdenoise help info").unwrap_err();
    assert_eq!(help.kind(), clap::error::ErrorKind::DisplayHelp);
}

fn denoising(line: &str) -> Denoise {
    match parse(&words(line)) {
        Ok(Request::Denoise(request)) => request,
        other => panic!("{line}: {other:?}"),
    }
}

#[test]
fn the_grammar_is_consistent() {
    Cli::command().debug_assert();
}

#[test]
fn two_files_are_denoised_and_a_command_is_a_command() {
    let request = denoising("wgdenoise a.exr b.exr --force --parents");
    assert_eq!((request.inputs, request.output), (vec!["a.exr".into()], Some("b.exr".into())));
    assert!(request.writing.force && request.writing.parents && !request.writing.in_place);
    let is = |line: &str| parse(&words(line)).unwrap();
    assert!(matches!(is("wgdenoise info a.exr --json"), Request::Info(Info { json: true, .. })));
    assert!(matches!(is("wgdenoise devices"), Request::Devices { json: false }));
    assert!(matches!(is("wgdenoise profile --width 64"), Request::Profile(_)));
    denoising("wgdenoise -- info out.exr");
    let report = is("wgdenoise report a.exr b.exr --albedo c --out d --force");
    assert!(matches!(report, Request::Report(Report { force: true, .. })));
    let preview = is("wgdenoise preview a.exr b.png --exposure -1.5 --layer N");
    assert!(matches!(preview, Request::Preview(Preview { exposure: -1.5, .. })));
}

#[test]
fn several_images_may_stand_on_both_sides_of_flags() {
    for line in ["wgdenoise a b --frames 1-2,9 out", "wgdenoise a --frames=1,2,9 b out -q"] {
        let request = denoising(line);
        assert_eq!(request.inputs, ["a", "b"].map(PathBuf::from));
        assert_eq!(request.output, Some("out".into()));
        assert_eq!(request.frames, Some(Frames(vec![1, 2, 9])));
    }
}

#[test]
fn weights_come_from_one_place() {
    let weights = |flags: &str| denoising(&format!("wgdenoise a.exr b.exr {flags}")).weights;
    assert_eq!(weights(""), WeightsChoice::BuiltIn(Quality::Balanced));
    assert_eq!(weights("--quality fast"), WeightsChoice::BuiltIn(Quality::Fast));
    assert_eq!(weights("--weights w.tza"), WeightsChoice::File("w.tza".into()));
    let folder =
        |quality, prefilter| WeightsChoice::Folder { path: "src".into(), quality, prefilter };
    assert_eq!(weights("--weights src --prefilter"), folder(None, true));
    assert_eq!(weights("--weights src --quality high"), folder(Some(Quality::High), false));
    let limit = Duration::from_millis(40);
    assert_eq!(
        weights("--budget 40ms --recalibrate"),
        WeightsChoice::Budget { limit, recalibrate: true }
    );
}

#[test]
fn what_makes_no_sense_is_refused() {
    for line in [
        "wgdenoise a.exr",
        "wgdenoise a b --weights w.tza --quality fast",
        "wgdenoise a b --weights w.tza --prefilter",
    ] {
        assert!(matches!(parse(&words(line)), Err(Failure::Usage(_))), "{line}");
    }
    for line in [
        "wgdenoise a.exr b.exr --frames 9-1",
        "wgdenoise a.exr b.exr -q -v",
        "wgdenoise a.exr b.exr --quality best",
        "wgdenoise a.exr b.exr --prefilter",
        "wgdenoise a.exr b.exr --prefilter --weights folder --no-aux",
        "wgdenoise convert a.tza",
        "wgdenoise a.exr b.exr --no-aux --albedo x",
        "wgdenoise a.exr b.exr --input-scale 0",
        "wgdenoise a.exr b.exr --memory 0MiB",
        "wgdenoise a.exr b.exr --memory 512",
        "wgdenoise a.exr b.exr --timeout 60",
        "wgdenoise a.exr b.exr --budget 0ms",
        "wgdenoise a.exr b.exr --budget 40",
        "wgdenoise a.exr b.exr --budget 40ms --quality fast",
        "wgdenoise a.exr b.exr --budget 40ms --weights w.safetensors",
        "wgdenoise a.exr b.exr --recalibrate",
        "wgdenoise a.exr b.exr --exposure bright",
        "wgdenoise bench --runs 0",
        "wgdenoise bench --no-aux",
        "wgdenoise bench --kernels best",
        "wgdenoise bench --profile",
        "wgdenoise bench --report a.exr b.exr",
        "wgdenoise profile --json",
        "wgdenoise report a.exr",
        "wgdenoise report a.exr b.exr --quality fast",
        "wgdenoise report a.exr b.exr --force",
        "wgdenoise preview a.exr",
        "wgdenoise compare a.exr",
        "wgdenoise completions tcsh",
    ] {
        assert!(grammar(line).is_err(), "{line}");
    }
}

#[test]
fn a_misspelled_command_is_answered_with_the_command() {
    for (word, command) in [
        ("compar", "compare"),
        ("infoo", "info"),
        ("Info", "info"),
        ("ifno", "info"),
        ("prevew", "preview"),
        ("device", "devices"),
        ("bensh", "bench"),
        ("completion", "completions"),
        ("hlep", "help"),
    ] {
        for rest in ["", " a.exr", " a.exr b.exr", " a.exr --json"] {
            let error = parse(&words(&format!("wgdenoise {word}{rest}"))).unwrap_err();
            assert!(matches!(error, Failure::Usage(_)));
            let text = error.to_string();
            assert!(text.contains(&format!("did you mean `wgdenoise {command}`?")), "{text}");
        }
    }
    // A command, files that exist, names of files, and words that resemble no command.
    for word in ["info", "help", "src", "compar.exr", "./infoo", "render", "a", "-v"] {
        assert_eq!(misspelled(OsStr::new(word)), None, "{word}");
    }
}

#[test]
fn a_lone_word_is_answered_by_what_it_lacks() {
    let error = |word: &str| parse(&words(&format!("wgdenoise {word}"))).unwrap_err().to_string();
    for word in ["render", "nowhere.exr", "./infoo"] {
        assert_eq!(error(word), format!("`{word}` is neither a file nor a command; see --help"));
    }
    for word in ["Cargo.toml", "beauty.####.exr", "renders/*.exr"] {
        assert!(error(word).contains(&format!("write wgdenoise {word} OUT")), "{word}");
    }
}

#[test]
fn images_that_replace_themselves_need_no_output() {
    let output = |files: &str| denoising(&format!("wgdenoise {files} --in-place")).output;
    for files in ["a.exr", "a.####.exr", "Cargo.toml", "Cargo.toml src/lib.rs", "a.exr *.exr"] {
        assert_eq!(output(files), None, "{files}");
    }
    for (files, out) in [
        ("Cargo.toml Cargo.toml", "Cargo.toml"),
        ("Cargo.toml ./src/../Cargo.toml", "./src/../Cargo.toml"),
        ("Cargo.toml nowhere.exr", "nowhere.exr"),
        ("Cargo.toml src", "src"),
        ("a.####.exr b.####.exr", "b.####.exr"),
    ] {
        assert_eq!(output(files), Some(out.into()), "{files}");
    }
    assert_eq!(denoising("wgdenoise Cargo.toml src/lib.rs").output, Some("src/lib.rs".into()));
}
