//! Converts arrays to the engine's images and back.
//!
//! An image is an array of height × width × channels. The engine owns its pixels, so an array in C
//! order is copied once, and any other twice.

use std::cell::Cell;

use half::f16;
use numpy::prelude::*;
use numpy::{Element, PyArray2, PyArray3, PyArrayDyn, PyReadonlyArrayDyn, PyUntypedArray, dtype};
use pyo3::intern;
use pyo3::prelude::*;
use wgdenoise::Image;

use crate::errors;

/// Color, with alpha if it has four channels.
pub(crate) struct Picture {
    pub(crate) image: Image,
    pub(crate) alpha: Option<Vec<f32>>,
}

/// Whether to decode `uint8` arrays as sRGB, and whether there was one.
pub(crate) struct Srgb {
    is_allowed: bool,
    is_used: Cell<bool>,
}

impl Srgb {
    pub(crate) fn new(is_allowed: bool) -> Self {
        Self { is_allowed, is_used: Cell::new(false) }
    }

    /// Whether sRGB decoding was requested but no array needed it.
    pub(crate) fn is_idle(&self) -> bool {
        self.is_allowed && !self.is_used.get()
    }
}

/// Reads an array of three or four channels; the fourth is alpha.
pub(crate) fn picture(name: &str, object: &Bound<'_, PyAny>, srgb: &Srgb) -> PyResult<Picture> {
    let array = Named::new(name, object)?;
    match *array.shape() {
        [height, width, 3] => {
            Ok(Picture { image: array.image([height, width], array.values(srgb)?)?, alpha: None })
        }
        [height, width, 4] => {
            let pixels: Vec<[f32; 4]> = array.values(&Srgb::new(false))?;
            let alpha = pixels.iter().map(|pixel| pixel[3]).collect();
            let pixels = pixels.into_iter().map(|[r, g, b, _]| [r, g, b]).collect();
            Ok(Picture { image: array.image([height, width], pixels)?, alpha: Some(alpha) })
        }
        _ => Err(array.misshapen("(height, width, 3) or (height, width, 4)")),
    }
}

/// Reads an array of three channels.
pub(crate) fn rgb(name: &str, object: &Bound<'_, PyAny>, srgb: &Srgb) -> PyResult<Image> {
    let array = Named::new(name, object)?;
    match *array.shape() {
        [height, width, 3] => array.image([height, width], array.values(srgb)?),
        _ => Err(array.misshapen("(height, width, 3)")),
    }
}

/// Reads an array of one channel: alpha for a color of this width and height.
pub(crate) fn alpha(object: &Bound<'_, PyAny>, (width, height): (u32, u32)) -> PyResult<Vec<f32>> {
    let array = Named::new("alpha", object)?;
    match *array.shape() {
        [h, w] | [h, w, 1] if [h, w] == [height as usize, width as usize] => {
            let values: Vec<[f32; 1]> = array.values(&Srgb::new(false))?;
            Ok(values.into_flattened())
        }
        _ => Err(array.misshapen(&format!("({height}, {width}), as the color has"))),
    }
}

/// Returns the result with three channels, or four with alpha.
pub(crate) fn color<'py>(
    py: Python<'py>,
    image: &Image,
    alpha: Option<&[f32]>,
) -> Bound<'py, PyArray3<f32>> {
    let [width, height] = [image.width(), image.height()].map(|side| side as usize);
    let channels = if alpha.is_some() { 4 } else { 3 };
    let array = PyArray3::zeros(py, [height, width, channels], false);
    let mut filled = array.readwrite();
    let values = filled.as_slice_mut().expect("a new array has no gaps");
    match alpha {
        None => values.copy_from_slice(image.pixels().as_flattened()),
        Some(alpha) => {
            let pixels = image.pixels().iter().zip(alpha);
            for (to, ([r, g, b], a)) in values.as_chunks_mut::<4>().0.iter_mut().zip(pixels) {
                *to = [*r, *g, *b, *a];
            }
        }
    }
    drop(filled);
    array
}

/// Returns alpha as an array of height × width.
pub(crate) fn plane<'py>(
    py: Python<'py>,
    values: &[f32],
    (width, height): (u32, u32),
) -> Bound<'py, PyArray2<f32>> {
    let array = PyArray2::zeros(py, [height as usize, width as usize], false);
    array.readwrite().as_slice_mut().expect("a new array has no gaps").copy_from_slice(values);
    array
}

/// An array, and its name in messages.
struct Named<'n, 'py> {
    name: &'n str,
    array: Bound<'py, PyUntypedArray>,
}

