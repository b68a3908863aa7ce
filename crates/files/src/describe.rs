//! Describes a file without reading its pixels.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use ::exr::meta::BlockDescription;
use ::exr::meta::attribute::SampleType;
use ::exr::meta::header::Header;

use super::choice::Choice;
use super::exr::ExrFile;
use super::format::Format;
use super::layers::{self, Layer, Place};
use super::pick::Pick;
use super::selection::Selection;
use super::wanted::{Files, LayerChoice};
use super::{FileError, Problem, ldr, light, picture};

/// A file's format, size and layers, and what would be denoised.
#[derive(Debug)]
pub struct Description {
    /// Such as `EXR with 2 parts` or `PNG, 8-bit RGB`.
    pub format: String,
    /// Pixels per row of the first color.
    pub width: u32,
    /// Rows of the first color.
    pub height: u32,
    /// The layers; none for PNG and JPEG.
    pub layers: Vec<LayerInfo>,
    /// The views to denoise, or why the file cannot be denoised.
    pub views: Result<Vec<ViewInfo>, Problem>,
}

/// What would be denoised of one view.
#[derive(Debug)]
pub struct ViewInfo {
    /// The view's name; `None` if the file has only one.
    pub name: Option<String>,
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The layer or file that would be read as albedo.
    pub albedo: Option<String>,
    /// The layer or file that would be read as normals.
    pub normal: Option<String>,
    /// The layer whose alpha would be read; `A` for that of a PNG.
    pub alpha: Option<String>,
    /// Which layers are used and why; `None` for PNG and JPEG.
    pub selection: Option<Selection>,
    /// Further layers that by renderers' conventions add up to the color, and what they are.
    pub light: Vec<(String, String)>,
    /// Other layers beside the color, and what they hold instead of light.
    pub data: Vec<(String, &'static str)>,
}

/// One layer.
#[derive(Clone, Debug)]
pub struct LayerInfo {
    /// The layer's name in the file.
    pub name: String,
    /// Index of the layer's part, or of its first one.
    pub part: usize,
    /// The view that the layer belongs to, if the file has several.
    pub view: Option<String>,
    /// Names of the channels, and the type of their samples.
    pub channels: Vec<(String, &'static str)>,
    /// Window, tiling and compression of the part.
    pub storage: String,
}

impl Description {
    /// Reads the header of a file.
    ///
    /// # Errors
    /// If the file cannot be read or is damaged. Having no layer to choose is not an error.
    pub fn of(path: &Path, wanted: &LayerChoice) -> Result<Self, FileError> {
        let described = match Format::of_content(path) {
            Ok(Format::Exr) => Self::of_exr(path, wanted),
            Ok(format) => Self::of_ldr(path, format.name(), wanted),
            Err(problem) => Err(problem),
        };
        described.map_err(|problem| problem.at(path))
    }

    fn of_ldr(path: &Path, name: &str, wanted: &LayerChoice) -> Result<Self, Problem> {
        picture::check_no_layers(wanted)?;
        let ldr::Kind { text, size: (width, height), has_alpha } =
            ldr::describe(path, wanted.limits)?;
        let view = ViewInfo {
            name: None,
            width,
            height,
            albedo: wanted.albedo.as_deref().map(shown),
            normal: wanted.normal.as_deref().map(shown),
            alpha: has_alpha.then(|| "A".into()),
            selection: None,
            light: Vec::new(),
            data: Vec::new(),
        };
        let (format, layers) = (format!("{name}, {text}"), Vec::new());
        Ok(Self { format, width, height, layers, views: Ok(vec![view]) })
    }

    fn of_exr(path: &Path, wanted: &LayerChoice) -> Result<Self, Problem> {
        let file = ExrFile::open(path, wanted.limits)?;
        let parts = file.parts();
        // A name that no layer has is an error; a file without a color layer is not.
        wanted.wishes(&parts)?;
        let all = layers::layers(&parts);
        let views = picture::choose(&file, wanted).map(|(choices, files)| {
            choices.iter().map(|choice| view_info(&file, &all, choice, &files)).collect::<Vec<_>>()
        });
        let first = views.as_ref().ok().and_then(|views| views.first());
        let size = file.window(0).size;
        let plural = if parts.len() == 1 { "" } else { "s" };
        Ok(Self {
            format: format!("EXR with {} part{plural}", parts.len()),
            width: first.map_or(size.width() as u32, |view| view.width),
            height: first.map_or(size.height() as u32, |view| view.height),
            layers: all.iter().map(|l| layer_info(l, file.headers())).collect(),
            views,
        })
    }
}

/// The name of a layer or file.
fn shown(name: &OsStr) -> String {
    name.to_string_lossy().into_owned()
}

fn view_info(file: &ExrFile, all: &[Layer], choice: &Choice, files: &Files) -> ViewInfo {
    let size = file.window(choice.color.part()).size;
    let file = |file: &Option<PathBuf>| file.as_ref().map(|file| shown(file.as_os_str()));
    let name = |pick: &Option<Pick>| pick.as_ref().map(|p| p.layer.clone());
    let used = [&choice.color.layer, &choice.target.layer];
    let color = all.iter().find(|layer| layer.shown() == choice.color.layer);
    let others = all.iter().filter(|layer| layer.view == choice.view);
    let others = others.filter(|layer| used.iter().all(|name| *name != layer.shown()));
    let (light, data) = color.map(|color| light::known(others, color)).unwrap_or_default();
    let features = [name(&choice.albedo), name(&choice.normal)];
    let is_used = |layer: &String| features.iter().flatten().any(|name| name == layer);
    ViewInfo {
        name: choice.view.clone(),
        width: size.width() as u32,
        height: size.height() as u32,
        albedo: file(&files.albedo).or_else(|| name(&choice.albedo)),
        normal: file(&files.normal).or_else(|| name(&choice.normal)),
        alpha: choice.alpha.map(|_| choice.color.layer.clone()),
        selection: Some(Selection::of(choice, files)),
        light: light.into_iter().map(|pick| (pick.layer, pick.reason)).collect(),
        data: data.into_iter().filter(|(layer, _)| !is_used(layer)).collect(),
    }
}

fn layer_info(layer: &Layer, headers: &[Header]) -> LayerInfo {
    let kind = |place: &Place| match headers[place.part].channels.list[place.channel].sample_type {
        SampleType::F16 => "half",
        SampleType::F32 => "float",
        SampleType::U32 => "uint",
    };
    let channels = layer.channels.iter().map(|(name, place)| (name.clone(), kind(place)));
    LayerInfo {
        name: layer.shown().to_string(),
        part: layer.part(),
        view: layer.view.clone(),
        channels: channels.collect(),
        storage: storage(&headers[layer.part()]),
    }
}

fn storage(header: &Header) -> String {
    let (size, corner) = (header.layer_size, header.own_attributes.layer_position);
    let blocks = match header.blocks {
        BlockDescription::ScanLines => "scan lines".to_string(),
        BlockDescription::Tiles(tiles) => {
            format!("tiles of {}×{}", tiles.tile_size.width(), tiles.tile_size.height())
        }
    };
    format!(
        "{}×{} from ({}, {}), {blocks}, {}",
        size.width(),
        size.height(),
        corner.x(),
        corner.y(),
        header.compression
    )
}
