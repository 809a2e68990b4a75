//! Arguments, messages and exit codes: 0 = done, 2 = bad input or a file that cannot be read or written.

mod compare;
mod curve;
mod devices;
mod facts;

mod reweight;

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use compare::CompareArguments;
use devices::{show_devices, show_gpu};
use microslip::Error;
use microslip::aft::gpu::{GpuSettings, Precision};
use microslip::ensemble::backend::{BackendChoice, BackendSettings};
use microslip::file::FileError;
use microslip::report::epistemic::EpistemicSummary;
use microslip::report::{Summary, render};
use microslip::study::{
    OutputFolder, Progress, RunResult, Study, extend, inspect, key_reference, run, schema, solve,
    write_arrow_tables,
};
use reweight::ReweightArguments;

/// Threads at most: more than any machine has, and few enough to start.
const MOST_THREADS: i64 = 1024;
/// Exit code of every failure.
const FAILURE: u8 = 2;

const EXAMPLES: &str = "\
Examples:
  microslip inspect study.toml              what would be computed: sizes, frequencies, time
  microslip solve study.toml                nominal forced response at every level
  microslip run study.toml --threads 8      all samples, statistics and report
  microslip run study.toml --output other/  the same into another folder
  microslip report results                  the report again, from the stored samples
  microslip schema > study.schema.json      what editors need to check a study file
  microslip compare strip-a strip-b         designs on the same samples, from their results
  microslip reweight results --prior p.toml the same samples under other distributions of the inputs
  microslip extend results --samples 800    more samples for these results; the old ones are kept

Exit codes: 0 done, 2 bad input or a file that cannot be read or written.";

#[derive(Parser)]
#[command(version, about, after_help = EXAMPLES)]
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
    /// Render the report of a run again from its stored samples, without solving.
    Report(ReportArguments),
    /// Compare designs sample by sample, from the results of their runs: comparison.json and comparison.html.
    Compare(CompareArguments),
    /// Quantiles of the same samples under other distributions of the inputs, without solving: reweighted.json.
    Reweight(ReweightArguments),
    /// Print the JSON Schema of the study file, for editors and programs.
    Schema {
        /// Print its keys as Markdown tables instead.
        #[arg(long)]
        markdown: bool,
    },
    /// Show what a study would compute: degrees of freedom, frequencies, contact pairs, memory and time.
    Inspect(StudyArguments),
    /// List the adapters that `run --backend gpu` can use, with a self-test of each.
    Devices,
}

