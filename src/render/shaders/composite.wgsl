// The display-linear picture onto the window. Concatenated behind tone.wgsl.

override ENCODE_SRGB: bool = true; // false where the target does it by itself

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var picture_sampler: sampler;

struct Screen {
    @builtin(position) clip: vec4f,
    @location(0) uv: vec2f,
}

@vertex fn vs_composite(@builtin(vertex_index) index: u32) -> Screen {
    let uv = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return Screen(vec4f(uv * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0), 0.0, 1.0), uv);
}

@fragment fn fs_composite(v: Screen) -> @location(0) vec4f {
    let linear = clamp(textureSample(picture, picture_sampler, v.uv).rgb, vec3f(0.0), vec3f(1.0));
    if !ENCODE_SRGB {
        return vec4f(linear, 1.0);
    }
    // Half a code of noise (interleaved gradient noise, Jimenez 2014) breaks up bands on smooth walls.
    let noise = fract(52.9829189 * fract(dot(floor(v.clip.xy), vec2f(0.06711056, 0.00583715))));
    return vec4f(srgb_encode(linear) + (noise - 0.5) / 255.0, 1.0);
}
