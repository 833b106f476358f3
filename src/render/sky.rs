use super::frame::FrameInput;
use super::pipelines::{DEPTH_FORMAT, PICTURE_FORMAT, TONE, sampler_entry, texture_entry, tone_index};
use crate::display::{Panorama, SkyLight, ToneMap};
use crate::scene::Outdoors;
use half::f16;
use std::collections::HashMap;

const SKY: &str = include_str!("shaders/sky.wgsl");

/// One band: the lamps bring the colours. Can be filtered on every adapter.
const MAP_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;

/// The uniform block `Sky` of sky.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct SkyUniform {
    right: [f32; 3],
    width: f32,
    up: [f32; 3],
    height: f32,
    forward: [f32; 3],
    border: f32,
    sun: [f32; 3],
    chord: f32,
    sky: [[f32; 4]; 2],
    disc: [[f32; 4]; 2],
    ground: f32,
    padding: [u32; 3],
}

/// Pipelines for skies, made when they are first needed.
pub(super) struct SkyPipelines {
    module: wgpu::ShaderModule,
    bindings: SkyBindings,
    layout: wgpu::PipelineLayout,
    pipelines: HashMap<(ToneMap, u32), wgpu::RenderPipeline>,
}

/// What a sky is bound by. Clones share one layout.
#[derive(Clone)]
pub(super) struct SkyBindings {
    layout: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
}

impl SkyPipelines {
    /// Behind a scene whose first bind group is of `frame_layout`, so that it can stay bound.
    pub(super) fn new(device: &wgpu::Device, frame_layout: &wgpu::BindGroupLayout) -> Self {
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("sky"),
            entries: &[
                wgpu::BindGroupLayoutEntry {
                    binding: 0,
                    visibility: wgpu::ShaderStages::FRAGMENT,
                    ty: wgpu::BindingType::Buffer {
                        ty: wgpu::BufferBindingType::Uniform,
                        has_dynamic_offset: false,
                        min_binding_size: None,
                    },
                    count: None,
                },
                texture_entry(1),
                sampler_entry(2),
            ],
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("sky"),
            // Once around, and from the horizon to the zenith.
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::ClampToEdge,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        Self {
            module: device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("sky"),
                source: wgpu::ShaderSource::Wgsl([TONE, SKY].concat().into()),
            }),
            layout: device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("sky"),
                bind_group_layouts: &[Some(frame_layout), Some(&layout)],
                immediate_size: 0,
            }),
            bindings: SkyBindings { layout, sampler },
            pipelines: HashMap::new(),
        }
    }

    pub(super) fn bindings(&self) -> &SkyBindings {
        &self.bindings
    }

    /// Makes the pipeline for so many samples a pixel where it does not exist yet.
    pub(super) fn prepare(&mut self, device: &wgpu::Device, tone_map: ToneMap, samples: u32) {
        let (module, layout) = (&self.module, &self.layout);
        self.pipelines.entry((tone_map, samples)).or_insert_with(|| {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("sky"),
                layout: Some(layout),
                vertex: wgpu::VertexState {
                    module,
                    entry_point: Some("vs_sky"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: DEPTH_FORMAT,
                    depth_write_enabled: Some(false),
                    // Only where nothing has been drawn.
                    depth_compare: Some(wgpu::CompareFunction::GreaterEqual),
                    stencil: wgpu::StencilState::default(),
                    bias: wgpu::DepthBiasState::default(),
                }),
                multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
                fragment: Some(wgpu::FragmentState {
                    module,
                    entry_point: Some("fs_sky"),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants: &[("TONE_MAP", tone_index(tone_map))],
                        ..Default::default()
                    },
                    targets: &[Some(PICTURE_FORMAT.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        });
    }

    /// Draws a sky that has been [prepared](UploadedSky::prepare) wherever there is no surface yet. The bind
    /// group of the frame stays.
    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, sky: &UploadedSky, key: (ToneMap, u32)) {
        if let Some(pipeline) = self.pipelines.get(&key) {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(1, &sky.bindings, &[]);
            pass.draw(0..3, 0..1);
        }
    }
}

/// The daylight of a scene on the graphics card.
pub struct UploadedSky {
    panorama: Panorama,
    uniform: wgpu::Buffer,
    bindings: wgpu::BindGroup,
}

impl UploadedSky {
    pub(super) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        bindings: &SkyBindings,
        outdoors: &Outdoors,
    ) -> Self {
        let panorama = Panorama::new(outdoors);
        let (columns, rows) = (Panorama::COLUMNS as u32, Panorama::ROWS as u32);
        let map = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("sky"),
            size: wgpu::Extent3d { width: columns, height: rows, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: MAP_FORMAT,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        // A unit of the lamp makes these near one, far from the ends of half precision.
        let texels: Vec<u16> =
            panorama.sky().iter().map(|&x| f16::from_f32(x.min(f16::MAX.to_f32())).to_bits()).collect();
        queue.write_texture(
            map.as_image_copy(),
            bytemuck::cast_slice(&texels),
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(2 * columns), rows_per_image: None },
            map.size(),
        );
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("sky"),
            size: size_of::<SkyUniform>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let view = map.create_view(&wgpu::TextureViewDescriptor::default());
        let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("sky"),
            layout: &bindings.layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&view) },
                wgpu::BindGroupEntry {
                    binding: 2,
                    resource: wgpu::BindingResource::Sampler(&bindings.sampler),
                },
            ],
        });
        Self { panorama, uniform, bindings }
    }

    /// Readies it for a frame of this size whose light left of `border`, pixels, is the stored one.
    pub(super) fn prepare(
        &self,
        queue: &wgpu::Queue,
        frame: &FrameInput,
        light: SkyLight,
        size_px: [u32; 2],
        border: u32,
    ) {
        let axes = frame.camera.image_plane(size_px);
        let [right, up, forward] = axes.map(|axis| self.panorama.to_sky(axis).as_vec3().to_array());
        let (sun, chord) = self.panorama.sun().unwrap_or((glam::DVec3::Z, -1.0));
        let lights = [light, frame.stored_sky.unwrap_or(light)];
        let exposed = |bands: [f32; 3], factor: f32| {
            let [r, g, b] = bands.map(|watts| watts * factor * frame.exposure.factor());
            [r, g, b, 0.0]
        };
        let of_disc = (chord * chord).recip() as f32;
        let uniform = SkyUniform {
            right,
            width: size_px[0] as f32,
            up,
            height: size_px[1] as f32,
            forward,
            border: border as f32,
            sun: sun.as_vec3().to_array(),
            chord: chord as f32,
            sky: lights.map(|light| exposed(light.sky, 1.0)),
            disc: lights.map(|light| exposed(light.sun, of_disc)),
            ground: self.panorama.ground(),
            padding: [0; 3],
        };
        queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::pipelines::validate;

    #[test]
    fn the_shader_is_valid() {
        validate("sky.wgsl", SKY);
    }
}
