//! Reads a picture, and writes it with what was denoised.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use ::exr::meta::attribute::Chromaticities;

use super::choice::{self, Choice};
use super::display::Display;
use super::escape::escaped;
use super::exr::{Change, ExrFile, Samples};
use super::format::Format;
use super::ldr::LdrFile;
use super::light::LayersWish;
use super::limits::Limits;
use super::motion::{MotionLayer, MotionPick, MotionWish};
use super::output::{Out, check_place, replace};
use super::selection::Selection;
use super::view::{Denoised, NoisyLayer, View};
use super::wanted::{Files, LayerChoice};
use super::window::{self, Place};
use super::{FileError, Problem, aux_file, normals};

/// An image file in memory, with everything needed to write it with another color.
#[derive(Debug)]
pub struct Picture {
    source: Source,
    views: Vec<View>,
    notices: Vec<String>,
}

#[derive(Debug)]
enum Source {
    Exr(Box<ExrFile>, Vec<Choice>),
    Ldr(Box<LdrFile>),
}

impl Picture {
    /// Reads color, albedo and normal, alpha and further layers of every view.
    ///
    /// # Errors
    /// If the file cannot be read, is damaged or too large, or a layer is missing.
    pub fn open(path: &Path, wanted: &LayerChoice) -> Result<Self, FileError> {
        let mut picture = match Format::of_content(path).map_err(|p| p.at(path))? {
            Format::Exr => Self::open_exr(path, wanted)?,
            Format::Png | Format::Jpeg => Self::open_ldr(path, wanted)?,
        };
        picture.decode_normals();
        Ok(picture)
    }

    fn open_exr(path: &Path, wanted: &LayerChoice) -> Result<Self, FileError> {
        let at = |problem: Problem| problem.at(path);
        let file = ExrFile::open(path, wanted.limits).map_err(at)?;
        let (choices, files) = choose(&file, wanted).map_err(at)?;
        check_size(&file, &choices, wanted.limits).map_err(at)?;
        let (mut views, mut notices) = (Vec::new(), Vec::new());
        for choice in &choices {
            let selection = Selection::of(choice, &files);
            notices.extend(selection.left_out.iter().cloned());
            let mut view = read_view(&file, choice, selection, &mut notices).map_err(at)?;
            let place = Place::of(&file.headers()[choice.color.part()]);
            add_files(&mut view, &files, &place, wanted.limits, &mut notices)?;
            views.push(view);
        }
        Ok(Self { source: Source::Exr(Box::new(file), choices), views, notices })
    }

    fn open_ldr(path: &Path, wanted: &LayerChoice) -> Result<Self, FileError> {
        check_no_layers(wanted).map_err(|problem| problem.at(path))?;
        let (file, color) = LdrFile::read(path, wanted.limits).map_err(|p| p.at(path))?;
        let wish =
            |name: &Option<OsString>| name.clone().filter(|_| !wanted.no_aux).map(PathBuf::from);
        let files = Files { albedo: wish(&wanted.albedo), normal: wish(&wanted.normal) };
        let from = |what, file: &Option<PathBuf>| {
            let shown = file.as_ref().map(|file| escaped(&file.to_string_lossy()));
            shown.map(|file| format!("{what} from the file {file}"))
        };
        let notices = [from("albedo", &files.albedo), from("normal", &files.normal)];
        let mut notices: Vec<_> = notices.into_iter().flatten().chain(file.notices()).collect();
        let place = Place::sized(color.size());
        let mut view = View::of_color(color, file.alpha());
        add_files(&mut view, &files, &place, wanted.limits, &mut notices)?;
        Ok(Self { source: Source::Ldr(Box::new(file)), views: vec![view], notices })
    }

    fn decode_normals(&mut self) {
        let normals = self.views.iter_mut().filter_map(|view| view.normal.as_mut());
        // Every view is decoded, and the notice is the same for all.
        if normals.map(normals::decode_if_encoded).fold(false, |any, was| any | was) {
            self.notices.push("the normals were stored as n·0.5+0.5 and have been decoded".into());
        }
    }

    /// The views to denoise, at least one. PNG and JPEG files have one.
    #[must_use]
    pub fn views(&self) -> &[View] {
        &self.views
    }

    /// The first view, which is the only one of most files.
    #[must_use]
    pub fn first(&self) -> &View {
        &self.views[0]
    }

    /// Whether the file is display-referred, as PNG and JPEG are: color from 0 to 1.
    #[must_use]
    pub fn is_display_referred(&self) -> bool {
        matches!(self.source, Source::Ldr(_))
    }

    /// The primaries of the first view's color, if the file has any.
    pub(super) fn primaries(&self) -> Option<Chromaticities> {
        let Source::Exr(file, choices) = &self.source else { return None };
        file.headers()[choices[0].color.part()].shared_attributes.chromaticities
    }

    /// What a user should know about how the file was read, one sentence each.
    #[must_use]
    pub fn notices(&self) -> &[String] {
        &self.notices
    }

