//! Fixtures from `training/make_fixtures.py`: inputs and `PyTorch` results.

use safetensors::SafeTensors;
use wgdenoise::internals::reference::Tensor;
use wgdenoise::{Image, Result};

use super::{Tolerance, assert_close};

/// The tensors of one file.
pub struct Fixture {
    name: &'static str,
    pub bytes: Vec<u8>,
}

impl Fixture {
    pub fn open(name: &'static str) -> Self {
        // Read at run time, so that a test built elsewhere finds the files here.
        let root = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_else(|_| ".".into());
        let path = format!("{root}/tests/fixtures/{name}.safetensors");
        let bytes = std::fs::read(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
        Self { name, bytes }
    }

    fn read(&self, tensor: &str) -> (Vec<usize>, Vec<f32>) {
        let file = SafeTensors::deserialize(&self.bytes).expect("a fixture is safetensors");
        let view = file.tensor(tensor).unwrap_or_else(|e| panic!("{}: {e}", self.name));
        assert_eq!(view.dtype(), safetensors::Dtype::F32, "type of {tensor} in {}", self.name);
        let (values, _) = view.data().as_chunks();
        (view.shape().to_vec(), values.iter().map(|&v| f32::from_le_bytes(v)).collect())
    }

    /// Returns the values of a tensor of any shape.
    pub fn values(&self, tensor: &str) -> Vec<f32> {
        self.read(tensor).1
    }

    /// Returns a tensor `[c, h, w]`.
    pub fn tensor(&self, tensor: &str) -> Tensor {
        let (shape, values) = self.read(tensor);
        let [c, h, w] = shape[..] else { panic!("{tensor} in {} is {shape:?}", self.name) };
        Tensor::new(c, h, w, values)
    }

    /// Returns a tensor `[3, h, w]` as an image.
    pub fn image(&self, tensor: &str) -> Result<Image> {
        let tensor = self.tensor(tensor);
        let (width, height) = (tensor.width, tensor.height);
        let pixel = |i| [0, 1, 2].map(|c| tensor.at(c, i / width, i % width));
        Image::new(width as u32, height as u32, (0..width * height).map(pixel).collect())
    }

    pub fn expect(&self, expected: &str, found: &Tensor, tolerance: Tolerance) {
        let name = format!("{expected} of {}", self.name);
        assert_close(&name, found, &self.tensor(expected), tolerance);
    }
}
