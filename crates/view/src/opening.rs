//! Opens files on their own thread. The latest request wins: earlier or canceled ones are never
//! shown, however late they arrive. The open file stays until the new one is read.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use wgdenoise::Image;
use wgdenoise_files::escaped;

use crate::gpu::host::Gpu;
use crate::gpu::texture::Texture;
use crate::open::{Opened, Wish, sentence};
use crate::session::Session;
use crate::state::pending::Reading;
use crate::state::sequence::Sequence;
use crate::state::settings::listed;
use crate::state::settling::Stamp;
use crate::work::{Loaded, Reference, Report};

impl Session {
    pub(crate) fn is_opening(&self) -> bool {
        self.opening.name().is_some()
    }

    /// Opens the first of these files; the arrow keys lead to the others, or to the other frames.
    pub(crate) fn open(&mut self, files: &[PathBuf]) {
        match Sequence::of(files) {
            Ok(Some(sequence)) => {
                let path = sequence.current().to_path_buf();
                self.read(&path, Some(sequence), Wish::default());
            }
            Ok(None) => {}
            Err(error) => self.fail(sentence(&error)),
        }
    }

    /// Reads the open file again, with another layer or view.
    pub(crate) fn choose(&mut self, wish: Wish) {
        if let Some(path) = self.opened().map(|opened| opened.path.clone()) {
            self.read(&path, self.sequence.clone(), wish);
        }
    }

    /// Reads the watched file again if it was rewritten, once nothing else is being opened.
    pub(crate) fn read_version(&mut self) {
        let Some(watch) = self.watch.as_ref().filter(|_| !self.is_opening()) else { return };
        if let (path, version @ Some(_)) = (watch.path().to_path_buf(), watch.unread) {
            self.start(&path, self.sequence.clone(), self.wish.clone(), version);
        }
    }

    /// Reads a file that the user asked for, with its sequence.
    pub(crate) fn read(&mut self, path: &Path, sequence: Option<Sequence>, wish: Wish) {
        self.start(path, sequence, wish, None);
    }

    fn start(
        &mut self,
        path: &Path,
        sequence: Option<Sequence>,
        wish: Wish,
        version: Option<Stamp>,
    ) {
        let replaced = std::mem::replace(&mut self.sequence, sequence);
        let chosen = (replaced, std::mem::replace(&mut self.wish, wish.clone()));
        let before = self.opening.noisy.take().map_or(chosen, |reading| reading.before);
        self.opening.noisy = Some(Reading { name: name(path), version, before });
        let latest = self.opening.latest_noisy.clone();
        let (ticket, path, gpu) = (latest.next(), path.to_path_buf(), self.gpu.clone());
        self.in_background(move || {
            if latest.is(ticket) {
                Report::Opened(ticket, load(&gpu, &path, wish))
            } else {
                Report::Nothing
            }
        });
    }

    /// Reads a reference.
    pub(crate) fn read_reference(&mut self, path: &Path) {
        self.opening.reference = Some(name(path));
        let latest = self.opening.latest_reference.clone();
        let (ticket, path, gpu) = (latest.next(), path.to_path_buf(), self.gpu.clone());
        self.in_background(move || {
            if latest.is(ticket) {
                Report::Reference(ticket, load_reference(&gpu, path))
            } else {
                Report::Nothing
            }
        });
    }

    /// Cancels opening and keeps what is open. Returns whether a file was being read.
    pub(crate) fn cancel_opening(&mut self) -> bool {
        let was_opening = self.is_opening();
        self.opening.latest_noisy.next();
        self.opening.latest_reference.next();
        self.opening.reference = None;
        if let Some(reading) = self.opening.noisy.take() {
            self.finish_version(reading.version);
            (self.sequence, self.wish) = reading.before;
        }
        was_opening
    }

    /// Shows a file that was read, unless it is no longer wanted.
    pub(crate) fn take_opened(&mut self, ticket: u64, loaded: Result<Loaded, String>) {
        if !self.opening.latest_noisy.is(ticket) {
            return;
        }
        let Some(reading) = self.opening.noisy.take() else { return };
        self.finish_version(reading.version);
        match loaded {
            Ok(loaded) => {
                self.show(loaded);
                self.denoise();
                self.compare();
            }
            Err(error) => {
                let (sequence, wish) = reading.before;
                let files = |s: &Option<Sequence>| s.as_ref().map(|s| s.files().to_vec());
                // Keep the position, so that the arrow keys can step past a broken frame.
                if files(&sequence) != files(&self.sequence) {
                    self.sequence = sequence;
                }
                self.wish = wish;
                self.fail(error);
            }
        }
    }

    fn show(&mut self, loaded: Loaded) {
        let size = self.opened().map(|opened| opened.size());
        if size != Some(loaded.opened.size()) {
            self.transform.fit();
        }
        let wish = &loaded.opened.wish;
        if wish.color.is_none() {
            self.colors = loaded.opened.colors();
        }
        if self.opened().is_none_or(|opened| opened.wish.layers != wish.layers) {
            self.patterns = wish.layers.as_ref().map(listed).unwrap_or_default();
        }
        self.finish_version(loaded.opened.stamp);
        let with = self.sequence.as_ref().map(Sequence::files).unwrap_or_default();
        self.recent.add(&loaded.opened.path, with, &self.desk);
        self.loaded = Some(loaded);
        (self.denoised, self.figures, self.message) = (None, None, None);
    }

    /// Takes a reference that was read, unless it is no longer wanted.
    pub(crate) fn take_reference(&mut self, ticket: u64, reference: Result<Reference, String>) {
        if !self.opening.latest_reference.is(ticket) {
            return;
        }
        self.opening.reference = None;
        match reference {
            Ok(reference) => {
                (self.reference, self.message) = (Some(reference), None);
                self.compare();
                if let Some(why) = self.misfit() {
                    self.fail(why);
                }
            }
            Err(error) => self.fail(error),
        }
    }

    fn finish_version(&mut self, version: Option<Stamp>) {
        if let Some(watch) = &mut self.watch {
            watch.finish(version);
        }
    }
}

/// The file name as shown in the window.
fn name(path: &Path) -> String {
    escaped(&path.file_name().unwrap_or_default().to_string_lossy())
}

fn load(gpu: &Gpu, path: &Path, wish: Wish) -> Result<Loaded, String> {
    let opened = Opened::noisy(path, wish)?;
    let view = opened.view();
    let upload = |image: Option<&Image>| image.map(|i| Texture::upload(gpu, i)).transpose();
    let noisy = Texture::upload(gpu, view.color())?;
    let (albedo, normal) = (upload(view.albedo())?, upload(view.normal())?);
    Ok(Loaded { opened: Arc::new(opened), noisy, albedo, normal })
}

fn load_reference(gpu: &Gpu, path: PathBuf) -> Result<Reference, String> {
    let opened = Opened::reference(&path)?;
    let image = opened.view().color();
    let texture = Texture::upload(gpu, image)?;
    Ok(Reference { image: Arc::new(image.clone()), texture, path })
}

#[cfg(test)]
mod tests;
