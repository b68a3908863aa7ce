//! What a file holds, found without reading its pixels.

use std::path::Path;

use ::exr::meta::BlockDescription;
use ::exr::meta::attribute::SampleType;
use ::exr::meta::header::Header;

use super::choice::{self, Pick};
use super::exr::ExrFile;
use super::format::{self, Format};
use super::layers::{self, Layer};
use super::wanted::{LayerChoice, wish};
use super::{FileError, Problem, ldr};

/// What `wgdenoise info` shows.
#[derive(Clone, Debug)]
pub struct Description {
    /// `EXR`, or what kind of PNG or JPEG.
    pub format: String,
    /// Pixels per row of the colour.
    pub width: u32,
    /// Rows of the colour.
    pub height: u32,
    /// The layers there are; none for PNG and JPEG.
    pub layers: Vec<LayerInfo>,
    /// The layer that would be read as colour.
    pub color: Option<String>,
    /// The layer that would be written.
    pub target: Option<String>,
    /// The layer or file that would be read as albedo.
    pub albedo: Option<String>,
    /// The layer or file that would be read as normals.
    pub normal: Option<String>,
    /// The choice and its reasons in one line, or why there is none.
    pub choice: String,
}

/// One layer.
#[derive(Clone, Debug)]
pub struct LayerInfo {
    /// Its name.
    pub name: String,
    /// The index of its part.
    pub part: usize,
    /// Names of the channels and how their samples are stored.
    pub channels: Vec<(String, &'static str)>,
    /// Window, tiling and compression of its part.
    pub storage: String,
}

impl Description {
    /// Reads the header of a file.
    ///
    /// # Errors
    /// If the file cannot be read or is damaged. A choice that cannot be made is no error.
    pub fn of(path: &Path, wanted: &LayerChoice) -> Result<Self, FileError> {
        let described = match format::sniff(path) {
            Ok(Format::Exr) => Self::of_exr(path, wanted),
            Ok(_) => Self::of_ldr(path, wanted),
            Err(problem) => Err(problem),
        };
        described.map_err(|problem| problem.at(path))
    }

    fn of_ldr(path: &Path, wanted: &LayerChoice) -> Result<Self, Problem> {
        let (format, (width, height)) = ldr::describe(path, wanted.limits)?;
        let (albedo, normal) = (wanted.albedo.clone(), wanted.normal.clone());
        let choice = "colour from the pixels, decoded by the sRGB curve".into();
        let (color, target) = (None, None);
        Ok(Self { format, width, height, layers: vec![], color, target, albedo, normal, choice })
    }

    fn of_exr(path: &Path, wanted: &LayerChoice) -> Result<Self, Problem> {
        let file = ExrFile::open(path, wanted.limits)?;
        let parts = file.parts();
        let (albedo, albedo_file) = wish(&parts, wanted.albedo.as_deref(), wanted)?;
        let (normal, normal_file) = wish(&parts, wanted.normal.as_deref(), wanted)?;
        let choice = choice::choose(&parts, wanted.color.as_deref(), &albedo, &normal)
            .and_then(|choice| file.check(&choice.target).map(|()| choice))
            .map(|mut choice| {
                choice.leave_out_unusable(|pick| file.check(pick));
                choice
            });
        let explained = match &choice {
            Ok(choice) => choice.explain(albedo_file.as_deref(), normal_file.as_deref()),
            Err(problem) => format!("cannot be denoised: it {problem}"),
        };
        let choice = choice.ok();
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
            choice: explained,
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
