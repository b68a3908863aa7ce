//! Views, alpha, further layers, gray and parts of one channel, from file to file.

use ::exr::meta::attribute::Chromaticities;

use super::*;
use crate::{Denoised, LayersWish, MotionWish, Problem};

/// A file with one part of these layers, each with R, G and B, and with these plain channels.
fn single_part(layers: &[&str], others: &[&str], views: &[&str]) -> AnyImage {
    let n = SIZE.0 * SIZE.1;
    let names = layers.iter().flat_map(|l| ["R", "G", "B"].map(|letter| format!("{l}{letter}")));
    let names: Vec<String> = names.chain(others.iter().map(ToString::to_string)).collect();
    let channels = names.iter().enumerate().map(|(i, name)| {
        // In UTF-8, as renderers write names.
        let name = Text::from_slice_unchecked(name.as_bytes());
        AnyChannel::new(name, if i % 2 == 0 { half(i, n) } else { float(i, n) })
    });
    let mut attributes = LayerAttributes::default();
    let views: Vec<_> = views.iter().map(|view| Text::from(*view)).collect();
    attributes.multi_view_names = Some(views).filter(|views| !views.is_empty());
    let channels = AnyChannels::sort(channels.collect());
    let layer = Layer::new(SIZE, attributes, Encoding::SMALL_LOSSLESS, channels);
    AnyImage {
        attributes: ImageAttributes::with_size(SIZE),
        layer_data: SmallVec::from_vec(vec![layer]),
    }
}

fn open_as(path: &std::path::Path, wanted: &LayerChoice) -> Picture {
    Picture::open(path, wanted).unwrap()
}

/// The names of all channels that differ between two files, which must be alike otherwise.
fn changed(before: &AnyImage, after: &AnyImage) -> Vec<String> {
    let mut names = Vec::new();
    assert_eq!(before.layer_data.len(), after.layer_data.len());
    for (old, new) in before.layer_data.iter().zip(&after.layer_data) {
        assert!(old.attributes == new.attributes, "an attribute changed");
        for (old, new) in old.channel_data.list.iter().zip(&new.channel_data.list) {
            assert_eq!(old.name, new.name);
            if old.sample_data != new.sample_data {
                names.push(crate::exr::text::name(&old.name));
            }
        }
    }
    names
}

fn values(image: &AnyImage, name: &str) -> Vec<f32> {
    let channels = image.layer_data.iter().flat_map(|layer| &layer.channel_data.list);
    let mut named = channels.filter(|channel| crate::exr::text::name(&channel.name) == name);
    named.next().expect(name).sample_data.values_as_f32().collect()
}

#[test]
fn every_view_is_read_with_its_features_and_written_and_nothing_else_changes() {
    let layers = ["", "albedo.", "N.", "right.", "right.albedo.", "right.N."];
    let image = single_part(&layers, &["Z"], &["left", "right"]);
    let folder = Folder::new();
    let picture = open(&folder.with(&image));
    let names: Vec<_> = picture.views().iter().map(crate::View::name).collect();
    assert_eq!(names, [Some("left"), Some("right")]);
    for (view, prefix) in picture.views().iter().zip(["", "right."]) {
        for (image_read, layer) in
            [(Some(view.color()), ""), (view.albedo(), "albedo."), (view.normal(), "N.")]
        {
            let expected = ["R", "G", "B"].map(|c| values(&image, &format!("{prefix}{layer}{c}")));
            assert!(planes(image_read.unwrap()) == expected, "{prefix}{layer}");
        }
    }
    let mut results: Vec<_> = picture.views().iter().map(|view| painted(view.color())).collect();
    results[1].pixels_mut().reverse();
    let denoised: Vec<_> = results.iter().cloned().map(Denoised::from).collect();
    let output = folder.path("out.exr");
    assert!(picture.save(&output, &denoised, false).unwrap().is_empty());
    let after = read(&output);
    assert_eq!(changed(&image, &after), ["B", "G", "R", "right.B", "right.G", "right.R"]);
    for (result, prefix) in results.iter().zip(["", "right."]) {
        let written = ["R", "G", "B"].map(|c| values(&after, &format!("{prefix}{c}")));
        assert!(written == planes(result), "{prefix}");
    }
}

