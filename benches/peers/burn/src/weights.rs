//! Weights files (`weights-format.md`) as lists of numbers, with batch norms folded in.

use half::f16;
use safetensors::{Dtype, SafeTensors};

use crate::Result;

/// The parameters of one convolution.
pub struct Layer {
    pub weight: Vec<f32>,
    pub shape: [usize; 4],
    pub bias: Vec<f32>,
}

/// Reads the widths of the levels and the ε of the norms.
pub fn metadata(file: &[u8]) -> Result<(Vec<usize>, f64)> {
    let (_, header) = SafeTensors::read_metadata(file)?;
    let all = header.metadata().as_ref().ok_or("the weights file has no metadata")?;
    let get = |key: &str| all.get(key).ok_or(format!("the weights file has no `{key}`"));
    let widths =
        get("widths")?.split(',').map(str::parse).collect::<std::result::Result<_, _>>()?;
    Ok((widths, get("norm_eps")?.parse()?))
}

/// Reads values and shape of an F16 or F32 tensor.
pub fn floats(file: &SafeTensors, name: &str) -> Result<(Vec<f32>, Vec<usize>)> {
    let tensor = file.tensor(name)?;
    let data = tensor.data();
    let values = match tensor.dtype() {
        Dtype::F16 => data.as_chunks().0.iter().map(|b| f16::from_le_bytes(*b).to_f32()).collect(),
        Dtype::F32 => data.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect(),
        other => return Err(format!("{name} is of type {other:?}, not F16 or F32").into()),
    };
    Ok((values, tensor.shape().to_vec()))
}

/// Reads a layer's weight and bias, and folds in its batch norm if there is one.
pub fn layer(file: &SafeTensors, name: &str, eps: f64) -> Result<Layer> {
    let (weight, shape) = floats(file, &format!("{name}.weight"))?;
    let shape: [usize; 4] = shape.try_into().map_err(|_| format!("{name} has not four axes"))?;
    let Ok((gamma, _)) = floats(file, &format!("{name}.norm.weight")) else {
        return Ok(Layer { weight, shape, bias: floats(file, &format!("{name}.bias"))?.0 });
    };
    let norm = |part: &str| {
        Ok::<_, Box<dyn std::error::Error>>(floats(file, &format!("{name}.norm.{part}"))?.0)
    };
    let (beta, mean, variance) = (norm("bias")?, norm("running_mean")?, norm("running_var")?);
    let scale = |o: usize| f64::from(gamma[o]) / (f64::from(variance[o]) + eps).sqrt();
    let per_output = weight.len() / shape[0];
    let folded = |(i, w): (usize, &f32)| (f64::from(*w) * scale(i / per_output)) as f32;
    let bias = |o: usize| (f64::from(beta[o]) - f64::from(mean[o]) * scale(o)) as f32;
    Ok(Layer {
        weight: weight.iter().enumerate().map(folded).collect(),
        shape,
        bias: (0..shape[0]).map(bias).collect(),
    })
}
