//! The names that renderers give to layers, preferred first: color, albedo, normals and motion
//! vectors; also light that adds up to the color, and data that is not light.

/// A layer name and the renderer that uses it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Convention {
    /// The last word of the layer's name as [`simple`] leaves it.
    pub(super) pass: &'static str,
    /// Whether the channels must be called `red`, `green` and `blue`, as in V-Ray: its `diffuse` is
    /// an albedo, while that of other renderers is light.
    pub(super) words: bool,
    /// What messages call the layer.
    pub(super) whose: &'static str,
}

const fn of(pass: &'static str, whose: &'static str) -> Convention {
    Convention { pass, words: false, whose }
}

/// Noisy color.
pub(super) const COLOR: &[Convention] = &[
    of("noisyimage", "Blender's noisy image"),
    of("combined", "Blender's combined pass"),
    of("", "the file's plain R, G, B"),
    of("c", "Karma's beauty"),
    of("ci", "RenderMan's beauty"),
    of("rgba", "the beauty by its name"),
    of("rgb", "the beauty by its name"),
    of("beauty", "the beauty by its name"),
    of("color", "the beauty by its name"),
    of("image", "the image by its name"),
    of("finalimage", "Unreal's final image"),
    of("rgbimagepipeline", "LuxCore's image pipeline"),
];

/// Albedo.
pub(super) const ALBEDO: &[Convention] = &[
    of("denoisingalbedo", "Blender's denoising albedo"),
    of("denoisealbedo", "Arnold's denoiser albedo"),
    of("albedo", "the albedo by its name"),
    of("diffusealbedo", "Arnold's diffuse albedo"),
    of("diffusefilter", "Redshift's diffuse filter"),
    of("vraydiffusefilter", "V-Ray's diffuse filter"),
    of("diffusefilter(beauty)", "Octane's diffuse filter"),
    of("cshadingsourcecolor", "Corona's source color"),
    of("finalimagepwbasecolor", "Unreal's base color"),
    Convention { pass: "diffuse", words: true, whose: "V-Ray's diffuse filter" },
];

/// Normals, shading normals before geometric ones.
pub(super) const NORMAL: &[Convention] = &[
    of("denoisingnormal", "Blender's denoising normal"),
    of("bumpnormals", "V-Ray's bump normals"),
    of("ns", "pbrt's shading normal"),
    of("shnormal", "Mitsuba's shading normal"),
    of("shadingnormal", "Octane's shading normal"),
    of("avgshadingnormal", "LuxCore's shading normal"),
    of("cgeometrynormalsshading", "Corona's shading normal"),
    of("finalimagepwworldnormal", "Unreal's world normal"),
    of("n", "the normal by its name"),
    of("normal", "the normal by its name"),
    of("normals", "the normal by its name"),
];

/// Motion vectors.
pub(super) const MOTION: &[Convention] = &[
    of("vector", "Blender's motion vectors"),
    of("motionvector", "the motion vectors by their name"),
    of("motionvectors", "the motion vectors by their name"),
    of("velocity", "V-Ray's velocity"),
    of("vrayvelocity", "V-Ray's velocity"),
    of("motionback", "RenderMan's motion to the previous frame"),
    of("motion", "the motion by its name"),
    of("flow", "the motion by its name"),
];

/// Parts of names, as [`simple`] leaves them, and what layers with such names hold.
const DATA_WITHIN: &[(&str, &str)] = &[
    ("crypto", "cryptomatte"),
    ("variance", "variance"),
    ("albedo", "albedo"),
    ("normal", "normals"),
    ("filter", "surface color"),
    ("basecolor", "surface color"),
    ("sourcecolor", "surface color"),
    ("depth", "depth"),
    ("position", "positions"),
    ("motion", "motion vectors"),
    ("velocity", "motion vectors"),
    ("multimatte", "masks"),
    ("roughness", "roughness"),
    ("samplecount", "sample counts"),
    ("samplerate", "sample counts"),
    ("occlusion", "occlusion"),
    ("shadow", "shadows"),
    ("objectid", "IDs"),
    ("materialid", "IDs"),
    ("effectsresult", "a finished picture"),
    ("denoised", "a finished picture"),
];

/// Whole names, as [`simple`] leaves them, and what layers with such names hold.
const DATA: &[(&str, &str)] = &[
    ("diffcol", "surface color"),
    ("diffusecolor", "surface color"),
    ("glosscol", "surface color"),
    ("glossycolor", "surface color"),
    ("transcol", "surface color"),
    ("transmissioncolor", "surface color"),
    ("subsurfacecolor", "surface color"),
    ("z", "depth"),
    ("deep", "depth"),
    ("mist", "mist"),
    ("p", "positions"),
    ("pworld", "positions"),
    ("pref", "positions"),
    ("n", "normals"),
    ("ng", "normals"),
    ("uv", "texture coordinates"),
    ("st", "texture coordinates"),
    ("vector", "motion vectors"),
    ("ao", "occlusion"),
    ("indexob", "IDs"),
    ("indexma", "IDs"),
    ("objectindex", "IDs"),
    ("materialindex", "IDs"),
    ("id", "IDs"),
    ("mask", "masks"),
    ("matte", "masks"),
    ("alpha", "alpha"),
];

