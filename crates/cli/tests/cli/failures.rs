use std::fs;
use std::process::{Command, Stdio};
use std::thread;

use crate::support::{Folder, Run};

#[test]
fn an_input_that_cannot_be_read_is_one_sentence_and_leaves_nothing_behind() {
    let folder = Folder::new();
    let whole = fs::read(folder.copy("blender5_parts.exr")).unwrap();
    fs::write(folder.path("cut.exr"), &whole[..whole.len() * 9 / 10]).unwrap();
    fs::write(folder.path("header.exr"), &whole[..200]).unwrap();
    fs::write(folder.path("garbage.exr"), "this is no picture").unwrap();
    fs::write(folder.path("empty.exr"), "").unwrap();
    fs::write(folder.path("cut.png"), b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR").unwrap();
    let jpeg = folder.path("cut.jpg");
    image::RgbImage::from_fn(64, 64, |x, y| image::Rgb([(x * y) as u8; 3])).save(&jpeg).unwrap();
    let whole = fs::read(&jpeg).unwrap();
    fs::write(&jpeg, &whole[..whole.len() * 2 / 3]).unwrap();
    fs::create_dir(folder.path("folder.exr")).unwrap();
    let before = folder.names();
    for (input, words) in [
        ("nowhere.exr", "nowhere.exr: cannot be read: No such file"),
        ("cut.exr", "blocks are missing"),
        ("header.exr", "header.exr: is cut off within the header of its part 0, at the attribute"),
        ("garbage.exr", "is not an EXR, PNG or JPEG file"),
        ("empty.exr", "is empty"),
        ("cut.png", "is cut off or damaged"),
        ("cut.jpg", "cut.jpg: is cut off"),
        ("folder.exr", "is a folder"),
    ] {
        folder.denoise(&[input, "out.exr"]).assert_failed(1, &[words]);
        assert_eq!(folder.names(), before, "{input}");
    }
}

/// Reading a device may never end; weights must be regular files.
#[cfg(unix)]
#[test]
fn a_device_is_refused_wherever_a_file_is_read_and_a_pipe_for_weights() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    image::RgbImage::new(37, 23).save(folder.path("a.png")).unwrap();
    let pipe = folder.path("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    // Unblocks a program that opens the pipe, so that the test fails instead of hanging.
    thread::spawn(move || while fs::write(&pipe, "").is_ok() {});
    for args in [
        &["/dev/zero", "out.exr"][..],
        &["/dev/null", "out.exr"],
        &["info", "/dev/zero"],
        &["preview", "/dev/zero", "look.png"],
        &["compare", "plain_rgb.exr", "/dev/zero"],
        &["convert", "pipe", "w.safetensors"],
        &["convert", "/dev/zero", "w.safetensors"],
        &["plain_rgb.exr", "out.exr", "-q", "--albedo", "/dev/zero"],
        &["a.png", "out.exr", "-q", "--normal", "/dev/zero"],
        &["plain_rgb.exr", "out.exr", "-q", "--weights", "pipe"],
    ] {
        let output = folder.command(args).stdin(Stdio::piped()).output().unwrap();
        let name = args.iter().find(|arg| arg.contains("pipe") || arg.contains("/dev/")).unwrap();
        let words = format!("{name}: is not a regular file; give a file on disk");
        Run::of(&output).assert_failed(1, &[&words]);
    }
    assert_eq!(folder.names(), ["a.png", "pipe", "plain_rgb.exr"]);
}

/// The decoder panics only with overflow checks; the user must not see the panic.
#[cfg(debug_assertions)]
#[test]
fn a_block_that_the_decoder_panics_at_is_one_sentence() {
    use exr::prelude::*;
    let folder = Folder::new();
    let path = folder.path("b44.exr");
    let value = |at: Vec2<usize>| f16::from_f32((at.x() * 7 % 16 + at.y() * 5 % 16) as f32);
    let channels = SpecificChannels::rgb(|at| (value(at), value(at), value(at)));
    let compression = Compression::B44;
    let encoding = Encoding { compression, ..Encoding::UNCOMPRESSED };
    let layer = Layer::new((64, 32), LayerAttributes::default(), encoding, channels);
    Image::from_layer(layer).write().to_file(&path).unwrap();
    let mut bytes = fs::read(&path).unwrap();
    let end = bytes.len();
    bytes[end - 140..].fill(0);
    fs::write(&path, bytes).unwrap();
    folder.denoise(&["b44.exr", "out.exr"]).assert_failed(1, &["b44.exr: is damaged: a block"]);
}

/// The file contains neither the 3 GiB of pixels nor the table.
#[test]
fn a_header_that_claims_a_huge_picture_is_refused_before_memory_is_taken() {
    let folder = Folder::new();
    let path = folder.copy("plain_rgb.exr");
    let mut bytes = fs::read(&path).unwrap();
    let window = bytes.windows(10).position(|w| w == b"dataWindow").unwrap();
    let corner = window + b"dataWindow\0box2i\0".len() + 4 + 8;
    bytes[corner..corner + 8].copy_from_slice(&[0x30, 0x75, 0, 0, 0x30, 0x75, 0, 0]);
    fs::write(&path, bytes).unwrap();
    let refused = &["claims 29996×29998 pixels, and at most 268435456 are accepted"];
    folder.denoise(&["plain_rgb.exr", "out.exr"]).assert_failed(1, refused);
    let args = ["plain_rgb.exr", "out.exr", "--max-pixels", "900000000"];
    folder.denoise(&args).assert_failed(1, &["is cut off: its table of 3515625 blocks"]);
}

#[test]
fn the_most_pixels_that_are_accepted_hold_for_every_format_and_command() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    let picture = image::RgbImage::from_fn(37, 23, |x, y| image::Rgb([(x * y % 256) as u8; 3]));
    picture.save(folder.path("a.png")).unwrap();
    picture.save(folder.path("a.jpg")).unwrap();
    for file in ["plain_rgb.exr", "a.png", "a.jpg"] {
        let says = format!("{file}: claims 37×23 pixels, and at most 850 are accepted; give --max");
        for command in [&[file, "out.exr"][..], &["info", file], &["compare", file, file]] {
            let run = |most| folder.run(&[command, &["--max-pixels", most]].concat());
            run("850").assert_failed(1, &[&says]);
            assert!(command[0] == file || run("851").code == 0, "{command:?}");
        }
    }
    assert_eq!(folder.names(), ["a.jpg", "a.png", "plain_rgb.exr"]);
}

