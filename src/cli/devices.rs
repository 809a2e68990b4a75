//! What GPUs there are, and what one did in a run.

use std::io::Write;

use microslip::gpu::{adapters, examined};
use microslip::report::Summary;

/// What the GPU did, with the time of its passes if wanted.
pub(super) fn show_gpu(
    out: &mut dyn Write,
    summary: &Summary,
    profile: bool,
) -> std::io::Result<()> {
    let Some(gpu) = &summary.backend.gpu else {
        return Ok(());
    };
    writeln!(
        out,
        "{}: {} evaluations in {} batches, {} audited, largest difference {:.1e} of a force",
        gpu.adapter.name, gpu.evaluations, gpu.batches, gpu.audited, gpu.largest_force_difference
    )?;
    if profile {
        for (pass, seconds) in &gpu.pass_seconds {
            writeln!(out, "{pass:20} {seconds:.3} s on the device")?;
        }
    }
    Ok(())
}

/// One block per adapter.
pub(super) fn show_devices(out: &mut dyn Write) -> std::io::Result<()> {
    let all = adapters();
    if all.is_empty() {
        writeln!(out, "no adapter: the processor evaluates the contacts")?;
    }
    for facts in all {
        let yes = |has: bool| if has { "yes" } else { "no" };
        writeln!(
            out,
            "{}: {} ({}, {})",
            facts.index, facts.name, facts.kind, facts.interface
        )?;
        writeln!(out, "   driver           {}", facts.driver)?;
        writeln!(out, "   pci address      {}", facts.pci)?;
        writeln!(
            out,
            "   largest binding  {} MiB",
            facts.largest_binding >> 20
        )?;
        writeln!(
            out,
            "   f64, timestamps  {}, {}",
            yes(facts.f64),
            yes(facts.timestamps)
        )?;
        writeln!(out, "   self-test        {}", examined(facts.index))?;
    }
    Ok(())
}
