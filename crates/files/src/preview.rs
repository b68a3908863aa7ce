//! Saves any layer of a file as a PNG or JPEG.

use std::path::Path;

use super::choice::{self, Wishes};
use super::display::Display;
use super::exr::ExrFile;
use super::format::Format;
use super::layers::{self, Part};
use super::ldr::LdrFile;
use super::limits::Limits;
use super::pick::Pick;
use super::picture::no_layers;
use super::{FileError, Problem, output};
use wgdenoise::Image;

/// One layer of an image file.
#[derive(Debug)]
pub struct Preview {
    image: Image,
    layer: Option<String>,
    display: Display,
    limits: Limits,
}

impl Preview {
    /// Reads the layer or channel called `name`; by default the layer that results are written to.
    /// A single channel becomes gray, and two become red and green.
    ///
    /// # Errors
    /// If the file cannot be read, is damaged or too large, or has no such layer.
    pub fn open(path: &Path, name: Option<&str>, limits: Limits) -> Result<Self, FileError> {
        let opened = match (Format::of_content(path), name) {
            (Err(problem), _) => Err(problem),
            (Ok(Format::Exr), _) => Self::of_exr(path, name, limits),
            (Ok(_), Some(name)) => Err(no_layers(name)),
            (Ok(_), None) => LdrFile::read(path, limits).map(|(file, image)| {
                let display = file.display();
                Self { image, layer: None, display, limits }
            }),
        };
        opened.map_err(|problem| problem.at(path))
    }

    fn of_exr(path: &Path, name: Option<&str>, limits: Limits) -> Result<Self, Problem> {
        let file = ExrFile::open(path, limits)?;
        let parts = file.parts();
        let pick = match name {
            Some(name) => pick(&parts, name)?,
            None => choice::choose(&parts, &Wishes::default())?.remove(0).target,
        };
        let mut image = file.read(&[&pick], &[])?.0.remove(0);
        let [_, green, blue] = pick.channels;
        if green == blue && pick.channels[0] != green {
            image.pixels_mut().iter_mut().for_each(|pixel| pixel[2] = 0.0);
        }
        let display = Display::of(&file.headers()[pick.part()]);
        let display = if is_color(&parts, &pick) { display } else { display.of_data() };
        Ok(Self { image, layer: Some(pick.layer), display, limits })
    }

    /// The values in the file; PNG and JPEG are decoded to linear light.
    #[must_use]
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// The layer's name; `None` for PNG and JPEG.
    #[must_use]
    pub fn layer(&self) -> Option<&str> {
        self.layer.as_deref()
    }

    /// The format of a preview file, by its extension.
    ///
    /// # Errors
    /// If the extension is not .png, .jpg or .jpeg.
    pub fn format(path: &Path) -> Result<Format, FileError> {
        let what = "cannot be written: a preview is a .png, .jpg or .jpeg file";
        Format::of_extension(path)
            .ok()
            .filter(|format| format.is_display_referred())
            .ok_or_else(|| Problem::Format(what.into()).at(path))
    }

    /// Writes an 8-bit PNG or JPEG: values times 2^`stops`, cropped to the display window, with
    /// sRGB's primaries if they are colors, clipped to [0, 1] and sRGB-encoded. Returns what a user
    /// should know about it, one sentence each.
    ///
    /// # Errors
    /// If `path` names another format, exists and `force` is not given, or cannot be written.
    pub fn save(self, path: &Path, stops: f32, force: bool) -> Result<Vec<String>, FileError> {
        let format = Self::format(path)?;
        output::check(path, force)?;
        let image = exposed(self.image, stops);
        let shown = self.display.show(&image, None, self.limits);
        let (shown, notices) = shown.map_err(|problem| problem.at(path))?;
        output::replace(path, force, |out| shown.write(out, format)).map(|_| notices)
    }
}

/// Brightens an image by `stops`: multiplies every value by 2^`stops`.
#[must_use]
pub fn exposed(mut image: Image, stops: f32) -> Image {
    if stops != 0.0 {
        let factor = stops.exp2();
        image.pixels_mut().iter_mut().flatten().for_each(|value| *value *= factor);
    }
    image
}

/// Whether a layer holds light or surface color, and so has primaries.
fn is_color(parts: &[Part], pick: &Pick) -> bool {
    let all = layers::layers(parts);
    let layer = all.iter().find(|layer| layer.rgb() == Some(pick.channels));
    layer.is_some_and(|layer| matches!(layer.data(), None | Some("albedo" | "surface color")))
}

/// Picks the first three channels of a layer, or a channel by its full name.
fn pick(parts: &[Part], name: &str) -> Result<Pick, Problem> {
    let all = layers::layers(parts);
    let missing = match layers::named(&all, name) {
        Ok(found) => {
            let layer = found[0];
            let places: Vec<_> = layer.channels.iter().map(|(_, place)| *place).collect();
            let first = [0, 1, 2].map(|i: usize| places[i.min(places.len() - 1)]);
            let channels = layer.rgb().or_else(|| layer.xyz()).unwrap_or(first);
            return Ok(Pick::named(layer.shown(), channels));
        }
        Err(problem) => problem,
    };
    let (_, place) = layers::channel(parts, &all, name).ok_or(missing)?;
    Ok(Pick::named(name, [place; 3]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_number_of_channels_can_be_shown() {
        let names = "R G B A depth.Z motion.X motion.Y id.r id.a uvw.u uvw.v uvw.w uvw.q";
        let channels = names.split(' ').map(String::from).collect();
        let parts = [Part { channels, ..Part::default() }];
        let of = |name: &str| pick(&parts, name).unwrap().channels.map(|place| place.channel);
        assert_eq!((of("RGB"), of("depth"), of("motion")), ([0, 1, 2], [4; 3], [5, 6, 6]));
        assert_eq!((of("uvw"), of("A"), of("id.a")), ([9, 10, 11], [3; 3], [8; 3]));
        let error = pick(&parts, "nothing").unwrap_err().to_string();
        assert!(error.contains("no layer `nothing`"), "{error}");
    }

    #[test]
    fn a_stop_doubles_every_value() {
        let image = Image::filled(1, 1, [0.25, 3.0, -1.0]).unwrap();
        assert_eq!(exposed(image.clone(), 1.0).pixels(), [[0.5, 6.0, -2.0]]);
        assert_eq!(exposed(image.clone(), 0.0), image);
    }
}