#[derive(Args)]
struct RunArguments {
    #[command(flatten)]
    study: StudyArguments,
    /// Who drafts contact forces; the results do not depend on it. `auto` takes a GPU that is hardware, if there is one.
    #[arg(long, value_enum, default_value = "cpu")]
    backend: BackendName,
    /// Adapter of the GPU: index, PCI address or part of its name, as `devices` lists them. One that is software must be
    /// named.
    #[arg(long)]
    adapter: Option<String>,
    /// Share of the GPU's evaluations that the processor repeats in double precision.
    #[arg(long, default_value_t = 0.01, value_parser = share)]
    audit: f64,
    /// Numbers of the shaders; f64 where the adapter has it.
    #[arg(long, value_enum, default_value = "f32")]
    precision: PrecisionName,
    /// Show the time of every pass on the GPU.
    #[arg(long)]
    profile: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum BackendName {
    Cpu,
    Gpu,
    Auto,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum PrecisionName {
    F32,
    F64,
}

impl RunArguments {
    fn backend(&self) -> BackendSettings {
        BackendSettings {
            choice: match self.backend {
                BackendName::Cpu => BackendChoice::Cpu,
                BackendName::Gpu => BackendChoice::Gpu,
                BackendName::Auto => BackendChoice::Auto,
            },
            gpu: GpuSettings {
                adapter: self.adapter.clone(),
                precision: match self.precision {
                    PrecisionName::F32 => Precision::F32,
                    PrecisionName::F64 => Precision::F64,
                },
                audit: self.audit,
                ..GpuSettings::default()
            },
        }
    }
}

/// A number from 0 to 1.
fn share(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("must be from 0 to 1".to_owned()),
    }
}

#[derive(Args)]
struct StudyArguments {
    /// The study file.
    study: PathBuf,
    /// Threads, 1 to 1024; all cores if absent. The results do not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    threads: Option<u16>,
    /// Folder of the results, instead of the study's own.
    #[arg(long)]
    output: Option<PathBuf>,
    /// No progress and no summary.
    #[arg(long)]
    quiet: bool,
}

#[derive(Args)]
struct ReportArguments {
    /// Folder of the results of a run.
    folder: PathBuf,
    /// Write the tables as Arrow files, too: samples.arrow and curves.arrow.
    #[arg(long)]
    arrow: bool,
    /// No summary.
    #[arg(long)]
    quiet: bool,
}

#[derive(Args)]
struct ExtendArguments {
    /// Folder with the results of `run`.
    folder: PathBuf,
    /// Number of samples in all.
    #[arg(long)]
    samples: u64,
    /// Threads, 1 to 1024; all cores if absent. The results do not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    threads: Option<u16>,
    /// No progress and no summary.
    #[arg(long)]
    quiet: bool,
}

/// Runs the command of the process's arguments.
pub(crate) fn main() -> ExitCode {
    // Help and version end here with 0; wrong arguments with clap's own message and 2.
    let arguments = Arguments::parse();
    match execute(&arguments.command) {
        Ok(()) => ExitCode::SUCCESS,
        // A reader such as `head` that has seen enough is no failure of ours.
        Err(Error::File(FileError::System { source, .. }))
            if source.kind() == ErrorKind::BrokenPipe =>
        {
            ExitCode::SUCCESS
        }
        Err(error) => {
            // Nothing is left to be done if even the message cannot be written.
            let _ = writeln!(std::io::stderr(), "error: {error}");
            ExitCode::from(FAILURE)
        }
    }
}

fn start_threads(threads: Option<u16>) -> Result<(), Error> {
    match threads {
        None => Ok(()),
        Some(threads) => rayon::ThreadPoolBuilder::new()
            .num_threads(usize::from(threads))
            .build_global()
            .map_err(|error| Error::Threads(error.to_string())),
    }
}

fn execute(command: &Command) -> Result<(), Error> {
    match command {
        Command::Run(arguments) => start_threads(arguments.study.threads)?,
        Command::Solve(common) | Command::Inspect(common) => start_threads(common.threads)?,
        Command::Extend(arguments) => start_threads(arguments.threads)?,
        Command::Report(_)
        | Command::Compare(_)
        | Command::Reweight(_)
        | Command::Schema { .. }
        | Command::Devices => {}
    }
    match command {
        Command::Schema { markdown: true } => print(|out| write!(out, "{}", key_reference())),
        Command::Schema { markdown: false } => print(|out| {
            serde_json::to_writer_pretty(&mut *out, &schema())?;
            writeln!(out)
        }),
        Command::Report(arguments) => {
            let (summary, _) = render(&arguments.folder)?;
            if arguments.arrow {
                write_arrow_tables(&arguments.folder, true)?;
            }
            if arguments.quiet {
                return Ok(());
            }
            print(|out| {
                show_levels(out, &summary)?;
                let tables = match arguments.arrow {
                    true => "samples.arrow, curves.arrow, ",
                    false => "",
                };
                let path = arguments.folder.display();
                writeln!(
                    out,
                    "{tables}summary.json, report.json and report.html are in {path}"
                )
            })
        }
        Command::Compare(arguments) => compare::execute(arguments),
        Command::Reweight(arguments) => reweight::execute(arguments),
        Command::Inspect(arguments) => {
            let study = Study::read(&arguments.study)?;
            let inspection = inspect(&study)?;
            print(|out| facts::show(out, &inspection))
        }
        Command::Solve(arguments) => {
            let study = Study::read(&arguments.study)?;
            show_warnings(&study.warnings);
            let folder = output_folder(&study, arguments)?;
            let bar = Bar::new(arguments.quiet);
            let curves = solve(&study, &folder, |progress| bar.show(progress))?;
            bar.clear();
            if arguments.quiet {
                return Ok(());
            }
            print(|out| {
                for curve in &curves {
                    curve::show(out, curve, study.frequency.unit)?;
                }
                writeln!(
                    out,
                    "curve.csv and solution.json are in {}",
                    folder.path().display()
                )
            })
        }
        Command::Devices => print(show_devices),
        Command::Run(arguments) => {
            let backend = arguments.backend();
            let profile = arguments.profile;
            let arguments = &arguments.study;
            let study = Study::read(&arguments.study)?;
            show_warnings(&study.warnings);
            let folder = output_folder(&study, arguments)?;
            let bar = Bar::new(arguments.quiet);
            let result = run(&study, &folder, &backend, |progress| bar.show(progress))?;
            bar.clear();
            show_warnings(&result.summary.backend.messages());
            show_result(&result, folder.path(), arguments.quiet)?;
            if arguments.quiet {
                return Ok(());
            }
            print(|out| show_gpu(out, &result.summary, profile))
        }
        Command::Extend(arguments) => {
            let bar = Bar::new(arguments.quiet);
            let result = extend(&arguments.folder, arguments.samples, |progress| {
                bar.show(progress);
            })?;
            bar.clear();
            show_result(&result, &arguments.folder, arguments.quiet)
        }
    }
}

/// Warnings go to standard error; one that cannot be shown is no reason to stop.
fn show_warnings(messages: &[String]) {
    for message in messages {
        let _ = writeln!(std::io::stderr(), "warning: {message}");
    }
}

/// What the samples say, and where the files are.
fn show_result(result: &RunResult, folder: &Path, quiet: bool) -> Result<(), Error> {
    if quiet {
        return Ok(());
    }
    print(|out| {
        show_levels(out, &result.summary)?;
        if let Some(reason) = &result.unfolded {
            writeln!(out, "{reason}")?;
        }
        if let Some(stopping) = &result.stopping {
            writeln!(out, "{}", stopping.in_words())?;
        }
        writeln!(
            out,
            "samples.parquet, curves.parquet, run.json, summary.json, report.json and report.html are in {}",
            folder.display()
        )
    })
}

/// Means with their intervals, where there are replicates; by outer point, where the samples belong to such.
fn show_replicates(out: &mut dyn Write, summary: &Summary) -> std::io::Result<()> {
    for (i, outer, means) in summary.replicate_means() {
        let level = summary.levels[i].level;
        let point = at_point(outer);
        let (frequency, amplitude) = (means.frequency_hz, means.amplitude_m);
        let hertz = frequency.interval.in_words(" .. ", |v| format!("{v:.4}"));
        let metres = amplitude.interval.in_words(" .. ", |v| format!("{v:.4e}"));
        writeln!(
            out,
            "level {level}{point}, mean of {} replicates and its {:.0} % interval: {:.4} Hz ({hertz}), {:.4e} m ({metres}) ({} failed samples not in it)",
            frequency.replicates,
            100.0 * summary.confidence,
            frequency.mean,
            amplitude.mean,
            amplitude.failed
        )?;
    }
    Ok(())
}

/// Samples solved, and the 5, 50 and 95 % quantiles of frequency and amplitude, one line per level; then what outer
/// points and replicates say.
fn show_levels(out: &mut dyn Write, summary: &Summary) -> std::io::Result<()> {
    for level in &summary.levels {
        let solved = summary.samples - level.failed;
        let (value, unit) = (level.level, &summary.level_unit);
        write!(
            out,
            "level {value} {unit}: {solved} of {} samples solved",
            summary.samples
        )?;
        let quantiles = level
            .frequency_hz
            .quantiles
            .iter()
            .zip(&level.amplitude_m.quantiles);
        for (frequency, amplitude) in quantiles {
            write!(
                out,
                "; {:.0} %: {:.3} Hz, {:.4e} m",
                100.0 * frequency.probability,
                frequency.estimate,
                amplitude.estimate
            )?;
        }
        writeln!(out)?;
    }
    if let Some(epistemic) = &summary.epistemic {
        show_ranges(out, epistemic)?;
    }
    show_replicates(out, summary)
}

/// Ranges of the quantiles over the outer points, with the point of each end.
fn show_ranges(out: &mut dyn Write, epistemic: &EpistemicSummary) -> std::io::Result<()> {
    let (inputs, n) = (epistemic.inputs.join(", "), epistemic.points.len());
    writeln!(
        out,
        "lowest and highest over {n} outer points of {inputs} (these have no probability):"
    )?;
    for level in &epistemic.levels {
        let quantities: [(_, _, &dyn Fn(f64) -> String); 2] = [
            (&level.frequency_hz, "Hz", &|v| format!("{v:.3}")),
            (&level.amplitude_m, "m", &|v| format!("{v:.4e}")),
        ];
        for (ranges, unit, show) in quantities {
            for quantile in ranges {
                let ends = [quantile.range.lowest, quantile.range.highest].map(|end| {
                    let value = end.value.in_words(show);
                    format!("{value} (point {})", end.outer)
                });
                writeln!(
                    out,
                    "level {}, {:.0} %: {} .. {} {unit}",
                    level.level,
                    100.0 * quantile.probability,
                    ends[0],
                    ends[1]
                )?;
            }
        }
        for exceedance in &level.exceedances {
            let limit = exceedance.threshold_m;
            let ends = [exceedance.range.lowest, exceedance.range.highest].map(|end| {
                let value = end.value.value().unwrap_or(f64::NAN);
                format!("{value:.3} (point {})", end.outer)
            });
            writeln!(
                out,
                "level {}, P(amplitude > {limit:.4e} m): {} .. {}",
                level.level, ends[0], ends[1]
            )?;
        }
    }
    Ok(())
}

/// Progress on standard error: a bar on a terminal, else one line per twentieth.
struct Bar {
    bar: indicatif::ProgressBar,
    quiet: bool,
}

impl Bar {
    fn new(quiet: bool) -> Self {
        let bar = if quiet {
            indicatif::ProgressBar::hidden()
        } else {
            indicatif::ProgressBar::new(0)
        };
        Self { bar, quiet }
    }

