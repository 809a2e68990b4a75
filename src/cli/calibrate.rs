//! `calibrate`: arguments, progress and what was found.

use std::io::Write;
use std::path::PathBuf;

use super::log::{Event, Messages};
use super::process::Process;
use super::terminal::print;
use clap::Args;
use microslip::Error;
use microslip::calibrate::found::Round;
use microslip::calibrate::settings::Discrepancy;
use microslip::calibrate::write::FILES;
use microslip::calibrate::{Calibration, CalibrationSettings, CalibrationStage, calibrate};
use microslip::file::refuse_inputs;
use microslip::study::{OutputFolder, Study};
use serde_json::json;

#[derive(Args)]
pub(super) struct CalibrateArguments {
    /// Study file: its inputs with their distributions are what is known before.
    study: PathBuf,
    /// Table of the measured response: level [N], resonance frequency [Hz], amplitude [um], one row per level and repetition.
    #[arg(long)]
    measured: PathBuf,
    /// Folder of calibration.json, posterior.csv and calibration.html.
    #[arg(long)]
    output: PathBuf,
    /// Samples of the study that are solved for the surrogates, instead of all.
    #[arg(long)]
    samples: Option<u64>,
    /// Markov chains.
    #[arg(long, default_value_t = CalibrationSettings::default().chains)]
    chains: usize,
    /// Draws of each chain.
    #[arg(long, default_value_t = CalibrationSettings::default().draws)]
    draws: usize,
    /// Seed of the chains.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// What the model may be wrong by in frequency, whatever its inputs: standard deviation (Hz), itself uncertain by a factor e.
    #[arg(long, default_value_t = 0.0)]
    discrepancy_hz: f64,
    /// The same in amplitude, in percent.
    #[arg(long, default_value_t = 0.0)]
    discrepancy_percent: f64,
    #[command(flatten)]
    pub process: Process,
}

impl CalibrateArguments {
    pub(super) fn execute(&self) -> Result<(), Error> {
        self.process.threads.start()?;
        let messages = &self.process.messages;
        let settings = CalibrationSettings {
            samples: self.samples,
            chains: self.chains,
            draws: self.draws,
            seed: self.seed,
            discrepancy: Discrepancy {
                frequency_hz: self.discrepancy_hz,
                amplitude: 0.01 * self.discrepancy_percent,
            },
            ..CalibrationSettings::default()
        };
        let study = Study::read(&self.study)?;
        let read = [study.inputs_on_disk(), vec![self.measured.clone()]].concat();
        refuse_inputs(FILES.map(|name| self.output.join(name)), &read)?;
        messages.log.warn(&study.warnings);
        let output = OutputFolder::open(&self.output)?;
        let found = calibrate(study, &self.measured, &settings, |stage| self.tell(stage))?;
        let files = found.write(&output)?;
        messages.log.warn(&found.summary.warnings);
        messages.log.write(&Event::Finished(json!({
            "folder": output.path().display().to_string(),
            "rounds": found.summary.rounds.len(),
            "acceptance": found.summary.acceptance,
            "misfit_probability": found.summary.misfit_probability,
        })));
        if messages.quiet {
            return Ok(());
        }
        print(|out| {
            show(out, &found.summary)?;
            for file in &files {
                writeln!(out, "{}", file.display())?;
            }
            Ok(())
        })
    }

    fn tell(&self, stage: CalibrationStage) {
        let Messages { quiet, log } = self.process.messages;
        if quiet {
            return;
        }
        let (words, fields) = match stage {
            CalibrationStage::Samples(n) => (
                format!("solving {n} samples"),
                json!({ "stage": "samples", "samples": n }),
            ),
            CalibrationStage::Chains(round) => (
                format!("round {round}: fit, and chains"),
                json!({ "stage": "chains", "round": round }),
            ),
            CalibrationStage::Check(n) => (
                format!("solving {n} draws of the posterior"),
                json!({ "stage": "check", "draws": n }),
            ),
        };
        log.write(&Event::Stage {
            words: &words,
            fields,
        });
    }
}

fn show(out: &mut dyn Write, found: &Calibration) -> std::io::Result<()> {
    for input in &found.inputs {
        let (before, after) = (input.prior, input.posterior);
        writeln!(
            out,
            "{:28}{:.5} ({:.5} .. {:.5}); before {:.5} ({:.5} .. {:.5})",
            input.name, after.q50, after.q025, after.q975, before.q50, before.q025, before.q975
        )?;
    }
    let worst = found.inputs.iter().filter_map(|input| input.mixing);
    let r_hat = worst.clone().map(|m| m.r_hat).fold(1.0, f64::max);
    let effective = worst.map(|m| m.bulk_effective.min(m.tail_effective));
    let effective = effective.fold(f64::INFINITY, f64::min);
    writeln!(
        out,
        "R-hat at most {r_hat:.4}, {effective:.0} effective draws or more, {:.0} % of the moves taken",
        100.0 * found.acceptance
    )?;
    if let Some(last) = found.rounds.last() {
        let rounds = match found.rounds.len() {
            1 => "1 round".to_owned(),
            n => format!("{n} rounds"),
        };
        writeln!(
            out,
            "surrogates of {} points, {} ({rounds})",
            last.points,
            checked(last)
        )?;
    }
    writeln!(
        out,
        "posterior predictive p = {:.3}",
        found.misfit_probability
    )
}

/// At what the surrogates were checked, and what came out.
fn checked(last: &Round) -> String {
    let Some(ratio) = last.worst_ratio else {
        return format!(
            "checked at no draw of the posterior: none of {} has a solution",
            last.checked
        );
    };
    let unsolved = match last.failed {
        0 => String::new(),
        failed => format!(" ({failed} more have no solution)"),
    };
    format!(
        "checked at {} draws of the posterior{unsolved}: their error is at most {ratio:.2} times what the likelihood takes it for",
        last.solved()
    )
}