#[test]
fn results_that_do_not_fit_are_refused_before_anything_is_written() {
    let folder = Folder::new();
    let picture = open(&folder.with(&single_part(&["left.", "right."], &["left.A"], &[])));
    let output = folder.path("out.exr");
    let right = || Denoised::from(painted(picture.first().color()));
    let small = Pixels::filled(1, 1, [0.0; 3]).unwrap();
    let refused = |results: &[Denoised]| {
        let error = picture.save(&output, results, false).unwrap_err();
        assert!(matches!(error.problem, Problem::Size(_)) && !output.exists(), "{error}");
        error.to_string()
    };
    assert!(refused(&[right()]).contains("1 results are given for 2 views"));
    assert!(refused(&[right(), small.clone().into()]).contains("is 1×1 pixels"));
    let alpha = Denoised { alpha: Some(vec![1.0; 3]), ..right() };
    assert!(refused(&[alpha, right()]).contains("the alpha is not of its size"));
    let layers = Denoised { layers: vec![painted(picture.first().color())], ..right() };
    assert!(refused(&[right(), layers]).contains("1 further layers are given and 0 were read"));
}

#[test]
fn alpha_is_read_and_replaced_or_kept() {
    let folder = Folder::new();
    let image = single_part(&["beauty.", "albedo."], &["beauty.A", "Z"], &[]);
    let input = folder.with(&image);
    let picture = open(&input);
    let view = picture.first();
    assert_eq!(view.alpha().unwrap(), values(&image, "beauty.A"));
    assert!(view.has_fractional_alpha());
    for (alpha, others) in
        [(None, &["B", "G", "R"][..]), (Some(vec![0.25; 37 * 41]), &["A", "B", "G", "R"])]
    {
        let result = Denoised { alpha: alpha.clone(), ..painted(view.color()).into() };
        let output = folder.path("out.exr");
        picture.save(&output, &[result], true).unwrap();
        let after = read(&output);
        assert_eq!(
            changed(&image, &after),
            others.iter().map(|c| format!("beauty.{c}")).collect::<Vec<_>>()
        );
        assert!(alpha.is_none_or(|alpha| values(&after, "beauty.A") == alpha));
    }
}

#[test]
fn alpha_of_0_and_1_alone_is_not_fractional_and_alpha_of_integers_is_left_alone() {
    let folder = Folder::new();
    for (alpha, expected) in [
        (FlatSamples::F32([0.0, 1.0].repeat(12)), Some(false)),
        (FlatSamples::F32([0.0, 1.0, 0.5].repeat(8)), Some(true)),
        (FlatSamples::U32(vec![1; 24]), None),
    ] {
        let channels = ["R", "G", "B"].map(|name| (name, float(1, 24))).to_vec();
        let channels = [channels, vec![("A", alpha)]].concat();
        let layer = layer("x", (6, 4), Encoding::default(), channels);
        let attributes = ImageAttributes::with_size((6, 4));
        let image = AnyImage { attributes, layer_data: SmallVec::from_vec(vec![layer]) };
        let picture = open(&folder.with(&image));
        let view = picture.first();
        assert_eq!(view.alpha().map(|_| view.has_fractional_alpha()), expected);
        let told = picture.notices().iter().any(|notice| notice.starts_with("the alpha holds"));
        assert_eq!(told, expected.is_none(), "{picture:?}");
    }
}

