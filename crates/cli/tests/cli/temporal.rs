//! Animations: frames averaged along their motion vectors.

use std::fs;
use std::path::Path;

use exr::prelude::*;

use crate::support::{Folder, read_exr, take};

const SIZE: [usize; 2] = [96, 64];
/// Pixels to the right and down per frame.
const STEP: [f32; 2] = [3.0, -2.0];
/// A step that ends between pixels.
const BETWEEN: [f32; 2] = [2.4, -1.3];

/// A noisy patterned wall that slides past.
#[derive(Clone, Copy)]
struct Wall {
    frame: usize,
    step: [f32; 2],
    /// Selects the pattern.
    scene: f32,
    size: [usize; 2],
    /// X position of the file's first column.
    left: i32,
    /// Name of the second light group.
    group: &'static str,
}

impl Wall {
    fn at(frame: usize) -> Self {
        Self { frame, step: STEP, scene: 1.0, size: SIZE, left: 0, group: "fill" }
    }

    /// A wall moved right and down by this many pixels since frame 0.
    fn moved(frame: usize, pixels: [f32; 2]) -> Self {
        Self { step: pixels.map(|pixels| pixels / frame as f32), ..Self::at(frame) }
    }

    fn pixels(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let [width, height] = self.size;
        (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
    }

    fn albedo(&self, (x, y): (usize, usize), channel: usize) -> f32 {
        let moved = |at: usize, axis: usize| at as f32 - self.step[axis] * self.frame as f32;
        let (x, y) = (moved(x, 0) * self.scene, moved(y, 1) * self.scene);
        0.5 + 0.4 * (x * 0.21 + channel as f32).sin() * (y * 0.17 - x * 0.03).cos()
    }

    /// Noise in [0, 2] with mean 1, different in every pixel of every frame.
    fn noise(&self, (x, y): (usize, usize), channel: usize) -> f32 {
        let seed = ((self.frame * 4 + channel) * 1_000_003 + y * 7919 + x) as u32;
        let mixed = (seed ^ (seed >> 15)).wrapping_mul(0x2c1b_3c6d);
        let mixed = (mixed ^ (mixed >> 12)).wrapping_mul(0x297a_2d39);
        (mixed ^ (mixed >> 15)) as f32 / u32::MAX as f32 * 2.0
    }

    fn plane(&self, name: &str, value: impl Fn((usize, usize)) -> f32) -> AnyChannel<FlatSamples> {
        let values = self.pixels().map(value).collect();
        AnyChannel::new(name, FlatSamples::F32(values))
    }

    /// Writes the frame like Blender, with two light groups.
    fn write(&self, path: &Path, motion: Option<[f32; 4]>) {
        self.write_with(path, motion.as_ref().map_or(&[], |motion| &motion[..]));
    }

    /// Writes the frame with these components of the motion vectors.
    fn write_with(&self, path: &Path, motion: &[f32]) {
        let light = |p, c| self.albedo(p, c) * self.noise(p, c);
        // The groups alternate in bars, so they have edges where their sum has none.
        let key = |(x, _): (usize, usize)| if x / 7 % 2 == 0 { 0.9 } else { 0.1 };
        let mut channels = Vec::new();
        for (c, (rgb, xyz)) in ["R", "G", "B"].into_iter().zip(["X", "Y", "Z"]).enumerate() {
            let group = format!("V.Combined_{}.{rgb}", self.group);
            channels.push(self.plane(&format!("V.Combined.{rgb}"), |p| light(p, c)));
            channels.push(self.plane(&format!("V.Combined_key.{rgb}"), |p| key(p) * light(p, c)));
            channels.push(self.plane(&group, |p| (1.0 - key(p)) * light(p, c)));
            channels.push(self.plane(&format!("V.Denoising Albedo.{rgb}"), |p| self.albedo(p, c)));
            let normal = if c == 2 { 1.0 } else { 0.0 };
            channels.push(self.plane(&format!("V.Denoising Normal.{xyz}"), |_| normal));
        }
        let names = ["V.Vector.X", "V.Vector.Y", "V.Vector.Z", "V.Vector.W"];
        for (name, value) in names.into_iter().zip(motion) {
            channels.push(self.plane(name, |_| *value));
        }
        let channels = AnyChannels::sort(channels.into());
        let mut image = Image::from_channels((self.size[0], self.size[1]), channels);
        image.layer_data.attributes.layer_position = Vec2(self.left, 0);
        image.attributes.display_window = IntegerBounds::from_dimensions((256, 64));
        image.write().to_file(path).unwrap();
    }

    /// Mean difference between the denoised color and the noise-free wall.
    fn error(&self, path: &Path) -> f32 {
        let mut file = read_exr(path);
        let channels = ["R", "G", "B"].map(|c| take(&mut file, 0, &format!("V.Combined.{c}")));
        let of = |(c, samples): (usize, &FlatSamples)| -> f32 {
            let pairs = samples.values_as_f32().zip(self.pixels());
            pairs.map(|(found, p)| (found - self.albedo(p, c)).abs()).sum()
        };
        channels.iter().enumerate().map(of).sum::<f32>() / (3 * self.size[0] * self.size[1]) as f32
    }
}

/// Blender's vectors: to the position in the previous frame with y up, and back from the one in the
/// next frame.
fn blender(step: [f32; 2]) -> [f32; 4] {
    blender_between(step, step)
}

/// The same with different steps before and after the frame.
fn blender_between(before: [f32; 2], after: [f32; 2]) -> [f32; 4] {
    [-before[0], before[1], -after[0], after[1]]
}

/// A folder with five frames, this step apart, and a folder `clean`.
fn animation(step: [f32; 2], motion: Option<[f32; 4]>) -> Folder {
    let folder = Folder::new();
    for frame in 1..=5 {
        Wall { step, ..Wall::at(frame) }.write(&folder.path(&noisy(frame)), motion);
    }
    fs::create_dir(folder.path("clean")).unwrap();
    folder
}

fn noisy(frame: usize) -> String {
    format!("n.{frame:04}.exr")
}

impl Folder {
    fn clean(&self, frame: usize) -> std::path::PathBuf {
        self.path(&format!("clean/n.{frame:04}.exr"))
    }

