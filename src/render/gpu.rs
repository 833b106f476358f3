use std::sync::mpsc;
use std::time::Duration;

/// Why there is no picture from the graphics adapter.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No adapter at all.
    #[error("no graphics adapter was found: {0}")]
    Adapter(#[from] wgpu::RequestAdapterError),
    /// The adapter gave no device.
    #[error("the graphics adapter gave no device: {0}")]
    Device(#[from] wgpu::RequestDeviceError),
    /// Waiting failed or took too long.
    #[error("the graphics device did not finish: {0}")]
    Poll(#[from] wgpu::PollError),
    /// The copy could not be mapped.
    #[error("the picture could not be read back: {0}")]
    Map(#[from] wgpu::BufferAsyncError),
    /// The mapped range was refused.
    #[error("the picture could not be read back: {0}")]
    Range(#[from] wgpu::MapRangeError),
    /// The device went away while the copy was being mapped.
    #[error("the graphics device went away before the picture was read back")]
    Lost,
}

/// A device without any window, for tests and pictures from the command line.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// Makes resources.
    pub device: wgpu::Device,
    /// Takes commands.
    pub queue: wgpu::Queue,
    /// What it runs on.
    pub info: wgpu::AdapterInfo,
}

impl Gpu {
    /// Opens the adapter that the environment prefers, with default limits and no optional feature.
    pub fn headless() -> Result<Self, GpuError> {
        pollster::block_on(async {
            let instance =
                wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
            let adapter = instance
                .request_adapter(&wgpu::RequestAdapterOptions {
                    power_preference: wgpu::PowerPreference::HighPerformance,
                    ..Default::default()
                })
                .await?;
            let (device, queue) = adapter
                .request_device(&wgpu::DeviceDescriptor { label: Some("headless"), ..Default::default() })
                .await?;
            Ok(Self { device, queue, info: adapter.get_info() })
        })
    }

    /// Whether the adapter computes on the processor.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }
}

/// Copies the first mip level of a colour texture (usage `COPY_SRC`) to the CPU, row by row
/// without padding. Blocks until the device is done.
pub fn read_texture(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Result<Vec<u8>, GpuError> {
    let size = texture.size();
    let texel_bytes = texture.format().block_copy_size(None).unwrap_or(4);
    let row_bytes = size.width * texel_bytes;
    let padded_row_bytes = row_bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let readback = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size: u64::from(padded_row_bytes) * u64::from(size.height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &readback,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(padded_row_bytes),
                rows_per_image: None,
            },
        },
        size,
    );
    let submission = queue.submit([encoder.finish()]);
    let (sender, receiver) = mpsc::sync_channel(1);
    readback.map_async(wgpu::MapMode::Read, .., move |result| {
        // The receiver lives until the poll below returns, so that a failed send cannot matter.
        sender.send(result).ok();
    });
    device.poll(wgpu::PollType::Wait {
        submission_index: Some(submission),
        timeout: Some(Duration::from_secs(60)),
    })?;
    receiver.try_recv().map_err(|_| GpuError::Lost)??;
    let view = readback.get_mapped_range(..)?;
    Ok(view
        .chunks_exact(padded_row_bytes as usize)
        .flat_map(|row| &row[..row_bytes as usize])
        .copied()
        .collect())
}
