// Surfaces and patch borders into a display-linear picture. Concatenated behind tone.wgsl.

struct Frame {
    clip_from_local: mat4x4f,
    eye: vec3f,        // local
    exposure: f32,
    highlight: u32,    // patch, or NO_PATCH
    scale: f32,        // position along the colour map = value * scale + offset
    offset: f32,
    logarithmic: u32,
    map_row: f32,      // v coordinate of the map in the table
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var colour_maps: texture_2d<f32>;
@group(0) @binding(2) var colour_map_sampler: sampler;

@group(1) @binding(0) var reflectance_texture: texture_2d<f32>;
@group(1) @binding(1) var reflectance_sampler: sampler;

const NO_VALUE_BELOW = -1e29; // NO_VALUE of display/false_colour.rs is less
const MIDDLE_GREY = 0.3; // as display/tone.rs has it
const HIGHLIGHT = vec3f(1.0, 0.36, 0.02);

struct Corner {
    @location(0) position: vec3f, // local
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) patch_index: u32,
}

fn clip(position: vec3f) -> vec4f {
    return frame.clip_from_local * vec4f(position, 1.0);
}

fn highlighted(colour: vec3f, patch_index: u32) -> vec4f {
    return vec4f(mix(colour, HIGHLIGHT, select(0.0, 0.55, patch_index == frame.highlight)), 1.0);
}

struct Lit {
    @builtin(position) clip: vec4f,
    @location(0) light: vec3f,
    @location(1) uv: vec2f,
    @location(2) @interpolate(flat) patch_index: u32,
}

@vertex fn vs_lit(corner: Corner, @location(4) light: vec3f) -> Lit {
    return Lit(clip(corner.position), light, corner.uv, corner.patch_index);
}

@fragment fn fs_plain(v: Lit) -> @location(0) vec4f {
    return highlighted(tone_map(v.light * frame.exposure), v.patch_index);
}

@fragment fn fs_textured(v: Lit) -> @location(0) vec4f {
    let texel = textureSample(reflectance_texture, reflectance_sampler, vec2f(v.uv.x, 1.0 - v.uv.y)).rgb;
    return highlighted(tone_map(texel * v.light * frame.exposure), v.patch_index);
}

// Nothing where the image is transparent.
@fragment fn fs_perforated(v: Lit) -> @location(0) vec4f {
    let texel = textureSample(reflectance_texture, reflectance_sampler, vec2f(v.uv.x, 1.0 - v.uv.y));
    if texel.a < 0.5 {
        discard;
    }
    return highlighted(tone_map(texel.rgb * v.light * frame.exposure), v.patch_index);
}

struct Valued {
    @builtin(position) clip: vec4f,
    @location(0) value: f32,
    @location(1) facing: f32,
    @location(2) @interpolate(flat) patch_index: u32,
}

@vertex fn vs_valued(corner: Corner, @location(5) value: f32) -> Valued {
    let facing = abs(dot(corner.normal, normalize(frame.eye - corner.position)));
    return Valued(clip(corner.position), value, facing, corner.patch_index);
}

@fragment fn fs_false_colour(v: Valued) -> @location(0) vec4f {
    if v.value < NO_VALUE_BELOW {
        return highlighted(vec3f(0.04 + 0.08 * v.facing), v.patch_index);
    }
    let x = select(v.value, log2(max(v.value, 1e-37)), frame.logarithmic != 0u);
    let position = clamp(x * frame.scale + frame.offset, 0.0, 1.0);
    // From the centre of the first entry to that of the last.
    let at = vec2f((position * 255.0 + 0.5) / 256.0, frame.map_row);
    let colour = textureSampleLevel(colour_maps, colour_map_sampler, at, 0.0).rgb;
    return highlighted(colour, v.patch_index);
}

struct Plain {
    @builtin(position) clip: vec4f,
    @location(0) normal: vec3f,
    @location(1) position: vec3f,
    @location(2) @interpolate(flat) patch_index: u32,
}

@vertex fn vs_static(corner: Corner) -> Plain {
    return Plain(clip(corner.position), corner.normal, corner.position, corner.patch_index);
}

// How much a surface faces the eye, so that shapes show without light.
fn facing(v: Plain) -> f32 {
    return abs(dot(normalize(v.normal), normalize(frame.eye - v.position)));
}

