//! Renderers' names for color, albedo and normal layers, the preferred name first.

/// A layer's name, and the renderer that uses it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Convention {
    /// The last word of the layer's name as [`simple`] leaves it.
    pub(super) pass: &'static str,
    /// Whether the channels must be called `red`, `green` and `blue`, as V-Ray does: its
    /// `diffuse` is an albedo, while that of other renderers is light.
    pub(super) words: bool,
    /// How messages name it.
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
];

/// Albedo.
pub(super) const ALBEDO: &[Convention] = &[
    of("denoisingalbedo", "Blender's denoising albedo"),
    of("denoisealbedo", "Arnold's denoiser albedo"),
    of("albedo", "the albedo by its name"),
    of("diffusealbedo", "Arnold's diffuse albedo"),
    of("diffusefilter", "Redshift's diffuse filter"),
    of("vraydiffusefilter", "V-Ray's diffuse filter"),
    Convention { pass: "diffuse", words: true, whose: "V-Ray's diffuse filter" },
];

/// Normals, shading normals before geometric ones.
pub(super) const NORMAL: &[Convention] = &[
    of("denoisingnormal", "Blender's denoising normal"),
    of("bumpnormals", "V-Ray's bump normals"),
    of("ns", "pbrt's shading normal"),
    of("shnormal", "Mitsuba's shading normal"),
    of("n", "the normal by its name"),
    of("normal", "the normal by its name"),
    of("normals", "the normal by its name"),
];

/// Whether a layer of this name holds data or finished images, never noisy color.
pub(super) fn is_data(pass: &str) -> bool {
    let pass = simple(pass);
    let known = ["variance", "position", "p", "uv", "vector", "motionvectors", "effectsresult"];
    pass.contains("crypto") || known.contains(&pass.as_str())
}

/// A name in lower case, without blanks and underscores.
pub(super) fn simple(name: &str) -> String {
    name.chars().filter(|c| !matches!(c, ' ' | '_')).collect::<String>().to_lowercase()
}
