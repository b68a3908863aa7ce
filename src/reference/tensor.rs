//! The feature map that the reference operators read and return.

/// A feature map: channels, then rows from the top, then columns from the left.
#[derive(Clone, Debug, PartialEq)]
pub struct Tensor {
    /// Number of channels.
    pub channels: usize,
    /// Number of rows.
    pub height: usize,
    /// Number of columns.
    pub width: usize,
    /// `channels · height · width` values; `(c, y, x)` is at `(c · height + y) · width + x`.
    pub data: Vec<f32>,
}

impl Tensor {
    /// Wraps values that are already in the order of [`Tensor::data`].
    ///
    /// # Panics
    /// Panics if there are not `channels · height · width` values.
    #[must_use]
    pub fn new(channels: usize, height: usize, width: usize, data: Vec<f32>) -> Self {
        assert_eq!(data.len(), channels * height * width, "values of {channels}×{height}×{width}");
        Self { channels, height, width, data }
    }

    /// The tensor whose value at `(c, y, x)` is `value(c, y, x)`.
    #[must_use]
    pub fn from_fn(
        channels: usize,
        height: usize,
        width: usize,
        value: impl Fn(usize, usize, usize) -> f32,
    ) -> Self {
        let mut data = Vec::with_capacity(channels * height * width);
        for c in 0..channels {
            for y in 0..height {
                data.extend((0..width).map(|x| value(c, y, x)));
            }
        }
        Self::new(channels, height, width, data)
    }

    /// `(channels, height, width)`.
    #[must_use]
    pub fn shape(&self) -> (usize, usize, usize) {
        (self.channels, self.height, self.width)
    }

    /// The value in channel `c`, row `y`, column `x`.
    ///
    /// # Panics
    /// Panics outside the tensor.
    #[must_use]
    pub fn at(&self, c: usize, y: usize, x: usize) -> f32 {
        // Without this, a column past the end would silently read the next row.
        assert!(
            c < self.channels && y < self.height && x < self.width,
            "({c}, {y}, {x}) is outside"
        );
        self.data[(c * self.height + y) * self.width + x]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_run_fastest_and_channels_slowest() {
        let tensor = Tensor::new(2, 2, 3, (0..12u8).map(f32::from).collect());
        assert_eq!(tensor.at(0, 0, 2), 2.0);
        assert_eq!(tensor.at(0, 1, 0), 3.0);
        assert_eq!(tensor.at(1, 0, 0), 6.0);
        assert_eq!(tensor, Tensor::from_fn(2, 2, 3, |c, y, x| (6 * c + 3 * y + x) as f32));
    }

    #[test]
    #[should_panic(expected = "outside")]
    fn a_column_past_the_end_is_not_the_next_row() {
        let _ = Tensor::new(1, 2, 2, vec![0.0; 4]).at(0, 0, 2);
    }
}
