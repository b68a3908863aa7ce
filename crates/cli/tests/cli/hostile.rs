//! Malicious files and files with unsupported features: the program rejects each in one sentence,
//! within 256 MiB of address space, and leaves no file behind.

use std::fs::File;
use std::io::Write;
use std::time::{Duration, Instant};

use crate::support::{Folder, Run};

/// A release build on an idle machine takes a second; tests run unoptimized and in parallel.
const PATIENCE: Duration = Duration::from_secs(30);

const TILED: u32 = 0x200;
const DEEP: u32 = 0x800;
const MULTI_PART: u32 = 0x1000;

fn attribute(name: &str, kind: &str, value: &[u8]) -> Vec<u8> {
    let head = [name.as_bytes(), b"\0", kind.as_bytes(), b"\0"].concat();
    [&head, &(value.len() as u32).to_le_bytes()[..], value].concat()
}

fn ints(values: &[i32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// Half channels with one sample per `step` × `step` pixels.
fn channels(names: &[String], step: i32) -> Vec<u8> {
    let channel = |name: &String| [name.as_bytes(), b"\0", &ints(&[1, 0, step, step])].concat();
    [names.iter().flat_map(channel).collect(), vec![0]].concat()
}

fn rgb() -> Vec<u8> {
    channels(&["B", "G", "R"].map(String::from), 1)
}

fn tiles(side: u32, mode: u8) -> Vec<u8> {
    attribute(
        "tiles",
        "tiledesc",
        &[&side.to_le_bytes()[..], &side.to_le_bytes(), &[mode]].concat(),
    )
}

/// The attributes that every header has, without the terminator.
fn part(width: i32, height: i32, channels: &[u8], compression: u8) -> Vec<u8> {
    let window = ints(&[0, 0, width - 1, height - 1]);
    [
        attribute("channels", "chlist", channels),
        attribute("compression", "compression", &[compression]),
        attribute("dataWindow", "box2i", &window),
        attribute("displayWindow", "box2i", &window),
        attribute("lineOrder", "lineOrder", &[0]),
        attribute("pixelAspectRatio", "float", &1_f32.to_le_bytes()),
        attribute("screenWindowCenter", "v2f", &[0; 8]),
        attribute("screenWindowWidth", "float", &1_f32.to_le_bytes()),
    ]
    .concat()
}

fn exr(flags: u32, rest: &[u8]) -> Vec<u8> {
    [&[0x76, 0x2f, 0x31, 0x01][..], &(2 | flags).to_le_bytes(), rest].concat()
}

/// A one-pixel image with its only block.
fn one_pixel(channels: &[u8], more: &[u8]) -> Vec<u8> {
    let head = exr(0, &[&part(1, 1, channels, 0), more, &[0]].concat());
    let table = (head.len() as u64 + 8).to_le_bytes();
    [&head[..], &table, &ints(&[0, 6]), &[0; 6]].concat()
}

struct Case {
    name: &'static str,
    bytes: Vec<u8>,
    /// Zeros appended to the bytes; they take no disk space.
    zeros: u64,
    words: &'static [&'static str],
}

impl Case {
    fn new(name: &'static str, bytes: Vec<u8>, words: &'static [&'static str]) -> Self {
        Self { name, bytes, zeros: 0, words }
    }

    fn then_zeros(self, zeros: u64) -> Self {
        Self { zeros, ..self }
    }

    #[track_caller]
    fn check(&self) {
        let folder = Folder::new();
        let mut file = File::create(folder.path("x.exr")).unwrap();
        file.write_all(&self.bytes).unwrap();
        file.set_len(self.bytes.len() as u64 + self.zeros).unwrap();
        let mut command = folder.command_after("ulimit -v 262144", &["x.exr", "out.exr"]);
        let begin = Instant::now();
        let run = Run::of(&command.env("MALLOC_ARENA_MAX", "1").output().unwrap());
        let took = begin.elapsed();
        assert!(took < PATIENCE, "{}: {took:?}", self.name);
        run.assert_failed(1, &[&["x.exr: "], self.words].concat());
        assert_eq!(folder.names(), ["x.exr"], "{}", self.name);
    }
}

/// Shows that the other files are not rejected for what they share with this one.
#[test]
fn the_picture_that_the_others_are_made_from_is_valid() {
    let folder = Folder::new();
    std::fs::write(folder.path("x.exr"), one_pixel(&rgb(), &[])).unwrap();
    let info = folder.run(&["info", "x.exr"]);
    assert!(info.code == 0 && info.stdout.contains("1×1 pixels"), "{info:?}");
}

#[test]
fn small_files_that_claim_to_be_large_are_refused() {
    let huge = |more: &[u8], flags, side, kinds: &[u8]| {
        exr(flags, &[&part(side, side, kinds, 3), more, &[0]].concat())
    };
    let more = (3..65535).map(|i| format!("c{i:05}"));
    let many: Vec<String> = ["B", "G", "R"].map(String::from).into_iter().chain(more).collect();
    for case in [
        Case::new("window", huge(&[], 0, 1_000_000_000, &rgb()), &["claims", "--max-pixels"]),
        Case::new("no table", huge(&[], 0, 16384, &rgb()), &["is cut off: its table of 1024"]),
        Case::new("a tile", huge(&tiles(1 << 29, 0), TILED, 16384, &rgb()), &["has blocks of"]),
        Case::new("rip map", huge(&tiles(1, 2), TILED, 16384, &rgb()), &["its table of 107"]),
        Case::new(
            "channels",
            one_pixel(&channels(&many, 1), &[]),
            &["a block of 6 bytes cannot hold 131070"],
        ),
        Case::new(
            "attribute",
            exr(0, &[&b"a\0string\0"[..], &[0xff, 0xff, 0xff, 0x7f]].concat()),
            &["is cut off", "has 2147483647 bytes, and 0 are present"],
        ),
    ] {
        case.check();
    }
}

/// Names with terminal commands, with a forged message, and with reordered text.
#[test]
fn names_of_layers_are_escaped_wherever_they_are_shown() {
    const NAMES: [&str; 3] = ["a\u{1b}[2Jb", "c\nwgdenoise: wrote out.exr", "d\u{202e}gnp\u{2066}"];
    let folder = Folder::new();
    let mut list: Vec<String> = NAMES.iter().map(|name| format!("{name}.Z")).collect();
    list.extend(["B", "G", "R", "e\u{202e}f"].map(String::from));
    list.push("\u{753b}.Z".into());
    let head = exr(0, &[&part(1, 1, &channels(&list, 1), 0)[..], &[0]].concat());
    let table = (head.len() as u64 + 8).to_le_bytes();
    let pixels = vec![0; 2 * list.len()];
    let file = [&head[..], &table, &ints(&[0, pixels.len() as i32]), &pixels].concat();
    std::fs::write(folder.path("x.exr"), file).unwrap();

    let info = folder.run(&["info", "x.exr"]);
    let unknown = folder.run(&["x.exr", "out.exr", "--color", "b\u{202e}\n"]);
    unknown.assert_failed(1, &[r"no layer `b\u{202e}\n`"]);
    for text in [&info.stdout, &unknown.stderr] {
        for escaped in [r"a\u{1b}[2Jb", r"c\nwgdenoise: wrote out.exr", r"d\u{202e}gnp\u{2066}"] {
            assert!(text.contains(escaped), "no {escaped} in {text}");
        }
        assert!(text.contains('\u{753b}'), "a harmless name is escaped in {text}");
        assert!(!text.contains(['\u{1b}', '\u{202e}', '\u{2066}']), "{text:?}");
        assert!(!text.contains("\nwgdenoise: wrote"), "{text:?}");
    }
    let json = folder.run(&["info", "x.exr", "--json"]);
    assert!(!json.stdout.contains(['\u{1b}', '\u{202e}', '\u{2066}']), "{json:?}");
    let layers = json.json()["layers"].as_array().unwrap().clone();
    for name in NAMES {
        assert!(layers.iter().any(|layer| layer["name"] == name), "no {name:?} in {layers:?}");
    }
}

/// The zeros take neither disk space nor memory.
#[test]
fn files_of_many_zeros_are_refused() {
    let tiled = exr(TILED, &[&part(16384, 16384, &rgb(), 3)[..], &tiles(1, 0), &[0]].concat());
    let long = exr(0, &[&b"a\0string\0"[..], &(1_u32 << 30).to_le_bytes()].concat());
    let mut block = one_pixel(&rgb(), &[]);
    let size = block.len() - 10;
    block[size..size + 4].copy_from_slice(&(1_i32 << 30).to_le_bytes());
    for case in [
        Case::new("table", tiled, &["over 10000000 of 268435456 blocks are missing"]),
        Case::new("header", long, &["a header that would take over 128 MiB of memory"]),
        Case::new("block", block, &["has 1073741824 bytes, more than its pixels"]),
    ] {
        case.then_zeros(3 << 30).check();
    }
}

#[test]
fn headers_with_very_many_entries_are_refused() {
    let numbered = |i: i32| {
        let name = attribute("name", "string", format!("{i}").as_bytes());
        let kind = attribute("type", "string", b"scanlineimage");
        let count = attribute("chunkCount", "int", &ints(&[1]));
        [&part(1, 1, &rgb(), 0)[..], &name, &kind, &count, &[0]].concat()
    };
    let parts = |n| exr(MULTI_PART, &[(0..n).flat_map(numbered).collect(), vec![0]].concat());
    let odd = |i: u32| attribute(&format!("{i:x}"), "t", &[]);
    let texts = attribute("multiView", "stringvector", &vec![0; 8 << 20]);
    let too_long = &["a header that would take over 128 MiB of memory"][..];
    for case in [
        Case::new("5000 parts", parts(5000), &["is cut off: its table of 5000 blocks"]),
        Case::new("20000 parts", parts(20_000), too_long),
        Case::new(
            "attributes",
            one_pixel(&rgb(), &(0..300_000).flat_map(odd).collect::<Vec<_>>()),
            too_long,
        ),
        Case::new("texts", one_pixel(&rgb(), &texts), too_long),
    ] {
        case.check();
    }
}

#[test]
fn what_is_not_supported_is_named() {
    let of_type = |kind: &str| attribute("type", "string", kind.as_bytes());
    let deep = |kind| exr(DEEP, &[&part(4, 4, &rgb(), 0)[..], &of_type(kind), &[0]].concat());
    let packed = |code| exr(0, &[&part(4, 4, &rgb(), code)[..], &[0]].concat());
    let names = ["B", "G", "R"].map(String::from);
    for case in [
        Case::new("deep", deep("deepscanline"), &["holds deep data", "flatten it first"]),
        Case::new("HTJ2K", packed(10), &["is compressed with HTJ2K", "write it with ZIP or PIZ"]),
        Case::new("HTJ2K 32", packed(11), &["is compressed with HTJ2K"]),
        Case::new("unknown", packed(99), &["names an unknown compression"]),
        Case::new(
            "subsampled",
            one_pixel(&channels(&names, 2), &[]),
            &["channel `B` has one sample for 2×2 pixels", "at full resolution"],
        ),
    ] {
        case.check();
    }
}
