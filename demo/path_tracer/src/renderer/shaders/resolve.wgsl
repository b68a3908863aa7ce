// Writes the averages to textures, which the denoiser reads and the window shows.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> colors: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> albedos: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> normals: array<vec4<f32>>;
@group(0) @binding(4) var color: texture_storage_2d<rgba32float, write>;
@group(0) @binding(5) var albedo: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(6) var normal: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn resolve(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let pixel = id.y * frame.size.x + id.x;
    let share = 1.0 / f32(frame.first_sample + frame.samples);
    textureStore(color, id.xy, colors[pixel] * share);
    textureStore(albedo, id.xy, albedos[pixel] * share);
    textureStore(normal, id.xy, normals[pixel] * share);
}