@fragment fn fs_patch_ids(v: Plain) -> @location(0) vec4f {
    // Multiplicative hashing (Knuth 6.4) keeps neighbours apart in hue and in lightness.
    let hash = v.patch_index * 2654435769u;
    let hue = f32(hash >> 16u) / 65536.0;
    let lightness = 0.35 + 0.5 * f32((hash * 747796405u) >> 24u) / 256.0;
    let rgb = clamp(abs(fract(hue + vec3f(0.0, 2.0 / 3.0, 1.0 / 3.0)) * 6.0 - 3.0) - 1.0, vec3f(0.0), vec3f(1.0));
    let colour = lightness * mix(vec3f(1.0), rgb, 0.7);
    return highlighted(colour * colour * (0.6 + 0.4 * facing(v)), v.patch_index);
}

@fragment fn fs_normals(v: Plain) -> @location(0) vec4f {
    let coded = normalize(v.normal) * 0.5 + 0.5;
    return highlighted(coded * coded, v.patch_index);
}

@fragment fn fs_unlit(v: Plain) -> @location(0) vec4f {
    return vec4f(vec3f(0.02 + 0.09 * facing(v)), 1.0);
}

struct Line {
    @builtin(position) clip: vec4f,
    @location(0) light: vec3f,
    @location(1) towards_eye: f32,
}

@vertex fn vs_line(corner: Corner, @location(4) light: vec3f) -> Line {
    // A little nearer than the surface that it lies on (depth is reversed).
    var position = clip(corner.position);
    position.z *= 1.0005;
    return Line(position, light, dot(corner.normal, frame.eye - corner.position));
}

fn line(v: Line, colour: vec3f) -> vec4f {
    if v.towards_eye < 0.0 {
        discard;
    }
    return vec4f(colour, 0.5);
}

// Dark on bright surfaces and bright on dark ones.
@fragment fn fs_line_on_lit(v: Line) -> @location(0) vec4f {
    let shown = dot(tone_map(v.light * frame.exposure), vec3f(0.2126, 0.7152, 0.0722));
    return line(v, vec3f(select(0.35, 0.0, shown > 0.06)));
}

@fragment fn fs_line(v: Line) -> @location(0) vec4f {
    return line(v, vec3f(0.0));
}

// Panes of glass over what lies behind them: first dimmed, then with a sheen.
struct Pane {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) @interpolate(flat) normal: vec3f,
    @location(2) @interpolate(flat) tint: vec3f,
    @location(3) @interpolate(flat) sides: u32,
}

@vertex fn vs_pane(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tint: vec3f,
    @location(3) sides: u32,
) -> Pane {
    return Pane(clip(position), position, normal, tint, sides);
}

// Share that a pane of window glass mirrors (Fresnel 1823; both surfaces, all reflections between them).
fn mirrored(cosine: f32) -> f32 {
    const INDEX = 1.52;
    let inside = sqrt(1.0 - (1.0 - cosine * cosine) / (INDEX * INDEX));
    let s = (cosine - INDEX * inside) / (cosine + INDEX * inside);
    let p = (INDEX * cosine - inside) / (INDEX * cosine + inside);
    let surface = 0.5 * (s * s + p * p);
    return 2.0 * surface / (1.0 + surface);
}

// Cosine of the angle under which the eye sees it; below zero from a side on which it is not drawn.
fn seen(v: Pane) -> f32 {
    let cosine = dot(normalize(v.normal), normalize(frame.eye - v.position));
    let side = select(2u, 1u, cosine > 0.0);
    return select(-1.0, abs(cosine), (v.sides & side) != 0u);
}

@fragment fn fs_pane_dims(v: Pane) -> @location(0) vec4f {
    let cosine = seen(v);
    if cosine < 0.0 {
        discard;
    }
    return vec4f(v.tint * (1.0 - mirrored(cosine)) / (1.0 - mirrored(1.0)), 1.0);
}

// It mirrors surroundings that look middling grey whatever the exposure: a sheen, stronger where it slants.
@fragment fn fs_pane_shines(v: Pane) -> @location(0) vec4f {
    let cosine = seen(v);
    if cosine < 0.0 {
        discard;
    }
    return vec4f(tone_map(vec3f(MIDDLE_GREY * mirrored(cosine))), 0.0);
}
