//! BRISQUE

use wgdenoise::{Error, Image, Result};

use self::features::{SMALLEST, features};
use super::{displayed, scaled};

mod distribution;
mod features;

/// x
/// # Errors
/// x
pub fn brisque(image: &Image, exposure: f64) -> Result<f64> {
    Ok(features(&luma(image, exposure)?, image.width() as usize)[0])
}

/// The picture's luma, if it can be judged.
fn luma(image: &Image, exposure: f64) -> Result<Vec<f64>> {
    let (width, height) = image.size();
    if (width.min(height) as usize) < SMALLEST {
        return Err(Error::Image(format!(
            "BRISQUE cannot judge {width}×{height} pixels; it needs {SMALLEST}×{SMALLEST} or more"
        )));
    }
    let shown = displayed(&scaled(image, exposure));
    let luma: Vec<f64> =
        shown.iter().map(|p| 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2]).collect();
    if luma.iter().all(|v| *v == luma[0]) {
        return Err(Error::Image("BRISQUE cannot judge a picture of one brightness".into()));
    }
    Ok(luma)
}
