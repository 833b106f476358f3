use super::frame::{ColourSource, FrameInput};
use super::gpu::{GpuError, read_texture};
use super::pipelines::{FrameUniform, Pass, Pipelines, SceneKey};
use super::sky::{SkyPipelines, UploadedSky};
use super::target::Target;
use super::textures;
use super::upload::{MeshUploader, UploadError, UploadedMesh, Values};
use crate::display::{DisplayMesh, SkyLight};
use crate::mesh::NO_PATCH;
use crate::scene::{Outdoors, Texture};
use glam::DVec3;

/// Draws a lit mesh with wgpu, into a panel of a window or into memory.
///
/// The mesh is uploaded once, the light whenever it changes; a camera move uploads a hundred
/// bytes. [`ViewportRenderer::prepare`] draws into a picture of its own, which
/// [`ViewportRenderer::paint`] puts onto the target: display-linear, so that edges are smoothed
/// after the tone map, where the eye sees them.
pub struct ViewportRenderer {
    pipelines: Pipelines,
    skies: SkyPipelines,
    target_format: wgpu::TextureFormat,
    frame_buffer: wgpu::Buffer,
    frame_bindings: wgpu::BindGroup,
    picture_sampler: wgpu::Sampler,
    texture_samplers: [wgpu::Sampler; 2],
    mesh: Option<UploadedMesh>,
    target: Option<Target>,
}

