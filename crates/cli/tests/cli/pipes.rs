//! Standard input and output, and other pipes.

use std::fs;
use std::io::Write;
use std::process::{Command, Output, Stdio};
use std::thread;

use crate::support::{Folder, Run, WEIGHTS, data};

/// A folder with an image and its denoised result in each format.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.copy("karma_like.exr");
    let picture = image::RgbImage::from_fn(20, 20, |x, y| image::Rgb([(x * y % 256) as u8; 3]));
    for name in ["in.png", "in.jpg"] {
        picture.save(folder.path(name)).unwrap();
    }
    for input in ["karma_like.exr", "in.png", "in.jpg"] {
        let out = format!("out.{}", input.split_once('.').unwrap().1);
        folder.denoise(&[input, &out, "-q"]).assert_done();
    }
    folder
}

impl Folder {
    /// Runs with the fast test weights and these bytes on standard input.
    fn pipe(&self, input: &[u8], args: &[&str]) -> Output {
        let mut command = self.command(&[args, &["--weights", WEIGHTS]].concat());
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let (mut stdin, input) = (child.stdin.take().unwrap(), input.to_vec());
        // It is fine if the program stops reading.
        let writer = thread::spawn(move || stdin.write_all(&input));
        let output = child.wait_with_output().unwrap();
        let _ = writer.join().unwrap();
        output
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap()
    }
}

#[test]
fn a_pipe_is_read_and_written_in_every_format_as_a_file_is() {
    let folder = folder();
    for (input, expected) in
        [("karma_like.exr", "out.exr"), ("in.png", "out.png"), ("in.jpg", "out.jpg")]
    {
        let output = folder.pipe(&folder.bytes(input), &["-", "-", "-v"]);
        assert!(output.status.success(), "{output:?}");
        assert!(output.stdout == folder.bytes(expected), "{input}");
        assert!(String::from_utf8_lossy(&output.stderr).contains("wgdenoise: wrote - in "));
        for stdin in ["-", "/dev/stdin"] {
            let output = folder.pipe(&folder.bytes(input), &[stdin, "again.exr", "-q"]);
            Run::of(&output).assert_done();
            folder.denoise(&[input, "named.exr", "-q"]).assert_done();
            assert!(folder.bytes("again.exr") == folder.bytes("named.exr"), "{input}");
            for name in ["again.exr", "named.exr"] {
                fs::remove_file(folder.path(name)).unwrap();
            }
        }
    }
}

#[test]
fn the_format_of_standard_output_can_be_chosen() {
    let folder = folder();
    let args = ["karma_like.exr", "look.png", "--exposure", "1", "-q"];
    folder.denoise(&args).assert_done();
    let output = folder.pipe(b"", &["karma_like.exr", "-", "--format", "png", "--exposure", "1"]);
    assert!(output.stdout == folder.bytes("look.png"));
    let output = folder.pipe(&folder.bytes("in.png"), &["-", "-", "--format", "exr"]);
    assert!(output.stdout.starts_with(&[0x76, 0x2f, 0x31, 0x01]));
    let named = ["in.png", "o.exr", "--format", "exr"];
    folder.denoise(&named).assert_failed(2, &["--format is for standard output"]);
    let output = folder.pipe(b"", &["karma_like.exr", "-", "--exposure", "1"]);
    Run::of(&output).assert_failed(2, &["--exposure changes PNG and JPEG only"]);
}

#[test]
fn named_pipes_and_process_substitution_are_read_too() {
    let folder = folder();
    folder
        .denoise(&["karma_like.exr", "aux.exr", "-q", "--albedo", "karma_like.exr"])
        .assert_done();
    let program = env!("CARGO_BIN_EXE_wgdenoise");
    let script = format!(
        "{program} <(cat karma_like.exr) a.exr -q --weights {WEIGHTS} && \
         {program} karma_like.exr b.exr -q --weights {WEIGHTS} --albedo <(cat karma_like.exr) && \
         {program} info <(cat in.png) && {program} preview - p.png < karma_like.exr"
    );
    let mut command = Command::new("bash");
    let output = command.args(["-c", &script]).current_dir(folder.path(".")).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stdout).contains("PNG, 8-bit RGB, 20×20 pixels"));
    assert!(folder.bytes("a.exr") == folder.bytes("out.exr"));
    assert!(folder.bytes("b.exr") == folder.bytes("aux.exr"));
}

#[test]
fn what_no_pipe_can_do_is_one_sentence() {
    let folder = folder();
    fs::create_dir(folder.path("results")).unwrap();
    let before = folder.names();
    let whole = folder.bytes("karma_like.exr");
    for (input, args, code, words) in [
        (&b""[..], &["-", "o.exr"][..], 1, "-: is empty"),
        (b"no picture", &["-", "-"], 1, "-: is not an EXR, PNG or JPEG file"),
        (&whole[..whole.len() / 2], &["-", "-"], 1, "-: is cut off"),
        (b"", &["karma_like.exr", "in.png", "-"], 2, "standard output takes the result of one"),
        (b"", &["-", "results"], 2, "-: standard input has no name; name OUT"),
        (b"", &["-", "--in-place"], 2, "-: standard input has no name; name OUT"),
        (b"", &["-"], 2, "`-` has no output; write wgdenoise - OUT"),
        (
            b"",
            &["karma_like.exr", "in.png", "results", "--albedo", "-"],
            2,
            "-: a pipe is read for",
        ),
        (b"", &["karma_like.exr", "/dev/stdout"], 2, "give - for standard output"),
    ] {
        Run::of(&folder.pipe(input, args)).assert_failed(code, &[words]);
    }
    assert_eq!(folder.names(), before);
}

/// If the reader goes away, the program fails, because the image is lost.
#[cfg(unix)]
#[test]
fn a_missing_temporary_folder_is_named() {
    let folder = folder();
    folder.copy("karma_like.exr");
    let mut command = folder.command(&["karma_like.exr", "-", "-q", "--weights", WEIGHTS]);
    let run = Run::of(&command.env("TMPDIR", "/missing").output().unwrap());
    run.assert_failed(1, &["-: cannot be kept in /missing"]);
}

#[test]
fn a_closed_pipe_is_one_sentence() {
    let folder = Folder::new();
    fs::copy(data("karma_like.exr"), folder.path("in.exr")).unwrap();
    let mut command = folder.command(&["in.exr", "-", "-q", "--weights", WEIGHTS]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    Run::of(&output).assert_failed(1, &["-: cannot be written: Broken pipe"]);
}
