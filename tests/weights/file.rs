//! Valid and invalid weights files.

use std::collections::HashMap;

use safetensors::tensor::{Dtype, TensorView, serialize};

/// A file before writing: metadata, and the type, shape and bytes of every tensor.
#[derive(Clone)]
pub(crate) struct File {
    pub(crate) metadata: HashMap<String, String>,
    pub(crate) tensors: HashMap<String, (Dtype, Vec<usize>, Vec<u8>)>,
}

impl File {
    /// The smallest valid network, 3 → 2 | 2 → 3, without norms.
    pub(crate) fn valid() -> Self {
        let pairs = [
            ("format", "wgdenoise"),
            ("format_version", "1"),
            ("topology", "unet"),
            ("widths", "2,3"),
            ("inputs", "color"),
            ("transfer_function", "pu"),
            ("name", "test"),
            ("provenance", "made by a test"),
        ];
        let metadata = pairs.map(|(k, v)| (k.to_string(), v.to_string())).into();
        let mut file = Self { metadata, tensors: HashMap::new() };
        let convs = [
            ("enc_conv0a", 3, 2),
            ("enc_conv0b", 2, 2),
            ("mid_conva", 2, 3),
            ("mid_convb", 3, 3),
            ("dec_conv0a", 4, 2),
            ("dec_conv0b", 2, 2),
        ];
        for (layer, inputs, outputs) in convs {
            file.layer(layer, &[outputs, inputs, 3, 3], outputs);
        }
        file.layer("dec_up0", &[3, 2, 2, 2], 2);
        file.layer("out_conv", &[3, 2, 1, 1], 3);
        file
    }

    /// [`valid`](Self::valid) with logits instead of color, and with albedo.
    pub(crate) fn kernel_pyramid() -> Self {
        let mut file = Self::valid();
        file.metadata.extend(
            [("topology", "kernel-pyramid"), ("inputs", "color,albedo")]
                .map(|(k, v)| (k.into(), v.into())),
        );
        file.tensors.retain(|name, _| !name.starts_with("out_conv"));
        file.layer("enc_conv0a", &[2, 6, 3, 3], 2);
        file.layer("kernel_conv0", &[11, 2, 1, 1], 11);
        file.layer("kernel_conv1", &[10, 3, 1, 1], 10);
        file
    }

    fn layer(&mut self, layer: &str, shape: &[usize], outputs: usize) {
        self.fill(&format!("{layer}.weight"), shape, 0.25);
        self.fill(&format!("{layer}.bias"), &[outputs], 0.5);
    }

    pub(crate) fn fill(&mut self, name: &str, shape: &[usize], value: f32) {
        let bytes = value.to_le_bytes().repeat(shape.iter().product());
        self.tensors.insert(name.into(), (Dtype::F32, shape.to_vec(), bytes));
    }

    pub(crate) fn norm(&mut self, layer: &str, outputs: usize) {
        for part in ["weight", "bias", "running_mean", "running_var"] {
            self.fill(&format!("{layer}.norm.{part}"), &[outputs], 1.0);
        }
        self.metadata.insert("norm_eps".into(), "1e-5".into());
    }

    pub(crate) fn set(mut self, key: &str, value: &str) -> Self {
        self.metadata.insert(key.into(), value.into());
        self
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        let views = self.tensors.iter().map(|(name, (dtype, shape, bytes))| {
            let view = TensorView::new(*dtype, shape.clone(), bytes).expect("the sizes agree");
            (name.clone(), view)
        });
        serialize(views, Some(self.metadata.clone().into_iter().collect())).expect("it fits")
    }

    #[track_caller]
    pub(crate) fn is_refused(&self, expected: &str) {
        crate::refused(&self.bytes(), expected);
    }
}

/// A file with this header, which can be anything, and these tensor bytes.
pub(crate) fn raw(header: &[u8], data: &[u8]) -> Vec<u8> {
    [&(header.len() as u64).to_le_bytes(), header, data].concat()
}

/// The valid file with its header changed by `change`.
pub(crate) fn with_header(change: impl FnOnce(String) -> String) -> Vec<u8> {
    let bytes = File::valid().bytes();
    let (length, rest) = bytes.split_first_chunk().expect("a header's length");
    let (header, data) = rest.split_at(u64::from_le_bytes(*length) as usize);
    raw(change(String::from_utf8(header.to_vec()).expect("JSON")).as_bytes(), data)
}

/// The valid file with text in its header replaced.
#[track_caller]
pub(crate) fn replaced(from: &str, to: &str) -> Vec<u8> {
    with_header(|header| {
        assert!(header.contains(from), "{header} has no {from}");
        header.replacen(from, to, 1)
    })
}
