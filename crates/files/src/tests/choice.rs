//! Which layers of renderers' files are color, albedo and normal.

use crate::Problem;
use crate::choice::{Choice, Wish, Wishes, choose};
use crate::features::{Kind, choose_single};
use crate::layers::{Part, Place};
use crate::pick::Pick;
use crate::selection::Selection;
use crate::wanted::Files;

struct Case {
    renderer: &'static str,
    parts: &'static [(&'static str, &'static str)],
    expected: [&'static str; 4],
}

/// Parts as `(name, channels)`; expected are color, target, albedo and normal.
const CASES: &[Case] = &[
    Case {
        renderer: "Blender 4, one part",
        parts: &[(
            "",
            "ViewLayer.Combined.A ViewLayer.Combined.B ViewLayer.Combined.G ViewLayer.Combined.R \
             ViewLayer.CryptoObject00.b ViewLayer.CryptoObject00.g ViewLayer.CryptoObject00.r \
             ViewLayer.Denoising_Albedo.B ViewLayer.Denoising_Albedo.G ViewLayer.Denoising_Albedo.R \
             ViewLayer.Denoising_Normal.X ViewLayer.Denoising_Normal.Y ViewLayer.Denoising_Normal.Z \
             ViewLayer.Noisy_Image.A ViewLayer.Noisy_Image.B ViewLayer.Noisy_Image.G \
             ViewLayer.Noisy_Image.R ViewLayer.Normal.X ViewLayer.Normal.Y ViewLayer.Normal.Z",
        )],
        expected: [
            "ViewLayer.Noisy_Image",
            "ViewLayer.Combined",
            "ViewLayer.Denoising_Albedo",
            "ViewLayer.Denoising_Normal",
        ],
    },
    Case {
        renderer: "Blender 5, a part per pass, two view layers",
        parts: &[
            ("Far.Combined", "Far.Combined.B Far.Combined.G Far.Combined.R"),
            (
                "Near.Denoising_Albedo",
                "Near.Denoising_Albedo.B Near.Denoising_Albedo.G Near.Denoising_Albedo.R",
            ),
            (
                "Far.Denoising_Albedo",
                "Far.Denoising_Albedo.B Far.Denoising_Albedo.G Far.Denoising_Albedo.R",
            ),
        ],
        expected: ["Far.Combined", "Far.Combined", "Far.Denoising_Albedo", ""],
    },
    Case {
        renderer: "Blender 4, one part, with the compositor's picture",
        parts: &[(
            "",
            "Composite.Combined.B Composite.Combined.G Composite.Combined.R \
             ViewLayer.Combined.B ViewLayer.Combined.G ViewLayer.Combined.R \
             ViewLayer.Denoising_Albedo.B ViewLayer.Denoising_Albedo.G ViewLayer.Denoising_Albedo.R \
             ViewLayer.Denoising_Normal.X ViewLayer.Denoising_Normal.Y ViewLayer.Denoising_Normal.Z",
        )],
        expected: [
            "ViewLayer.Combined",
            "ViewLayer.Combined",
            "ViewLayer.Denoising_Albedo",
            "ViewLayer.Denoising_Normal",
        ],
    },
    Case {
        renderer: "Blender 4, one part, with a view layer of fog alone",
        parts: &[(
            "",
            "Composite.Combined.B Composite.Combined.G Composite.Combined.R \
             Fog.Combined.B Fog.Combined.G Fog.Combined.R \
             ViewLayer.Combined.B ViewLayer.Combined.G ViewLayer.Combined.R \
             ViewLayer.Denoising_Albedo.B ViewLayer.Denoising_Albedo.G ViewLayer.Denoising_Albedo.R",
        )],
        expected: ["ViewLayer.Combined", "ViewLayer.Combined", "ViewLayer.Denoising_Albedo", ""],
    },
    Case {
        renderer: "Karma",
        parts: &[("C", "A B G R"), ("albedo", "B G R"), ("N", "B G R"), ("Z", "Z")],
        expected: ["C", "C", "albedo", "N"],
    },
    Case {
        renderer: "Arnold",
        parts: &[(
            "",
            "A B G N.X N.Y N.Z R Z denoise_albedo.B denoise_albedo.G denoise_albedo.R \
             diffuse.B diffuse.G diffuse.R diffuse_albedo.B diffuse_albedo.G diffuse_albedo.R \
             variance.B variance.G variance.R",
        )],
        expected: ["RGB", "RGB", "denoise_albedo", "N"],
    },
    Case {
        renderer: "V-Ray",
        parts: &[(
            "",
            "A B G R bump_normals.X bump_normals.Y bump_normals.Z diffuse.blue diffuse.green \
             diffuse.red effectsResult.B effectsResult.G effectsResult.R normals.X normals.Y \
             normals.Z",
        )],
        expected: ["RGB", "RGB", "diffuse", "bump_normals"],
    },
    Case {
        renderer: "RenderMan",
        parts: &[(
            "",
            "Ci.a Ci.b Ci.g Ci.r albedo.b albedo.g albedo.r normal.b normal.g normal.r z",
        )],
        expected: ["Ci", "Ci", "albedo", "normal"],
    },
    Case {
        renderer: "pbrt-v4",
        parts: &[(
            "",
            "Albedo.B Albedo.G Albedo.R B G N.X N.Y N.Z Ns.X Ns.Y Ns.Z P.X P.Y P.Z R \
             Variance.B Variance.G Variance.R dzdx dzdy u v",
        )],
        expected: ["RGB", "RGB", "Albedo", "Ns"],
    },
    Case {
        renderer: "pbrt-v4, older",
        parts: &[("", "Albedo.B Albedo.G Albedo.R B G Nsx Nsy Nsz Nx Ny Nz R dzdx dzdy")],
        expected: ["RGB", "RGB", "Albedo", "Ns"],
    },
    Case {
        renderer: "Mitsuba 3 with the integrator's name",
        parts: &[(
            "",
            "alb.B alb.G alb.R img.A img.B img.G img.R sh_normal.X sh_normal.Y sh_normal.Z",
        )],
        expected: ["img", "img", "", "sh_normal"],
    },
    Case {
        renderer: "Redshift",
        parts: &[("Beauty", "A B G R"), ("DiffuseFilter", "B G R"), ("Normals", "B G R")],
        expected: ["Beauty", "Beauty", "DiffuseFilter", "Normals"],
    },
    Case {
        renderer: "plain",
        parts: &[("beauty pass", "A B G R Z")],
        expected: ["RGB", "RGB", "", ""],
    },
];

/// `_` stands for the blank of Blender's names.
fn parts(named: &[(&str, &str)]) -> Vec<Part> {
    let blank = |text: &str| text.replace("Denoising_", "Denoising ").replace("Noisy_", "Noisy ");
    let part = |&(name, channels): &(&str, &str)| Part {
        name: (!name.is_empty()).then(|| blank(name)),
        channels: channels.split_whitespace().map(blank).collect(),
        ..Part::default()
    };
    named.iter().map(part).collect()
}

/// The choice for a file with one view.
fn choose_one(
    parts: &[Part],
    color: Option<&str>,
    albedo: &Wish,
    normal: &Wish,
) -> Result<Choice, Problem> {
    let (color, albedo, normal) = (color.map(Into::into), albedo.clone(), normal.clone());
    let mut choices = choose(parts, &Wishes { color, albedo, normal, ..Wishes::default() })?;
    assert_eq!(choices.len(), 1);
    Ok(choices.remove(0))
}

fn automatic(parts: &[Part]) -> Result<Choice, Problem> {
    choose_one(parts, None, &Wish::Auto, &Wish::Auto)
}

fn selection(choice: &Choice, albedo: Option<&str>) -> Selection {
    Selection::of(choice, &Files { albedo: albedo.map(Into::into), normal: None })
}

#[test]
fn every_renderers_names_are_known() {
    assert!(CASES.len() >= 10);
    for case in CASES {
        let choice = automatic(&parts(case.parts)).expect(case.renderer);
        let name = |pick: Option<Pick>| pick.map_or(String::new(), |p| p.layer);
        let found = [Some(choice.color), Some(choice.target), choice.albedo, choice.normal];
        let expected = case.expected.map(|n| n.replace("g_", "g ").replace("y_", "y "));
        assert_eq!(found.map(name), expected, "{}", case.renderer);
    }
}

#[test]
fn red_green_blue_and_x_y_z_are_found_in_any_order() {
    let choice = automatic(&parts(&[("C", "A B G R"), ("N", "Y X Z")])).unwrap();
    assert_eq!(choice.color.channels, [3, 2, 1].map(|channel| Place { part: 0, channel }));
    let normal = choice.normal.unwrap();
    assert_eq!(normal.channels, [1, 0, 2].map(|channel| Place { part: 1, channel }));
}

#[test]
fn a_named_layer_is_found_exactly_or_by_its_last_word() {
    let parts = parts(&[("", "R G B a.light.R a.light.G a.light.B b.gloss.R b.gloss.G b.gloss.B")]);
    for (wish, layer) in
        [("a.light", "a.light"), ("A.LIGHT", "a.light"), ("gloss", "b.gloss"), ("RGB", "RGB")]
    {
        let choice = choose_one(&parts, Some(wish), &Wish::Auto, &Wish::Without).unwrap();
        assert_eq!((choice.color.layer.as_str(), choice.target.layer.as_str()), (layer, layer));
    }
}

#[test]
fn an_unknown_layer_is_refused_with_a_list_of_the_layers() {
    let parts = parts(&[("", "R G B albedo.R albedo.G albedo.B depth.Z")]);
    let wish = Wish::Named("albido".into());
    let error = choose_one(&parts, None, &wish, &Wish::Auto).unwrap_err().to_string();
    assert!(error.contains("no layer `albido`") && error.contains("`RGB`, `albedo`, `depth`"));
    let error =
        choose_one(&parts, Some("depth"), &Wish::Auto, &Wish::Auto).unwrap_err().to_string();
    assert!(error.contains("layer `depth` has the channels Z"), "{error}");
}

#[test]
fn ambiguous_or_missing_color_is_an_error_with_the_reason() {
    let error = |p: &[(&str, &str)]| automatic(&parts(p)).unwrap_err().to_string();
    let two = automatic(&parts(&[("", "x.R x.G x.B y.R y.G y.B")])).unwrap_err();
    assert!(matches!(two, Problem::AmbiguousColor(_)), "{two}");
    assert!(two.to_string().contains("2 layers that could be the color"), "{two}");
    assert!(error(&[("", "Y A")]).contains("luminance (Y)"));
    assert!(error(&[("", "depth.Z")]).contains("no layer with R, G and B"));
}

#[test]
fn a_view_layer_is_preferred_to_the_compositors_output_and_the_others_are_named() {
    let parts = parts(&[(
        "",
        "Composite.Combined.B Composite.Combined.G Composite.Combined.R \
         Fog.Combined.B Fog.Combined.G Fog.Combined.R",
    )]);
    let said = selection(&automatic(&parts).unwrap(), None);
    assert!(said.explanation[0].starts_with("color from `Fog.Combined`"), "{said:?}");
    assert_eq!(said.other_colors, ["Composite.Combined"]);
    let named = choose_one(&parts, Some("Fog.Combined"), &Wish::Auto, &Wish::Auto).unwrap();
    assert!(named.other_colors.is_empty() && named.left_out.is_empty(), "{named:?}");
}

#[test]
fn an_unusable_albedo_is_left_out_unless_it_was_named() {
    let parts = parts(&[("C", "R G B"), ("albedo", "R G B"), ("N", "X Y Z")]);
    let named = Wish::Named("N".into());
    let mut choice = choose_one(&parts, None, &Wish::Auto, &named).unwrap();
    choice.leave_out_unusable(|_| Err(Problem::Unsupported("it holds integers".into())));
    assert_eq!((choice.albedo.is_some(), choice.normal.is_some()), (false, true));
    let said = selection(&choice, None).left_out;
    assert_eq!(said, ["`albedo` is left out: it holds integers"]);
}

#[test]
fn a_separate_file_with_two_candidates_is_refused_with_advice() {
    let error = |kind| {
        choose_single(&parts(&[("", "x.R x.G x.B y.R y.G y.B")]), kind).unwrap_err().to_string()
    };
    assert!(
        error(Kind::Albedo).contains("2 layers that could be the albedo; give a file with one")
    );
    assert!(!error(Kind::Normal).contains("--color"), "{}", error(Kind::Normal));
}

#[test]
fn no_aux_leaves_both_out_and_the_choice_is_explained() {
    let parts = parts(&[("C", "R G B"), ("albedo", "R G B"), ("N", "X Y Z")]);
    let choice = choose_one(&parts, None, &Wish::Without, &Wish::Without).unwrap();
    assert_eq!(
        selection(&choice, None).explanation,
        ["color from `C` (Karma's beauty), written to `C`", "no albedo", "no normal"]
    );
    let with_file = selection(&choice, Some("a.exr"));
    assert!(with_file.explanation[1..] == ["albedo from the file a.exr", "no normal"]);
    assert!(with_file.albedo && !with_file.normal, "{with_file:?}");
}
