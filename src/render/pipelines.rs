use crate::display::ToneMap;
use std::collections::HashMap;

/// What surfaces are drawn into: display-linear, finer than eight bits.
pub(super) const PICTURE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Depth, reversed: one near, zero at infinity.
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Tone maps and the sRGB code; stands before the other shaders.
pub(super) const TONE: &str = include_str!("shaders/tone.wgsl");
const SCENE: &str = include_str!("shaders/scene.wgsl");
const COMPOSITE: &str = include_str!("shaders/composite.wgsl");

/// The uniform block `Frame` of scene.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct FrameUniform {
    pub(super) clip_from_local: [[f32; 4]; 4],
    pub(super) eye: [f32; 3],
    pub(super) exposure: f32,
    pub(super) highlight: u32,
    pub(super) scale: f32,
    pub(super) offset: f32,
    pub(super) logarithmic: u32,
    pub(super) map_row: f32,
    pub(super) padding: [u32; 3],
}

/// A corner in the static vertex buffer: `Corner` of scene.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct CornerVertex {
    pub(super) position: [f32; 3],
    pub(super) normal: [f32; 3],
    pub(super) uv: [f32; 2],
    pub(super) patch: u32,
}

/// A corner of a pane in its vertex buffer: the arguments of `vs_pane` of scene.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct PaneVertex {
    pub(super) position: [f32; 3],
    pub(super) normal: [f32; 3],
    pub(super) tint: [f32; 3],
    pub(super) sides: u32,
}

/// What a pipeline draws. All but those of panes read the static corners from slot 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Pass {
    /// Radiosities from slot 1.
    Plain,
    /// The same, multiplied with a texture.
    Textured,
    /// The same, and nothing where the texture is transparent.
    Perforated,
    /// Scalars from slot 1 through a colour map.
    FalseColour,
    /// A colour for each patch.
    PatchIds,
    /// Normals as colours.
    Normals,
    /// Sides without a patch.
    Unlit,
    /// Patch borders over radiosities from slot 1.
    LinesOnLit,
    /// Patch borders over anything else.
    Lines,
    /// Panes of glass, which dim what lies behind them.
    PaneDims,
    /// What panes mirror, on top.
    PaneShines,
}

impl Pass {
    fn entry_points(self) -> (&'static str, &'static str) {
        match self {
            Self::Plain => ("vs_lit", "fs_plain"),
            Self::Textured => ("vs_lit", "fs_textured"),
            Self::Perforated => ("vs_lit", "fs_perforated"),
            Self::FalseColour => ("vs_valued", "fs_false_colour"),
            Self::PatchIds => ("vs_static", "fs_patch_ids"),
            Self::Normals => ("vs_static", "fs_normals"),
            Self::Unlit => ("vs_static", "fs_unlit"),
            Self::LinesOnLit => ("vs_line", "fs_line_on_lit"),
            // The light in slot 1 is bound and not used.
            Self::Lines => ("vs_line", "fs_line"),
            Self::PaneDims => ("vs_pane", "fs_pane_dims"),
            Self::PaneShines => ("vs_pane", "fs_pane_shines"),
        }
    }

    fn is_lines(self) -> bool {
        matches!(self, Self::LinesOnLit | Self::Lines)
    }

    pub(super) fn is_pane(self) -> bool {
        matches!(self, Self::PaneDims | Self::PaneShines)
    }

    /// How it mixes with the picture so far; in place of it where it is `None`.
    fn blend(self) -> Option<wgpu::BlendState> {
        let both = |src_factor, dst_factor| {
            let part = wgpu::BlendComponent { src_factor, dst_factor, operation: wgpu::BlendOperation::Add };
            wgpu::BlendState { color: part, alpha: part }
        };
        match self {
            _ if self.is_lines() => Some(wgpu::BlendState::ALPHA_BLENDING),
            Self::PaneDims => Some(both(wgpu::BlendFactor::Zero, wgpu::BlendFactor::Src)),
            Self::PaneShines => Some(both(wgpu::BlendFactor::One, wgpu::BlendFactor::One)),
            _ => None,
        }
    }

    fn takes_light(self) -> bool {
        matches!(self, Self::Plain | Self::Textured | Self::Perforated) || self.is_lines()
    }
}

/// What tells one pipeline of the scene from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct SceneKey {
    pub(super) pass: Pass,
    pub(super) tone_map: ToneMap,
    /// Samples a pixel: 1 or 4.
    pub(super) samples: u32,
    /// Surfaces stand back a little from their borders, which are drawn over them.
    pub(super) stands_back: bool,
}

