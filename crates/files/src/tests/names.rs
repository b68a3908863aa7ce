//! Layers chosen from names: views, prefixes, single channels and further light layers.

use crate::Problem;
use crate::choice::{Choice, Wish, Wishes, choose};
use crate::layers::{Part, layers, list};
use crate::light::LayersWish;
use crate::pick::Pick;

/// A part of this name and view with these channels, `~` standing for a blank.
fn part(name: &str, view: &str, channels: &str) -> Part {
    let some = |text: &str| (!text.is_empty()).then(|| text.to_string());
    let channels = channels.split_whitespace().map(|name| name.replace('~', " ")).collect();
    Part { name: some(name), view: some(view), channels, views: Vec::new() }
}

/// The channels `nameR`, `nameG` and `nameB` of each name.
fn rgb(names: &str) -> String {
    let three = |name: &str| ["R", "G", "B"].map(|letter| format!("{name}{letter}"));
    names.split_whitespace().flat_map(three).collect::<Vec<_>>().join(" ")
}

fn multi_view(channels: &str) -> Part {
    Part { views: vec!["left".into(), "right".into()], ..part("", "", channels) }
}

fn of_color(parts: &[Part], color: &str) -> Result<Vec<Choice>, Problem> {
    choose(parts, &Wishes { color: Some(color.into()), ..Wishes::default() })
}

fn with_layers(parts: &[Part], layers: &str) -> Result<Vec<Choice>, Problem> {
    choose(parts, &Wishes { layers: Some(LayersWish::parse(layers)), ..Wishes::default() })
}

/// View, color, albedo and normal of each choice.
fn chosen(choices: &[Choice]) -> Vec<[String; 4]> {
    let name = |pick: &Option<Pick>| pick.as_ref().map_or_else(String::new, |p| p.layer.clone());
    let of = |choice: &Choice| {
        let view = choice.view.clone().unwrap_or_default();
        [view, choice.color.layer.clone(), name(&choice.albedo), name(&choice.normal)]
    };
    choices.iter().map(of).collect()
}

#[track_caller]
fn assert_chosen<T>(parts: &[Part], expected: &[[T; 4]])
where
    T: std::fmt::Debug,
    String: PartialEq<T>,
{
    let choices = choose(parts, &Wishes::default()).expect("every view has a color");
    assert_eq!(chosen(&choices), expected);
}

#[test]
fn every_view_has_its_own_features_in_every_convention() {
    let left = ["left", "left", "left.albedo", "left.N"];
    let right = ["right", "right", "right.albedo", "right.N"];
    // OpenEXR's default view in a single part, and prefixes that no attribute declares.
    let second = "right.albedo. right.N. right. albedo. N.";
    let plain = multi_view(&(rgb(second) + " R G B"));
    assert_chosen(&[plain], &[["left", "RGB", "albedo", "N"], right]);
    let prefixes = part("", "", &rgb("left. left.albedo. left.N. right. right.N. right.albedo."));
    assert_chosen(&[prefixes], &[left, right]);
    // Blender's view is the last word of the layer.
    let blender = |view: &str| {
        rgb(&format!(
            "ViewLayer.Combined.{view}. ViewLayer.Noisy~Image.{view}. \
             ViewLayer.Denoising~Albedo.{view}. ViewLayer.Denoising~Normal.{view}."
        ))
    };
    assert_chosen(
        &[multi_view(&(blender("left") + " " + &blender("right")))],
        &["left", "right"].map(|view| {
            let name = |pass: &str| format!("ViewLayer.{pass}.{view}");
            [view.into(), name("Noisy Image"), name("Denoising Albedo"), name("Denoising Normal")]
        }),
    );
}

#[test]
fn parts_name_their_views_by_attribute_or_suffix() {
    for separator in ["_", "."] {
        let name = |pass: &str, view: &str| format!("{pass}{separator}{view}");
        let of = |pass, view, attribute| part(&name(pass, view), attribute, "A B G R");
        let albedo = |view, attribute| of("albedo", view, attribute);
        // Nuke's only view, with and without the attribute.
        for attribute in ["main", ""] {
            let parts = [of("rgba", "main", attribute), albedo("main", attribute)];
            let expected = ["", &name("rgba", "main"), &name("albedo", "main"), ""];
            assert_chosen(&parts, &[expected]);
        }
        for attributes in [["left", "right"], ["", ""]] {
            let [l, r] = attributes;
            let parts = [
                of("rgba", "left", l),
                albedo("right", r),
                of("rgba", "right", r),
                albedo("left", l),
            ];
            let expected = ["left", "right"]
                .map(|view| [view, &*name("rgba", view).leak(), &*name("albedo", view).leak(), ""]);
            assert_chosen(&parts, &expected);
        }
    }
    // The same channels in the parts of two views.
    let both = rgb("beauty. albedo.");
    let parts = [part("one", "left", &both), part("two", "right", &both)];
    assert_chosen(
        &parts,
        &[["left", "one.beauty", "one.albedo", ""], ["right", "two.beauty", "two.albedo", ""]],
    );
    assert_eq!(list(&layers(&parts)), "`one.beauty`, `one.albedo`, `two.beauty`, `two.albedo`");
}