impl ViewportRenderer {
    /// For a window (or texture) of this format, with one sample a pixel and no depth buffer.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, target_format: wgpu::TextureFormat) -> Self {
        let mut pipelines = Pipelines::new(device);
        pipelines.prepare_composite(device, target_format);
        let sampler = |label, address, filter, mipmaps| {
            device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some(label),
                address_mode_u: address,
                address_mode_v: address,
                mag_filter: filter,
                min_filter: filter,
                mipmap_filter: mipmaps,
                ..Default::default()
            })
        };
        let (clamped, repeated) = (wgpu::AddressMode::ClampToEdge, wgpu::AddressMode::Repeat);
        let (nearest, linear) = (wgpu::FilterMode::Nearest, wgpu::FilterMode::Linear);
        let (one_level, levels) = (wgpu::MipmapFilterMode::Nearest, wgpu::MipmapFilterMode::Linear);
        // The picture has the pixels of the window: nothing to blend.
        let picture_sampler = sampler("picture", clamped, nearest, one_level);
        let map_sampler = sampler("colour maps", clamped, linear, one_level);
        let texture_samplers = [repeated, clamped].map(|address| sampler("texture", address, linear, levels));
        let frame_buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: size_of::<FrameUniform>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let colour_maps = textures::upload_colour_maps(device, queue);
        let frame_bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &pipelines.frame_layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: frame_buffer.as_entire_binding() },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::TextureView(&colour_maps),
                },
                wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::Sampler(&map_sampler) },
            ],
        });
        Self {
            skies: SkyPipelines::new(device, &pipelines.frame_layout),
            pipelines,
            target_format,
            frame_buffer,
            frame_bindings,
            picture_sampler,
            texture_samplers,
            mesh: None,
            target: None,
        }
    }

    /// What uploads meshes for this renderer, from any thread.
    pub fn uploader(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> MeshUploader {
        let (layout, samplers) = (self.pipelines.texture_layout.clone(), self.texture_samplers.clone());
        let sky = self.skies.bindings().clone();
        MeshUploader::new(device.clone(), queue.clone(), layout, samplers, sky)
    }

    /// Draws this mesh from now on; it is dark until light is set. Takes no time to speak of.
    pub fn adopt(&mut self, mesh: UploadedMesh) {
        self.mesh = Some(mesh);
    }

    /// Draws this sky behind the mesh from now on.
    pub fn adopt_sky(&mut self, sky: UploadedSky) {
        if let Some(mesh) = &mut self.mesh {
            mesh.sky = Some(sky);
        }
    }

    /// Uploads a mesh with the scene's textures and its daylight, and adopts it. On an error the mesh before it stays.
    ///
    /// # Errors
    /// As [`MeshUploader::upload`].
    pub fn set_mesh(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        mesh: &DisplayMesh,
        textures: &[Texture],
        outdoors: Option<&Outdoors>,
    ) -> Result<(), UploadError> {
        let uploaded = self.uploader(device, queue).upload(mesh, textures, outdoors)?;
        self.adopt(uploaded);
        Ok(())
    }

    /// Sets what [`ColourSource::Radiosity`] shows: `DisplayMesh::corner_radiosity` of the mesh
    /// that was set last. Values for corners that it does not have are dropped.
    pub fn set_light(&mut self, queue: &wgpu::Queue, corner_radiosity: &[[f32; 3]]) {
        if let Some(mesh) = &self.mesh {
            mesh.write(queue, &mesh.present.light, corner_radiosity);
        }
    }

    /// Sets what [`ColourSource::FalseColour`] shows: `DisplayMesh::corner_scalars`.
    pub fn set_scalars(&mut self, queue: &wgpu::Queue, corner_scalars: &[f32]) {
        if let Some(mesh) = &self.mesh {
            mesh.write(queue, &mesh.present.scalars, corner_scalars);
        }
    }

    /// As [`ViewportRenderer::set_light`], for the part left of [`FrameInput::split`].
    pub fn set_stored_light(&mut self, queue: &wgpu::Queue, corner_radiosity: &[[f32; 3]]) {
        if let Some(mesh) = &self.mesh {
            mesh.write(queue, &mesh.stored.light, corner_radiosity);
        }
    }

    /// As [`ViewportRenderer::set_scalars`], for the part left of [`FrameInput::split`].
    pub fn set_stored_scalars(&mut self, queue: &wgpu::Queue, corner_scalars: &[f32]) {
        if let Some(mesh) = &self.mesh {
            mesh.write(queue, &mesh.stored.scalars, corner_scalars);
        }
    }

    /// Draws a frame into the renderer's own picture. Submit the result before the pass that
    /// paints it; nothing is drawn twice in between.
    pub fn prepare(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        frame: &FrameInput,
    ) -> wgpu::CommandBuffer {
        let limit = device.limits().max_texture_dimension_2d;
        let size_px = frame.size_px.map(|n| n.clamp(1, limit));
        self.fit_target(device, size_px, samples(frame));
        self.make_ready(device, frame);
        let [surfaces, .., lines] = passes(frame);
        queue.write_buffer(&self.frame_buffer, 0, bytemuck::bytes_of(&self.frame_uniform(frame, size_px)));
        if let Some((sky, light)) = self.sky_of(frame) {
            sky.prepare(queue, frame, light, size_px, border(frame, size_px[0]));
            self.skies.prepare(device, frame.tone_map, samples(frame));
        }
        let mut encoder =
            device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("viewport") });
        self.draw(&mut encoder, frame, surfaces, lines);
        encoder.finish()
    }

    /// Makes the pipelines that frames like this one need, where they are not there yet: the first picture
    /// then comes sooner.
    pub fn make_ready(&mut self, device: &wgpu::Device, frame: &FrameInput) {
        let has_panes = self.mesh.as_ref().is_some_and(|mesh| mesh.pane_corners > 0);
        let panes = [Pass::PaneDims, Pass::PaneShines].into_iter().filter(|_| has_panes);
        for pass in passes(frame).into_iter().chain(panes) {
            self.pipelines.prepare_scene(device, scene_key(frame, pass));
        }
    }

    fn fit_target(&mut self, device: &wgpu::Device, size_px: [u32; 2], samples: u32) {
        let fits = |target: &Target| target.size_px == size_px && target.samples == samples;
        if !self.target.as_ref().is_some_and(fits) {
            let layout = &self.pipelines.texture_layout;
            self.target = Some(Target::new(device, layout, &self.picture_sampler, size_px, samples));
        }
    }

    /// The sky that a frame shows, and how strongly.
    fn sky_of(&self, frame: &FrameInput) -> Option<(&UploadedSky, SkyLight)> {
        let sky = self.mesh.as_ref()?.sky.as_ref()?;
        Some((sky, frame.sky.filter(|_| frame.source == ColourSource::Radiosity)?))
    }

    fn frame_uniform(&self, frame: &FrameInput, size_px: [u32; 2]) -> FrameUniform {
        let (origin, size) = self.mesh.as_ref().map_or((DVec3::ZERO, 1.0), |m| (m.origin, m.size));
        let near = (1e-4 * size).clamp(1e-6, 0.02);
        let clip = frame.camera.clip_from_local(origin, size_px, near).as_mat4();
        let (scale, map_row, logarithmic) = match frame.source {
            ColourSource::FalseColour(scale) => {
                (scale.coefficients(), textures::colour_map_row(scale.map), scale.logarithmic)
            }
            _ => ([1.0, 0.0], 0.0, false),
        };
        FrameUniform {
            clip_from_local: clip.to_cols_array_2d(),
            eye: (frame.camera.eye - origin).as_vec3().to_array(),
            exposure: frame.exposure.factor(),
            highlight: frame.highlight.unwrap_or(NO_PATCH),
            scale: scale[0] as f32,
            offset: scale[1] as f32,
            logarithmic: u32::from(logarithmic),
            map_row,
            padding: [0; 3],
        }
    }

    fn draw(&self, encoder: &mut wgpu::CommandEncoder, frame: &FrameInput, surfaces: Pass, lines: Pass) {
        let Some(target) = &self.target else { return };
        let [r, g, b] = frame.background.map(|x| f64::from(x.clamp(0.0, 1.0)));
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("scene"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target.multisampled.as_ref().unwrap_or(&target.picture),
                depth_slice: None,
                resolve_target: target.multisampled.as_ref().map(|_| &target.picture),
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 }),
                    store: if target.multisampled.is_some() {
                        wgpu::StoreOp::Discard
                    } else {
                        wgpu::StoreOp::Store
                    },
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &target.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        let Some(mesh) = &self.mesh else { return };
        pass.set_bind_group(0, &self.frame_bindings, &[]);
        let [width, height] = target.size_px;
        let border = border(frame, width);
        for (values, left, right) in [(&mesh.stored, 0, border), (&mesh.present, border, width)] {
            if left < right {
                pass.set_scissor_rect(left, 0, right - left, height);
                self.draw_mesh(&mut pass, frame, mesh, values, surfaces, lines);
            }
        }
    }

    fn draw_mesh(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        frame: &FrameInput,
        mesh: &UploadedMesh,
        values: &Values,
        surfaces: Pass,
        lines: Pass,
    ) {
        let select = |pass: &mut wgpu::RenderPass<'_>, kind: Pass| {
            if let Some(pipeline) = self.pipelines.scene(scene_key(frame, kind)) {
                pass.set_pipeline(pipeline);
            }
        };
        pass.set_vertex_buffer(0, mesh.corners.slice(..));
        let coloured = if surfaces == Pass::FalseColour { &values.scalars } else { &values.light };
        pass.set_vertex_buffer(1, coloured.slice(..));
        pass.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
        for batch in &mesh.batches {
            let bindings = batch.texture.and_then(|t| mesh.textures.get(t as usize));
            match bindings.filter(|_| surfaces == Pass::Plain) {
                Some(bindings) => {
                    select(pass, if batch.has_holes { Pass::Perforated } else { Pass::Textured });
                    pass.set_bind_group(1, bindings, &[]);
                }
                None => select(pass, surfaces),
            }
            pass.draw_indexed(batch.indices.clone(), 0, 0..1);
        }
        if frame.show_unlit && !mesh.unlit.is_empty() {
            select(pass, Pass::Unlit);
            pass.draw_indexed(mesh.unlit.clone(), 0, 0..1);
        }
        // Behind surfaces, and before lines that reach over their edges.
        if let Some((sky, _)) = self.sky_of(frame) {
            self.skies.draw(pass, sky, (frame.tone_map, samples(frame)));
        }
        if mesh.pane_corners > 0 && frame.source == ColourSource::Radiosity {
            pass.set_vertex_buffer(0, mesh.panes.slice(..));
            for kind in [Pass::PaneDims, Pass::PaneShines] {
                select(pass, kind);
                pass.draw(0..mesh.pane_corners, 0..1);
            }
            pass.set_vertex_buffer(0, mesh.corners.slice(..));
        }
        if frame.wireframe && mesh.edge_indices > 0 {
            select(pass, lines);
            pass.set_vertex_buffer(1, values.light.slice(..));
            pass.set_index_buffer(mesh.edges.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..mesh.edge_indices, 0, 0..1);
        }
    }

    /// Puts the prepared picture onto the whole viewport of `pass`, encoded for its format, with
    /// half a code of dither, pixel by pixel: both should have the size of the frame. Draws nothing before the first [`ViewportRenderer::prepare`].
    pub fn paint(&self, pass: &mut wgpu::RenderPass<'_>) {
        self.paint_as(pass, self.target_format);
    }

    fn paint_as(&self, pass: &mut wgpu::RenderPass<'_>, format: wgpu::TextureFormat) {
        if let (Some(target), Some(pipeline)) = (&self.target, self.pipelines.composite(format)) {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &target.bindings, &[]);
            pass.draw(0..3, 0..1);
        }
    }

    /// Draws a frame and reads it back as sRGB bytes R, G, B, 255, row by row from the top. Blocks.
    pub fn capture(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        frame: &FrameInput,
    ) -> Result<Vec<u8>, GpuError> {
        const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
        let scene = self.prepare(device, queue, frame);
        self.pipelines.prepare_composite(device, FORMAT);
        let [width, height] = self.target.as_ref().map_or([1, 1], |target| target.size_px);
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("capture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder =
            device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("capture") });
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("capture"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..Default::default()
            });
            self.paint_as(&mut pass, FORMAT);
        }
        queue.submit([scene, encoder.finish()]);
        read_texture(device, queue, &texture)
    }
}

/// Where the present light begins, pixels from the left.
fn border(frame: &FrameInput, width: u32) -> u32 {
    frame.split.map_or(0, |split| (split.clamp(0.0, 1.0) * width as f32).round() as u32)
}

fn samples(frame: &FrameInput) -> u32 {
    if frame.multisample { 4 } else { 1 }
}

/// What a frame is drawn in: surfaces with patches first, lines last.
fn passes(frame: &FrameInput) -> [Pass; 5] {
    let surfaces = match frame.source {
        ColourSource::Radiosity => Pass::Plain,
        ColourSource::FalseColour(_) => Pass::FalseColour,
        ColourSource::PatchIds => Pass::PatchIds,
        ColourSource::Normals => Pass::Normals,
    };
    let lines = if surfaces == Pass::Plain { Pass::LinesOnLit } else { Pass::Lines };
    [surfaces, Pass::Textured, Pass::Perforated, Pass::Unlit, lines]
}

fn scene_key(frame: &FrameInput, pass: Pass) -> SceneKey {
    SceneKey { pass, tone_map: frame.tone_map, samples: samples(frame), stands_back: frame.wireframe }
}
