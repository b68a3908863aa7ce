//! Carries out the actions of keys and buttons.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use wgdenoise_files::escaped;

use crate::dialog;
use crate::gpu::screen::Kind;
use crate::open::Wish;
use crate::perceived::Asked;
use crate::picture::{Pixels, Side, picture};
use crate::save;
use crate::session::Session;
use crate::state::keys::Action;
use crate::state::looking::{Measure, Shown};
use crate::state::sequence::Sequence;
use crate::state::settings::{Layers, Source};
use crate::watch::Watch;
use crate::work::{Purpose, Report};

/// Carries out an action. Returns text for the clipboard.
pub(crate) fn act(session: &mut Session, action: Action) -> Option<String> {
    match action {
        Action::Show(shown) => show(session, shown),
        Action::Toggle => session.looking.toggle(),
        Action::Arrange(layout) => session.looking.toggle_layout(layout),
        Action::Fit => session.transform.fit(),
        Action::OneToOne => session.transform.one_to_one(),
        Action::Zoom(factor) => {
            let middle = session.area.map(|side| side / 2.0);
            session.transform.zoom_at(middle, factor, session.area);
        }
        Action::Brighten(stops) => session.tone.brighten(stops),
        Action::ResetExposure => session.tone.exposure = 0.0,
        Action::NextCurve => session.tone.next_curve(),
        Action::NextMeasure => next_measure(session),
        Action::Open => ask_to_open(session, Purpose::Open),
        Action::OpenReference => ask_to_open(session, Purpose::Reference),
        Action::OpenWeights => ask_to_open(session, Purpose::Weights),
        Action::OpenWeightsFolder => ask_to_open(session, Purpose::WeightsFolder),
        Action::BuiltInWeights => use_weights(session, Source::BuiltIn),
        Action::Save => ask_to_save(session, Purpose::Save),
        Action::SaveComparison => ask_to_save(session, Purpose::SaveComparison),
        Action::CopyCommand => return command(session),
        Action::CopyImage => copy_image(session),
        Action::Step(by) => go(session, |sequence| sequence.step(by)),
        Action::First => go(session, |sequence| sequence.go(0)),
        Action::Last => go(session, |sequence| sequence.go(usize::MAX)),
        Action::Watch => toggle_watch(session),
        Action::Cancel => cancel(session),
        Action::Help => session.shows_help = !session.shows_help,
    }
    None
}

/// Steps through the sequence and reads the file it arrives at.
pub(crate) fn go(session: &mut Session, step: impl FnOnce(&mut Sequence) -> bool) {
    let Some(mut sequence) = session.sequence.clone() else { return };
    if step(&mut sequence) {
        let (path, wish) = (sequence.current().to_path_buf(), session.wish.clone());
        session.read(&path, Some(sequence), wish);
    }
}

/// Processes the threads' reports and starts the work that follows from them.
pub(crate) fn catch_up(session: &mut Session) {
    for report in session.take_reports() {
        follow(session, report);
    }
    keep_watching(session);
    keep_perceiving(session);
    keep_further(session);
}

/// Handles a report that does not concern the session's own work.
fn follow(session: &mut Session, report: Report) {
    match report {
        Report::Chosen(purpose, paths) => chosen(session, purpose, &paths),
        Report::Changed(path, version) => {
            if let Some(watch) = session.watch.as_mut().filter(|watch| watch.path() == path) {
                watch.unread = Some(version);
            }
        }
        Report::Perceived(ticket, Ok(found)) => session.perceiving.take(ticket, found),
        Report::Perceived(_, Err(error))
        | Report::Further(Err(error))
        | Report::Saved(Err(error)) => session.fail(error),
        Report::Further(Ok(layer)) => session.further.take(layer),
        Report::NoDialog(prompt) => session.prompt = Some(prompt),
        Report::Recent(entries) => session.recent.entries = entries,
        Report::Saved(Ok(told)) => session.tell(told),
        Report::Pictured(pixels) => {
            session.copied = Some(pixels);
            session.tell("copied the picture that is shown");
        }
        _ => {}
    }
}

