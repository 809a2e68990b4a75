//! All tests in a table, and what was noted of each.

use super::parameter::{show, show_all};
use super::view::View;
use crate::identify::found::parameter::ContactParameter;
use crate::identify::found::result::{TestEstimate, TestResult, TestStatus};
use crate::identify::found::uncertain::Uncertain;
use crate::page::block::{Block, Cell, Section, Table};
use crate::page::display::{DASH, from_to, hertz, percent};

/// Fields of a value with its interval in the download.
macro_rules! fields {
    ($name:literal) => {
        &[$name, concat!($name, "_lower"), concat!($name, "_upper")] as &'static [&'static str]
    };
}

pub(super) fn section(view: &View) -> Section {
    let hint = format!(
        "In small print: {} intervals, and the range of the load in a cycle. Friction: coefficient from the plateaus of T/N. By \
         energy: from dissipated energy, slip distance and load, a second estimate of the same. Stiffness: tangential; at \
         reversals: after the greatest and after the least displacement. Misfit: root of the mean square of the difference between the mean \
         loop and that of an elastic-Coulomb contact, over the swing of T.",
        percent(view.confidence())
    );
    Section {
        id: "tests",
        title: "Tests".to_owned(),
        blocks: [
            Some(table(view)),
            Some(Block::Hint(hint)),
            Some(cycle_table(view)),
            Some(Block::Hint(OF_CYCLES.to_owned())),
            notes(view),
        ]
        .into_iter()
        .flatten()
        .collect(),
    }
}

fn table(view: &View) -> Block {
    let normal =
        |(_, _, e): (usize, &TestResult, &TestEstimate)| e.normal_stiffness_n_per_um.is_some();
    let normal = view.estimates().any(normal);
    let mut columns: Vec<(String, &'static [&'static str])> = vec![
        ("Test".to_owned(), &["test", "specimen"]),
        (
            "Load (N)".to_owned(),
            &[
                "normal_force_n",
                "normal_force_least_n",
                "normal_force_greatest_n",
            ],
        ),
        (
            format!("Amplitude ({})", view.unit.symbol),
            &["displacement_amplitude_m"],
        ),
        (
            "Cycles".to_owned(),
            &["frequency_hz", "cycles", "run_in", "steady"],
        ),
        ("Friction".to_owned(), fields!("friction")),
        (
            "By energy".to_owned(),
            &["friction_from_energy", "energy_difference"],
        ),
        (
            "Stiffness (N/µm)".to_owned(),
            fields!("tangential_n_per_um"),
        ),
        (
            "At reversals".to_owned(),
            &["after_greatest_n_per_um", "after_least_n_per_um"],
        ),
        ("Misfit".to_owned(), &["misfit"]),
    ];
    if normal {
        columns.push(("Normal (N/µm)".to_owned(), fields!("normal_n_per_um")));
    }
    let mut table = Table::new("Tests, mean of the steady cycles of each", "tests", columns);
    for (i, test) in view.found.tests.iter().enumerate() {
        let mut cells = vec![name_cell(view, i, test)];
        cells.extend(numbers(view, test));
        if normal {
            cells.push(uncertain_cell(value(
                test,
                ContactParameter::NormalStiffnessNPerUm,
            )));
        }
        match test.estimate {
            Some(_) => table.row(cells),
            None => table.quiet_row(cells),
        }
    }
    table.block()
}

const OF_CYCLES: &str = "Slip begins: way after a reversal to where the branch leaves its first slope; slips: way from the middle of the stick branch to \
                         where the whole contact slips. Scatter: standard deviation of the steady cycles over their mean, with the noise of each cycle.";

/// What the cycles of each test dissipate, where they begin to slip, and how they differ.
fn cycle_table(view: &View) -> Block {
    let unit = view.unit.symbol;
    let columns: Vec<(String, &'static [&'static str])> = vec![
        ("Test".to_owned(), &["test"]),
        ("Energy per cycle (J)".to_owned(), fields!("energy_j")),
        (format!("Slip begins ({unit})"), &["first_slip_m"]),
        (format!("Slips ({unit})"), &["elastic_limit_m"]),
        ("Scatter of friction".to_owned(), &["scatter_of_friction"]),
        ("Of stiffness".to_owned(), &["scatter_of_stiffness"]),
        ("Of energy".to_owned(), &["scatter_of_energy"]),
    ];
    let title = "Energy, onset of slip and scatter from cycle to cycle";
    let mut table = Table::new(title, "cycles-of-tests", columns);
    for (i, _, estimate) in view.estimates() {
        let way = |way: Option<f64>| shown(way, &|way| show(way * view.unit.per_metre));
        let share = |share: Option<f64>| shown(share, &percent);
        let scatter = estimate.loop_scatter;
        table.row(vec![
            view.test_cell(i),
            uncertain_cell(Some(estimate.energy_j)),
            way(estimate.onset.map(|onset| onset.first_slip_m)),
            way(estimate.onset.map(|onset| onset.elastic_limit_m)),
            share(scatter.and_then(|s| s.friction_coefficient)),
            share(scatter.and_then(|s| s.tangential_stiffness)),
            share(scatter.and_then(|s| s.energy)),
        ]);
    }
    table.block()
}