#[test]
fn what_compared_files_differ_in_is_told() {
    let folder = Folder::new();
    let plain = single_part(&[""], &[], &[]);
    let stereo = single_part(&["", "right."], &[], &["left", "right"]);
    let at = |corner| {
        let mut moved = plain.clone();
        moved.layer_data[0].attributes.layer_position = corner;
        moved
    };
    let mut wide = plain.clone();
    wide.attributes.chromaticities = Some(Chromaticities {
        red: Vec2(0.7, 0.3),
        green: Vec2(0.17, 0.8),
        blue: Vec2(0.13, 0.05),
        white: Vec2(0.3127, 0.329),
    });
    let differences = |other: &AnyImage| {
        let [image, reference] = [&plain, other].map(|image| open(&folder.with(image)));
        crate::comparison::differences(&image, &reference)
    };
    assert!(differences(&plain).is_empty());
    for (other, expected) in [
        (&stereo, "only one view is compared: the only view with `left`; --color names another"),
        (
            &at(Vec2(-3, 0)),
            "the first pixel is at (0, 0) in the image and at (-3, 0) in the reference; they \
             are compared with each other",
        ),
        (
            &at(Vec2(0, 5)),
            "the first pixel is at (0, 0) in the image and at (0, 5) in the reference; they \
             are compared with each other",
        ),
        (&wide, "the files have different primaries; values are compared as they are"),
    ] {
        assert_eq!(differences(other), [expected]);
    }
}

#[test]
fn further_layers_are_read_and_written_in_order() {
    let folder = Folder::new();
    let image = single_part(&["", "RGBA_key.", "RGBA_fill.", "albedo.", "other."], &["A"], &[]);
    let input = folder.with(&image);
    assert!(open(&input).first().layers().is_empty());
    let layers = Some(LayersWish::parse("RGBA_*"));
    let picture = open_as(&input, &LayerChoice { layers, ..LayerChoice::default() });
    let view = picture.first();
    let names: Vec<_> = view.layers().iter().map(|layer| layer.name.as_str()).collect();
    assert_eq!(names, ["RGBA_fill", "RGBA_key"]);
    let possible = [("RGBA_fill".into(), true), ("RGBA_key".into(), true), ("other".into(), false)];
    assert_eq!(view.selection().unwrap().possible_layers, possible);
    for layer in view.layers() {
        let expected = ["R", "G", "B"].map(|c| values(&image, &format!("{}.{c}", layer.name)));
        assert!(planes(&layer.image) == expected);
    }
    let mut results = vec![painted(view.color()); 2];
    results[1].pixels_mut().reverse();
    let denoised = Denoised { layers: results.clone(), ..painted(view.color()).into() };
    let output = folder.path("out.exr");
    picture.save(&output, &[denoised], false).unwrap();
    let after = read(&output);
    let three = |name: &str| ["B", "G", "R"].map(|c| format!("{name}{c}"));
    assert_eq!(
        changed(&image, &after),
        [three(""), three("RGBA_fill."), three("RGBA_key.")].concat()
    );
    for (result, name) in results.iter().zip(names) {
        assert!(planes(result) == ["R", "G", "B"].map(|c| values(&after, &format!("{name}.{c}"))));
    }
    let explained = &view.selection().unwrap().explanation;
    assert_eq!(
        explained[3..5],
        ["alpha from `RGB`", "further layer: `RGBA_fill` (matches a pattern)"]
    );
}

#[test]
fn a_layer_of_integers_is_left_out_of_a_pattern_and_refused_by_name() {
    let folder = Folder::new();
    let mut image = single_part(&["", "RGBA_key."], &[], &[]);
    for channel in &mut image.layer_data[0].channel_data.list {
        if channel.name.to_string().starts_with("RGBA_key") {
            channel.sample_data = FlatSamples::U32(vec![1; SIZE.0 * SIZE.1]);
        }
    }
    let input = folder.with(&image);
    let with = |layers: &str| {
        let layers = Some(LayersWish::parse(layers));
        Picture::open(&input, &LayerChoice { layers, ..LayerChoice::default() })
    };
    for pattern in ["RGBA_*", "auto"] {
        let picture = with(pattern).unwrap();
        assert!(picture.first().layers().is_empty());
        assert!(picture.notices()[0].starts_with("`RGBA_key` is left out"), "{picture:?}");
    }
    assert!(with("RGBA_key").unwrap_err().to_string().contains("holds integers"));
}

