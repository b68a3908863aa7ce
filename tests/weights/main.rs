//! Every fault in a weights file is rejected with its reason.

mod file;
mod lies;

use safetensors::Dtype;
use wgdenoise::{Inputs, Quality, Weights};

use self::file::File;

#[track_caller]
fn refused(bytes: &[u8], expected: &str) {
    let message = Weights::from_bytes(bytes).expect_err("it should be refused").to_string();
    assert!(message.contains(expected), "`{message}` does not say `{expected}`");
}

#[test]
fn a_valid_file_is_read_in_either_type() {
    let mut file = File::valid();
    let weights = Weights::from_bytes(&file.bytes()).unwrap();
    assert_eq!(weights.metadata().widths, [2, 3]);
    assert_eq!(weights.params("dec_up0").weight, [0.25; 3 * 2 * 2 * 2]);
    let halves = half::f16::from_f32(0.25).to_le_bytes().repeat(6);
    file.tensors.insert("out_conv.weight".into(), (Dtype::F16, vec![3, 2, 1, 1], halves));
    let weights = Weights::from_bytes(&file.bytes()).unwrap();
    assert_eq!(weights.params("out_conv").weight, [0.25; 6]);
}

#[test]
fn the_built_in_weights_are_valid() {
    for quality in [Quality::Fast, Quality::Balanced, Quality::High] {
        let weights = Weights::builtin(quality).unwrap();
        assert_eq!(weights.metadata().inputs, Inputs::ALL, "{quality:?}");
        assert!(!weights.metadata().provenance.is_empty(), "{quality:?}");
    }
}

#[test]
fn what_is_no_whole_safetensors_file_is_refused() {
    refused(b"", "not a whole safetensors file");
    refused(b"no weights at all, but long enough", "not a whole safetensors file");
    let bytes = File::valid().bytes();
    refused(&bytes[..bytes.len() - 1], "not a whole safetensors file");
    let mut bomb = (u64::MAX / 2).to_le_bytes().to_vec();
    bomb.extend(b"{}");
    refused(&bomb, "not a whole safetensors file");
}

#[test]
fn metadata_of_another_format_is_refused() {
    for key in ["format", "format_version", "transfer_function", "topology"] {
        let expected = format!("metadata `{key}` is `other`, but this version reads only");
        File::valid().set(key, "other").is_refused(&expected);
    }
    for key in ["format", "widths", "inputs", "name", "provenance"] {
        let mut file = File::valid();
        file.metadata.remove(key);
        file.is_refused(&format!("metadata `{key}` is missing"));
    }
    let mut file = File::valid();
    file.metadata.clear();
    file.is_refused("metadata");
}

#[test]
fn metadata_with_impossible_values_is_refused() {
    for widths in ["", "2", "2,0", "2,x", "2,3000", "1,1,1,1,1,1,1,1,1", "-2,3"] {
        File::valid().set("widths", widths).is_refused("metadata `widths` is");
    }
    File::valid().set("inputs", "color,normal").is_refused("metadata `inputs` is `color,normal`");
    for eps in ["0", "-1e-5", "NaN", "2", "small"] {
        File::valid().set("norm_eps", eps).is_refused("metadata `norm_eps` is");
    }
}

#[test]
fn missing_unknown_and_misshapen_tensors_are_refused_by_name() {
    let mut file = File::valid();
    file.tensors.remove("mid_convb.weight");
    file.is_refused("tensor `mid_convb.weight` is missing, expected shape [3, 3, 3, 3]");

    let mut file = File::valid();
    file.tensors.remove("out_conv.bias");
    file.is_refused("tensor `out_conv.bias` is missing, expected shape [3]");

    let mut file = File::valid();
    file.fill("enc_conv1a.weight", &[2, 2, 3, 3], 0.0);
    file.is_refused("tensor `enc_conv1a.weight`");

    let mut file = File::valid();
    file.fill("dec_up0.weight", &[2, 3, 2, 2], 0.0);
    file.is_refused("`dec_up0.weight` has shape [2, 3, 2, 2], expected [3, 2, 2, 2]");

    File::valid().set("widths", "2,4").is_refused("has shape");
    File::valid().set("inputs", "color,albedo").is_refused("expected [2, 6, 3, 3]");
}

