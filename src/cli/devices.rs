//! `devices`: the adapters that a run can use.

use std::io::Write;

use super::device_layer;
use super::terminal::print;
use microslip::Error;
use microslip::gpu::{adapters, examined};

pub(super) fn execute() -> Result<(), Error> {
    device_layer::leave_out();
    print(show)
}

/// One block per adapter.
fn show(out: &mut dyn Write) -> std::io::Result<()> {
    let all = adapters();
    if all.is_empty() {
        writeln!(out, "no adapter: the processor does all of it")?;
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
