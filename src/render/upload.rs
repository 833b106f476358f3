use super::pipelines::{CornerVertex, PaneVertex};
use super::sky::{SkyBindings, UploadedSky};
use super::textures;
use crate::display::{Batch, DisplayMesh};
use crate::scene::{Outdoors, Texture};
use glam::DVec3;
use std::ops::Range;
use wgpu::util::DeviceExt as _;

/// Why a mesh cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UploadError {
    /// A buffer would be larger than the device allows.
    #[error(
        "the mesh needs a buffer of {needed} bytes and the graphics device allows {allowed}; use larger patches"
    )]
    TooLarge {
        /// Bytes of the largest buffer.
        needed: u64,
        /// What the device allows.
        allowed: u64,
    },
}

/// A mesh on the graphics card, to be drawn by the renderer whose uploader made it.
pub struct UploadedMesh {
    pub(super) origin: DVec3,
    pub(super) size: f64,
    pub(super) lit_corners: usize,
    pub(super) corners: wgpu::Buffer,
    pub(super) present: Values,
    pub(super) stored: Values,
    pub(super) indices: wgpu::Buffer,
    pub(super) batches: Vec<Batch>,
    pub(super) unlit: Range<u32>,
    pub(super) edges: wgpu::Buffer,
    pub(super) edge_indices: u32,
    /// Triangles of panes, and how many corners they have.
    pub(super) panes: wgpu::Buffer,
    pub(super) pane_corners: u32,
    /// One for each of the scene's textures.
    pub(super) textures: Vec<wgpu::BindGroup>,
    pub(super) sky: Option<UploadedSky>,
}

/// What colours the lit corners, one value a corner.
pub(super) struct Values {
    pub(super) light: wgpu::Buffer,
    pub(super) scalars: wgpu::Buffer,
}

impl Values {
    /// Dark: fresh buffers are zero.
    fn new(device: &wgpu::Device, corners: usize) -> Self {
        let empty = |label, bytes: usize| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: bytes.max(16) as u64,
                usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        Self {
            light: empty("light", size_of::<[f32; 3]>() * corners),
            scalars: empty("scalars", size_of::<f32>() * corners),
        }
    }
}

impl UploadedMesh {
    /// Writes values for the lit corners; those beyond are dropped.
    pub(super) fn write<T: bytemuck::NoUninit>(
        &self,
        queue: &wgpu::Queue,
        buffer: &wgpu::Buffer,
        values: &[T],
    ) {
        let values = &values[..values.len().min(self.lit_corners)];
        queue.write_buffer(buffer, 0, bytemuck::cast_slice(values));
    }
}

/// Brings meshes to the graphics card, from any thread: a large one with its textures takes longer than a
/// frame. Clones share one device.
#[derive(Clone)]
pub struct MeshUploader {
    device: wgpu::Device,
    queue: wgpu::Queue,
    texture_layout: wgpu::BindGroupLayout,
    /// Images repeated beyond their borders, and those whose borders go on.
    texture_samplers: [wgpu::Sampler; 2],
    sky: SkyBindings,
}

impl MeshUploader {
    pub(super) fn new(
        device: wgpu::Device,
        queue: wgpu::Queue,
        texture_layout: wgpu::BindGroupLayout,
        texture_samplers: [wgpu::Sampler; 2],
        sky: SkyBindings,
    ) -> Self {
        Self { device, queue, texture_layout, texture_samplers, sky }
    }

    /// Uploads a mesh with the scene's textures and its daylight.
    ///
    /// # Errors
    /// A buffer larger than the device allows.
    pub fn upload(
        &self,
        mesh: &DisplayMesh,
        textures: &[Texture],
        outdoors: Option<&Outdoors>,
    ) -> Result<UploadedMesh, UploadError> {
        let corners: Vec<CornerVertex> = mesh
            .corners
            .iter()
            .map(|c| CornerVertex {
                position: c.position.to_array(),
                normal: c.normal.to_array(),
                uv: c.uv.to_array(),
                patch: c.patch,
            })
            .collect();
        let needed = size_of_val(&*corners).max(size_of_val(&*mesh.indices)) as u64;
        let allowed = self.device.limits().max_buffer_size;
        if needed > allowed {
            return Err(UploadError::TooLarge { needed, allowed });
        }
        let buffer = |label, contents: &[u8], usage| {
            self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(label),
                contents,
                usage,
            })
        };
        let panes: Vec<PaneVertex> = mesh
            .panes
            .iter()
            .map(|c| PaneVertex {
                position: c.position.to_array(),
                normal: c.normal.to_array(),
                tint: c.tint,
                sides: c.sides,
            })
            .collect();
        let (vertex, index) = (wgpu::BufferUsages::VERTEX, wgpu::BufferUsages::INDEX);
        let largest = self.device.limits().max_texture_dimension_2d;
        Ok(UploadedMesh {
            origin: mesh.origin,
            size: mesh.size,
            lit_corners: mesh.lit_corners,
            corners: buffer("corners", bytemuck::cast_slice(&corners), vertex),
            present: Values::new(&self.device, mesh.lit_corners),
            stored: Values::new(&self.device, mesh.lit_corners),
            indices: buffer("triangles", bytemuck::cast_slice(&mesh.indices), index),
            batches: mesh.batches.clone(),
            unlit: mesh.unlit.clone(),
            edges: buffer("patch borders", bytemuck::cast_slice(&mesh.edges), index),
            edge_indices: 2 * mesh.edges.len() as u32,
            panes: buffer("panes", bytemuck::cast_slice(&panes), vertex),
            pane_corners: panes.len() as u32,
            textures: textures.iter().map(|image| self.texture_bindings(image, largest)).collect(),
            sky: outdoors.map(|outdoors| UploadedSky::new(&self.device, &self.queue, &self.sky, outdoors)),
        })
    }

    /// Uploads the daylight of another hour.
    pub fn sky(&self, outdoors: &Outdoors) -> UploadedSky {
        UploadedSky::new(&self.device, &self.queue, &self.sky, outdoors)
    }

    fn texture_bindings(&self, image: &Texture, largest: u32) -> wgpu::BindGroup {
        let view = textures::upload(&self.device, &self.queue, image, largest);
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("texture"),
            layout: &self.texture_layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view) },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::Sampler(
                        &self.texture_samplers[usize::from(image.clamped)],
                    ),
                },
            ],
        })
    }
}
