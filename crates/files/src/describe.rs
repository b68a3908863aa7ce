//! What a file holds, without reading its pixels.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use ::exr::meta::BlockDescription;
use ::exr::meta::attribute::SampleType;
use ::exr::meta::header::Header;

use super::choice::{self, Choice, Pick};
use super::exr::ExrFile;
use super::format::Format;
use super::layers::{self, Layer};
use super::selection::Selection;
use super::wanted::{LayerChoice, wish};
use super::{FileError, Problem, ldr};

/// A file's format, size and layers, and which of them would be denoised.
#[derive(Debug)]
pub struct Description {
    /// Such as `EXR with 2 parts` or `PNG, 8-bit RGB`.
    pub format: String,
    /// Pixels per row of the color.
    pub width: u32,
    /// Rows of the color.
    pub height: u32,
    /// The layers; none for PNG and JPEG.
    pub layers: Vec<LayerInfo>,
    /// The layer that would be read as color.
    pub color: Option<String>,
    /// The layer that the result would be written to.
    pub target: Option<String>,
    /// The layer or file that would be read as albedo.
    pub albedo: Option<String>,
    /// The layer or file that would be read as normals.
    pub normal: Option<String>,
    /// Which layers are used and why, or why the file cannot be denoised; `None` for PNG and JPEG.
    pub selection: Option<Result<Selection, Problem>>,
}

/// One layer.
#[derive(Clone, Debug)]
pub struct LayerInfo {
    /// The layer's name, as the file has it.
    pub name: String,
    /// Index of its part.
    pub part: usize,
    /// Names of the channels, and the type of their samples.
    pub channels: Vec<(String, &'static str)>,
    /// Window, tiling and compression of its part.
    pub storage: String,
}

impl Description {
    /// Reads the header of a file.
    ///
    /// # Errors
    /// If the file cannot be read or is damaged. That no layer can be chosen is not an error.
    pub fn of(path: &Path, wanted: &LayerChoice) -> Result<Self, FileError> {
        let described = match Format::of_content(path) {
            Ok(Format::Exr) => Self::of_exr(path, wanted),
            Ok(format) => Self::of_ldr(path, format.name(), wanted),
            Err(problem) => Err(problem),
        };
        described.map_err(|problem| problem.at(path))
    }

    fn of_ldr(path: &Path, name: &str, wanted: &LayerChoice) -> Result<Self, Problem> {
        let (kind, (width, height)) = ldr::describe(path, wanted.limits)?;
        let format = format!("{name}, {kind}");
        let shown = |name: &Option<OsString>| name.as_ref().map(|n| n.to_string_lossy().into());
        let (albedo, normal) = (shown(&wanted.albedo), shown(&wanted.normal));
        let (layers, color, target, selection) = (Vec::new(), None, None, None);
        Ok(Self { format, width, height, layers, color, target, albedo, normal, selection })
    }

    fn of_exr(path: &Path, wanted: &LayerChoice) -> Result<Self, Problem> {
        let file = ExrFile::open(path, wanted.limits)?;
        let parts = file.parts();
        let (albedo, albedo_file) = wish(&parts, wanted.albedo.as_deref(), wanted)?;
        let (normal, normal_file) = wish(&parts, wanted.normal.as_deref(), wanted)?;
        let shown = |file: PathBuf| file.to_string_lossy().into_owned();
        let (albedo_file, normal_file) = (albedo_file.map(shown), normal_file.map(shown));
        let choice = choice::choose(&parts, wanted.color.as_deref(), &albedo, &normal)
            .and_then(|choice| file.check(&choice.target).map(|()| choice))
            .map(|mut choice| {
                choice.leave_out_unusable(|pick| file.check(pick));
                choice
            });
        let files = (albedo_file.as_deref(), normal_file.as_deref());
        let select = |choice: &Choice| choice.selection(files.0, files.1);
        let (choice, selection) = match choice {
            Ok(choice) => {
                let selection = select(&choice);
                (Some(choice), Ok(selection))
            }
            Err(problem) => (None, Err(problem)),
        };
        let size = file.window(choice.as_ref().map_or(0, |c| c.color.part)).size;
        let name = |pick: Option<&Pick>| pick.map(|p| p.layer.clone());
        let all = layers::layers(&parts);
        Ok(Self {
            format: format!(
                "EXR with {} part{}",
                parts.len(),
                if parts.len() == 1 { "" } else { "s" }
            ),
            width: size.width() as u32,
            height: size.height() as u32,
            layers: all.iter().map(|l| layer_info(l, &file.headers()[l.part])).collect(),
            color: name(choice.as_ref().map(|c| &c.color)),
            target: name(choice.as_ref().map(|c| &c.target)),
            albedo: albedo_file.or_else(|| name(choice.as_ref().and_then(|c| c.albedo.as_ref()))),
            normal: normal_file.or_else(|| name(choice.as_ref().and_then(|c| c.normal.as_ref()))),
            selection: Some(selection),
        })
    }
}

fn layer_info(layer: &Layer, header: &Header) -> LayerInfo {
    let kind = |index: usize| match header.channels.list[index].sample_type {
        SampleType::F16 => "half",
        SampleType::F32 => "float",
        SampleType::U32 => "uint",
    };
    let channels = layer.channels.iter().map(|(name, index)| (name.clone(), kind(*index)));
    LayerInfo {
        name: layer.shown().to_string(),
        part: layer.part,
        channels: channels.collect(),
        storage: storage(header),
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
