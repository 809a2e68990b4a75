//! `rig`: virtual tests with known truth.

use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

use super::log::Event;
use super::process::Process;
use super::terminal::{Bar, print};
use clap::Args;
use microslip::Error;
use microslip::rig::{MeasuredResonance, Rig, RigSummary, Slip, write_tests};
use microslip::study::Progress;
use serde_json::json;

#[derive(Args)]
pub(super) struct RigArguments {
    /// The rig file.
    rig: PathBuf,
    /// Folder of the measurements; must not exist or be empty.
    #[arg(long)]
    output: PathBuf,
    #[command(flatten)]
    pub process: Process,
}

impl RigArguments {
    pub(super) fn execute(&self) -> Result<(), Error> {
        self.process.threads.start()?;
        let rig = Rig::read(&self.rig)?;
        let messages = &self.process.messages;
        if let Some(study) = &rig.study {
            messages.log.warn(&study.warnings);
        }
        messages.log.warn(&rig.warnings());
        let bar = Bar::new(messages);
        let (done, total) = (AtomicU64::new(0), rig.number_of_tests());
        let summary = write_tests(&rig, &self.output, || {
            let done = 1 + done.fetch_add(1, Ordering::Relaxed);
            bar.show(Progress {
                done,
                total,
                newton_iterations: 0,
            });
        })?;
        bar.clear();
        messages.log.write(&Event::Finished(json!({
            "folder": self.output.display().to_string(),
            "tests": summary.tests.len(),
            "resonances": summary.resonances.len(),
        })));
        let clipped = summary.tests.iter().filter(|test| test.out_of_range > 0);
        if let n @ 1.. = clipped.count() {
            let warning = format!("in {n} tests an instrument was at the end of its range");
            messages.log.warn(&[warning]);
        }
        let cut = |resonance: &&MeasuredResonance| {
            resonance.steps.iter().any(|step| step.out_of_range > 0)
        };
        if let n @ 1.. = summary.resonances.iter().filter(cut).count() {
            let warning = format!("of {n} resonances the vibrometer was at the end of its range");
            messages.log.warn(&[warning]);
        }
        if messages.quiet {
            return Ok(());
        }
        print(|out| {
            show(out, &summary)?;
            writeln!(out, "measurements are in {}", self.output.display())
        })
    }
}

fn show(out: &mut dyn Write, summary: &RigSummary) -> std::io::Result<()> {
    let pressure = &summary.pressure;
    writeln!(
        out,
        "load {:.1} N; pressure {:.3} MPa, at most {:.3} MPa; within 10 % of the mean {:.0} % of the strip, {:.0} % of the contact",
        summary.load_n,
        pressure.mean_mpa,
        pressure.largest_mpa,
        100.0 * pressure.within_tenth,
        100.0 * summary.even_area
    )?;
    show_blade(out, summary)?;
    let gross = summary.tests.iter().filter(|test| test.slip == Slip::Gross);
    writeln!(
        out,
        "{} tests of one blade and strip, {} of them with gross slip",
        summary.tests.len(),
        gross.count()
    )?;
    for resonance in &summary.resonances {
        let (specimen, level) = (resonance.specimen + 1, resonance.level);
        match &resonance.peak {
            Some(peak) => writeln!(
                out,
                "specimen {specimen}, level {level}: {:.3} Hz, {:.4} um",
                peak.frequency_hz, peak.amplitude_um
            )?,
            None => writeln!(
                out,
                "specimen {specimen}, level {level}: {}",
                resonance.status
            )?,
        }
    }
    Ok(())
}

/// Natural frequencies of a blade, and the platform's motion in each test; nothing without one.
fn show_blade(out: &mut dyn Write, summary: &RigSummary) -> std::io::Result<()> {
    let Some(blade) = &summary.blade else {
        return Ok(());
    };
    let shown = |all: &[f64]| {
        let each: Vec<String> = all.iter().map(|f| format!("{f:.1}")).collect();
        each.join(", ")
    };
    writeln!(out, "blade: {} Hz", shown(&blade.free_hz))?;
    writeln!(
        out,
        "with a strip that sticks: {} Hz",
        shown(&blade.stuck_hz)
    )?;
    for test in &summary.tests {
        if let Some(platform) = test.platform {
            writeln!(
                out,
                "  {} {} Hz: platform {:.3} um, {:.0} degrees after the force",
                test.file, test.frequency_hz, platform.amplitude_um, platform.lag_deg
            )?;
        }
    }
    Ok(())
}
