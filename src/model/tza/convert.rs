//! Converts a TZA file to a weights file.

use std::collections::{BTreeMap, HashMap};

use safetensors::tensor::{Dtype, TensorView, serialize};

use super::kind::TzaKind;
use super::reader::{TzaTensor, read};
use crate::error::{Error, Result};
use crate::model::metadata::{MAX_WIDTH, Topology};
use crate::model::{Network, OidnSize};

/// Converts a TZA file called `name` (without its extension) to a weights file, as bytes.
/// [`Weights::from_bytes`](crate::Weights::from_bytes) then checks that the tensors are complete
/// and finite.
///
/// # Errors
/// Fails if the file cannot be [`read`], if `name` is not one of Open Image Denoise's, or if the
/// convolutions do not match the name or any network this version knows.
pub fn to_safetensors(bytes: &[u8], name: &str) -> Result<Vec<u8>> {
    let tensors = read(bytes)?;
    let kind = TzaKind::of(name)?;
    let (size, widths) = shape_of(&tensors)?;
    check_inputs(&kind, &tensors, size)?;
    let network = Network::oidn(kind.inputs.channels(), size, &widths[..widths.len() - 1]);
    let data = tensors.iter().map(|tensor| Ok((tensor, skip_first(&network, tensor)?)));
    let data: Vec<_> = data.collect::<Result<_>>()?;
    let views = data.iter().map(|(tensor, data)| {
        let view = TensorView::new(tensor.dtype, tensor.shape.clone(), data);
        Ok((tensor.name, view.map_err(|e| not_written(&e))?))
    });
    let views: BTreeMap<_, _> = views.collect::<Result<_>>()?;
    serialize(views, Some(metadata(&kind, name, size, &widths).into_iter().collect()))
        .map_err(|e| not_written(&e))
}

fn not_written(error: &dyn std::fmt::Display) -> Error {
    Error::weights(format!("the weights file cannot be made: {error}"))
}

/// Identifies the network by its number of convolutions; also returns the output channels of each.
fn shape_of(tensors: &[TzaTensor<'_>]) -> Result<(OidnSize, Vec<usize>)> {
    let weights = || tensors.iter().filter(|tensor| tensor.shape.len() == 4);
    let size = [OidnSize::Base, OidnSize::Large]
        .into_iter()
        .find(|size| size.convolutions() == weights().count())
        .ok_or_else(|| {
            let count = weights().count();
            Error::weights(format!("{count} convolutions, expected 16 (base, small) or 19 (large)"))
        })?;
    let outputs = |name: &str| {
        let found = tensors.iter().find(|tensor| tensor.name == format!("{name}.weight"));
        let found = found.filter(|tensor| tensor.shape.len() == 4).ok_or_else(|| {
            Error::weights(format!("tensor `{name}.weight` is missing, expected a convolution"))
        })?;
        let width = found.shape[0];
        (1..=MAX_WIDTH).contains(&width).then_some(width).ok_or_else(|| {
            Error::weights(format!("`{name}` makes {width} channels, expected 1 to {MAX_WIDTH}"))
        })
    };
    let widths = size.names().map(outputs).collect::<Result<_>>()?;
    Ok((size, widths))
}

/// Rejects a file whose inputs contradict its name.
fn check_inputs(kind: &TzaKind, tensors: &[TzaTensor<'_>], size: OidnSize) -> Result<()> {
    let first = size.names().next().expect("a network has convolutions");
    let first = tensors.iter().find(|tensor| tensor.name == format!("{first}.weight"));
    let (found, expected) = (first.map_or(0, |tensor| tensor.shape[1]), kind.inputs.channels());
    if found == expected {
        return Ok(());
    }
    Err(Error::weights(format!(
        "the file's network reads {found} channels, but by its name, {}, it should read {expected} \
         ({}); restore the file's original name",
        kind.stem, kind.inputs
    )))
}

/// A tensor's data. After a concat, moves the skip's input channels before the upsampled ones.
fn skip_first(network: &Network, tensor: &TzaTensor<'_>) -> Result<Vec<u8>> {
    let concat = network.layers.iter().enumerate().find_map(|(i, layer)| {
        let weight = tensor.name.strip_suffix(".weight") == Some(&layer.name);
        let before = &network.layers[layer.inputs[0].checked_sub(1)?];
        (weight && i > 0 && before.op.facts().joins).then_some(before)
    });
    let Some(concat) = concat else { return Ok(tensor.data.to_vec()) };
    let [skip, up] = [0, 1].map(|i| network.shapes[concat.inputs[i]].channels);
    if tensor.shape.get(1..) != Some(&[skip + up, 3, 3]) {
        return Err(Error::weights(format!(
            "tensor `{}` has shape {:?}, expected {} input channels and 3×3 taps",
            tensor.name,
            tensor.shape,
            skip + up
        )));
    }
    let channel = 9 * if tensor.dtype == Dtype::F16 { 2 } else { 4 };
    let filters = tensor.data.chunks_exact((skip + up) * channel);
    let turned = filters.flat_map(|filter| {
        let (up, skip) = filter.split_at(up * channel);
        [skip, up].concat()
    });
    Ok(turned.collect())
}

fn metadata(
    kind: &TzaKind,
    name: &str,
    size: OidnSize,
    widths: &[usize],
) -> HashMap<String, String> {
    let widths: Vec<_> = widths[..widths.len() - 1].iter().map(ToString::to_string).collect();
    let pairs = [
        ("format", "wgdenoise".into()),
        ("format_version", "1".into()),
        ("topology", Topology::Oidn(size).name().into()),
        ("widths", widths.join(",")),
        ("inputs", kind.inputs.to_string().replace(' ', "")),
        ("main", kind.main.name().into()),
        ("transfer_function", kind.transfer.name().into()),
        ("name", name.into()),
        ("provenance", PROVENANCE.into()),
    ];
    pairs.into_iter().map(|(key, value)| (key.to_string(), value)).collect()
}

const PROVENANCE: &str = "Intel Open Image Denoise, Apache-2.0; converted from TZA";