#[test]
fn an_output_that_cannot_be_written_is_refused_before_the_work() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    folder.denoise(&["plain_rgb.exr", "out.tiff"]).assert_failed(2, &[".exr, .png, .jpg"]);
    folder
        .denoise(&["plain_rgb.exr", "no/out.exr"])
        .assert_failed(1, &["the folder no does not exist", "--parents"]);
    assert_eq!(folder.names(), ["plain_rgb.exr"]);
}

#[test]
fn an_unknown_layer_is_answered_with_the_layers_of_the_file() {
    let folder = Folder::new();
    folder.copy("karma_like.exr");
    folder
        .denoise(&["karma_like.exr", "out.exr", "--color", "beauty"])
        .assert_failed(1, &["no layer `beauty`", "`C`, `albedo`, `N`"]);
    folder
        .denoise(&["karma_like.exr", "out.exr", "--albedo", "nowhere.exr"])
        .assert_failed(1, &["no layer `nowhere.exr`", "no file `nowhere.exr`"]);
}

#[test]
fn a_file_that_is_no_weights_file_is_answered_by_what_one_is() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    fs::write(folder.path("w.safetensors"), "not weights").unwrap();
    let run = |file| folder.run(&["plain_rgb.exr", "out.exr", "-q", "--weights", file]);
    let explained = ["is not a weights file", ".safetensors", ".tza"];
    run("w.safetensors").assert_failed(1, &[&["w.safetensors: "], &explained[..]].concat());
    fs::write(folder.path("README.md"), "# A heading\n\nText and more text.\n").unwrap();
    run("README.md").assert_failed(1, &[&["README.md: "], &explained[..]].concat());
    run("plain_rgb.exr").assert_failed(1, &[&["plain_rgb.exr: "], &explained[..]].concat());
    run("nowhere.safetensors").assert_failed(1, &["nowhere.safetensors: cannot be read"]);
}

#[test]
fn wrong_usage_has_exit_code_2() {
    let folder = Folder::new();
    for args in [
        &[][..],
        &["only_one.exr"],
        &["a.exr", "b.exr", "--quality", "best"],
        &["a.exr", "b.exr", "-q", "-v"],
        &["compare", "a.exr"],
        &["bench", "--width", "0"],
    ] {
        let run = folder.run(args);
        assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{args:?}: {run:?}");
    }
}

#[test]
fn a_missing_adapter_has_exit_code_3_and_a_hint_how_to_get_one() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    folder
        .denoise(&["plain_rgb.exr", "out.exr", "-q", "--adapter", "nosuch"])
        .assert_failed(3, &["nosuch", "mesa-vulkan-drivers"]);
    assert_eq!(folder.names(), ["plain_rgb.exr"]);
}

/// Only where Vulkan is the only backend can all adapters be hidden.
#[cfg(target_os = "linux")]
#[test]
fn a_machine_without_any_adapter_has_exit_code_3_and_is_told_the_package() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    let denoise = ["plain_rgb.exr", "out.exr", "-q", "--weights", crate::support::WEIGHTS];
    for args in [&denoise[..], &["devices"]] {
        let mut command = folder.command(args);
        for variable in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
            command.env(variable, folder.path("no_driver.json"));
        }
        let run = Run::of(&command.output().unwrap());
        run.assert_failed(3, &["apt install mesa-vulkan-drivers"]);
    }
    assert_eq!(folder.names(), ["plain_rgb.exr"]);
}
