//! `identify`: arguments, and the tables of tests and of the pooled parameters.

use std::io::{Result as IoResult, Write};
use std::path::PathBuf;

use super::terminal::print;
use clap::Args;
use microslip::Error;
use microslip::file::refuse_inputs;
use microslip::identify::found::pooled_result::PooledParameter;
use microslip::identify::write::FILES;
use microslip::identify::{
    Identified, IdentifySettings, TestResult, TestStatus, Uncertain, identify_files, write,
};
use microslip::study::OutputFolder;

#[derive(Args)]
pub(super) struct IdentifyArguments {
    /// Tables of hysteresis tests: time, relative displacement, tangential and normal force, with units in the header.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Folder of identified.json, loops.csv and report.html.
    #[arg(long, default_value = "identified")]
    output: PathBuf,
    /// Table of the pressure on the contact in all tests: pressure and, unless they are equal, area of each cell, with units in the header.
    #[arg(long, value_name = "FILE")]
    pressure_map: Option<PathBuf>,
    /// Confidence of the intervals.
    #[arg(long, default_value_t = IdentifySettings::default().confidence, allow_hyphen_values = true)]
    confidence: f64,
    /// Tangential stiffness of the rig in series with the contact, which the displacement sensor sees too.
    #[arg(long, value_name = "N/UM", allow_hyphen_values = true)]
    series_stiffness_n_per_um: Option<f64>,
    /// Standard uncertainty of the gain of each force sensor, the same in all tests.
    #[arg(
        long,
        value_name = "PERCENT",
        default_value_t = 0.0,
        allow_hyphen_values = true
    )]
    force_error_percent: f64,
    /// Standard uncertainty of the gain of the displacement sensors, the same in all tests.
    #[arg(
        long,
        value_name = "PERCENT",
        default_value_t = 0.0,
        allow_hyphen_values = true
    )]
    displacement_error_percent: f64,
    /// Offset of the normal force, which is subtracted: loops do not show it.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0.0,
        allow_hyphen_values = true
    )]
    normal_force_offset_n: f64,
    /// Cycles left out at the start of each test; found from the loops if absent.
    #[arg(long, value_name = "CYCLES")]
    run_in: Option<usize>,
    /// Greatest friction coefficient that is possible: gives a distribution if no test slips.
    #[arg(long, value_name = "COEFFICIENT", allow_hyphen_values = true)]
    friction_at_most: Option<f64>,
    /// Area of the study's interface over that of the tested contact: multiplies the stiffness for the study.
    #[arg(
        long,
        value_name = "RATIO",
        default_value_t = 1.0,
        allow_hyphen_values = true
    )]
    interface_area_ratio: f64,
    /// No tables.
    #[arg(long)]
    quiet: bool,
}

impl IdentifyArguments {
    pub(super) fn execute(&self) -> Result<(), Error> {
        let map = self.pressure_map.as_ref();
        let inputs: Vec<PathBuf> = self.files.iter().chain(map).cloned().collect();
        refuse_inputs(FILES.map(|name| self.output.join(name)), &inputs)?;
        let identified = identify_files(&self.files, map, &self.settings())?;
        let output = OutputFolder::open(&self.output)?;
        write(output.path(), &identified)?;
        if self.quiet {
            return Ok(());
        }
        print(|out| {
            show(out, &identified)?;
            let path = output.path().display();
            writeln!(
                out,
                "identified.json, loops.csv and report.html are in {path}"
            )
        })
    }

    fn settings(&self) -> IdentifySettings {
        IdentifySettings {
            confidence: self.confidence,
            series_stiffness_n_per_um: self.series_stiffness_n_per_um,
            force_error_percent: self.force_error_percent,
            displacement_error_percent: self.displacement_error_percent,
            normal_force_offset_n: self.normal_force_offset_n,
            run_in_cycles: self.run_in,
            friction_at_most: self.friction_at_most,
            interface_area_ratio: self.interface_area_ratio,
        }
    }
}

