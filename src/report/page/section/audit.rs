//! Audit: what produced the numbers, and what they depend on.

use crate::ensemble::backend::GpuReport;
use crate::page::block::{Block, Cell, Section, Table};
use crate::page::display::{percent, short};
use crate::page::sheet::{fields, sheet};
use crate::report::page::view::View;
use crate::report::run::record::FileRecord;

pub(super) fn section(view: &View) -> Section {
    let hint = "The same study file, program and instruction set give the same samples, bit by bit, for any number of \
                threads. `microslip report` on the folder of the results renders this page again without solving.";
    Section {
        id: "audit",
        title: "Audit".to_owned(),
        blocks: vec![
            priors(view),
            provenance(view),
            files(view),
            Block::Hint(hint.replace('`', "")),
        ],
    }
}

fn priors(view: &View) -> Block {
    let inputs = view.input.record.inputs.iter();
    let title =
        "Distributions of the inputs: every probability of this page is conditional on them";
    sheet(
        title,
        "inputs",
        inputs.map(|i| (i.name.clone(), i.assumption())),
    )
}

/// The provenance under the names that it has in the files.
fn provenance(view: &View) -> Block {
    let record = view.input.record;
    let stated = fields(&record.provenance);
    let failed: usize = view.summary.levels.iter().map(|l| l.failed).sum();
    let solves = view.summary.samples * view.summary.levels.len();
    let absent = || "not used".to_owned();
    let more = [
        ("Design", record.design.description.clone()),
        ("Backend", record.backend.description()),
        ("Adapter", record.backend.adapter().unwrap_or_else(absent)),
        (
            "Audit of the GPU",
            (record.backend.gpu.as_ref()).map_or_else(absent, gpu_audit),
        ),
        (
            "Without a solution",
            format!(
                "{failed} of {solves} solves ({})",
                percent(failed as f64 / solves.max(1) as f64)
            ),
        ),
        (
            "Wall time of the last command",
            format!("{} s", short(record.wall_time_s)),
        ),
    ];
    let more = more.map(|(name, value)| (name.to_owned(), value));
    sheet("Run", "run", stated.into_iter().chain(more))
}

fn gpu_audit(gpu: &GpuReport) -> String {
    format!(
        "{} of {} predicted peaks improved, {} of them searched again without, largest difference {:.1e} of a frequency and {:.1e} of an amplitude, {} replaced by those searched again",
        gpu.lanes - gpu.lanes_lost,
        gpu.lanes,
        gpu.peaks_compared,
        gpu.largest_frequency_difference,
        gpu.largest_amplitude_difference,
        gpu.peaks_beyond_limit
    )
}

fn files(view: &View) -> Block {
    let record = view.input.record;
    let mut table = Table::of(
        "Files",
        "files",
        &[
            ("File", &["file"]),
            ("BLAKE3 of its content", &["blake3"]),
            ("Now", &["state"]),
        ],
    );
    let state = |file: &FileRecord| match view.input.changed.contains(&file.name) {
        true => "changed",
        false => "as written",
    };
    let tables = record.tables.iter().map(|file| (file, state(file)));
    let read = [&record.study_file].into_iter().chain(&record.files);
    for (file, state) in read.map(|file| (file, "as read")).chain(tables) {
        table.row(vec![
            Cell::text(&file.name),
            Cell::text(&file.blake3).with_class("text wide code"),
            Cell::text(state),
        ]);
    }
    table.block()
}
