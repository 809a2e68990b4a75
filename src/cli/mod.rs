//! Arguments, messages and exit codes: 0 = done, 1 = a curve of `solve` has a gap, 2 = bad input or a file that cannot be read or written,
//! 3 = stopped before the end.
//!
//! Each command is a file: its arguments, what it calls of the library, and what it shows.

mod calibrate;
mod compare;
mod completions;
mod device_layer;
mod devices;
mod disk;
mod export;
mod extend;
mod identify;
mod import;
mod inspect;
mod levels;
mod log;
mod man;
mod merge;
mod pace;
mod process;
mod report;
mod reweight;
mod rig;
mod run;
mod run_control;
mod schema;
mod serve;
mod shares;
mod solve;
mod status;
mod study_arguments;
mod terminal;
mod threads;
mod total_mass;

use std::io::ErrorKind;
use std::process::ExitCode;
use std::sync::LazyLock;

use calibrate::CalibrateArguments;
use clap::{Parser, Subcommand};
use compare::CompareArguments;
use completions::CompletionsArguments;
use disk::DiskArguments;
use export::ExportArguments;
use extend::ExtendArguments;
use identify::IdentifyArguments;
use import::{ImportArguments, PairsArguments};
use log::{Event, Log};
use man::ManArguments;
use merge::MergeArguments;
use microslip::Error;
use microslip::file::FileError;
use report::ReportArguments;
use reweight::ReweightArguments;
use rig::RigArguments;
use run::RunArguments;
use schema::SchemaArguments;
use serve::ServeArguments;
use status::StatusArguments;
use study_arguments::StudyArguments;

/// Exit code of a command that has written what it found, where a part of the answer is not known.
const INCOMPLETE: u8 = 1;
/// Exit code of every failure.
const FAILURE: u8 = 2;
/// Exit code of a command that was stopped.
const STOPPED: u8 = 3;

/// Version, with the commit where the build was told it (`MICROSLIP_COMMIT` in its environment).
static VERSION: LazyLock<String> = LazyLock::new(|| {
    let version = env!("CARGO_PKG_VERSION");
    match option_env!("MICROSLIP_COMMIT") {
        Some(commit) => format!("{version} ({commit})"),
        None => version.to_owned(),
    }
});

const EXAMPLES: &str = "\
Examples:
  microslip inspect study.toml              what would be computed: sizes, frequencies, time
  microslip solve study.toml                nominal forced response at every level
  microslip run study.toml --threads 8      all samples, statistics and report
  microslip run study.toml --output other/  the same into another folder
  microslip status results                  how far a run has come; after a stop the same `run` goes on
  microslip report results                  the report again, from the stored samples
  microslip schema > study.schema.json      what editors need to check a study file
  microslip schema --of summary             what programs that read summary.json need to know
  microslip compare strip-a strip-b         designs on the same samples, from their results
  microslip disk eo3 eo4 eo5                Campbell and SAFE diagram of a disk, a run per engine order
  microslip reweight results --prior p.toml the same samples under other distributions of the inputs
  microslip extend results --samples 800    more samples for these results; the old ones are kept
  microslip rig rig.toml --output tests     virtual measurements of a contact, with the truth beside them
  microslip identify loops.csv              friction and stiffness of a contact from measured hysteresis loops
  microslip calibrate study.toml --measured response.csv --output calibrated
                                            the inputs that a measured response tells of, as samples
  microslip serve study.toml --port 4242    the model for UM-Bridge clients: inputs in, resonances out

Exit codes: 0 done, 1 a curve of `solve` has a gap, 2 bad input or a file that cannot be read or written, 3 stopped before the end.";