#[test]
fn features_come_from_inside_the_color_then_beside_it_then_above_and_from_nowhere_else() {
    let near = |names: &str, color: &str| {
        let choices = of_color(&[part("", "", &rgb(names))], color).unwrap();
        let [.., albedo, _] = chosen(&choices).remove(0);
        (albedo, choices[0].missing[0].clone())
    };
    let all = "albedo. a.albedo. a.key.albedo. a.key. b.albedo. b.key.";
    assert_eq!(near(all, "a.key").0, "a.key.albedo");
    assert_eq!(near("albedo. a.albedo. a.key. b.albedo. a.b.", "a.key").0, "a.albedo");
    assert_eq!(near("albedo. a.key. b.albedo. a.b.albedo.", "a.key").0, "albedo");
    let (none, why) = near("b.albedo. a.key. a.b.albedo.", "a.key");
    assert_eq!(none, "");
    assert_eq!(why.as_deref(), Some("`b.albedo` belongs to another prefix"));
    // A light group has the features beside it, and never those of another group.
    let groups = "RGBA_key. RGBA_fill. C_key.albedo. C_fill.albedo.";
    assert_eq!(near(&format!("{groups} albedo."), "RGBA_fill").0, "albedo");
    assert_eq!(near(groups, "RGBA_fill").0, "");
    let stereo = of_color(&[multi_view(&rgb("right. left. left.albedo."))], "right").unwrap();
    assert_eq!(stereo[0].missing[0].as_deref(), Some("`left.albedo` belongs to another view"));
}

#[test]
fn a_named_color_is_alone_and_the_other_views_are_named() {
    let parts = [multi_view(&rgb("left.beauty. left.albedo. right.beauty. right.albedo."))];
    for name in ["right.beauty", "Right.Beauty", "right"] {
        let choices = of_color(&parts, name).unwrap();
        assert_eq!(chosen(&choices), [["right", "right.beauty", "right.albedo", ""]], "{name}");
        assert_eq!(choices[0].other_colors, ["left.beauty"]);
    }
    // Without the view, the name is that of a layer in each.
    let both = of_color(&parts, "beauty").unwrap();
    assert_eq!(both.len(), 2);
    assert!(both[0].other_colors.is_empty());
    let wishes = Wishes { albedo: Wish::Named("right.albedo".into()), ..Wishes::default() };
    let [left, right] = ["left", "right"]
        .map(|v| [v, &format!("{v}.beauty"), &format!("{v}.albedo"), ""].map(String::from));
    assert_eq!(chosen(&choose(&parts, &wishes).unwrap()), [left, right]);
}

#[test]
fn a_view_without_a_color_stays_as_it_is_with_a_notice() {
    let parts = [multi_view(&rgb("left.beauty. right.x. right.y."))];
    let choices = choose(&parts, &Wishes::default()).unwrap();
    assert_eq!(chosen(&choices), [["left", "left.beauty", "", ""]]);
    let said = &choices[0].left_out[0];
    assert!(said.starts_with("the view `right` stays as it is: it has 2 layers"), "{said}");
}

#[test]
fn many_views_are_refused_and_many_layers_are_quick() {
    let names: Vec<_> = (0..600).map(|i| format!("v{i}")).collect();
    let channels = rgb(&(names.join(". ") + "."));
    let parts = [Part { views: names, ..part("", "", &channels) }];
    let error = choose(&parts, &Wishes::default()).unwrap_err().to_string();
    assert!(error.contains("has 600 views, and at most 512"), "{error}");
    let groups = (0..50_000).map(|i| format!("p{i}.RGBA_x. p{i}.albedo."));
    let groups = rgb(&groups.collect::<Vec<_>>().join(" "));
    let parts = [part("", "", &(groups + " R G B"))];
    let choice = with_layers(&parts, "RGBA*").unwrap().remove(0);
    assert_eq!((choice.layers.len(), choice.albedo), (50_000, None));
}

