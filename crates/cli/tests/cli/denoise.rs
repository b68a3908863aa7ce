use crate::support::{AnyImage, Folder, data, read_exr, take};

struct Case {
    file: &'static str,
    /// Index of the written part; `layer` prefixes its three channels.
    part: usize,
    layer: &'static str,
    /// The notice; `said` is part of the longer one with `--verbose`.
    summary: &'static str,
    said: &'static [&'static str],
}

const CASES: &[Case] = &[
    Case {
        file: "blender5_parts.exr",
        part: 0,
        layer: "ViewLayer.Combined.",
        summary: "denoising `Noisy Image` into `Combined` with albedo and normal",
        said: &[
            "color from `ViewLayer.Noisy Image` (Blender's noisy image), written to \
             `ViewLayer.Combined`\n",
            "albedo from `ViewLayer.Denoising Albedo`",
        ],
    },
    Case {
        file: "blender4_single_part.exr",
        part: 0,
        layer: "ViewLayer.Combined.",
        summary: "denoising `Noisy Image` into `Combined` with albedo and normal",
        said: &["normal from `ViewLayer.Denoising Normal`"],
    },
    Case {
        file: "karma_like.exr",
        part: 0,
        layer: "",
        summary: "denoising `C` with albedo and normal",
        said: &["color from `C` (Karma's beauty)"],
    },
    Case {
        file: "mitsuba_like.exr",
        part: 0,
        layer: "",
        summary: "denoising `RGB` with albedo and normal",
        said: &["normal from `sh_normal`"],
    },
    Case {
        file: "plain_rgb.exr",
        part: 0,
        layer: "",
        summary: "denoising `RGB` without albedo and normal",
        said: &["no albedo\n", "no normal\n"],
    },
    Case {
        file: "rgba_zips.exr",
        part: 0,
        layer: "",
        summary: "denoising `RGB` without albedo and normal",
        said: &["the file's plain R, G, B"],
    },
];

/// Takes the three channels that a case writes out of an image.
fn take_color(image: &mut AnyImage, case: &Case) -> [Vec<f32>; 3] {
    ["R", "G", "B"].map(|letter| {
        let name = format!("{}{letter}", case.layer);
        take(image, case.part, &name).values_as_f32().collect()
    })
}

#[test]
fn only_the_color_changes_and_everything_else_comes_out_as_it_came_in() {
    assert_eq!(CASES.len(), 6);
    for case in CASES {
        let folder = Folder::new();
        folder.copy(case.file);
        let run = folder.denoise(&[case.file, "out.exr", "--alpha", "keep"]);
        run.assert_done();
        let lines: Vec<_> = run.stderr.lines().collect();
        assert_eq!(lines[0], format!("wgdenoise: {}", case.summary), "{run:?}");
        assert!(
            lines.len() == 2 && lines[1].starts_with("wgdenoise: wrote out.exr in "),
            "{run:?}"
        );
        assert!(lines[1].ends_with(" s") && lines.iter().all(|l| l.chars().count() <= 80));
        let verbose = folder.denoise(&[case.file, "out.exr", "-v", "--force"]);
        verbose.assert_done();
        for said in case.said {
            assert!(verbose.stderr.contains(said), "no `{said}` in {verbose:?}");
        }

        let before_path = data(case.file);
        let (mut before, mut after) = (read_exr(&before_path), read_exr(&folder.path("out.exr")));
        let (old, new) = (take_color(&mut before, case), take_color(&mut after, case));
        assert_ne!(old, new, "{}", case.file);
        let finite = |v: &f32| v.is_finite() && *v >= 0.0;
        assert!(!new[0].is_empty() && new.iter().flatten().all(finite), "{}", case.file);
        assert!(before == after, "{}: something else changed", case.file);
        assert_eq!(folder.names().len(), 2, "{}: a file was left behind", case.file);
    }
}

#[test]
fn the_header_is_copied_byte_for_byte() {
    let folder = Folder::new();
    let input = folder.copy("rgba_zips.exr");
    folder.denoise(&["rgba_zips.exr", "out.exr"]).assert_done();
    let (before, after) = (std::fs::read(input), std::fs::read(folder.path("out.exr")));
    let (before, after) = (before.unwrap(), after.unwrap());
    let same = before.iter().zip(&after).take_while(|(a, b)| a == b).count();
    // Custom attributes must stay the same, too.
    let shot = before.windows(14).position(|w| w == b"still life 010").unwrap();
    assert!(same > shot + 14, "the files differ at byte {same}");
}

