use super::{Pick, Picker};
use crate::display::{DisplayMesh, Exposure, MIDDLE_GREY, SkyView, ToneMap, srgb_encode};
use crate::mesh::NO_PATCH;
use crate::navigation::Camera;
use crate::scene::Texture;
use glam::{DVec2, Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::PI;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// What a still shows: the mesh that the viewport draws, and its corner values.
#[derive(Clone, Copy, Debug)]
pub struct StillInput<'a> {
    /// Triangles and their textures.
    pub mesh: &'a DisplayMesh,
    /// Of the same patch mesh.
    pub picker: &'a Picker,
    /// The scene's.
    pub textures: &'a [Texture],
    /// [`DisplayMesh::corner_radiosity`], one a lit corner.
    pub corner_radiosity: &'a [[f32; 3]],
    /// [`DisplayMesh::corner_values`] of the irradiances, one a lit corner.
    pub corner_irradiance: &'a [[f32; 3]],
    /// What is seen where there is no surface; the background of the options where it is `None`.
    pub sky: Option<SkyView<'a>>,
}

/// How a still is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StillOptions {
    /// Pixels across and down; at least one each.
    pub size_px: [u32; 2],
    /// Rays along each edge of a pixel: 2 casts four of them.
    pub samples: u32,
    /// Brightness of [`Still::display`].
    pub exposure: Exposure,
    /// Tone map of [`Still::display`].
    pub tone_map: ToneMap,
    /// Factors per band of [`Still::display`], above zero: eyes that have adapted to the lamps.
    pub gains: [f32; 3],
    /// Display-linear colour where there is neither a surface nor a sky, 0..1.
    pub background: [f32; 3],
}

impl StillOptions {
    /// Four rays a pixel over a black background, for eyes adapted to white.
    pub fn new(size_px: [u32; 2], exposure: Exposure, tone_map: ToneMap) -> Self {
        Self { size_px, samples: 2, exposure, tone_map, gains: [1.0; 3], background: [0.0; 3] }
    }
}

/// A picture with its layers, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Still {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Radiance averaged over the pixel, W/(m² sr) per band: B / pi of surfaces, and that of sky, ground and
    /// sun where there is none. A background counts as zero.
    pub radiance: Vec<[f32; 3]>,
    /// Share of the pixel that shows a surface, 0..1. A sky is none: with this as its alpha a picture can be
    /// put before another one.
    pub coverage: Vec<f32>,
    /// Exposed, tone-mapped, then averaged: display-linear 0..1, background included.
    pub display: Vec<[f32; 3]>,
    /// Irradiance at the pixel's centre, W/m² per band; zero where there is no surface.
    pub irradiance: Vec<[f32; 3]>,
    /// Patch at the pixel's centre, or [`NO_PATCH`].
    pub patch_id: Vec<u32>,
    /// Shading normal at the pixel's centre in world space; zero where there is no surface.
    pub normal: Vec<[f32; 3]>,
    /// Distance along the view axis at the pixel's centre, metres; zero where there is no surface.
    pub depth: Vec<f32>,
}

impl Still {
    /// The display layer as sRGB bytes R, G, B, 255.
    pub fn to_rgba8(&self) -> Vec<u8> {
        let byte = |linear: f32| (srgb_encode(linear.clamp(0.0, 1.0)) * 255.0).round() as u8;
        self.display.iter().flat_map(|rgb| [byte(rgb[0]), byte(rgb[1]), byte(rgb[2]), 255]).collect()
    }
}

/// One pixel of every layer.
#[derive(Clone, Copy)]
struct Pixel {
    radiance: [f32; 3],
    coverage: f32,
    display: [f32; 3],
    irradiance: [f32; 3],
    patch_id: u32,
    normal: [f32; 3],
    depth: f32,
}

/// Takes a still by casting rays, row by row on rayon's threads. The result does not depend on
/// their number.
///
/// `progress` is told the share done after each row, 0 to 1, from several threads; when it
/// returns false the still is given up and `None` comes back.
pub fn render_still(
    input: &StillInput<'_>,
    camera: &Camera,
    options: &StillOptions,
    progress: &(dyn Fn(f32) -> bool + Sync),
) -> Option<Still> {
    let [width, height] = options.size_px.map(|n| n.max(1));
    let (rows_done, cancelled) = (AtomicU32::new(0), AtomicBool::new(false));
    let rows: Vec<Vec<Pixel>> = (0..height)
        .into_par_iter()
        .map(|y| {
            if cancelled.load(Ordering::Relaxed) {
                return Vec::new();
            }
            let row =
                (0..width).map(|x| input.pixel(camera, options, DVec2::new(x.into(), y.into()))).collect();
            let done = rows_done.fetch_add(1, Ordering::Relaxed) + 1;
            if !progress(done as f32 / height as f32) {
                cancelled.store(true, Ordering::Relaxed);
            }
            row
        })
        .collect();
    if cancelled.into_inner() {
        return None;
    }
    let pixels = rows.concat();
    Some(Still {
        width,
        height,
        radiance: pixels.iter().map(|p| p.radiance).collect(),
        coverage: pixels.iter().map(|p| p.coverage).collect(),
        display: pixels.iter().map(|p| p.display).collect(),
        irradiance: pixels.iter().map(|p| p.irradiance).collect(),
        patch_id: pixels.iter().map(|p| p.patch_id).collect(),
        normal: pixels.iter().map(|p| p.normal).collect(),
        depth: pixels.iter().map(|p| p.depth).collect(),
    })
}