#[test]
fn one_channel_is_gray_and_gets_the_mean() {
    let folder = Folder::new();
    let image = single_part(&[""], &["AO.V", "Z"], &[]);
    let choice = LayerChoice { color: Some("AO".into()), ..LayerChoice::default() };
    let picture = open_as(&folder.with(&image), &choice);
    let color = picture.first().color();
    let ao = values(&image, "AO.V");
    assert!(planes(color) == [ao.clone(), ao.clone(), ao]);
    let mut result = painted(color);
    result.pixels_mut()[5] = [1.0, 2.0, 6.0];
    let output = folder.path("out.exr");
    picture.save(&output, &[result.into()], false).unwrap();
    let after = read(&output);
    assert_eq!((changed(&image, &after), values(&after, "AO.V")[5]), (vec!["AO.V".into()], 3.0));
}

#[test]
fn the_chroma_of_a_luminance_file_stays() {
    let folder = Folder::new();
    let image = single_part(&[], &["BY", "RY", "Y"], &[]);
    let choice = LayerChoice { color: Some("Y".into()), ..LayerChoice::default() };
    let picture = open_as(&folder.with(&image), &choice);
    let output = folder.path("out.exr");
    picture.save(&output, &[painted(picture.first().color()).into()], false).unwrap();
    assert_eq!(changed(&image, &read(&output)), ["Y"]);
}

#[test]
fn three_parts_of_one_channel_are_one_color() {
    let folder = Folder::new();
    let n = SIZE.0 * SIZE.1;
    let part = |(i, letter): (usize, &str)| {
        layer(&format!("rgba.{letter}"), SIZE, Encoding::SMALL_LOSSLESS, vec![(letter, half(i, n))])
    };
    let parts: Vec<_> = ["A", "B", "G", "R"].into_iter().enumerate().map(part).collect();
    let attributes = ImageAttributes::with_size(SIZE);
    let mut image = AnyImage { attributes, layer_data: SmallVec::from_vec(parts) };
    let picture = open(&folder.with(&image));
    let view = picture.first();
    assert!(planes(view.color()) == ["R", "G", "B"].map(|c| values(&image, c)));
    assert_eq!(view.alpha().unwrap(), values(&image, "A"));
    let (result, output) = (painted(view.color()), folder.path("out.exr"));
    picture.save(&output, &[result.clone().into()], false).unwrap();
    let after = read(&output);
    assert_eq!(changed(&image, &after), ["B", "G", "R"]);
    assert!(planes(&result) == ["R", "G", "B"].map(|c| values(&after, c)));

    image.layer_data[1].attributes.layer_position = Vec2(1, 0);
    let error = Picture::open(&folder.with(&image), &LayerChoice::default()).unwrap_err();
    assert!(error.to_string().contains("are in parts that cover different rectangles"), "{error}");
}

#[test]
fn motion_vectors_of_another_rectangle_are_left_out_or_refused() {
    let folder = Folder::new();
    let n = SIZE.0 * SIZE.1;
    let color = ["B", "G", "R"].map(|c| (c, half(1, n))).to_vec();
    let vectors = ["X", "Y"].map(|c| (c, float(2, n))).to_vec();
    let parts = [("C", color), ("motion", vectors)]
        .map(|(name, channels)| layer(name, SIZE, Encoding::SMALL_LOSSLESS, channels));
    let attributes = ImageAttributes::with_size(SIZE);
    let mut image = AnyImage { attributes, layer_data: SmallVec::from_iter(parts) };
    let with = |motion: MotionWish, image: &AnyImage| {
        Picture::open(&folder.with(image), &LayerChoice { motion, ..LayerChoice::default() })
    };
    let picture = with(MotionWish::Auto, &image).unwrap();
    let motion = picture.first().motion().unwrap();
    assert_eq!((motion.name.as_str(), motion.planes.len()), ("motion", 2));
    assert_eq!(motion.planes[0], values(&image, "X"));
    image.layer_data[1].attributes.layer_position = Vec2(1, 0);
    let picture = with(MotionWish::Auto, &image).unwrap();
    assert!(picture.first().motion().is_none());
    assert!(picture.notices().iter().any(|notice| notice.contains("`motion`")), "{picture:?}");
    let error = with(MotionWish::Named("motion".into()), &image).unwrap_err();
    assert!(error.to_string().contains("cover another rectangle than the color"), "{error}");
}