    /// Writes the picture with one result per view in place of the noisy layers, in the format of
    /// `path`'s extension. Returns what a user should know about it, one sentence each.
    ///
    /// # Errors
    /// If `path` exists and `force` is not given, it cannot be written, or the results do not fit.
    /// A file that was there stays as it was.
    pub fn save(
        &self,
        path: &Path,
        results: &[Denoised],
        force: bool,
    ) -> Result<Vec<String>, FileError> {
        let format = Format::of_extension(path).map_err(|p| p.at(path))?;
        self.save_as(path, format, results, force)
    }

    /// Writes the picture like [`save`](Self::save), but in a given format. `-` is standard output.
    ///
    /// # Errors
    /// As in [`save`](Self::save).
    pub fn save_as(
        &self,
        path: &Path,
        format: Format,
        results: &[Denoised],
        force: bool,
    ) -> Result<Vec<String>, FileError> {
        check_place(path, force)?;
        self.check(results).map_err(|problem| problem.at(path))?;
        replace(path, force, |out| match (&self.source, format) {
            (Source::Exr(file, choices), Format::Exr) => save_exr(file, choices, results, out),
            (Source::Exr(file, choices), format) => {
                self.show(file, &choices[0], &results[0], format, out)
            }
            (Source::Ldr(file), format) => {
                file.write(out, format, &results[0].color, results[0].alpha.as_deref())
            }
        })
    }

    /// Writes the first view of an EXR file for display.
    fn show(
        &self,
        file: &ExrFile,
        choice: &Choice,
        result: &Denoised,
        format: Format,
        out: &mut Out<'_>,
    ) -> Result<Vec<String>, Problem> {
        let display = Display::of(&file.headers()[choice.color.part()]);
        let alpha = result.alpha.as_deref().or(self.first().alpha());
        let (shown, notices) = display.show(&result.color, alpha, file.limits)?;
        let mut notices = [shown.write(out, format)?, notices].concat();
        notices.extend(self.only_first(format));
        Ok(notices)
    }

    fn check(&self, results: &[Denoised]) -> Result<(), Problem> {
        if results.len() != self.views.len() {
            let (given, views) = (results.len(), self.views.len());
            return Err(Problem::Size(format!(
                "cannot be written: {given} results are given for {views} views"
            )));
        }
        self.views.iter().zip(results).try_for_each(|(view, result)| view.check(result))
    }

    /// A notice if a format without views and layers keeps only the first view's color.
    fn only_first(&self, format: Format) -> Option<String> {
        let first = self.first();
        let view = first.name().filter(|_| self.views.len() > 1);
        let view = view.map(|name| format!("the view `{}`", escaped(name)));
        let layers = (!first.layers().is_empty()).then(|| "the color".to_string());
        let only = view.or(layers)?;
        Some(format!("{} has no views and layers: only {only} was written", format.name()))
    }
}

/// Refuses a choice of layers for a PNG or JPEG file.
pub(super) fn check_no_layers(wanted: &LayerChoice) -> Result<(), Problem> {
    let further = wanted.layers.as_ref().and_then(LayersWish::first);
    let vectors = match &wanted.motion {
        MotionWish::Named(name) => Some(name.as_str()),
        MotionWish::Auto | MotionWish::Without => None,
    };
    let first = wanted.color.as_deref().or(further).or(vectors);
    first.map_or(Ok(()), |layer| Err(no_layers(layer)))
}

/// The error that PNG and JPEG files have no layers.
pub(super) fn no_layers(wanted: &str) -> Problem {
    Problem::Layers(format!("has no layers, so no layer `{}`", escaped(wanted)))
}

/// Chooses the layers of an EXR file to read, and the files that stand in for some.
pub(super) fn choose(
    file: &ExrFile,
    wanted: &LayerChoice,
) -> Result<(Vec<Choice>, Files), Problem> {
    let parts = file.parts();
    let (wishes, files) = wanted.wishes(&parts)?;
    let mut choices = choice::choose(&parts, &wishes)?;
    let given = files.albedo.as_ref().or(files.normal.as_ref());
    if let Some(given) = given.filter(|_| choices.len() > 1) {
        return Err(Problem::AmbiguousColor(format!(
            "has {} views, and {} fits only one of them",
            choices.len(),
            escaped(&given.to_string_lossy())
        )));
    }
    for choice in &mut choices {
        if wanted.finished && wanted.color.is_none() {
            choice.color = choice.target.clone();
        }
        file.check(&choice.target)?;
        let window = file.window(choice.color.part());
        let usable = |place| file.check_channel(place).is_ok() && file.window(place.part) == window;
        if choice.alpha.take_if(|(from, to)| !usable(*from) || !usable(*to)).is_some() {
            choice.left_out.push(UNUSABLE_ALPHA.into());
        }
        let has_unusable = |pick: &mut MotionPick| !pick.channels.iter().all(|at| usable(*at));
        if let Some(pick) = choice.motion.take_if(has_unusable) {
            choice.leave_out_motion(&pick)?;
        }
        choice.leave_out_unusable(|pick| file.check(pick));
    }
    Ok((choices, files))
}

const UNUSABLE_ALPHA: &str = "the alpha holds integers or covers another rectangle than the color; \
                              it stays as it is";

