use clap::CommandFactory;

use super::*;

fn parse(line: &str) -> Result<Cli, clap::Error> {
    Cli::try_parse_from(line.split_whitespace())
}

#[test]
fn the_grammar_holds_together() {
    Cli::command().debug_assert();
}

#[test]
fn two_files_are_denoised_and_a_command_is_a_command() {
    let denoise = parse("wgdenoise a.exr b.exr --force").unwrap().denoise;
    assert_eq!(denoise.files().unwrap(), (&[PathBuf::from("a.exr")][..], Path::new("b.exr")));
    assert!(denoise.force);
    let info = parse("wgdenoise info a.exr --json").unwrap();
    assert!(matches!(info.command, Some(Command::Info(_))));
    assert!(matches!(parse("wgdenoise devices").unwrap().command, Some(Command::Devices(_))));
    let named_info = parse("wgdenoise -- info out.exr").unwrap();
    assert!(named_info.command.is_none() && named_info.denoise.files().is_ok());
    parse("wgdenoise bench --report a.exr b.exr --albedo c --out d --force").unwrap();
}

#[test]
fn several_pictures_may_stand_on_both_sides_of_flags() {
    for line in ["wgdenoise a b --frames 1-2,9 out", "wgdenoise a --frames=1,2,9 b out -q"] {
        let denoise = parse(line).unwrap().denoise;
        let files = ["a", "b"].map(PathBuf::from);
        assert_eq!(denoise.files().unwrap(), (&files[..], Path::new("out")));
        assert_eq!(denoise.frames, Some(Frames(vec![1, 2, 9])));
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    assert!(parse("wgdenoise a.exr").unwrap().denoise.files().is_err());
    for line in [
        "wgdenoise a.exr b.exr --frames 9-1",
        "wgdenoise a.exr b.exr -q -v",
        "wgdenoise a.exr b.exr --quality best",
        "wgdenoise a.exr b.exr --prefilter",
        "wgdenoise a.exr b.exr --prefilter --weights folder --no-aux",
        "wgdenoise convert a.tza",
        "wgdenoise a.exr b.exr --no-aux --albedo x",
        "wgdenoise a.exr b.exr --input-scale 0",
        "wgdenoise a.exr b.exr --memory 0",
        "wgdenoise a.exr b.exr --budget 0",
        "wgdenoise a.exr b.exr --budget 40 --quality fast",
        "wgdenoise a.exr b.exr --budget 40 --weights w.safetensors",
        "wgdenoise a.exr b.exr --recalibrate",
        "wgdenoise bench --runs 0",
        "wgdenoise bench --report a.exr",
        "wgdenoise bench --report a.exr b.exr --quality fast",
        "wgdenoise bench --out folder",
        "wgdenoise bench --no-aux",
        "wgdenoise bench --kernels best",
        "wgdenoise compare a.exr",
    ] {
        assert!(parse(line).is_err(), "{line}");
    }
}