impl<'n, 'py> Named<'n, 'py> {
    /// Rejects objects that are not arrays, and arrays without values.
    fn new(name: &'n str, object: &Bound<'py, PyAny>) -> PyResult<Self> {
        let array = as_array(name, object)?;
        // NumPy gathers other strides and misaligned fields of packed records.
        let array = if array.is_c_contiguous() && array.is_aligned() {
            array
        } else {
            array.call_method1(intern!(object.py(), "copy"), ("C",))?.cast_into()?
        };
        let named = Self { name, array };
        if named.array.is_empty() {
            return Err(named.refused(&format!("is empty: its shape is {}", named.shown_shape())));
        }
        Ok(named)
    }

    fn shape(&self) -> &[usize] {
        self.array.shape()
    }

    fn image(&self, size: [usize; 2], pixels: Vec<[f32; 3]>) -> PyResult<Image> {
        let [height, width] = size.map(|side| u32::try_from(side).unwrap_or(u32::MAX));
        Image::new(width, height, pixels)
            .map_err(|error| errors::of_engine(self.array.py(), &error))
    }

    /// Returns all pixels of `N` channels, row by row, as linear 32-bit floats.
    fn values<const N: usize>(&self, srgb: &Srgb) -> PyResult<Vec<[f32; N]>> {
        let values = if let Some(array) = self.of_type::<f32>()? {
            collect(&array, |value| value)
        } else if let Some(array) = self.of_type::<f16>()? {
            collect(&array, f16::to_f32)
        } else if let Some(array) = self.of_type::<f64>()? {
            collect(&array, |value| value as f32)
        } else if let Some(array) = self.of_type::<u8>()?.filter(|_| srgb.is_allowed) {
            srgb.is_used.set(true);
            collect(&array, decoded)
        } else {
            return Err(self.mistyped());
        };
        if values.as_flattened().iter().any(|value| value.is_finite()) {
            return Ok(values);
        }
        Err(self.refused("has no finite value"))
    }

    /// Returns the array if its elements are of this type.
    fn of_type<T: Element>(&self) -> PyResult<Option<PyReadonlyArrayDyn<'py, T>>> {
        if !self.array.dtype().is_equiv_to(&dtype::<T>(self.array.py())) {
            return Ok(None);
        }
        let array = self.array.cast::<PyArrayDyn<T>>()?;
        array.try_readonly().map(Some).map_err(|_| self.refused("is being written to"))
    }

    fn mistyped(&self) -> PyErr {
        let dtype = self.array.dtype();
        let is_bytes = dtype.is_equiv_to(&numpy::dtype::<u8>(dtype.py()));
        let advice = if is_bytes {
            "; srgb=True decodes uint8 in color, albedo and layers of three channels"
        } else {
            ""
        };
        let expected = "expected float32, float16 or float64";
        self.refused(&format!("has the dtype {dtype}, {expected}{advice}"))
    }

    fn misshapen(&self, expected: &str) -> PyErr {
        self.refused(&format!("has the shape {}, expected {expected}", self.shown_shape()))
    }

    /// Formats the shape as Python does.
    fn shown_shape(&self) -> String {
        let sides: Vec<_> = self.shape().iter().map(ToString::to_string).collect();
        let comma = if sides.len() == 1 { "," } else { "" };
        format!("({}{comma})", sides.join(", "))
    }

    fn refused(&self, what: &str) -> PyErr {
        errors::of_image(self.array.py(), format!("{} {what}", self.name))
    }
}

/// Copies the pixels of a contiguous array.
fn collect<T: Element + Copy, const N: usize>(
    array: &PyReadonlyArrayDyn<'_, T>,
    convert: impl Fn(T) -> f32,
) -> Vec<[f32; N]> {
    let values = array.as_slice().expect("it was made contiguous");
    values.as_chunks().0.iter().map(|pixel| pixel.map(&convert)).collect()
}

/// Decodes an sRGB value to linear (IEC 61966-2-1).
fn decoded(code: u8) -> f32 {
    let value = f64::from(code) / 255.0;
    let linear = if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) };
    linear as f32
}

/// Returns a NumPy array, or converts an object by `__array__`, NumPy's array interface, or DLPack
/// in main memory.
fn as_array<'py>(name: &str, object: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyUntypedArray>> {
    if let Ok(array) = object.cast::<PyUntypedArray>() {
        return Ok(array.clone());
    }
    let py = object.py();
    let has = |attribute: &str| object.hasattr(attribute);
    let function = if has("__array__")? || has("__array_interface__")? {
        "asarray"
    } else if has("__dlpack__")? {
        "from_dlpack"
    } else {
        let kind = object.get_type().name()?;
        let expected = "a NumPy array, or an object with __array__ or __dlpack__";
        return Err(errors::of_image(py, format!("{name} is a {kind}, expected {expected}")));
    };
    let read = py.import(intern!(py, "numpy"))?.call_method1(function, (object,));
    read.and_then(|array| Ok(array.cast_into()?)).map_err(|cause| {
        let error = errors::of_image(py, format!("{name} cannot be read as an array: {cause}"));
        error.set_cause(py, Some(cause));
        error
    })
}
