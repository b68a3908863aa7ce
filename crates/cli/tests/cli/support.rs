//! Runs the binary in a temporary folder.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use exr::prelude::*;

/// Fast weights; the quality of their results does not matter here.
pub(crate) const WEIGHTS: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/fixtures/unet_tiny.safetensors");

pub(crate) type AnyImage = Image<Layers<AnyChannels<FlatSamples>>>;

/// A temporary folder, removed when the test ends.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Copies a file from `tests/data`.
    pub(crate) fn copy(&self, name: &str) -> PathBuf {
        let path = self.path(name);
        std::fs::copy(data(name), &path).unwrap();
        path
    }

    /// All file names, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> =
            entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// The command in this folder, without a desktop session, which makes drivers complain, and on
    /// Linux with a cache other than the user's.
    pub(crate) fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_wgdenoise"));
        command.current_dir(self.0.path()).env_remove("XDG_RUNTIME_DIR").args(args);
        command.env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"));
        command
    }

    /// The command as run by a shell after `ulimit` or the like.
    #[cfg(target_os = "linux")]
    pub(crate) fn command_after(&self, words: &str, args: &[&str]) -> Command {
        let direct = self.command(args);
        let mut command = Command::new("sh");
        command.args(["-c", &format!("{words}; exec \"$0\" \"$@\"")]);
        command.arg(direct.get_program()).args(direct.get_args());
        command.current_dir(self.0.path()).env_remove("XDG_RUNTIME_DIR");
        command.env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"));
        command
    }

    pub(crate) fn run(&self, args: &[&str]) -> Run {
        Run::of(&self.command(args).output().unwrap())
    }

    /// Runs `wgdenoise` with the fast test weights.
    pub(crate) fn denoise(&self, args: &[&str]) -> Run {
        self.run(&[args, &["--weights", WEIGHTS]].concat())
    }
}

pub(crate) fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// The outcome of a run.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Run {
    pub(crate) fn of(output: &Output) -> Self {
        Self {
            code: output.status.code().expect("the program was not killed"),
            stdout: String::from_utf8(output.stdout.clone()).unwrap(),
            stderr: String::from_utf8(output.stderr.clone()).unwrap(),
        }
    }

    /// Asserts exit code 0 and nothing on stdout.
    #[track_caller]
    pub(crate) fn assert_done(&self) {
        assert_eq!((self.code, self.stdout.as_str()), (0, ""), "{self:?}");
    }

    /// Asserts this exit code, and one sentence with all of `words`.
    #[track_caller]
    pub(crate) fn assert_failed(&self, code: i32, words: &[&str]) {
        assert_eq!((self.code, self.stdout.as_str()), (code, ""), "{self:?}");
        let lines: Vec<_> = self.stderr.lines().collect();
        assert!(lines.len() == 1 && lines[0].starts_with("wgdenoise: error: "), "{self:?}");
        for word in words {
            assert!(lines[0].contains(word), "no `{word}` in {self:?}");
        }
    }

    #[track_caller]
    pub(crate) fn json(&self) -> serde_json::Value {
        assert_eq!((self.code, self.stderr.as_str()), (0, ""), "{self:?}");
        serde_json::from_str(&self.stdout).expect(&self.stdout)
    }
}

/// Reads everything in an EXR file.
pub(crate) fn read_exr(path: &Path) -> AnyImage {
    let reader = read().no_deep_data().largest_resolution_level().all_channels();
    reader.all_layers().all_attributes().from_file(path).unwrap()
}

/// Takes the channel `name` of a part out of an image.
pub(crate) fn take(image: &mut AnyImage, part: usize, name: &str) -> FlatSamples {
    let list = &mut image.layer_data[part].channel_data.list;
    let index = list.iter().position(|c| c.name == *name).expect(name);
    list.remove(index).sample_data
}
