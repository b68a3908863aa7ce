//! Reads and rejects Open Image Denoise's weights. The files are small ones with random weights,
//! made by `training/make_oidn_fixtures.py`.

use std::path::Path;

use proptest::prelude::*;
use wgdenoise::internals::model::Metadata;
use wgdenoise::internals::model::tza::{self, KINDS};
use wgdenoise::internals::reference::{self, Tensor};
use wgdenoise::{Inputs, Weights};
use wgdenoise_testing::Tolerance;
use wgdenoise_testing::fixture::Fixture;

const NAMES: [&str; 3] = ["rt_hdr_alb_nrm", "rt_hdr_alb_nrm_large", "rt_alb"];

/// About twenty layers that round their results to 32 bits. Measured 1e-7.
const WHOLE_NETWORK: Tolerance = Tolerance { absolute: 5e-7, relative: 0.0 };

fn file(name: &str) -> Vec<u8> {
    let root = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_else(|_| ".".into());
    std::fs::read(format!("{root}/tests/fixtures/oidn/{name}.tza")).expect("the fixture exists")
}

#[track_caller]
fn refused(bytes: &[u8], name: &str, expected: &str) {
    let message = Weights::from_tza(bytes, name).expect_err("it should be refused").to_string();
    assert!(message.contains(expected), "`{message}` does not say `{expected}`");
}

#[test]
fn the_networks_make_what_pytorch_makes() {
    let f = Fixture::open("oidn/io");
    for name in NAMES {
        let weights = Weights::from_tza(&file(name), name).unwrap();
        let params = |layer: &str| weights.params(layer);
        let all = f.tensor("input");
        let channels = weights.metadata().inputs.channels();
        let input = Tensor::from_fn(channels, all.height, all.width, |c, y, x| all.at(c, y, x));
        let found = reference::run(weights.network(), params, &input);
        f.expect(&format!("expected.{name}"), &found, WHOLE_NETWORK);
    }
}

#[test]
fn the_converted_file_holds_the_same() {
    let bytes = tza::to_safetensors(&file(NAMES[0]), NAMES[0]).unwrap();
    let weights = Weights::from_bytes(&bytes).unwrap();
    let metadata = weights.metadata();
    assert_eq!((metadata.name.as_str(), metadata.inputs), (NAMES[0], Inputs::ALL));
    assert_eq!(metadata.widths.len(), 15);
    let direct = Weights::from_tza(&file(NAMES[0]), NAMES[0]).unwrap();
    for layer in &weights.network().layers {
        assert_eq!(weights.params(&layer.name), direct.params(&layer.name), "{}", layer.name);
    }
}

#[test]
fn a_name_that_says_something_else_than_the_file_is_refused() {
    refused(&file(NAMES[0]), "weights", "`weights` is not the name of any Open Image Denoise");
    for kind in KINDS.iter().filter(|kind| kind.inputs != Inputs::ALL) {
        refused(&file(NAMES[0]), kind.stem, "reads 9 channels, but by its name");
    }
}

#[test]
fn fewer_inputs_than_the_network_was_trained_with_are_refused() {
    let weights = Weights::from_tza(&file(NAMES[0]), NAMES[0]).unwrap();
    let [albedo, normal] = [true, false].map(|albedo| Inputs { albedo, normal: !albedo });
    // No file takes color with normals only.
    for (given, file) in [(Inputs::default(), "hdr"), (albedo, "hdr_alb"), (normal, "hdr")] {
        let message = weights.for_inputs(given).unwrap_err().to_string();
        let expected = format!(
            "needs color, albedo, normal, but {given} was given; use weights that need no more, \
             such as rt_{file}.tza"
        );
        assert!(message.ends_with(&expected), "{message}");
    }
    weights.for_inputs(Inputs::ALL).unwrap();
}

#[test]
fn what_is_no_whole_file_is_refused() {
    let whole = file(NAMES[0]);
    for length in [0, 1, 11, 12, 40, whole.len() / 2, whole.len() - 1] {
        refused(&whole[..length], NAMES[0], "not a whole TZA file: ");
    }
    let with = |at: usize, bytes: &[u8]| {
        let mut file = whole.clone();
        file[at..at + bytes.len()].copy_from_slice(bytes);
        file
    };
    refused(&with(0, b"PK"), NAMES[0], "weights: TZA file: the signature is missing");
    refused(b"<html>", NAMES[0], "weights: TZA file: the signature is missing");
    refused(&with(2, &[3]), NAMES[0], "weights: TZA file: version 3.0, but this reads 2.x only");
    refused(&with(4, &[0xff; 8]), NAMES[0], "not a whole TZA file: ");
}