fn show(out: &mut dyn Write, identified: &Identified) -> IoResult<()> {
    for test in &identified.tests {
        show_test(out, test)?;
    }
    if let Some(pooled) = &identified.pooled {
        writeln!(out, "all tests, {} specimens:", pooled.specimens)?;
        for parameter in &pooled.parameters {
            show_parameter(out, parameter)?;
        }
        show_correlation(out, identified)?;
    }
    for note in &identified.notes {
        writeln!(out, "note: {note}")?;
    }
    Ok(())
}

fn show_test(out: &mut dyn Write, test: &TestResult) -> IoResult<()> {
    write!(out, "{}: ", test.name)?;
    if let Some(cycles) = test.cycles {
        write!(
            out,
            "{:.4} Hz, {} steady loops of {}",
            cycles.frequency_hz, cycles.steady, cycles.whole
        )?;
    }
    if let TestStatus::Unusable(reason) = &test.status {
        return writeln!(out, " not used: {reason}");
    }
    let Some(estimate) = &test.estimate else {
        return writeln!(out);
    };
    writeln!(out, ", {:.4} N", estimate.normal_force_n)?;
    match (estimate.friction, estimate.friction_at_least) {
        (Some(friction), _) => {
            write!(
                out,
                "  friction coefficient  {}",
                in_words(&friction.coefficient)
            )?;
            match friction.from_energy {
                Some(energy) => writeln!(out, ", from energy {energy:.4}")?,
                None => writeln!(out)?,
            }
        }
        (None, Some(least)) => {
            writeln!(out, "  friction coefficient  at least {least:.4}: no slip")?
        }
        (None, None) => writeln!(out, "  friction coefficient  unknown: no slip")?,
    }
    let tangential = &estimate.tangential;
    let side = |side: Option<Uncertain>| {
        side.map_or_else(|| "-".to_owned(), |s| format!("{:.4}", s.value))
    };
    writeln!(
        out,
        "  tangential stiffness  {} N/um; after the reversals {} and {}",
        in_words(&tangential.stiffness_n_per_um),
        side(tangential.sides_n_per_um[0]),
        side(tangential.sides_n_per_um[1]),
    )?;
    if let Some(normal) = estimate.normal_stiffness_n_per_um {
        writeln!(out, "  normal stiffness      {} N/um", in_words(&normal))?;
    }
    writeln!(
        out,
        "  energy per cycle      {:.4e} J; misfit {:.2} % of the swing",
        estimate.energy_j.value,
        100.0 * estimate.misfit.relative_rms
    )?;
    for note in &test.notes {
        writeln!(out, "  note: {note}")?;
    }
    Ok(())
}

/// `0.6 (0.59 .. 0.61)`
fn in_words(value: &Uncertain) -> String {
    format!(
        "{:.4} ({:.4} .. {:.4})",
        value.value, value.lower, value.upper
    )
}

fn show_parameter(out: &mut dyn Write, pooled: &PooledParameter) -> IoResult<()> {
    let name = pooled.parameter.in_words();
    // not every terminal shows the letter of micro
    let unit = pooled.parameter.unit();
    let unit = unit.map_or_else(String::new, |unit| format!(" {}", unit.replace('µ', "u")));
    let [low, high] = pooled.further_contact;
    writeln!(
        out,
        "  {name:<21} median {}{unit} from {} tests; a further contact {low:.4} .. {high:.4}{unit}",
        in_words(&pooled.median),
        pooled.tests
    )
}

fn show_correlation(out: &mut dyn Write, identified: &Identified) -> IoResult<()> {
    for (i, a) in identified.inputs.iter().enumerate() {
        for (j, b) in identified.inputs.iter().enumerate().skip(i + 1) {
            let value = identified.correlation[i][j];
            let [a, b] = [a, b].map(|input| input.parameter.name());
            writeln!(out, "  correlation of {a} and {b}: {value:.3}")?;
        }
    }
    Ok(())
}