#[derive(Parser)]
#[command(version = VERSION.as_str(), about, after_help = EXAMPLES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Compute every sample of a study and write tables and report.
    Run(RunArguments),
    /// Solve more samples for the results of a run; the files are then those of a run with so many.
    Extend(ExtendArguments),
    /// Compute the nominal forced response at every level: curve.csv and solution.json.
    Solve(StudyArguments),
    /// Put the shares of a run together, and write tables and report.
    Merge(MergeArguments),
    /// Show how far a run has come that is not finished, and what its folder holds.
    Status(StatusArguments),
    /// Check that every file of results and parts is what was written, and the report what the tables give.
    Verify(StatusArguments),
    /// Render the report of a run again from its stored samples, without solving.
    Report(ReportArguments),
    /// Compare designs sample by sample, from the results of their runs: comparison.json and comparison.html.
    Compare(CompareArguments),
    /// Gather the engine orders of a tuned disk, from the results of their runs: disk.json and disk.html.
    Disk(DiskArguments),
    /// Quantiles of the same samples under other distributions of the inputs, without solving: reweighted.json.
    Reweight(ReweightArguments),
    /// Simulate tests of a friction contact on a rig whose truth is known: hysteresis records, resonances, truth.json.
    Rig(RigArguments),
    /// Calibrate the inputs of a study with a measured response: posterior.csv and calibration.json.
    Calibrate(CalibrateArguments),
    /// Serve the model of a study to programs in other languages, by the UM-Bridge protocol: inputs in, resonances out.
    Serve(ServeArguments),
    /// Print the JSON Schema of the study file or of a result file, for editors and programs.
    Schema(SchemaArguments),
    /// Show what a study would compute: degrees of freedom, frequencies, contact pairs, memory and time.
    Inspect(StudyArguments),
    /// Read the matrices of a finite-element program and write them as a study: matrices, contact pairs, study.toml.
    Import(ImportArguments),
    /// Write the model of a study as matrices, with a study of kind "matrices" that gives the same answer.
    Export(ExportArguments),
    /// Propose contact pairs for `import`: each node of one surface with the nearest node of the other.
    Pairs(PairsArguments),
    /// Identify friction and stiffness of a contact from measured hysteresis loops: identified.json, which a study reads.
    Identify(IdentifyArguments),
    /// List the adapters that `run --backend gpu` can use, with a self-test of each.
    Devices,
    /// Print what a shell needs to complete commands and options.
    Completions(CompletionsArguments),
    /// Write a manual page for each command.
    Man(ManArguments),
}

impl Command {
    /// Form of what it says on standard error.
    fn log(&self) -> Log {
        match self {
            Self::Run(arguments) => arguments.study.messages.log,
            Self::Solve(arguments) | Self::Inspect(arguments) => arguments.messages.log,
            Self::Extend(arguments) => arguments.process.messages.log,
            Self::Merge(arguments) => arguments.process.messages.log,
            Self::Serve(arguments) => arguments.process.messages.log,
            Self::Rig(arguments) => arguments.process.messages.log,
            Self::Calibrate(arguments) => arguments.process.messages.log,
            _ => Log::Text,
        }
    }

    /// Whether it takes signals itself: to keep what is solved, or to end as a server does.
    fn takes_signals(&self) -> bool {
        matches!(
            self,
            Self::Run(_) | Self::Extend(_) | Self::Merge(_) | Self::Serve(_)
        )
    }

    fn execute(&self) -> Result<ExitCode, Error> {
        let done = match self {
            Self::Solve(arguments) => return solve::execute(arguments),
            Self::Run(arguments) => arguments.execute(),
            Self::Extend(arguments) => arguments.execute(),
            Self::Merge(arguments) => arguments.execute(),
            Self::Status(arguments) => arguments.status(),
            Self::Verify(arguments) => arguments.verify(),
            Self::Report(arguments) => arguments.execute(),
            Self::Compare(arguments) => arguments.execute(),
            Self::Disk(arguments) => arguments.execute(),
            Self::Reweight(arguments) => arguments.execute(),
            Self::Rig(arguments) => arguments.execute(),
            Self::Calibrate(arguments) => arguments.execute(),
            Self::Serve(arguments) => arguments.execute(),
            Self::Schema(arguments) => arguments.execute(),
            Self::Inspect(arguments) => inspect::execute(arguments),
            Self::Import(arguments) => arguments.execute(),
            Self::Export(arguments) => arguments.execute(),
            Self::Pairs(arguments) => arguments.execute(),
            Self::Identify(arguments) => arguments.execute(),
            Self::Devices => devices::execute(),
            Self::Completions(arguments) => arguments.execute(),
            Self::Man(arguments) => arguments.execute(),
        };
        done.map(|()| ExitCode::SUCCESS)
    }
}

/// Runs the command of the process's arguments.
pub(crate) fn main() -> ExitCode {
    // Help and version end here with 0; wrong arguments with clap's own message and 2.
    let arguments = Arguments::parse();
    let log = arguments.command.log();
    if !arguments.command.takes_signals() {
        run_control::end_on_signal(log);
    }
    match arguments.command.execute() {
        Ok(code) => code,
        // A reader such as `head` that has seen enough is no failure of ours.
        Err(Error::File(FileError::System { source, .. }))
            if source.kind() == ErrorKind::BrokenPipe =>
        {
            ExitCode::SUCCESS
        }
        Err(stopped @ Error::Stopped { .. }) => {
            log.write(&Event::Stopped(&stopped.to_string()));
            ExitCode::from(STOPPED)
        }
        Err(error) => {
            log.write(&Event::Error(&error.to_string()));
            ExitCode::from(FAILURE)
        }
    }
}