    /// Makes room for the summary.
    fn clear(&self) {
        self.bar.finish_and_clear();
    }

    fn show(&self, Progress { done, total }: Progress) {
        let before = self.bar.position();
        self.bar.set_length(total);
        self.bar.set_position(done);
        let twentieth = |n: u64| 20 * n / total.max(1);
        let step = twentieth(done) > twentieth(before);
        if !self.quiet && self.bar.is_hidden() && step {
            let eta = self.bar.eta().as_secs();
            // Progress that cannot be shown is no reason to stop.
            let _ = writeln!(std::io::stderr(), "{done}/{total}, about {eta} s left");
        }
    }
}

/// What the intervals of a design without independent samples are.
const INDICATIONS: &str = "no independent samples: intervals are indications";

/// ` at outer point 3`, where there are such.
fn at_point(outer: Option<u64>) -> String {
    outer.map_or_else(String::new, |outer| format!(" at outer point {outer}"))
}

/// Opened before any work, so that an unwritable folder costs no computation.
fn output_folder(study: &Study, arguments: &StudyArguments) -> Result<OutputFolder, Error> {
    let own = study.folder().join(&study.output.folder);
    OutputFolder::open(arguments.output.as_deref().unwrap_or(&own))
}

/// Writes to the standard output; a full disk behind it is an error, not a panic.
fn print(content: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<(), Error> {
    let mut out = std::io::stdout().lock();
    content(&mut out)
        .and_then(|()| out.flush())
        .map_err(|source| Error::file("standard output".as_ref(), source))
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => "a second".to_owned(),
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