impl StillInput<'_> {
    fn pixel(&self, camera: &Camera, options: &StillOptions, corner: DVec2) -> Pixel {
        let size_px = options.size_px.map(|n| n.max(1));
        let samples = options.samples.max(1);
        let share = 1.0 / (samples * samples) as f32;
        let mut pixel = self.centre(camera, camera.ray(corner + 0.5, size_px));
        let factors = options.gains.map(|gain| gain * options.exposure.factor());
        for sample in 0..samples * samples {
            let at = DVec2::new((sample % samples).into(), (sample / samples).into()) + 0.5;
            let ray = camera.ray(corner + at / f64::from(samples), size_px);
            let (behind, distance) = match (self.seen(&ray), self.sky) {
                (Some(pick), _) => {
                    pixel.coverage += share;
                    (self.radiosity(&pick), pick.distance)
                }
                (None, Some(sky)) => (sky.radiosity(ray.direction), f64::INFINITY),
                (None, None) => {
                    add(&mut pixel.display, options.background, share);
                    continue;
                }
            };
            let glass = self.picker.glass();
            let passed = glass.along(ray.origin, ray.direction, [0.0, distance]);
            let radiosity: [f32; 3] = std::array::from_fn(|b| behind[b] * passed[b] as f32);
            add(&mut pixel.radiance, radiosity, share / PI);
            // As in the window: what a pane mirrors looks middling grey.
            let sheen =
                MIDDLE_GREY as f32 * glass.mirrored(ray.origin, ray.direction, [0.0, distance]) as f32;
            let exposed = std::array::from_fn(|b| radiosity[b] * factors[b] + sheen);
            add(&mut pixel.display, options.tone_map.apply(exposed), share);
        }
        pixel
    }

    /// The layers that cannot be averaged, and zeros in the others.
    fn centre(&self, camera: &Camera, ray: crate::geometry::Ray) -> Pixel {
        let mut pixel = Pixel {
            radiance: [0.0; 3],
            coverage: 0.0,
            display: [0.0; 3],
            irradiance: [0.0; 3],
            patch_id: NO_PATCH,
            normal: [0.0; 3],
            depth: 0.0,
        };
        if let Some(pick) = self.seen(&ray) {
            let (corners, weights, _) = self.corners(&pick);
            let normal: Vec3 = corners
                .iter()
                .zip(weights)
                .filter_map(|(&c, w)| Some(self.mesh.corners.get(c as usize)?.normal * w))
                .sum();
            pixel.irradiance = interpolate(self.corner_irradiance, corners, weights);
            pixel.patch_id = pick.patch.unwrap_or(NO_PATCH);
            pixel.normal = normal.normalize_or(pick.normal.as_vec3()).to_array();
            pixel.depth = (pick.position - camera.eye).dot(camera.axes()[2]) as f32;
        }
        pixel
    }

    /// What a ray meets that is there: not the holes of an image.
    fn seen(&self, ray: &crate::geometry::Ray) -> Option<Pick> {
        /// Through more surfaces with holes nobody looks.
        const MOST: usize = 256;
        let mut pick = self.picker.pick(ray)?;
        for _ in 0..MOST {
            if !self.is_hole(&pick) {
                break;
            }
            pick = self.picker.pick_beyond(ray, pick.distance * (1.0 + 1e-9) + 1e-9)?;
        }
        Some(pick)
    }

    fn is_hole(&self, pick: &Pick) -> bool {
        let holes = pick.patch.and_then(|patch| self.mesh.holes_of(patch));
        holes.and_then(|texture| self.textures.get(texture as usize)).is_some_and(|texture| {
            let (corners, weights, _) = self.corners(pick);
            texture.opacity_at(self.uv(corners, weights).as_dvec2()) < 0.5
        })
    }

    /// Texture coordinates between corners.
    fn uv(&self, corners: [u32; 3], weights: [f32; 3]) -> Vec2 {
        let uv: Vec2 = corners
            .iter()
            .zip(weights)
            .filter_map(|(&c, w)| Some(self.mesh.corners.get(c as usize)?.uv * w))
            .sum();
        // A sum of huge coordinates may overflow.
        if uv.is_finite() { uv } else { Vec2::ZERO }
    }

    fn corners(&self, pick: &Pick) -> ([u32; 3], [f32; 3], Option<u32>) {
        let [u, v] = pick.barycentric;
        self.mesh.place(pick.triangle, pick.side, [1.0 - u - v, u, v])
    }

    fn radiosity(&self, pick: &Pick) -> [f32; 3] {
        let (corners, weights, texture) = self.corners(pick);
        let value = interpolate(self.corner_radiosity, corners, weights);
        let Some(texture) = texture.and_then(|t| self.textures.get(t as usize)) else { return value };
        let texel = texture.sample(self.uv(corners, weights).as_dvec2());
        std::array::from_fn(|b| value[b] * texel[b])
    }
}

fn add(sum: &mut [f32; 3], rgb: [f32; 3], weight: f32) {
    for band in 0..3 {
        sum[band] += weight * rgb[band];
    }
}

fn interpolate(values: &[[f32; 3]], corners: [u32; 3], weights: [f32; 3]) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for (corner, weight) in corners.into_iter().zip(weights) {
        add(&mut sum, values.get(corner as usize).copied().unwrap_or_default(), weight);
    }
    // Weights reach a rounding error below zero at edges.
    sum.map(|x| x.max(0.0))
}