#[test]
fn names_at_the_edge_of_the_specification_are_understood() {
    let one = |channels: &str| {
        chosen(&choose(&[part("", "", channels)], &Wishes::default()).unwrap()).remove(0)
    };
    assert_eq!(one(".R .G .B"), ["", "RGB", "", ""]);
    assert_eq!(one("R. G. B."), ["", "RGB", "", ""]);
    let colon = "beauty:R beauty:G beauty:B albedo:R albedo:G albedo:B";
    assert_eq!(one(colon), ["", "beauty", "albedo", ""]);
    let underscore = "R G B normal_x normal_y normal_z albedo_r albedo_g albedo_b mask_a";
    assert_eq!(one(underscore), ["", "RGB", "albedo", "normal"]);
    let cases = choose(&[part("", "", "b g r B G R")], &Wishes::default()).unwrap();
    assert_eq!(cases[0].color.channels.map(|place| place.channel), [5, 4, 3]);
    let blanks = "№1.~Combined~.R №1.~Combined~.G №1.~Combined~.B №1.~Albedo~.R №1.~Albedo~.G \
                  №1.~Albedo~.B";
    assert_eq!(one(blanks), ["", "№1. Combined ", "№1. Albedo ", ""]);
}

#[test]
fn further_renderers_are_known() {
    let one = |names: &str| {
        chosen(&choose(&[part("", "", &rgb(names))], &Wishes::default()).unwrap()).remove(0)
    };
    for (color, albedo, normal) in [
        ("FinalImage", "FinalImagePWBaseColor", "FinalImagePWWorldNormal"),
        ("Beauty", "Diffuse~filter~(beauty)", "Shading~normal"),
        ("RGB_IMAGEPIPELINE", "ALBEDO", "AVG_SHADING_NORMAL"),
        ("Image", "Denoising~Albedo", "Denoising~Normal"),
        ("rgba", "CShading_SourceColor", "CGeometry_NormalsShading"),
    ] {
        let found = one(&format!("{normal}. {albedo}. {color}."));
        assert_eq!(found.map(|name| name.replace(' ', "~")), ["", color, albedo, normal]);
    }
}

#[test]
fn red_green_and_blue_may_be_in_parts_of_their_own() {
    for (names, channels, layer) in [
        (["rgba.R", "rgba.G", "rgba.B"], ["R", "G", "B"], "rgba"),
        (["R", "G", "B"], ["R", "G", "B"], "RGB"),
        (["p0", "p1", "p2"], ["beauty.R", "beauty.G", "beauty.B"], "beauty"),
    ] {
        let parts: Vec<_> =
            names.iter().zip(channels).map(|(name, channel)| part(name, "", channel)).collect();
        let choice = choose(&parts, &Wishes::default()).unwrap().remove(0);
        assert_eq!((choice.color.layer.as_str(), choice.alpha), (layer, None));
        assert_eq!(
            choice.color.channels.map(|place| (place.part, place.channel)),
            [(0, 0), (1, 0), (2, 0)]
        );
    }
    let parts = [part("rgb", "", "R G B"), part("alpha", "", "A"), part("Z", "", "Z")];
    let choice = choose(&parts, &Wishes::default()).unwrap().remove(0);
    let (read, written) = choice.alpha.unwrap();
    assert_eq!((read.part, written.part), (1, 1));
    assert_eq!(list(&layers(&parts)), "`rgb`, `alpha`, `Z`");
}

