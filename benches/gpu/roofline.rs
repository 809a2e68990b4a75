//! What an adapter does at best, measured.

use microslip::gpu::Device;
use std::time::Instant;

/// Runs of which the fastest counts.
const RUNS: usize = 5;

/// What the adapter does at best.
pub(super) struct Peak {
    /// Operations per second, f32.
    pub flops: f64,
    /// Bytes per second, read and written.
    pub bytes: f64,
}

/// Steps of the multiply-add kernel per thread; eight operands, two operations each.
const STEPS: u32 = 4096;

impl Peak {
    pub(super) fn of(device: &Device) -> Self {
        let threads: u32 = if device.adapter.is_hardware() {
            1 << 20
        } else {
            1 << 12
        };
        let words: u32 = if device.adapter.is_hardware() {
            1 << 23
        } else {
            1 << 22
        };
        let adds = format!(
            "@group(0) @binding(0) var<storage, read_write> x: array<vec4<f32>>;
             @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
               var a = x[id.x]; var b = a + vec4(1.0); let c = vec4(0.999);
               for (var i = 0u; i < {STEPS}u; i++) {{ a = fma(a, c, b); b = fma(b, c, a); }}
               x[id.x] = a + b; }}"
        );
        let copies = "@group(0) @binding(0) var<storage, read_write> x: array<vec4<f32>>;
             @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
               x[id.x] = x[id.x] + vec4(1.0); }";
        let seconds = best_seconds(device, &adds, threads, u64::from(threads) * 16);
        let copied = best_seconds(device, copies, words / 4, u64::from(words) * 4);
        let peak = Self {
            flops: f64::from(threads) * f64::from(STEPS) * 16.0 / seconds,
            bytes: f64::from(words) * 8.0 / copied,
        };
        println!(
            "peak: {:.0} Gflop/s, copy {:.1} GB/s (read and written)",
            peak.flops / 1e9,
            peak.bytes / 1e9
        );
        peak
    }
}

/// Shortest time of a kernel over one buffer.
fn best_seconds(device: &Device, text: &str, threads: u32, bytes: u64) -> f64 {
    let gpu = &device.device;
    let module = gpu.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(text.into()),
    });
    let pipeline = gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: None,
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let buffer = gpu.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: bytes,
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    });
    let group = gpu.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: buffer.as_entire_binding(),
        }],
    });
    let groups = threads / 64;
    assert!(groups <= 65_535, "the groups that one dimension has");
    let mut best = f64::INFINITY;
    for _ in 0..=RUNS {
        let mut encoder = gpu.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(groups, 1, 1);
        }
        let clock = Instant::now();
        device.queue.submit([encoder.finish()]);
        gpu.poll(wgpu::PollType::wait_indefinitely())
            .expect("the device answers");
        best = best.min(clock.elapsed().as_secs_f64());
    }
    best
}