/// What a layer of this name holds, if not light that adds up.
pub(super) fn data(pass: &str) -> Option<&'static str> {
    let pass = simple(pass);
    let within = DATA_WITHIN.iter().find(|(name, _)| pass.contains(name));
    within.or_else(|| DATA.iter().find(|(name, _)| pass == *name)).map(|(_, what)| *what)
}

/// Prefixes of light group names, in lower case.
const LIGHT_GROUPS: &[(&str, &str)] = &[
    ("combined_", "Blender's light group"),
    ("rgba_", "Arnold's light group"),
    ("vraylightselect", "V-Ray's light select"),
    ("vray_lightselect", "V-Ray's light select"),
    ("cshading_lightselect", "Corona's light select"),
    ("lightselect", "a light select"),
    ("lightgroup", "a light group by its name"),
    ("light_group", "a light group by its name"),
    ("lpe:", "a light path expression"),
    ("lpe_", "a light path expression"),
];

/// Words that make up the names of direct light, reflections and the like, as spelled by Blender,
/// Arnold, V-Ray, RenderMan, Karma, Redshift, Octane and Mitsuba.
const LIGHT_WORDS: &[&str] = &[
    "vray",
    "direct",
    "dir",
    "indirect",
    "ind",
    "combined",
    "diffuse",
    "diff",
    "specular",
    "spec",
    "glossy",
    "gloss",
    "transmission",
    "transmissive",
    "trans",
    "reflections",
    "reflection",
    "refractions",
    "refraction",
    "subsurface",
    "sss",
    "singlescatter",
    "clearcoat",
    "coat",
    "sheen",
    "volume",
    "volumetric",
    "emission",
    "emissive",
    "emit",
    "environment",
    "env",
    "background",
    "globalillumination",
    "gi",
    "selfillumination",
    "caustics",
    "lighting",
    "light",
    "lobe",
    "primary",
    "rough",
    "user",
];

/// Longer names are not split into words.
const MOST_LETTERS: usize = 64;

/// What light a layer of this name holds, if by a renderer's convention it adds up to the color.
pub(super) fn light(pass: &str) -> Option<&'static str> {
    let lower = pass.trim().to_lowercase();
    let group = LIGHT_GROUPS.iter().find(|(start, _)| lower.starts_with(start));
    if let Some((_, whose)) = group {
        return Some(whose);
    }
    let letters = simple(pass);
    let named = !letters.is_empty() && letters != "combined" && letters.len() <= MOST_LETTERS;
    (named && is_made_of(&letters, LIGHT_WORDS)).then_some("a light pass by its name")
}

/// Whether a text consists of some of the words in a row.
fn is_made_of(text: &str, words: &[&str]) -> bool {
    let mut reached = vec![false; text.len() + 1];
    reached[0] = true;
    for at in 0..text.len() {
        if !reached[at] {
            continue;
        }
        for word in words.iter().filter(|word| text[at..].starts_with(**word)) {
            reached[at + word.len()] = true;
        }
    }
    reached[text.len()]
}

/// A name in lower case, without spaces and underscores.
pub(super) fn simple(name: &str) -> String {
    name.chars().filter(|c| !matches!(c, ' ' | '_')).collect::<String>().to_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_that_add_up_are_known_in_every_spelling() {
        let names = "Combined_key DiffDir GlossInd TransDir VolumeInd Emit Env RGBA_rim \
                     direct_diffuse indirect_emission diffuse_direct sss_indirect VRayLightSelect_sun \
                     VRayLighting VRayGlobalIllumination VRayReflection VRaySelfIllumination \
                     directDiffuse indirectSpecular lpe:C<RD>[<L.>O] directdiffuse \
                     combinedglossyreflection DiffuseLighting Refractions";
        for name in names.split_whitespace().chain(["Diffuse Direct", "Glossy Indirect"]) {
            assert!(light(name).is_some() && data(name).is_none(), "{name}");
        }
    }

    #[test]
    fn what_is_no_light_is_known_by_what_it_holds() {
        for (name, what) in [
            ("DiffCol", "surface color"),
            ("diffuse_albedo", "albedo"),
            ("VRayZDepth", "depth"),
            ("Z", "depth"),
            ("AO", "occlusion"),
            ("Shadow", "shadows"),
            ("CryptoObject00", "cryptomatte"),
            ("IndexOB", "IDs"),
            ("UV", "texture coordinates"),
            ("Vector", "motion vectors"),
            ("Mist", "mist"),
            ("Ng", "normals"),
        ] {
            assert_eq!((data(name), light(name)), (Some(what), None), "{name}");
        }
        for other in ["Combined", "beauty", "key", "dirt", "", &"light".repeat(13)] {
            assert_eq!(light(other), None, "{other}");
        }
    }
}