#[test]
fn a_single_channel_is_gray_when_asked_for_unless_it_holds_no_light() {
    let parts = [part("", "", "R G B Z AO.Y shadow.A depth.Z")];
    for (name, layer) in [("AO", "AO"), ("ao", "AO"), ("AO.Y", "AO.Y"), ("shadow", "shadow")] {
        let choice = of_color(&parts, name).unwrap().remove(0);
        assert_eq!((choice.color.layer.as_str(), choice.color.is_gray()), (layer, true));
        assert_eq!((choice.target, choice.alpha), (choice.color, None));
    }
    for (name, said) in [
        ("depth", "layer `depth` has the channels Z and holds depth, not light"),
        ("Z", "channel `Z` holds depth, not light"),
        ("depth.Z", "channel `depth.Z` holds depth, not light"),
        ("A", "its layers are `RGB`, `AO`, `shadow`, `depth`"),
    ] {
        let error = of_color(&parts, name).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
}

#[test]
fn a_file_without_color_offers_the_channels_that_can_be_gray() {
    for (channels, offered) in
        [("AO.V", true), ("A", true), ("R", true), ("Z", false), ("depth.Z", false), ("U V", false)]
    {
        let error = choose(&[part("", "", channels)], &Wishes::default()).unwrap_err();
        assert_eq!(matches!(error, Problem::AmbiguousColor(_)), offered, "{error}");
    }
}

#[test]
fn files_of_luminance_are_gray_on_request_and_list_what_to_ask_for() {
    for (channels, names) in [("Y", "`Y`"), ("Y A", "`Y`, `A`"), ("BY RY Y", "`BY`, `RY`, `Y`")] {
        let parts = [part("", "", channels)];
        let error = choose(&parts, &Wishes::default()).unwrap_err();
        assert!(matches!(error, Problem::AmbiguousColor(_)), "{error}");
        let text = error.to_string();
        assert!(
            text.contains("luminance (Y)") && text.ends_with(&format!("are {names}")),
            "{text}"
        );
        let choice = of_color(&parts, "Y").unwrap().remove(0);
        let place = choice.color.channels[0];
        assert_eq!(parts[0].channels[place.channel], "Y");
        assert_eq!(choice.alpha.is_some(), channels == "Y A");
    }
}

#[test]
fn layers_of_light_are_found_by_convention_and_others_are_not() {
    let blender = "ViewLayer.Combined. ViewLayer.Combined_key. ViewLayer.Combined_fill. \
                   ViewLayer.DiffDir. ViewLayer.GlossInd. ViewLayer.Emit. ViewLayer.DiffCol. \
                   ViewLayer.Denoising~Albedo. ViewLayer.custom. Other.DiffDir.";
    let auto = with_layers(&[part("", "", &rgb(blender))], "auto").unwrap().remove(0);
    let names: Vec<_> = auto.layers.iter().map(|pick| pick.layer.as_str()).collect();
    let passes = ["Combined_key", "Combined_fill", "DiffDir", "GlossInd", "Emit"];
    assert_eq!(names, passes.map(|pass| format!("ViewLayer.{pass}")));
    assert!(auto.left_out.is_empty(), "{auto:?}");
    let none = with_layers(&[part("", "", "R G B")], "auto").unwrap().remove(0);
    assert_eq!(none.left_out, ["no further layer is known to add up to the color"]);
}

#[test]
fn patterns_take_light_and_name_what_they_leave_out() {
    let names = "RGBA_key. RGBA_fill. albedo. N. custom.";
    let parts = [part("", "", &(rgb(names) + " R G B Z id.X"))];
    let names = |patterns: &str| -> Vec<String> {
        let choice = with_layers(&parts, patterns).unwrap().remove(0);
        choice.layers.into_iter().map(|pick| pick.layer).collect()
    };
    assert_eq!(names("RGBA_*"), ["RGBA_key", "RGBA_fill"]);
    assert_eq!(names("custom, rgba_KEY"), ["RGBA_key", "custom"]);
    assert_eq!(names("rgba_[kf]*,RGBA_key"), ["RGBA_key", "RGBA_fill"]);
    assert_eq!(names("*"), ["RGBA_key", "RGBA_fill", "custom"]);
    let all = with_layers(&parts, "*").unwrap().remove(0);
    assert_eq!(
        all.left_out,
        ["layers not denoised, because they hold no light that adds up: `albedo`, `N`, `id`"]
    );
    for (pattern, said) in [
        ("albedo", "layer `albedo` holds albedo and no light that adds up to the color"),
        ("n", "layer `N` holds normals"),
        ("id", "layer `id` holds IDs"),
        ("lights_*", "has no further layer `lights_*`; its layers are `RGBA_key`"),
        ("RGB", "has no further layer `RGB`"),
        ("a[", "`a[` is not a valid pattern"),
    ] {
        let error = with_layers(&parts, pattern).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
    // The name of a layer may look like a pattern.
    let lpe = "lpe:C<RD>[<L.>O]";
    let parts = [part("", "", &(rgb(&format!("{lpe}.")) + " R G B"))];
    assert_eq!(with_layers(&parts, lpe).unwrap()[0].layers[0].layer, lpe);
}

#[test]
fn layers_of_each_view_stay_with_their_view() {
    let parts = [multi_view(&(rgb("right. RGBA_key. right.RGBA_key.") + " R G B"))];
    let names = |choices: &[Choice]| -> Vec<Vec<String>> {
        let of = |choice: &Choice| choice.layers.iter().map(|pick| pick.layer.clone()).collect();
        choices.iter().map(of).collect()
    };
    let [right, left] = [vec!["right.RGBA_key".to_string()], vec!["RGBA_key".to_string()]];
    for pattern in ["auto", "RGBA_*", "*key"] {
        assert_eq!(names(&with_layers(&parts, pattern).unwrap()), [left.clone(), right.clone()]);
    }
    assert_eq!(names(&with_layers(&parts, "right.*").unwrap()), [vec![], right]);
}