/// Refuses files whose images together would not fit in memory, however small each is.
fn check_size(file: &ExrFile, choices: &[Choice], limits: Limits) -> Result<(), Problem> {
    let area = |choice: &Choice| file.window(choice.color.part()).size.area() as u64;
    let pixels = |choice: &Choice| area(choice).saturating_mul(choice.picks().count() as u64);
    let pixels = choices.iter().map(pixels).fold(0, u64::saturating_add);
    let most = limits.pixels.saturating_mul(MOST_IMAGES);
    if pixels <= most {
        return Ok(());
    }
    Err(Problem::TooLarge(format!(
        "has {pixels} pixels in the layers to read, and at most {most} are accepted; denoise fewer \
         layers at a time"
    )))
}

/// How many images of the largest accepted size a file may hold in all views and layers.
const MOST_IMAGES: u64 = 8;

/// Reads the chosen layers of one view, each in the color's window.
fn read_view(
    file: &ExrFile,
    choice: &Choice,
    selection: Selection,
    notices: &mut Vec<String>,
) -> Result<View, Problem> {
    let picks: Vec<_> = choice.picks().collect();
    let to = file.window(choice.color.part());
    let mut planes: Vec<_> = choice.alpha.iter().map(|(from, _)| *from).collect();
    planes.extend(choice.motion.iter().flat_map(|pick| &pick.channels));
    if file.is_cube(choice.color.part()) {
        notices.push(
            "the faces of the cube map are denoised as one image, so light crosses their edges; \
             denoise them one by one"
                .into(),
        );
    }
    let (images, mut planes) = file.read(&picks, &planes)?;
    let vectors = planes.split_off(usize::from(choice.alpha.is_some()));
    let motion = choice.motion.as_ref();
    let mut images = images.into_iter().zip(&picks).map(|(image, pick)| {
        let from = file.window(pick.part());
        if from != to {
            notices.push(window::notice(&pick.layer, from, to));
        }
        window::align(image, from, to)
    });
    let color = images.next().transpose()?.expect("the color is always picked");
    let albedo = choice.albedo.as_ref().and_then(|_| images.next()).transpose()?;
    let normal = choice.normal.as_ref().and_then(|_| images.next()).transpose()?;
    let layers = images
        .zip(&choice.layers)
        .map(|(image, pick)| image.map(|image| NoisyLayer { name: pick.layer.clone(), image }));
    Ok(View {
        name: choice.view.clone(),
        layers: layers.collect::<Result<_, _>>()?,
        color,
        albedo,
        normal,
        alpha: planes.pop(),
        motion: motion.map(|pick| MotionLayer { name: pick.layer.clone(), planes: vectors }),
        selection: Some(selection),
        corner: [to.position.x(), to.position.y()],
        is_panorama: file.is_panorama(choice.color.part()),
    })
}

/// Reads albedo and normal from separate files, fitted to the color.
fn add_files(
    view: &mut View,
    files: &Files,
    color: &Place,
    limits: Limits,
    notices: &mut Vec<String>,
) -> Result<(), FileError> {
    if let Some(path) = &files.albedo {
        let (image, notice) = aux_file::albedo(path, color, limits)?;
        view.albedo = Some(image);
        notices.extend(notice);
    }
    if let Some(path) = &files.normal {
        let (image, notice) = aux_file::normal(path, color, limits)?;
        view.normal = Some(image);
        notices.extend(notice);
    }
    Ok(())
}

fn save_exr(
    file: &ExrFile,
    choices: &[Choice],
    results: &[Denoised],
    out: &mut Out<'_>,
) -> Result<Vec<String>, Problem> {
    let pairs = choices.iter().zip(results);
    let changes: Vec<_> =
        pairs.flat_map(|(choice, result)| changes(file, choice, result)).collect();
    let clamped = file.write(out, &changes)?;
    let mut notices = Vec::new();
    if clamped > 0 {
        notices.push(format!(
            "{clamped} values exceed 65504, the largest half float, and were clamped"
        ));
    }
    for part in file.rewritten_lossily(&changes) {
        let targets = choices.iter().flat_map(Choice::targets);
        let layer = targets.into_iter().find(|pick| pick.part() == part).map(|pick| &pick.layer);
        notices.push(format!(
            "other channels in the part of `{}` went through its lossy compression again and \
             may have changed slightly",
            escaped(layer.map_or("alpha", String::as_str))
        ));
    }
    if changes.iter().any(|change| file.has_levels(change.place.part)) {
        notices.push("only the largest mip level was denoised".into());
    }
    Ok(notices)
}

/// The changes that a view's result makes to the file.
fn changes<'a>(file: &ExrFile, choice: &Choice, result: &'a Denoised) -> Vec<Change<'a>> {
    let window = file.window(choice.color.part());
    let images = [&result.color].into_iter().chain(&result.layers);
    let mut changes = Vec::new();
    for (pick, image) in choice.targets().zip(images) {
        changes.extend(Change::of_image(pick, window, image));
    }
    if let (Some((_, place)), Some(alpha)) = (choice.alpha, &result.alpha) {
        changes.push(Change { place, window, samples: Samples::Plane(alpha) });
    }
    changes
}