    fn result(&self, frame: usize) -> Vec<u8> {
        fs::read(self.clean(frame)).unwrap()
    }
}

const RUN: [&str; 5] = ["n.####.exr", "clean", "--force", "--quality", "fast"];
const TEMPORAL: [&str; 6] = ["n.####.exr", "clean", "--force", "--quality", "fast", "--temporal"];

#[test]
fn what_moves_has_less_error_with_the_frames_around_it() {
    let folder = animation(STEP, Some(blender(STEP)));
    folder.run(&RUN).assert_done();
    let alone: Vec<_> = (1..=5).map(|n| Wall::at(n).error(&folder.clean(n))).collect();
    let run = folder.run(&TEMPORAL);
    run.assert_done();
    for text in [
        "motion to the next frame from `V.Vector`: ",
        "motion to the previous frame from `V.Vector`: ",
    ] {
        assert_eq!(run.stderr.matches(text).count(), 1, "{run:?}");
    }
    for (n, alone) in (1..=5).zip(&alone) {
        let found = Wall::at(n).error(&folder.clean(n));
        // The first and the last frame have a neighbor on one side only.
        let most = if (2..5).contains(&n) { 0.85 } else { 0.95 };
        assert!(found < most * alone, "frame {n}: {found}, alone {alone}");
    }
    let one = Wall::at(3).error(&folder.clean(3));
    folder.run(&[&RUN[..], &["--temporal=2"]].concat()).assert_done();
    let two = Wall::at(3).error(&folder.clean(3));
    assert!(two < 0.95 * one, "{two} with two frames to each side, {one} with one");
}

#[test]
fn some_frames_come_out_as_of_the_whole_animation_and_no_others_are_written() {
    let folder = animation(STEP, Some(blender(STEP)));
    folder.run(&TEMPORAL).assert_done();
    let whole: Vec<_> = (1..=5).map(|n| folder.result(n)).collect();
    for n in [2, 4, 5] {
        fs::remove_file(folder.clean(n)).unwrap();
    }
    let run = folder.run(&[&TEMPORAL[..], &["--frames", "2"]].concat());
    run.assert_done();
    assert!(run.stderr.contains("wrote clean/n.0002.exr in "), "{run:?}");
    assert!(folder.result(2) == whole[1] && !folder.clean(4).exists());
    let run =
        folder.run(&["n.####.exr", "clean", "--skip-existing", "--quality", "fast", "--temporal"]);
    run.assert_done();
    assert!(
        run.stderr.contains("wrote 2 images in ") && run.stderr.contains("; skipped 3"),
        "{run:?}"
    );
    assert!(folder.result(4) == whole[3] && folder.result(5) == whole[4]);
}

#[test]
fn nothing_is_averaged_across_gaps_other_sizes_and_frames_that_cannot_be_read() {
    let folder = animation(STEP, Some(blender(STEP)));
    fs::remove_file(folder.path(&noisy(2))).unwrap();
    Wall { size: [80, 64], ..Wall::at(4) }.write(&folder.path(&noisy(4)), Some(blender(STEP)));
    fs::copy(folder.path(&noisy(3)), folder.path(&noisy(6))).unwrap();
    fs::write(folder.path(&noisy(5)), "").unwrap();
    folder.run(&[&RUN[..], &["--frames", "1,3,4,6"]].concat()).assert_done();
    let alone = [1, 3, 4, 6].map(|n| folder.result(n));
    let run = folder.run(&[&TEMPORAL[..], &["--frames", "1,3,4,6"]].concat());
    run.assert_done();
    assert!(run.stderr.contains("n.0005.exr: is empty"), "{run:?}");
    assert!([1, 3, 4, 6].map(|n| folder.result(n)) == alone);
}

#[test]
fn a_cut_leaves_no_ghost() {
    let folder = animation(STEP, Some(blender(STEP)));
    for n in 3..=5 {
        Wall { scene: 1.9, ..Wall::at(n) }.write(&folder.path(&noisy(n)), Some(blender(STEP)));
    }
    folder.run(&TEMPORAL).assert_done();
    let error = |n| Wall { scene: 1.9, ..Wall::at(n) }.error(&folder.clean(n));
    let across = error(3);
    fs::remove_file(folder.path(&noisy(2))).unwrap();
    folder.run(&[&TEMPORAL[..], &["--frames", "3"]].concat()).assert_done();
    assert!(across < 1.1 * error(3), "{across} beside the cut, {} without it", error(3));
}

#[test]
fn groups_of_light_and_their_sum_are_averaged_alike() {
    let folder = animation(BETWEEN, Some(blender(BETWEEN)));
    folder.run(&[&TEMPORAL[..], &["--frames", "3", "--layers", "auto"]].concat()).assert_done();
    let mut file = read_exr(&folder.clean(3));
    let [sum, key, fill] = ["Combined", "Combined_key", "Combined_fill"].map(|layer| {
        take(&mut file, 0, &format!("V.{layer}.G")).values_as_f32().collect::<Vec<_>>()
    });
    for (i, sum) in sum.iter().enumerate() {
        assert!(
            (key[i] + fill[i] - sum).abs() < 1e-5,
            "{i}: {} + {} is not {sum}",
            key[i],
            fill[i]
        );
    }
}

#[test]
fn without_motion_vectors_what_stands_still_is_averaged() {
    let folder = animation([0.0; 2], None);
    folder.run(&RUN).assert_done();
    let wall = Wall { step: [0.0; 2], ..Wall::at(3) };
    let alone = wall.error(&folder.clean(3));
    let run = folder.run(&TEMPORAL);
    run.assert_done();
    assert_eq!(run.stderr.matches("no motion vectors: ").count(), 1, "{run:?}");
    let found = wall.error(&folder.clean(3));
    assert!(found < 0.85 * alone, "{found}, alone {alone}");
}

#[test]
fn vectors_that_lead_elsewhere_are_not_followed() {
    let folder = animation([17.0, 9.0], Some([4.0, -1.0, 2.0, 3.0]));
    folder.run(&RUN).assert_done();
    let alone: Vec<_> = (1..=5).map(|n| folder.result(n)).collect();
    let run = folder.run(&TEMPORAL);
    run.assert_done();
    let text = "no interpretation of the motion vectors `V.Vector` clearly finds the same surfaces in the ";
    assert_eq!(run.stderr.matches(text).count(), 2, "{run:?}");
    assert!((1..=5).all(|n| folder.result(n) == alone[n - 1]));
}

/// Five walls whose pan turns into a tilt at the third, with the steps before and after each.
fn turning() -> [(Wall, [f32; 2], [f32; 2]); 5] {
    let (right, down) = ([3.0, 0.0], [0.0, 3.0]);
    [
        (Wall::moved(1, [3.0, 0.0]), right, right),
        (Wall::moved(2, [6.0, 0.0]), right, right),
        (Wall::moved(3, [9.0, 0.0]), right, down),
        (Wall::moved(4, [9.0, 3.0]), down, down),
        (Wall::moved(5, [9.0, 6.0]), down, down),
    ]
}

/// The walls' errors with a subset of Blender's four values per pixel, and the program's messages.
fn errors_with(values: std::ops::Range<usize>, arguments: &[&str]) -> ([f32; 5], String) {
    let folder = animation(STEP, None);
    for (wall, before, after) in turning() {
        let motion = &blender_between(before, after)[values.clone()];
        wall.write_with(&folder.path(&noisy(wall.frame)), motion);
    }
    let run = folder.run(arguments);
    run.assert_done();
    (turning().map(|(wall, ..)| wall.error(&folder.clean(wall.frame))), run.stderr)
}

#[test]
fn a_tilt_after_a_pan_is_followed() {
    let [(alone, _), (found, told)] =
        [&RUN[..], &TEMPORAL].map(|arguments| errors_with(0..4, arguments));
    assert!(!told.contains("reversed"), "{told}");
    for (found, alone) in found.into_iter().zip(alone) {
        assert!(found < 0.95 * alone, "{found}, alone {alone}");
    }
}

#[test]
fn one_vector_to_either_side_is_as_good_as_two() {
    let both = errors_with(0..4, &TEMPORAL).0;
    for (values, [there, back]) in [(0..2, ["previous", "next"]), (2..4, ["next", "previous"])] {
        let (found, told) = errors_with(values, &TEMPORAL);
        assert_eq!(found, both, "{there}");
        let reversed = format!("motion to the {back} frame: that to the {there} frame, reversed");
        assert!(told.contains(&reversed), "{told}");
    }
}

#[test]
fn each_sequence_has_its_own_convention() {
    let folder = animation(STEP, Some(blender(STEP)));
    for n in 1..=3 {
        let opposite = blender(STEP).map(|v| -v);
        Wall::at(n).write(&folder.path(&format!("o.{n:04}.exr")), Some(opposite));
    }
    let error = || Wall::at(2).error(&folder.path("clean/o.0002.exr"));
    let both = ["n.####.exr", "o.####.exr", "clean", "--force", "--quality", "fast"];
    folder.run(&both).assert_done();
    let alone = error();
    folder.run(&[&both[..], &["--temporal"]].concat()).assert_done();
    assert!(error() < 0.85 * alone, "{}, alone {alone}", error());
}

#[test]
fn frames_after_a_cut_at_the_start_are_averaged() {
    let folder = animation(STEP, Some(blender(STEP)));
    Wall { scene: 1.9, ..Wall::at(1) }.write(&folder.path(&noisy(1)), Some(blender(STEP)));
    folder.run(&RUN).assert_done();
    let alone = Wall::at(4).error(&folder.clean(4));
    let run = folder.run(&TEMPORAL);
    run.assert_done();
    assert!(!run.stderr.contains("no interpretation of"), "{run:?}");
    let found = Wall::at(4).error(&folder.clean(4));
    assert!(found < 0.85 * alone, "{found}, alone {alone}");
}

#[test]
fn slow_motion_is_averaged() {
    let step = [0.05, 0.03];
    let folder = animation(step, Some(blender(step)));
    folder.run(&RUN).assert_done();
    let wall = Wall { step, ..Wall::at(3) };
    let alone = wall.error(&folder.clean(3));
    folder.run(&TEMPORAL).assert_done();
    let found = wall.error(&folder.clean(3));
    assert!(found < 0.85 * alone, "{found}, alone {alone}");
}

#[test]
fn frames_with_other_layers_places_or_vectors_are_not_mixed() {
    let folder = animation(STEP, Some(blender(STEP)));
    Wall { group: "rim", ..Wall::at(2) }.write(&folder.path(&noisy(2)), Some(blender(STEP)));
    Wall { left: 5, ..Wall::at(4) }.write(&folder.path(&noisy(4)), Some(blender(STEP)));
    let layers = ["--layers", "auto"];
    folder.run(&[&RUN[..], &layers].concat()).assert_done();
    let alone: Vec<_> = (1..=5).map(|n| folder.result(n)).collect();
    folder.run(&[&TEMPORAL[..], &layers].concat()).assert_done();
    assert!((1..=5).all(|n| folder.result(n) == alone[n - 1]));
}

#[test]
fn a_frame_with_fewer_vectors_is_read_by_itself() {
    // Only the second vector is correct; it points to the next frame.
    let folder = animation(STEP, Some(blender_between([9.0, 9.0], STEP)));
    Wall::at(4).write_with(&folder.path(&noisy(4)), &blender(STEP)[..2]);
    let run = folder.run(&TEMPORAL);
    run.assert_done();
    assert!(run.stderr.contains("`V.Vector`: the second vector, x left"), "{run:?}");
}

#[test]
fn single_files_and_images_that_replace_themselves_are_refused() {
    let folder = animation(STEP, Some(blender(STEP)));
    folder
        .run(&["n.0001.exr", "clean", "--temporal"])
        .assert_failed(2, &["--temporal needs an IN with a place for the frame number"]);
    let run = folder.run(&["n.####.exr", "--in-place", "--temporal"]);
    assert!(run.code == 2 && run.stderr.contains("cannot be used with"), "{run:?}");
    let run = folder.run(&["n.####.exr", "clean", "--temporal=5"]);
    assert!(run.code == 2 && run.stderr.contains("5 is not in 1..=4"), "{run:?}");
}

#[test]
fn a_frame_that_is_not_rendered_yet_is_reported_where_it_is_needed() {
    let folder = animation([4.0, 0.0], Some(blender([4.0, 0.0])));
    fs::remove_file(folder.path(&noisy(3))).unwrap();
    let run = folder.run(&[&TEMPORAL[..], &["--frames", "1"]].concat());
    run.assert_done();
    assert!(!run.stderr.contains("missing"), "{run:?}");
    let run = folder.run(&[&TEMPORAL[..], &["--frames", "2"]].concat());
    run.assert_done();
    let notice = "n.####.exr: frame 3 is missing; the frames around are averaged without";
    assert!(run.stderr.contains(notice), "{run:?}");
}