/// Moves the watch to the open file if it was on another, and reads a newly written version.
fn keep_watching(session: &mut Session) {
    let Some(watched) = session.watch.as_ref().map(|watch| watch.path().to_path_buf()) else {
        return;
    };
    if session.opened().is_some_and(|opened| opened.path != watched) {
        session.watch = None;
        toggle_watch(session);
    }
    session.read_version();
}

/// Requests the visible errors, if there are a result and a reference of the same size.
fn keep_perceiving(session: &mut Session) {
    let wanted = || {
        let reference = session.reference.as_ref().filter(|_| session.available().reference)?;
        Some(Asked {
            opened: session.opened()?.clone(),
            outcome: session.denoised.clone()?,
            reference: reference.image.clone(),
            exposure: session.tone.exposure,
        })
    };
    let wanted = wanted();
    session.perceiving.ask(wanted, &session.gpu);
}

/// Uploads the chosen further layer to the GPU.
fn keep_further(session: &mut Session) {
    let loaded = session.loaded.as_ref().map(|loaded| &loaded.opened);
    if let Some(source) = session.further.ask(loaded, session.denoised.as_ref()) {
        let gpu = session.gpu.clone();
        session.in_background(move || Report::Further(source.upload(&gpu)));
    }
}

fn show(session: &mut Session, shown: Shown) {
    session.looking.shown = shown;
    let has_file = session.opened().is_some();
    if has_file && !session.available().has(shown) {
        match shown {
            Shown::Reference => no_reference(session),
            Shown::Albedo => session.tell("the file has no albedo"),
            Shown::Normal => session.tell("the file has no normals"),
            Shown::Noisy | Shown::Denoised | Shown::Difference => {}
        }
    }
}

fn next_measure(session: &mut Session) {
    session.looking.next_measure();
    let needs_reference = session.looking.measure == Measure::Perceived;
    if needs_reference && session.layer().is_some() {
        session.tell("the reference belongs to the color; further layers have none");
    } else if needs_reference && !session.available().reference {
        no_reference(session);
    }
}

fn no_reference(session: &mut Session) {
    let none = "there is no reference; open one with R, or drop it with Shift held";
    session.tell(session.misfit().unwrap_or_else(|| none.into()));
}

/// Opens dropped or named files: weights, images, or a reference if `as_reference` is set.
pub(crate) fn open_any(session: &mut Session, paths: &[PathBuf], as_reference: bool) {
    match paths {
        [] => {}
        [first, ..] if as_reference => session.read_reference(first),
        [only] if Source::is_weights(only) => use_weights(session, Source::of(only)),
        _ => session.open(paths),
    }
}

/// Denoises with other weights.
fn use_weights(session: &mut Session, weights: Source) {
    session.settings.weights = weights;
    session.denoise();
}

fn ask_to_open(session: &Session, purpose: Purpose) {
    let folder = session.opened().and_then(|opened| opened.path.parent());
    dialog::open(purpose, folder, session.desk.clone());
}

fn ask_to_save(session: &mut Session, purpose: Purpose) {
    let Some(opened) = session.opened() else { return };
    if purpose == Purpose::Save && session.denoised.is_none() {
        session.tell("there is no result yet");
        return;
    }
    let suggested = match purpose {
        Purpose::SaveComparison => save::suggested(&opened.path, "comparison", Some("png")),
        _ => save::suggested(&opened.path, "denoised", None),
    };
    dialog::save(purpose, &suggested, session.desk.clone());
}