#[test]
fn an_output_that_exists_is_kept_unless_forced() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    let other = folder.copy("karma_like.exr");
    folder
        .denoise(&["plain_rgb.exr", "karma_like.exr"])
        .assert_failed(1, &["karma_like.exr: already exists", "--force"]);
    assert_eq!(std::fs::read(&other).unwrap(), std::fs::read(data("karma_like.exr")).unwrap());
    folder.denoise(&["plain_rgb.exr", "karma_like.exr", "--force"]).assert_done();
    assert_ne!(std::fs::read(&other).unwrap(), std::fs::read(data("karma_like.exr")).unwrap());
}

#[test]
fn a_file_is_replaced_by_its_own_result_only_in_place() {
    let folder = Folder::new();
    let path = folder.copy("plain_rgb.exr");
    let itself = ["plain_rgb.exr", "plain_rgb.exr"];
    for flags in [&[][..], &["--force"]] {
        folder
            .denoise(&[&itself[..], flags].concat())
            .assert_failed(1, &["is also the input plain_rgb.exr", "--in-place"]);
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("plain_rgb.exr", folder.path("link.exr")).unwrap();
        folder
            .denoise(&["plain_rgb.exr", "link.exr", "--force"])
            .assert_failed(1, &["link.exr: is also the input plain_rgb.exr"]);
        std::fs::remove_file(folder.path("link.exr")).unwrap();
    }
    assert!(std::fs::read(&path).unwrap() == std::fs::read(data("plain_rgb.exr")).unwrap());
    folder.denoise(&["plain_rgb.exr", "other.exr"]).assert_done();
    folder.denoise(&["plain_rgb.exr", "plain_rgb.exr", "--in-place"]).assert_done();
    assert!(read_exr(&path) == read_exr(&folder.path("other.exr")));
    assert_eq!(folder.names(), ["other.exr", "plain_rgb.exr"]);
}

#[test]
fn albedo_and_normal_matter_and_no_aux_leaves_them_out() {
    let folder = Folder::new();
    folder.copy("karma_like.exr");
    let color_of = |args: &[&str]| {
        let run = folder.denoise(&[&["karma_like.exr", "out.exr", "--force", "-v"], args].concat());
        run.assert_done();
        (take(&mut read_exr(&folder.path("out.exr")), 0, "R"), run.stderr)
    };
    let (all, _) = color_of(&[]);
    let (none, said) = color_of(&["--no-aux"]);
    assert!(all != none && said.contains("no albedo\n") && said.contains("no normal\n"), "{said}");
    let (named, said) = color_of(&["--albedo", "albedo", "--normal", "N"]);
    assert!(all == named && said.contains("albedo from `albedo` (as asked for)"), "{said}");
}

#[test]
fn albedo_and_normal_may_come_from_separate_files() {
    let folder = Folder::new();
    folder.copy("karma_like.exr");
    folder.copy("mitsuba_like.exr");
    let aux = ["--albedo", "mitsuba_like.exr", "--normal", "mitsuba_like.exr"];
    folder.denoise(&["karma_like.exr", "a.exr"]).assert_done();
    let run = folder.denoise(&[&["karma_like.exr", "b.exr", "-v"], &aux[..]].concat());
    run.assert_done();
    assert!(run.stderr.contains("albedo from the file mitsuba_like.exr"), "{run:?}");
    let red = |name| take(&mut read_exr(&folder.path(name)), 0, "R").values_as_f32().collect();
    let (a, b): (Vec<f32>, Vec<f32>) = (red("a.exr"), red("b.exr"));
    // The renders are the same, but one stores the albedo as half.
    let close = |(a, b): (&f32, &f32)| (a - b).abs() <= 1e-2 * a.abs().max(0.1);
    assert!(a.iter().zip(&b).all(close));

    folder.copy("plain_rgb.exr");
    folder
        .denoise(&["karma_like.exr", "c.exr", "--albedo", "plain_rgb.exr"])
        .assert_failed(1, &["plain_rgb.exr: is 37×23 pixels and the color is"]);
}

#[test]
fn quiet_says_nothing_and_verbose_says_adapter_tiles_and_times() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    let quiet = folder.denoise(&["plain_rgb.exr", "a.exr", "-q"]);
    quiet.assert_done();
    assert_eq!(quiet.stderr, "");
    let verbose = folder.denoise(&["plain_rgb.exr", "b.exr", "-v", "--memory", "64MiB"]);
    verbose.assert_done();
    for word in ["wgdenoise: on ", "37×23 pixels in 1 tile", "MiB of GPU memory", "written in"] {
        assert!(verbose.stderr.contains(word), "no `{word}` in {verbose:?}");
    }
}