#[test]
fn more_tensors_than_any_network_has_are_refused_before_they_are_read() {
    let with = |count: u32| {
        let mut file = file(NAMES[0]);
        let table = usize::from_le_bytes(*file[4..].first_chunk().unwrap());
        file[table..table + 4].copy_from_slice(&count.to_le_bytes());
        file
    };
    refused(&with(64), NAMES[0], "not a whole TZA file: ");
    refused(&with(65), NAMES[0], "weights: TZA file: 65 tensors, expected at most 64");
}

#[test]
fn the_format_is_told_by_the_name_and_else_by_the_beginning() {
    let safetensors = [&16855_u64.to_le_bytes()[..], b"{\"__metadata__\":"].concat();
    for (name, bytes, expected) in [
        ("a", &file(NAMES[0])[..], true),
        ("a.safetensors", &file(NAMES[0]), true),
        ("a.tza", b"version https://git-lfs.github.com/spec/v1", true),
        ("a.TZA", b"", true),
        ("a.safetensors", &safetensors, false),
        ("tza", b"", false),
    ] {
        assert_eq!(tza::is_tza(Path::new(name), bytes), expected, "{name}");
    }
}

#[test]
fn wrong_widths_are_answered_with_how_many_there_must_be() {
    for (topology, count) in [("oidn", "15"), ("oidn-large", "18"), ("unet", "2 to 8")] {
        let pairs = [("topology", topology), ("widths", "1"), ("name", "a")];
        let pairs = pairs.into_iter().chain([("format", "wgdenoise"), ("format_version", "1")]);
        let pairs = pairs.map(|(key, value)| (key.to_string(), value.to_string())).collect();
        let message = Metadata::parse(&pairs).unwrap_err().to_string();
        let expected = format!("metadata `widths` is `1`, expected {count} numbers from 1 to 1024");
        assert!(message.contains(&expected), "{message}");
    }
}

/// The file with bytes replaced at `offset` from the start of the last `text` in it, which is in
/// the table.
fn changed(text: &str, offset: usize, bytes: &[u8]) -> Vec<u8> {
    let mut file = file(NAMES[0]);
    let starts = (0..file.len()).rev().find(|&at| file[at..].starts_with(text.as_bytes()));
    let at = starts.expect("the text is in the table") + offset;
    file[at..at + bytes.len()].copy_from_slice(bytes);
    file
}

#[test]
fn tables_that_cannot_be_are_refused() {
    // After the name: dimensions, four sizes, layout, type, offset.
    let name = "enc_conv2.weight";
    let cases: [(&[u8], usize, &str); 7] = [
        (&[9], 0, "has 9 dimensions, expected 1 or 4"),
        (&[0xff; 4], 1, "lies outside the file"),
        (&[100, 0, 0, 0], 1, "weights: TZA file: the tensors up to `"),
        (&[0; 4], 1, "`enc_conv2` makes 0 channels"),
        (b"ohwi", 17, "`enc_conv2.weight` has layout `ohwi`, expected `oihw` or `x`"),
        (b"d", 21, "`enc_conv2.weight` has an unknown type"),
        (&[0xff; 8], 22, "lies outside the file"),
    ];
    for (bytes, offset, expected) in cases {
        refused(&changed(name, name.len() + offset, bytes), NAMES[0], expected);
    }
}

#[test]
fn tensors_that_do_not_make_the_network_are_refused() {
    let renamed = |to: &str| changed("enc_conv3.bias", 0, to.as_bytes());
    refused(&renamed("enc_conv2"), NAMES[0], "tensor `enc_conv2.bias` appears twice");
    refused(&renamed("enc conv3"), NAMES[0], "a tensor's name does not consist of 1 to 64 letters");
    refused(&renamed("enc_conv9"), NAMES[0], "tensor `enc_conv3.bias` is missing");
    // The very first value, as a 16-bit float.
    let mut infinite = file(NAMES[0]);
    infinite[64..66].copy_from_slice(&[0x00, 0x7c]);
    refused(&infinite, NAMES[0], "`enc_conv0.weight` has inf at element 0");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    /// Whatever the file contains, reading it returns a result.
    #[test]
    fn damaged_files_do_not_panic(at in 0.0..1.0_f64, bytes: [u8; 5], cut in 0.0..4.0_f64) {
        let mut file = file(NAMES[0]);
        let place = (at * (file.len() - 5) as f64) as usize;
        file[place..place + 5].copy_from_slice(&bytes);
        file.truncate((cut * file.len() as f64) as usize);
        let _ = Weights::from_tza(&file, NAMES[0]);
    }
}
