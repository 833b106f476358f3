// Sky, ground and sun where there is no surface. Concatenated behind tone.wgsl.

struct Sky {
    right: vec3f,   // what the picture spans at distance 1, half of it each way; x east, y north, z up
    width: f32,     // of the picture, pixels
    up: vec3f,
    height: f32,
    forward: vec3f, // unit
    border: f32,    // pixels left of it show the stored light
    sun: vec3f,     // unit
    chord: f32,     // from the middle of the disc to its edge; below zero without a sun
    sky: array<vec4f, 2>,  // exposed, per unit of the map: present light, stored light
    disc: array<vec4f, 2>, // exposed, on top of the sky
    ground: f32,    // as the map has the sky
}

@group(1) @binding(0) var<uniform> sky: Sky;
@group(1) @binding(1) var sky_map: texture_2d<f32>;
@group(1) @binding(2) var sky_sampler: sampler;

const TAU = 6.283185307;

@vertex fn vs_sky(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    // Depth is reversed: zero lies behind everything.
    return vec4f(vec2f(f32((index << 1u) & 2u), f32(index & 2u)) * 2.0 - 1.0, 0.0, 1.0);
}

// From north clockwise, and from the horizon (centres of the first texels) to the zenith (of the last ones).
fn map_place(direction: vec3f) -> vec2f {
    let rows = f32(textureDimensions(sky_map).y);
    let across = length(direction.xy);
    // Straight up there is no azimuth, and all texels are alike.
    let azimuth = atan2(select(0.0, direction.x, across > 1e-6), select(1.0, direction.y, across > 1e-6));
    let elevation = atan2(max(direction.z, 0.0), max(across, 1e-6));
    return vec2f(azimuth / TAU, (elevation * 4.0 / TAU * (rows - 1.0) + 0.5) / rows);
}

// How far inside an edge, in pixels across it, as a share of the pixel.
fn share_inside(distance: f32, across: f32, down: f32) -> f32 {
    return clamp(distance / max(length(vec2f(across, down)), 1e-9) + 0.5, 0.0, 1.0);
}

@fragment fn fs_sky(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let x = 2.0 * at.x / sky.width - 1.0;
    let y = 1.0 - 2.0 * at.y / sky.height;
    let direction = normalize(sky.forward + x * sky.right + y * sky.up);
    let from_sun = length(direction - sky.sun);
    let above = share_inside(direction.z, dpdx(direction.z), dpdy(direction.z));
    let in_disc = share_inside(sky.chord - from_sun, dpdx(from_sun), dpdy(from_sun));

    let side = select(0u, 1u, at.x < sky.border);
    let relative = textureSampleLevel(sky_map, sky_sampler, map_place(direction), 0.0).r;
    let sky_light = relative * sky.sky[side].rgb;
    // Edges are smoothed after the tone map, where the eye sees them.
    let without_sun = tone_map(sky_light);
    let with_sun = tone_map(sky_light + sky.disc[side].rgb);
    let ground = tone_map(sky.ground * sky.sky[side].rgb);
    return vec4f(mix(ground, mix(without_sun, with_sun, in_disc), above), 1.0);
}
