//! The tone maps in WGSL against those in Rust, over eight decades.

use super::gpu::{Gpu, read_texture};
use super::pipelines::TONE;
use crate::display::{ToneMap, srgb_encode};

const WIDTH: u32 = 256;

const PROBE: &str = "
@group(0) @binding(0) var exposed: texture_2d<f32>;

@vertex fn vs(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32((index << 1u) & 2u), f32(index & 2u)) * 2.0 - 1.0, 0.0, 1.0);
}

@fragment fn fs(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let mapped = tone_map(textureLoad(exposed, vec2i(at.xy), 0).rgb);
    return vec4f(select(mapped, srgb_encode(mapped), at.y > 3.0), 1.0);
}
";

/// Greys, warm and cold colours from 1e-4 to 1e4, each tone-mapped alone and encoded as well.
fn probes() -> Vec<[f32; 4]> {
    let colours = [[1.0, 1.0, 1.0], [1.0, 0.4, 0.05], [0.02, 0.3, 1.0]];
    (0..6 * WIDTH)
        .map(|i| {
            let level = 10_f32.powf(8.0 * (i % WIDTH) as f32 / WIDTH as f32 - 4.0);
            let [r, g, b] = colours[(i / WIDTH) as usize % 3];
            [r * level, g * level, b * level, 1.0]
        })
        .collect()
}

fn run(gpu: &Gpu, index: usize, input: &[[f32; 4]]) -> Vec<[f32; 4]> {
    let Gpu { device, queue, .. } = gpu;
    let format = wgpu::TextureFormat::Rgba32Float;
    let texture = |usage| {
        device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: WIDTH, height: 6, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    };
    let exposed = texture(wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST);
    let mapped = texture(wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC);
    queue.write_texture(
        exposed.as_image_copy(),
        bytemuck::cast_slice(input),
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(16 * WIDTH), rows_per_image: None },
        exposed.size(),
    );
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl([TONE, PROBE].concat().into()),
    });
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vs"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fs"),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &[("TONE_MAP", index as f64)],
                ..Default::default()
            },
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: wgpu::BindingResource::TextureView(&exposed.create_view(&Default::default())),
        }],
    });
    let view = mapped.create_view(&Default::default());
    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations::default(),
            })],
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &bindings, &[]);
        pass.draw(0..3, 0..1);
    }
    queue.submit([encoder.finish()]);
    let bytes = read_texture(device, queue, &mapped).expect("readback");
    bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect()
}

#[test]
fn both_languages_map_tones_alike() {
    let gpu = match Gpu::headless() {
        Ok(gpu) => gpu,
        Err(error) => {
            assert!(std::env::var_os("LUMENWALK_REQUIRE_GPU").is_none(), "an adapter is required: {error}");
            eprintln!("skipped: {error}");
            return;
        }
    };
    let input = probes();
    for (index, map) in ToneMap::ALL.into_iter().enumerate() {
        for (pixel, (exposed, shown)) in input.iter().zip(run(&gpu, index, &input)).enumerate() {
            let mapped = map.apply([exposed[0], exposed[1], exposed[2]]);
            let is_encoded = pixel as u32 / WIDTH >= 3;
            let expected = if is_encoded { mapped.map(srgb_encode) } else { mapped };
            for band in 0..3 {
                let error = (shown[band] - expected[band]).abs();
                assert!(error < 2e-5, "{map:?} of {exposed:?}: {shown:?} and {expected:?}");
            }
        }
    }
}
