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
    assert_eq!(denoise.files(), Some((Path::new("a.exr"), Path::new("b.exr"))));
    assert!(denoise.force);
    let info = parse("wgdenoise info a.exr --json").unwrap();
    assert!(matches!(info.command, Some(Command::Info(_))));
    assert!(matches!(parse("wgdenoise devices").unwrap().command, Some(Command::Devices(_))));
    let named_info = parse("wgdenoise -- info out.exr").unwrap();
    assert!(named_info.command.is_none() && named_info.denoise.files().is_some());
    parse("wgdenoise bench --report a.exr b.exr --albedo c --out d --force").unwrap();
}

#[test]
fn what_makes_no_sense_is_refused() {
    for line in [
        "wgdenoise a.exr",
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
