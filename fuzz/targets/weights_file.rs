//! Fuzzes bytes as a weights file of either format: rejected with a short sentence, or a network
//! within the documented limits.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use wgdenoise::internals::model::{Topology, tza};
use wgdenoise::{Error, Inputs, Weights};

/// Maximum length of an error message in bytes; it truncates names and values from the file.
const LONGEST_ERROR: usize = 1000;

fuzz_target!(|bytes: &[u8]| {
    if tza::is_tza(Path::new(""), bytes) {
        // The name selects 3, 6 or 9 channels.
        for name in ["rt_alb", "rt_hdr_alb", "rt_hdr_alb_nrm"] {
            judge(Weights::from_tza(bytes, name));
        }
    } else {
        judge(Weights::from_bytes(bytes));
    }
});

fn judge(read: Result<Weights, Error>) {
    match read {
        Ok(weights) => check(&weights),
        Err(error) => {
            let text = error.to_string();
            assert!(text.len() <= LONGEST_ERROR, "an error of {} bytes", text.len());
            assert!(!text.chars().any(char::is_control), "{text:?}");
        }
    }
}

/// An accepted file must conform to `weights-format.md`.
fn check(weights: &Weights) {
    let metadata = weights.metadata();
    let counts = match metadata.topology {
        Topology::Unet => 2..=8,
        Topology::Oidn(size) => size.convolutions() - 1..=size.convolutions() - 1,
    };
    assert!(counts.contains(&metadata.widths.len()), "{metadata:?}");
    assert!(metadata.widths.iter().all(|width| (1..=1024).contains(width)), "{metadata:?}");
    assert!(metadata.norm_eps.is_none_or(|eps| eps > 0.0 && eps < 1.0), "{metadata:?}");
    assert!(!metadata.name.chars().any(char::is_control), "{metadata:?}");
    for layer in weights.network().layers.iter().filter(|layer| layer.op.has_weights()) {
        let params = weights.params(&layer.name);
        assert!(!params.weight.is_empty() && !params.bias.is_empty(), "{}", layer.name);
        assert!(params.weight.iter().chain(&params.bias).all(|v| v.is_finite()), "{}", layer.name);
    }
    for inputs in [[false, false], [true, false], [false, true], [true, true]] {
        let inputs = Inputs { albedo: inputs[0], normal: inputs[1] };
        let fits = match metadata.topology {
            Topology::Unet => inputs.intersection(metadata.inputs) == inputs,
            Topology::Oidn(_) => inputs == metadata.inputs,
        };
        assert_eq!(weights.for_inputs(inputs).is_ok(), fits, "{inputs}");
    }
}