/// Pipelines, made when they are first needed.
pub(super) struct Pipelines {
    scene_module: wgpu::ShaderModule,
    composite_module: wgpu::ShaderModule,
    pub(super) frame_layout: wgpu::BindGroupLayout,
    pub(super) texture_layout: wgpu::BindGroupLayout,
    scene_layout: wgpu::PipelineLayout,
    textured_layout: wgpu::PipelineLayout,
    composite_layout: wgpu::PipelineLayout,
    scene: HashMap<SceneKey, wgpu::RenderPipeline>,
    composite: HashMap<wgpu::TextureFormat, wgpu::RenderPipeline>,
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        let module = |label, source: &str| {
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl([TONE, source].concat().into()),
            })
        };
        let frame_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("frame"),
            entries: &[
                wgpu::BindGroupLayoutEntry {
                    binding: 0,
                    visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
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
        let texture_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("texture"),
            entries: &[texture_entry(0), sampler_entry(1)],
        });
        let layout = |label, groups: &[Option<&wgpu::BindGroupLayout>]| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(label),
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        Self {
            scene_module: module("scene", SCENE),
            composite_module: module("composite", COMPOSITE),
            scene_layout: layout("scene", &[Some(&frame_layout)]),
            textured_layout: layout("textured", &[Some(&frame_layout), Some(&texture_layout)]),
            composite_layout: layout("composite", &[Some(&texture_layout)]),
            frame_layout,
            texture_layout,
            scene: HashMap::new(),
            composite: HashMap::new(),
        }
    }

    /// Makes a pipeline of the scene where it does not exist yet.
    pub(super) fn prepare_scene(&mut self, device: &wgpu::Device, key: SceneKey) {
        let is_textured = matches!(key.pass, Pass::Textured | Pass::Perforated);
        let layout = if is_textured { &self.textured_layout } else { &self.scene_layout };
        let module = &self.scene_module;
        self.scene.entry(key).or_insert_with(|| scene_pipeline(device, module, layout, key));
    }

    /// A pipeline that [`Pipelines::prepare_scene`] has made.
    pub(super) fn scene(&self, key: SceneKey) -> Option<&wgpu::RenderPipeline> {
        self.scene.get(&key)
    }

    /// Makes the pipeline that puts the picture onto a target of this format.
    pub(super) fn prepare_composite(&mut self, device: &wgpu::Device, format: wgpu::TextureFormat) {
        let (module, layout) = (&self.composite_module, &self.composite_layout);
        self.composite.entry(format).or_insert_with(|| {
            let encode = if format.is_srgb() { 0.0 } else { 1.0 };
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("composite"),
                layout: Some(layout),
                vertex: wgpu::VertexState {
                    module,
                    entry_point: Some("vs_composite"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module,
                    entry_point: Some("fs_composite"),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants: &[("ENCODE_SRGB", encode)],
                        ..Default::default()
                    },
                    targets: &[Some(format.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        });
    }

    /// The pipeline that [`Pipelines::prepare_composite`] has made for this format.
    pub(super) fn composite(&self, format: wgpu::TextureFormat) -> Option<&wgpu::RenderPipeline> {
        self.composite.get(&format)
    }
}

/// The value of `TONE_MAP` in tone.wgsl.
pub(super) fn tone_index(tone_map: ToneMap) -> f64 {
    ToneMap::ALL.iter().position(|&map| map == tone_map).unwrap_or(0) as f64
}

pub(super) fn texture_entry(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        count: None,
    }
}

pub(super) fn sampler_entry(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        count: None,
    }
}

fn scene_pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    key: SceneKey,
) -> wgpu::RenderPipeline {
    let pass = key.pass;
    let corner = wgpu::VertexBufferLayout {
        array_stride: size_of::<CornerVertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Uint32],
    };
    let light = wgpu::VertexBufferLayout {
        array_stride: size_of::<[f32; 3]>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![4 => Float32x3],
    };
    let scalar = wgpu::VertexBufferLayout {
        array_stride: size_of::<f32>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![5 => Float32],
    };
    let pane = wgpu::VertexBufferLayout {
        array_stride: size_of::<PaneVertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x3, 3 => Uint32],
    };
    let mut buffers = vec![Some(if pass.is_pane() { pane } else { corner })];
    let is_solid = !pass.is_lines() && !pass.is_pane();
    if pass.takes_light() {
        buffers.push(Some(light));
    } else if pass == Pass::FalseColour {
        buffers.push(Some(scalar));
    }
    let (vertex, fragment) = pass.entry_points();
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(fragment),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &buffers,
        },
        primitive: wgpu::PrimitiveState {
            topology: if pass.is_lines() {
                wgpu::PrimitiveTopology::LineList
            } else {
                wgpu::PrimitiveTopology::TriangleList
            },
            cull_mode: is_solid.then_some(wgpu::Face::Back),
            ..Default::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(is_solid),
            // Depth is reversed: nearer is greater.
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: wgpu::StencilState::default(),
            bias: if key.stands_back && is_solid {
                wgpu::DepthBiasState { constant: -4, slope_scale: -1.5, clamp: 0.0 }
            } else {
                wgpu::DepthBiasState::default()
            },
        }),
        multisample: wgpu::MultisampleState { count: key.samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(fragment),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &[("TONE_MAP", tone_index(key.tone_map))],
                ..Default::default()
            },
            targets: &[Some(wgpu::ColorTargetState {
                format: PICTURE_FORMAT,
                blend: pass.blend(),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Parses and validates a shader behind tone.wgsl like the browser would: no optional capability.
#[cfg(test)]
pub(super) fn validate(name: &str, source: &str) {
    use wgpu::naga::{front, valid};
    let source = [TONE, source].concat();
    let module = front::wgsl::parse_str(&source)
        .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(&source)));
    valid::Validator::new(valid::ValidationFlags::all(), valid::Capabilities::empty())
        .validate(&module)
        .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(&source)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shaders_are_valid() {
        validate("scene.wgsl", SCENE);
        validate("composite.wgsl", COMPOSITE);
    }

    #[test]
    fn every_entry_point_exists() {
        for pass in [
            Pass::Plain,
            Pass::Textured,
            Pass::Perforated,
            Pass::FalseColour,
            Pass::PatchIds,
            Pass::Normals,
            Pass::Unlit,
            Pass::LinesOnLit,
            Pass::Lines,
            Pass::PaneDims,
            Pass::PaneShines,
        ] {
            let (vertex, fragment) = pass.entry_points();
            assert!(SCENE.contains(&format!("@vertex fn {vertex}(")), "{vertex}");
            assert!(SCENE.contains(&format!("@fragment fn {fragment}(")), "{fragment}");
        }
    }
}