fn chosen(session: &mut Session, purpose: Purpose, paths: &[PathBuf]) {
    let Some(first) = paths.first() else { return };
    match purpose {
        Purpose::Open => session.open(paths),
        Purpose::Reference => session.read_reference(first),
        Purpose::Weights | Purpose::WeightsFolder => use_weights(session, Source::of(first)),
        Purpose::Save => save_result(session, first),
        Purpose::SaveComparison => save_comparison(session, first),
    }
}

/// Uses a typed path. It never replaces a file: only the system's dialog asks for consent.
pub(crate) fn typed(session: &mut Session, purpose: Purpose, path: PathBuf) {
    let saves = matches!(purpose, Purpose::Save | Purpose::SaveComparison);
    if path.as_os_str().is_empty() {
        session.tell("no path was typed");
    } else if saves && path.exists() {
        let name = escaped(&path.to_string_lossy());
        session.fail(format!("{name}: already exists; give another name"));
    } else {
        chosen(session, purpose, &[path]);
    }
}

/// Saves the result as the command line would.
pub(crate) fn save_result(session: &mut Session, path: &Path) {
    let (Some(opened), Some(denoised)) = (session.opened(), &session.denoised) else { return };
    let (opened, outcome) = (opened.clone(), denoised.clone());
    let path = path.to_path_buf();
    session.tell(saving(&path));
    session.in_background(move || Report::Saved(save::result(&opened, &outcome.results, &path)));
}

/// Saves what the window shows, in its layout, as PNG.
pub(crate) fn save_comparison(session: &mut Session, path: &Path) {
    let (Some(opened), Some(draw)) = (session.opened(), drawn(session)) else { return };
    let (opened, path) = (opened.clone(), path.to_path_buf());
    session.tell(saving(&path));
    session.in_background(move || Report::Saved(save::picture(&opened, &draw(), &path)));
}

fn saving(path: &Path) -> String {
    format!("saving {}…", escaped(&path.to_string_lossy()))
}

fn copy_image(session: &Session) {
    let Some(draw) = drawn(session) else { return };
    session.in_background(move || Report::Pictured(draw()));
}

/// Draws what the window shows; to be called on another thread.
fn drawn(session: &Session) -> Option<impl FnOnce() -> Pixels + Send + use<>> {
    let visible = session.looking.visible(session.available());
    let image = |shown| session.image(shown).cloned().map(Arc::new);
    let [left, right] = [image(visible[0])?, image(visible[1])?];
    let subtracted = image(session.subtracted())?;
    let has_map = session.perceived().is_some();
    let kinds = visible.map(|shown| Kind::of(shown, has_map));
    let (looking, tone) = (session.looking.clone(), session.tone);
    Some(move || {
        let side = |i: usize, image| Side { kind: kinds[i], image, subtracted: &subtracted };
        picture([side(0, &left), side(1, &right)], &looking, tone)
    })
}

fn command(session: &mut Session) -> Option<String> {
    let opened = session.opened()?;
    let output = save::suggested(&opened.path, "denoised", None);
    let Wish { color, layers, .. } = &opened.wish;
    let layers = Layers { color: color.as_deref(), further: layers.as_ref() };
    match session.settings.command(&opened.path, &output, layers) {
        Ok(command) => {
            session.tell(format!("copied: {command}"));
            Some(command)
        }
        Err(why) => {
            session.fail(why);
            None
        }
    }
}

fn toggle_watch(session: &mut Session) {
    if session.watch.take().is_some() {
        return;
    }
    let Some(opened) = session.opened() else { return };
    match Watch::start(&opened.path, opened.stamp, session.desk.clone()) {
        Ok(watch) => session.watch = Some(watch),
        Err(error) => session.fail(error),
    }
}

/// Cancels the topmost of help, running work and message.
fn cancel(session: &mut Session) {
    if session.shows_help {
        session.shows_help = false;
    } else if session.cancel_opening() {
        session.tell("canceled");
    } else if session.is_denoising() {
        session.cancel();
        session.tell("canceled");
    } else {
        session.message = None;
    }
}
