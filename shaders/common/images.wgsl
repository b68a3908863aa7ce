// The bound images by number. Callers pass a constant, so compilers keep only one branch.

@if(layer) import package::common::beauty::load_beauty;
import package::common::color::load_color;
import package::common::tile::tile;
@if(auxiliary || (demodulates && !stored_finest)) import package::common::albedo::load_albedo;
@if(auxiliary) import package::common::normal::load_normal;

const COLOR = 0u;
const ALBEDO = 1u;
const NORMAL = 2u;
const LAYER = 3u;            // the further layer, bound as the color

// The bits of a pixel as 32-bit floats.
fn load(image: u32, at: vec2<u32>) -> vec3<u32> {
    @if(auxiliary || (demodulates && !stored_finest))
    if image == ALBEDO {
        return load_albedo(tile.albedo, at);
    }
    @if(auxiliary)
    if image == NORMAL {
        return load_normal(tile.normal, at);
    }
    @if(layer)
    if image == COLOR {
        return load_beauty(tile.beauty, at);
    }
    return load_color(tile.color, at);
}
