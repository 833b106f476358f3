use super::pipelines::{DEPTH_FORMAT, PICTURE_FORMAT};

/// What the scene is drawn into before it is put onto the window.
pub(super) struct Target {
    pub(super) size_px: [u32; 2],
    pub(super) samples: u32,
    /// One sample a pixel: what is put onto the window.
    pub(super) picture: wgpu::TextureView,
    /// Where there are several samples, what is drawn into and then resolved to `picture`.
    pub(super) multisampled: Option<wgpu::TextureView>,
    pub(super) depth: wgpu::TextureView,
    /// The picture and its sampler for the composite pipeline.
    pub(super) bindings: wgpu::BindGroup,
}

impl Target {
    pub(super) fn new(
        device: &wgpu::Device,
        layout: &wgpu::BindGroupLayout,
        sampler: &wgpu::Sampler,
        size_px: [u32; 2],
        samples: u32,
    ) -> Self {
        let attachment = |label, format, samples, usage| {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: size_px[0], height: size_px[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        let none = wgpu::TextureUsages::empty();
        let picture = attachment("picture", PICTURE_FORMAT, 1, wgpu::TextureUsages::TEXTURE_BINDING);
        let multisampled =
            (samples > 1).then(|| attachment("multisampled picture", PICTURE_FORMAT, samples, none));
        let depth = attachment("depth", DEPTH_FORMAT, samples, none);
        let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("picture"),
            layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&picture) },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Sampler(sampler) },
            ],
        });
        Self { size_px, samples, picture, multisampled, depth, bindings }
    }
}