#[test]
fn a_kernel_pyramid_has_11_or_12_logits_at_full_resolution() {
    let with = |logits: [usize; 2]| {
        let mut file = File::kernel_pyramid();
        file.fill("kernel_conv0.weight", &[logits[0], 2, 1, 1], 0.25);
        file.fill("kernel_conv0.bias", &[logits[1]], 0.5);
        file
    };
    for logits in [11, 12] {
        let weights = Weights::from_bytes(&with([logits; 2]).bytes()).unwrap();
        assert_eq!(weights.params("kernel_conv0").bias.len(), logits);
        assert_eq!(weights.network().demodulates(), logits == 12);
        let sliced = weights.for_inputs(Inputs::default()).unwrap();
        assert_eq!(sliced.network().demodulates(), logits == 12);
    }
    with([10, 10])
        .is_refused("`kernel_conv0.weight` has shape [10, 2, 1, 1], expected [11, 2, 1, 1]");
    with([13, 13]).is_refused("expected [11, 2, 1, 1]");
    with([11, 12])
        .is_refused("`kernel_conv0.weight` has shape [11, 2, 1, 1], expected [12, 2, 1, 1]");
    let mut coarse = with([12, 12]);
    coarse.fill("kernel_conv1.bias", &[12], 0.5);
    coarse.is_refused("`kernel_conv1.bias` has shape [12], expected [10]");
    let mut unet = File::valid();
    unet.fill("kernel_conv0.bias", &[12], 0.5);
    unet.is_refused("tensor `kernel_conv0.bias` (one of 1 such) belongs to no layer");
}

#[test]
fn other_types_and_values_that_are_no_numbers_are_refused() {
    let mut file = File::valid();
    let doubles = 0.25_f64.to_le_bytes().repeat(6);
    file.tensors.insert("out_conv.weight".into(), (Dtype::F64, vec![3, 2, 1, 1], doubles));
    file.is_refused("`out_conv.weight` has type F64, expected F16 or F32");

    for bad in [f32::NAN, f32::INFINITY] {
        let mut file = File::valid();
        let bytes = &mut file.tensors.get_mut("mid_conva.weight").unwrap().2;
        bytes[20..24].copy_from_slice(&bad.to_le_bytes());
        file.is_refused(&format!("`mid_conva.weight` has {bad} at element 5"));
    }
}

#[test]
fn norms_that_are_incomplete_or_impossible_are_refused() {
    let mut file = File::valid();
    file.norm("mid_conva", 3);
    Weights::from_bytes(&file.bytes()).unwrap();

    let mut incomplete = file.clone();
    incomplete.tensors.remove("mid_conva.norm.running_var");
    incomplete.is_refused("tensor `mid_conva.norm.running_var` is missing");

    let mut headless = file.clone();
    headless.tensors.remove("mid_conva.norm.weight");
    headless.is_refused("tensor `mid_conva.norm.bias`");

    let mut negative = file.clone();
    negative.fill("mid_conva.norm.running_var", &[3], -1.0);
    negative.is_refused("`mid_conva.norm.running_var`[0] is -1, expected at least 0");

    let mut huge = file.clone();
    huge.fill("mid_conva.norm.weight", &[3], f32::MAX);
    huge.fill("mid_conva.weight", &[3, 2, 3, 3], 1e9);
    huge.is_refused("with its norm folded in");

    let mut without_eps = file.clone();
    without_eps.metadata.remove("norm_eps");
    without_eps.is_refused("metadata `norm_eps` is missing");

    let mut elsewhere = File::valid();
    elsewhere.norm("dec_up0", 2);
    elsewhere.is_refused("tensor `dec_up0.norm.bias`");
}

#[test]
fn inputs_that_the_network_was_not_trained_with_are_refused() {
    let weights = Weights::from_bytes(&File::valid().bytes()).unwrap();
    let message = weights.for_inputs(Inputs::ALL).unwrap_err().to_string();
    assert!(message.contains("`test` was trained with color"), "{message}");
}