/// A number as `text`, or a dash.
fn shown(value: Option<f64>, text: &dyn Fn(f64) -> String) -> Cell {
    Cell::number(value.map_or_else(|| DASH.to_owned(), text), value)
}

/// Word before the name of a specimen that does not begin with it.
const SPECIMEN: &str = "specimen";

fn name_cell(view: &View, i: usize, test: &TestResult) -> Cell {
    let specimen = test.conditions.specimen.as_deref().unwrap_or_default();
    let named = specimen.to_lowercase().starts_with(SPECIMEN);
    let small = match specimen {
        "" => String::new(),
        specimen if named => specimen.to_owned(),
        specimen => format!("{SPECIMEN} {specimen}"),
    };
    let cell = view.test_cell(i).with_small(small);
    let warning = match test.status {
        TestStatus::Slips => None,
        TestStatus::NoSlip => Some("does not slip as a whole"),
        TestStatus::Unusable(_) => Some("not used"),
    };
    cell.with_raw_text(specimen)
        .with_warning(warning.map(str::to_owned))
}

fn value(test: &TestResult, parameter: ContactParameter) -> Option<Uncertain> {
    test.estimate.as_ref()?.value(parameter)
}

fn numbers(view: &View, test: &TestResult) -> Vec<Cell> {
    let estimate = test.estimate.as_ref();
    let friction = match estimate.and_then(|e| Some((e.friction.is_none(), e.friction_at_least?))) {
        Some((true, least)) => {
            Cell::number(format!("≥ {}", show(least)), None).with_raw([Some(least), None])
        }
        _ => uncertain_cell(value(test, ContactParameter::FrictionCoefficient)),
    };
    let misfit = estimate.map(|e| e.misfit);
    let amplitude = estimate.map(|e| e.displacement_amplitude_m);
    let large = misfit.filter(|m| m.large).map(|_| "large".to_owned());
    vec![
        load_cell(estimate),
        shown(amplitude, &|a| show(a * view.unit.per_metre)),
        cycles_cell(test),
        friction,
        energy_cell(estimate),
        uncertain_cell(value(test, ContactParameter::TangentialStiffnessNPerUm)),
        sides_cell(estimate),
        shown(misfit.map(|m| m.relative_rms), &percent).with_warning(large),
    ]
}

fn load_cell(estimate: Option<&TestEstimate>) -> Cell {
    let Some(estimate) = estimate else {
        return Cell::number(DASH, None).with_raw([None; 2]);
    };
    let [least, greatest] = estimate.normal_force_range_n;
    Cell::number(show(estimate.normal_force_n), Some(estimate.normal_force_n))
        .with_raw([least, greatest].map(Some))
        .with_small(from_to([least, greatest], show))
}

fn cycles_cell(test: &TestResult) -> Cell {
    let Some(cycles) = test.cycles else {
        return Cell::number(DASH, None).with_raw([None; 3]);
    };
    let counts = [cycles.whole, cycles.run_in, cycles.steady];
    let frequency = cycles.frequency_hz;
    Cell::number(
        format!("{} of {}", cycles.steady, cycles.whole),
        Some(frequency),
    )
    .with_raw(counts.map(|n| Some(n as f64)))
    .with_small(format!("at {} Hz", hertz(frequency)))
}

fn energy_cell(estimate: Option<&TestEstimate>) -> Cell {
    let friction = estimate.and_then(|e| e.friction);
    let value = friction.and_then(|f| f.from_energy);
    let difference = friction.and_then(|f| f.energy_difference);
    let cell =
        Cell::number(value.map_or_else(|| DASH.to_owned(), show), value).with_raw([difference]);
    match difference {
        Some(difference) => cell.with_small(signed_percent(difference)),
        None => cell,
    }
}

/// `+1.2 %`.
fn signed_percent(share: f64) -> String {
    let sign = if share < 0.0 { "−" } else { "+" };
    format!("{sign}{}", percent(share.abs()))
}

/// Stiffness after both reversals.
fn sides_cell(estimate: Option<&TestEstimate>) -> Cell {
    let sides = estimate.map_or([None; 2], |e| e.tangential.sides_n_per_um);
    let values = sides.map(|side| side.map(|s| s.value));
    let shown = values.map(|value| value.map_or_else(|| DASH.to_owned(), show));
    Cell::number(shown.join(", "), values[0]).with_raw([values[1]])
}

fn uncertain_cell(found: Option<Uncertain>) -> Cell {
    let Some(found) = found else {
        return Cell::number(DASH, None).with_raw([None; 2]);
    };
    let ends = [found.lower, found.upper];
    let [value, lower, upper] = show_all(found);
    Cell::number(value, Some(found.value))
        .with_raw(ends.map(Some))
        .with_small(format!("{lower} … {upper}"))
}

/// What was noted of the tests; absent where nothing was.
fn notes(view: &View) -> Option<Block> {
    let mut table = Table::of(
        "Notes",
        "notes",
        &[("Test", &["test"]), ("Note", &["note"])],
    );
    let tests = view.found.tests.iter().enumerate();
    let mut notes = tests
        .flat_map(|(i, test)| test.notes.iter().map(move |note| (i, note)))
        .peekable();
    notes.peek()?;
    for (i, note) in notes {
        table.row(vec![
            view.test_cell(i),
            Cell::text(note).with_class("text wide"),
        ]);
    }
    Some(table.block())
}
