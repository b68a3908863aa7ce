//! Images in a safetensors file, as `[height, width, 3]` in 32-bit floats.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};
use wgdenoise::Image;

use crate::Result;

/// Images by name.
pub(crate) type Images = BTreeMap<String, Image>;

/// Writes all images.
pub(crate) fn write(path: &Path, images: &Images) -> Result<()> {
    let view = |(name, image): (&String, &Image)| {
        let shape = vec![image.height() as usize, image.width() as usize, 3];
        let bytes: Vec<u8> = bytemuck::cast_slice(image.pixels()).to_vec();
        (name.clone(), shape, bytes)
    };
    let tensors: Vec<_> = images.iter().map(view).collect();
    let views = tensors.iter().map(|(name, shape, bytes)| {
        let view = TensorView::new(Dtype::F32, shape.clone(), bytes);
        (name.clone(), view.expect("the shape is the image's"))
    });
    let file = safetensors::serialize(views, None).map_err(|e| e.to_string())?;
    fs::write(path, file).map_err(|e| format!("{} cannot be written: {e}", path.display()))
}

/// Reads all images.
pub(crate) fn read(path: &Path) -> Result<Images> {
    let wrong = |what: String| format!("{}: {what}", path.display());
    let bytes = fs::read(path).map_err(|e| wrong(format!("cannot be read: {e}")))?;
    let tensors = SafeTensors::deserialize(&bytes).map_err(|e| wrong(e.to_string()))?;
    let images = tensors.tensors().into_iter().map(|(name, view)| {
        let image = image(&view).ok_or_else(|| wrong(format!("`{name}` is not an image")))?;
        Ok((name, image))
    });
    images.collect()
}

fn image(view: &TensorView<'_>) -> Option<Image> {
    let &[height, width, 3] = view.shape() else { return None };
    let values: Vec<f32> = bytemuck::pod_collect_to_vec(view.data());
    let pixels = values.as_chunks().0.to_vec();
    (view.dtype() == Dtype::F32).then(|| Image::new(width as u32, height as u32, pixels).ok())?
}
