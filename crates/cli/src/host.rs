//! Runs the command line inside another program, which keeps its signals, terminal and process.

use std::ffi::OsString;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use wgdenoise::Weights;

use crate::console::Console;
use crate::denoise;
use crate::failure::Failure;
use crate::parse;

pub use crate::console::{Host, Level};

/// Denoises as the program does with these words, its name first: `wgdenoise [OPTIONS] IN... OUT`.
///
/// A pipe is read once per call. Once `stop` is true, the current image is abandoned; images
/// denoised before it are still written whole.
///
/// # Errors
/// Fails like the program, with the same sentences, and with [`Failure::Stopped`].
pub fn denoise(words: &[OsString], host: Box<dyn Host>, stop: &AtomicBool) -> Result<(), Failure> {
    let request = parse::parse_denoise(words)?;
    let console = Console::of_host(request.verbosity, host);
    let outcome = denoise::run(&request, &console, Some(stop));
    request.files().for_each(wgdenoise_files::forget);
    outcome
}

/// Reads a weights file as `--weights` does: safetensors in wgdenoise's format, or Open Image
/// Denoise's TZA.
///
/// # Errors
/// If the file cannot be read or is not a weights file.
pub fn weights(path: &Path) -> Result<Weights, Failure> {
    Ok(wgdenoise_files::weights::load(path)?)
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::rc::Rc;
    use std::sync::atomic::Ordering;

    use super::*;

    const NOISY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/plain_rgb.exr");
    const NOISY_KARMA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/karma_like.exr");
    const WEIGHTS: &str =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/fixtures/unet_tiny.safetensors");

    /// Records what it receives, and asks to stop at a given step.
    #[derive(Default)]
    struct Notes {
        messages: RefCell<Vec<(Level, String)>>,
        steps: RefCell<Vec<(u64, u64)>>,
        stop: AtomicBool,
        stop_at: Option<u64>,
    }

    impl Host for Rc<Notes> {
        fn message(&self, level: Level, text: &str) {
            self.messages.borrow_mut().push((level, text.into()));
        }

        fn progress(&self, done: u64, total: u64) {
            self.steps.borrow_mut().push((done, total));
            if self.stop_at.is_some_and(|at| done >= at) {
                self.stop.store(true, Ordering::Relaxed);
            }
        }
    }

    fn run(notes: &Rc<Notes>, words: &[&str]) -> Result<(), Failure> {
        let words: Vec<_> = [&["wgdenoise"], words].concat().iter().map(OsString::from).collect();
        denoise(&words, Box::new(Rc::clone(notes)), &notes.stop)
    }

    #[test]
    fn a_host_hears_what_the_program_prints_and_how_far_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("clean.exr");
        let notes = Rc::default();
        run(&notes, &["--weights", WEIGHTS, NOISY, out.to_str().unwrap()]).unwrap();
        assert!(out.is_file());
        let messages = notes.messages.borrow();
        let (level, last) = messages.last().unwrap();
        assert!(*level == Level::Notice && last.starts_with("wrote "), "{messages:?}");
        let steps = notes.steps.borrow();
        assert!(steps.is_sorted() && steps.last() == Some(&(1000, 1000)), "{steps:?}");
    }

    #[test]
    fn one_of_several_images_that_fails_is_an_error_message() {
        let folder = tempfile::tempdir().unwrap();
        let broken = folder.path().join("broken.exr");
        std::fs::write(&broken, "no image").unwrap();
        let out = folder.path().join("clean");
        std::fs::create_dir(&out).unwrap();
        let (notes, [broken, out]) = (Rc::default(), [&broken, &out].map(|p| p.to_str().unwrap()));
        let failure = run(&notes, &["--weights", WEIGHTS, broken, NOISY, out]).unwrap_err();
        assert_eq!(failure.to_string(), "1 of 2 images failed");
        let messages = notes.messages.borrow();
        let errors: Vec<_> = messages.iter().filter(|(level, _)| *level == Level::Error).collect();
        assert!(errors.len() == 1 && errors[0].1.starts_with(broken), "{messages:?}");
    }

    #[test]
    fn a_run_that_is_stopped_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("clean.exr");
        let notes = Rc::new(Notes { stop_at: Some(0), ..Notes::default() });
        let failure = run(&notes, &["--weights", WEIGHTS, NOISY, out.to_str().unwrap()]);
        assert!(matches!(failure, Err(Failure::Stopped)), "{failure:?}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[cfg(unix)]
    #[test]
    fn each_call_reads_a_pipe_anew() {
        let folder = tempfile::tempdir().unwrap();
        let [pipe, out] = ["pipe.exr", "out.exr"].map(|name| folder.path().join(name));
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let sizes = [NOISY, NOISY_KARMA].map(|file| {
            let (bytes, pipe) = (std::fs::read(file).unwrap(), pipe.clone());
            let [from, to] = [&pipe, &out].map(|path| path.to_str().unwrap());
            let writer = std::thread::spawn({
                let pipe = pipe.clone();
                move || std::fs::write(pipe, bytes).unwrap()
            });
            run(&Rc::default(), &["--force", "--weights", WEIGHTS, from, to]).unwrap();
            writer.join().unwrap();
            let written = wgdenoise_files::Picture::open(&out, &Default::default()).unwrap();
            written.first().color().size()
        });
        assert_ne!(sizes[0], sizes[1]);
    }

    #[test]
    fn words_that_the_grammar_refuses_are_one_sentence() {
        let refused = |words: &[&str]| match run(&Rc::default(), words) {
            Err(Failure::Usage(sentence)) => sentence,
            other => panic!("{other:?}"),
        };
        assert_eq!(refused(&["--haste", "a.exr", "b.exr"]), "unexpected argument '--haste' found");
        assert!(refused(&["--quality=best", "a", "b"]).starts_with("invalid value 'best'"));
        assert_eq!(refused(&["devices"]), "a host denoises and runs no other command");
    }
}
