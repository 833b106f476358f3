//! The picture inside the window: hands frames to the renderer, and draws none twice.

use super::frame_clock::DrawTime;
use super::recovery::{Trouble, Troubles};
use super::state::DisplaySettings;
use crate::navigation::Camera;
use crate::render::{FrameInput, MeshUploader, ViewportRenderer};
use eframe::egui_wgpu::{self, CallbackResources, RenderState};
use glam::DVec3;

/// What lives on the graphics card between frames.
struct Resources {
    renderer: ViewportRenderer,
    /// Counts uploads: a frame drawn before one is out of date.
    generation: u64,
    drawn: Option<(FrameInput, u64)>,
}

/// The way to the graphics card.
#[derive(Clone)]
pub(super) struct Viewport {
    state: RenderState,
    software: bool,
    drawing: DrawTime,
    uploader: MeshUploader,
    troubles: Troubles,
}

impl Viewport {
    /// Readies the drawing, which `drawing` counts from now on, for pictures of this display.
    pub(super) fn new(
        state: RenderState,
        display: &DisplaySettings,
        drawing: DrawTime,
        ctx: &egui::Context,
    ) -> Self {
        let troubles = Troubles::of(&state.device, ctx);
        let mut renderer = ViewportRenderer::new(&state.device, &state.queue, state.target_format);
        let uploader = renderer.uploader(&state.device, &state.queue);
        let software = state.adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        let camera = Camera { eye: DVec3::ZERO, forward: DVec3::X, up: DVec3::Z, fov_y_deg: 60.0 };
        let first = FrameInput {
            tone_map: display.tone_map,
            wireframe: display.wireframe,
            multisample: !software,
            ..FrameInput::new(camera, [1, 1])
        };
        renderer.make_ready(&state.device, &first);
        let resources = Resources { renderer, generation: 0, drawn: None };
        state.renderer.write().callback_resources.insert(resources);
        Self { state, software, drawing, uploader, troubles }
    }

    /// What the driver has complained of since the last look.
    pub(super) fn trouble(&self) -> Option<Trouble> {
        self.troubles.take()
    }

    /// What brings meshes to the graphics card, on any thread.
    pub(super) fn uploader(&self) -> MeshUploader {
        self.uploader.clone()
    }

    /// Whether the adapter is the processor itself: then edges are smoothed only at rest.
    pub(super) fn is_software(&self) -> bool {
        self.software
    }

    /// Runs an upload and marks what was drawn as out of date.
    pub(super) fn upload<T>(
        &self,
        with: impl FnOnce(&mut ViewportRenderer, &wgpu::Device, &wgpu::Queue) -> T,
    ) -> Option<T> {
        let mut egui_renderer = self.state.renderer.write();
        let resources: &mut Resources = egui_renderer.callback_resources.get_mut()?;
        resources.generation += 1;
        Some(with(&mut resources.renderer, &self.state.device, &self.state.queue))
    }

    /// Queues the frame for `rect`.
    pub(super) fn paint(&self, ui: &egui::Ui, rect: egui::Rect, frame: FrameInput) {
        ui.painter().add(egui_wgpu::Callback::new_paint_callback(
            rect,
            Callback { frame, drawing: self.drawing.clone() },
        ));
    }
}

struct Callback {
    frame: FrameInput,
    drawing: DrawTime,
}

impl egui_wgpu::CallbackTrait for Callback {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        _screen: &egui_wgpu::ScreenDescriptor,
        _egui_encoder: &mut wgpu::CommandEncoder,
        resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        let Some(Resources { renderer, generation, drawn }) = resources.get_mut() else {
            return Vec::new();
        };
        let wanted = (self.frame, *generation);
        if *drawn == Some(wanted) {
            return Vec::new();
        }
        *drawn = Some(wanted);
        self.drawing.count(|| vec![renderer.prepare(device, queue, &self.frame)])
    }

    fn paint(
        &self,
        _info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &CallbackResources,
    ) {
        if let Some(resources) = resources.get::<Resources>() {
            resources.renderer.paint(pass);
        }
    }
}