#[test]
fn names_in_utf_8_are_found_and_kept() {
    let folder = Folder::new();
    let layers = ["视图层.Combined.", "视图层.Denoising Albedo.", "Слой.Combined."];
    let image = single_part(&layers, &[], &[]);
    let input = folder.with(&image);
    let picture = open(&input);
    assert!(picture.first().selection().unwrap().color == "视图层.Combined");
    assert!(picture.first().albedo().is_some());
    for name in ["Слой.Combined", "слой.combined"] {
        let choice = LayerChoice { color: Some(name.into()), ..LayerChoice::default() };
        let picture = open_as(&input, &choice);
        assert_eq!(picture.first().selection().unwrap().color, "Слой.Combined");
        let output = folder.path("out.exr");
        picture.save(&output, &[painted(picture.first().color()).into()], true).unwrap();
        assert_eq!(
            changed(&image, &read(&output)),
            ["B", "G", "R"].map(|c| format!("Слой.Combined.{c}"))
        );
    }
}

/// A file of few bytes could otherwise take all memory.
#[test]
fn layers_that_would_take_too_much_memory_together_are_refused() {
    let folder = Folder::new();
    let names: Vec<_> = (0..9).map(|i| format!("RGBA_{i}.")).collect();
    let names: Vec<_> = [""].into_iter().chain(names.iter().map(String::as_str)).collect();
    let input = folder.with(&single_part(&names, &[], &[]));
    let limits = crate::Limits { pixels: (SIZE.0 * SIZE.1) as u64 };
    let with = |layers: &str| {
        let layers = Some(LayersWish::parse(layers));
        Picture::open(&input, &LayerChoice { layers, limits, ..LayerChoice::default() })
    };
    assert_eq!(with("RGBA_[0-6]").unwrap().first().layers().len(), 7);
    let error = with("auto").unwrap_err();
    assert!(matches!(error.problem, Problem::TooLarge(_)), "{error}");
}

#[test]
fn a_file_of_albedo_does_not_fit_several_views() {
    let folder = Folder::new();
    let input = folder.with(&single_part(&["left.", "right."], &[], &[]));
    let albedo = folder.path("albedo.exr");
    single_part(&["albedo."], &[], &[]).write().to_file(&albedo).unwrap();
    let albedo = Some(albedo.into_os_string());
    let mut choice = LayerChoice { albedo, ..LayerChoice::default() };
    let error = Picture::open(&input, &choice).unwrap_err();
    assert!(matches!(error.problem, Problem::AmbiguousColor(_)), "{error}");
    assert!(error.to_string().contains("fits only one of them"), "{error}");
    choice.color = Some("right".into());
    assert!(open_as(&input, &choice).first().albedo().is_some());
}

#[test]
fn formats_without_views_get_the_first_one_with_a_notice() {
    let folder = Folder::new();
    let picture = open(&folder.with(&single_part(&["left.", "right."], &[], &[])));
    let results = vec![Denoised::from(painted(picture.first().color())); 2];
    let notices = picture.save(&folder.path("out.png"), &results, false).unwrap();
    let said = "PNG has no views and layers: only the view `left` was written";
    assert!(notices.iter().any(|notice| notice == said), "{notices:?}");
}
