use crate::display::{ColourMap, srgb_encode};
use crate::scene::Texture;
use rayon::prelude::*;
use std::sync::LazyLock;

/// One level of an image in linear light.
struct Level {
    size: [u32; 2],
    /// R, G, B, and opacity.
    pixels: Vec<[f32; 4]>,
}

/// Uploads an image with its mip levels as sRGB bytes. An image whose pixels do not fit its size
/// becomes a white one. Images beyond `largest` pixels an edge are halved until they fit.
pub(super) fn upload(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    image: &Texture,
    largest: u32,
) -> wgpu::TextureView {
    let levels = levels(image, largest);
    let size = levels[0].size;
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some(&image.name),
        size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
        mip_level_count: levels.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (index, level) in levels.iter().enumerate() {
        let texels: Vec<[u8; 4]> = level
            .pixels
            .par_iter()
            .with_min_len(4096)
            .map(|p| [srgb_byte(p[0]), srgb_byte(p[1]), srgb_byte(p[2]), (255.0 * p[3]).round() as u8])
            .collect();
        write_level(queue, &texture, index as u32, level.size, &texels);
    }
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// All colour maps, one a row in the order of [`ColourMap::ALL`].
pub(super) fn upload_colour_maps(device: &wgpu::Device, queue: &wgpu::Queue) -> wgpu::TextureView {
    let texels: Vec<[u8; 4]> = ColourMap::ALL.iter().flat_map(|map| map.table()).collect();
    let rows = ColourMap::ALL.len() as u32;
    let size = [texels.len() as u32 / rows, rows];
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("colour maps"),
        size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    write_level(queue, &texture, 0, size, &texels);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// The v coordinate of a map in the texture of [`upload_colour_maps`].
pub(super) fn colour_map_row(map: ColourMap) -> f32 {
    let row = ColourMap::ALL.iter().position(|&m| m == map).unwrap_or(0);
    (row as f32 + 0.5) / ColourMap::ALL.len() as f32
}

fn write_level(queue: &wgpu::Queue, texture: &wgpu::Texture, level: u32, size: [u32; 2], texels: &[[u8; 4]]) {
    queue.write_texture(
        wgpu::TexelCopyTextureInfo { mip_level: level, ..texture.as_image_copy() },
        bytemuck::cast_slice(texels),
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * size[0]), rows_per_image: None },
        wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
    );
}

fn levels(image: &Texture, largest: u32) -> Vec<Level> {
    let size = [image.width, image.height];
    let is_whole = size[0] > 0 && size[1] > 0 && image.pixels.len() == size[0] as usize * size[1] as usize;
    let first = if is_whole {
        let opacity = |index: usize| image.opacity.get(index).copied().unwrap_or(1.0);
        let pixels = image.pixels.iter().enumerate().map(|(at, &[r, g, b])| [r, g, b, opacity(at)]).collect();
        Level { size, pixels }
    } else {
        Level { size: [1, 1], pixels: vec![[1.0; 4]] }
    };
    let mut levels = vec![first];
    while let Some(last) = levels.last().filter(|level| level.size != [1, 1]) {
        let half = halved(last);
        if last.size[0].max(last.size[1]) > largest {
            levels.clear();
        }
        levels.push(half);
    }
    levels
}

/// Half the size, each pixel the mean of the four (or two) that it covers; an odd last row or
/// column goes to its neighbour's.
fn halved(level: &Level) -> Level {
    let [width, height] = level.size;
    let size = [(width / 2).max(1), (height / 2).max(1)];
    let pixels = (0..size[0] * size[1])
        .into_par_iter()
        .with_min_len(4096)
        .map(|index| {
            let (x, y) = (2 * (index % size[0]), 2 * (index / size[0]));
            // What is transparent has no colour, whatever the image says there.
            let (mut sum, mut opaque, mut all) = ([0.0; 3], [0.0; 3], 0.0);
            for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let at = (y + dy).min(height - 1) * width + (x + dx).min(width - 1);
                let [r, g, b, opacity] = level.pixels[at as usize];
                all += 0.25 * opacity;
                for (band, value) in [r, g, b].into_iter().enumerate() {
                    sum[band] += 0.25 * value;
                    opaque[band] += 0.25 * opacity * value;
                }
            }
            let [r, g, b] = if all > 0.0 && all < 1.0 { opaque.map(|value| value / all) } else { sum };
            [r, g, b, all]
        })
        .collect();
    Level { size, pixels }
}

fn srgb_byte(linear: f32) -> u8 {
    /// Fine enough everywhere: a step is a twentieth of a code at the dark end.
    static TABLE: LazyLock<Vec<u8>> = LazyLock::new(|| {
        (0..=u16::MAX).map(|x| (srgb_encode(f32::from(x) / 65_535.0) * 255.0).round() as u8).collect()
    });
    TABLE[(linear.clamp(0.0, 1.0) * 65_535.0).round() as usize]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, height: u32) -> Texture {
        let pixels = (0..width * height).map(|i| [i as f32 / (width * height) as f32; 3]).collect();
        Texture {
            name: "ramp".to_owned(),
            width,
            height,
            clamped: false,
            mean: [0.5; 3],
            pixels,
            opacity: Vec::new(),
        }
    }

    #[test]
    fn levels_halve_down_to_one_pixel_and_keep_the_mean() {
        let levels = levels(&image(8, 4), 4096);
        let sizes: Vec<_> = levels.iter().map(|level| level.size).collect();
        assert_eq!(sizes, [[8, 4], [4, 2], [2, 1], [1, 1]]);
        let mean = image(8, 4).pixels.iter().map(|p| p[0]).sum::<f32>() / 32.0;
        assert!((levels[3].pixels[0][0] - mean).abs() < 1e-6);
    }

    #[test]
    fn large_images_are_made_to_fit_and_broken_ones_are_white() {
        assert_eq!(levels(&image(9, 5), 4)[0].size, [4, 2]);
        let broken = Texture { pixels: Vec::new(), ..image(3, 3) };
        assert_eq!(levels(&broken, 4096)[0].pixels, [[1.0; 4]]);
    }

    #[test]
    fn bytes_come_back_as_they_were_read() {
        for code in 0..=255_u8 {
            assert_eq!(srgb_byte(crate::display::srgb_decode(f32::from(code) / 255.0)), code);
        }
        assert_eq!(srgb_byte(f32::NAN), 0);
    }
}
