// The same formulae as in display/tone.rs; a test compares the two.

override TONE_MAP: u32 = 0u; // neutral, filmic, Reinhard, linear: the order of ToneMap::ALL

fn neutral(rgb: vec3f) -> vec3f {
    let start = 0.8 - 0.04;
    let smallest = min(rgb.r, min(rgb.g, rgb.b));
    let offset = select(0.04, smallest - 6.25 * smallest * smallest, smallest < 0.08);
    let colour = rgb - offset;
    let peak = max(colour.r, max(colour.g, colour.b));
    if peak < start {
        return colour;
    }
    let d = 1.0 - start;
    let new_peak = 1.0 - d * d / (peak + d - start);
    let g = 1.0 - 1.0 / (0.15 * (peak - new_peak) + 1.0);
    return mix(colour * (new_peak / peak), vec3f(new_peak), g);
}

fn filmic(rgb: vec3f) -> vec3f {
    let x = 0.6 * rgb;
    return (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14);
}

fn reinhard(rgb: vec3f) -> vec3f {
    let white = 4.0;
    let l = dot(rgb, vec3f(0.2126, 0.7152, 0.0722));
    return rgb * ((1.0 + l / (white * white)) / (1.0 + l));
}

fn tone_map(exposed: vec3f) -> vec3f {
    let rgb = clamp(exposed, vec3f(0.0), vec3f(1e6));
    var mapped = rgb;
    switch TONE_MAP {
        case 0u: { mapped = neutral(rgb); }
        case 1u: { mapped = filmic(rgb); }
        case 2u: { mapped = reinhard(rgb); }
        default: {}
    }
    return clamp(mapped, vec3f(0.0), vec3f(1.0));
}

fn srgb_encode(linear: vec3f) -> vec3f {
    let low = 12.92 * linear;
    let high = 1.055 * pow(linear, vec3f(1.0 / 2.4)) - 0.055;
    return select(high, low, linear <= vec3f(0.0031308));
}
