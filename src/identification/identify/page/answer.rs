//! The answer in a sentence, the numbers that matter most, and what must be known before they are used.

use super::parameter::{show, with_unit};
use super::view::View;
use crate::identify::found::parameter::ContactParameter;
use crate::identify::found::pooled_result::{Pooled, PooledParameter};
use crate::identify::found::result::{TestEstimate, TestStatus};
use crate::page::block::{Block, Cell, Section, Table};
use crate::page::display::{DASH, from_to, percent, with_digits};
use crate::statistics::hull;

pub(super) fn section(view: &View) -> Section {
    let mut blocks = vec![Block::Sentence(sentence(view)), Block::Facts(facts(view))];
    let notices = notices(view);
    if !notices.is_empty() {
        blocks.push(Block::Notices(notices));
    }
    if let Some(pooled) = &view.found.pooled {
        blocks.push(table(view, pooled));
    }
    let hint = "A further contact: another of the same kind, under the loads of the tests. Its interval holds the scatter between \
                contacts, what so few tests leave unknown of it, and the stated errors of the measuring chain. Scatter: \
                standard deviation of the logarithm.";
    blocks.push(Block::Hint(hint.to_owned()));
    Section {
        id: "answer",
        title: "Answer".to_owned(),
        blocks,
    }
}

/// What is known of a further contact, and what is not bounded.
fn sentence(view: &View) -> String {
    let known: Vec<&PooledParameter> = ContactParameter::ALL
        .into_iter()
        .filter_map(|p| view.pooled(p))
        .collect();
    let mut parts = known.iter().enumerate().map(|(i, found)| {
        let [low, high] = found.further_contact.map(show);
        let median = with_unit(found.parameter, &show(found.median.value));
        let words = match i {
            0 => {
                let probability = percent(view.confidence());
                format!("{median} (median; {low} to {high} with {probability} probability)")
            }
            _ => format!("{median} ({low} to {high})"),
        };
        format!("a {} of {words}", found.parameter.in_words())
    });
    let first = match (parts.next(), parts.collect::<Vec<_>>().as_slice()) {
        (None, _) => "The tests give no parameter of the contact.".to_owned(),
        (Some(one), others) => {
            let whole = match others {
                [] => one,
                [last] => format!("{one} and {last}"),
                [middle @ .., last] => format!("{one}, {} and {last}", middle.join(", ")),
            };
            format!(
                "A further contact of this kind has {whole}{}.",
                basis(view, &known)
            )
        }
    };
    let unknown = ContactParameter::ALL
        .into_iter()
        .filter(|p| view.pooled(*p).is_none());
    let unknown = unknown.map(|parameter| not_bounded(view, parameter));
    [first]
        .into_iter()
        .chain(unknown)
        .collect::<Vec<_>>()
        .join(" ")
}

/// `, from 12 tests of 5 specimens`.
fn basis(view: &View, known: &[&PooledParameter]) -> String {
    let tests = known.iter().map(|p| p.tests).max().unwrap_or(0);
    let specimens = view.found.pooled.as_ref().map_or(0, |p| p.specimens);
    match (tests, specimens) {
        (1, _) => ", from one test, which does not show how contacts differ".to_owned(),
        (tests, specimens) if specimens < tests => {
            format!(", from {tests} tests of {}", counted(specimens, "specimen"))
        }
        (tests, _) => format!(", from {tests} tests"),
    }
}

fn counted(number: usize, word: &str) -> String {
    match number {
        1 => format!("one {word}"),
        _ => format!("{number} {word}s"),
    }
}

/// Why a parameter is not in the answer, and what is known of it.
fn not_bounded(view: &View, parameter: ContactParameter) -> String {
    let pooled = view.found.pooled.as_ref();
    let least = pooled.and_then(|p| p.friction_at_least);
    match (parameter, least) {
        (ContactParameter::FrictionCoefficient, Some(least)) => format!(
            "Its friction coefficient is {} at least: no contact slipped as a whole, so the tests do not bound it from above.",
            show(least)
        ),
        (ContactParameter::NormalStiffnessNPerUm, _) => {
            "Its normal stiffness is not bounded: no test shows normal motion that is large enough."
                .to_owned()
        }
        _ => format!("Its {} is not bounded.", parameter.in_words()),
    }
}

fn facts(view: &View) -> Vec<(String, String)> {
    let tests = &view.found.tests;
    let usable = view.estimates().count();
    let of_all = |count: usize| match count == tests.len() {
        true => count.to_string(),
        false => format!("{count} of {}", tests.len()),
    };
    let slips = tests
        .iter()
        .filter(|t| t.status == TestStatus::Slips)
        .count();
    let cycles = tests
        .iter()
        .filter_map(|t| Some(t.cycles?.steady))
        .sum::<usize>();
    let range = |of: fn(&TestEstimate) -> f64, scale: f64, unit: &str| {
        let values = view.estimates().map(|(_, _, e)| of(e) * scale);
        match hull(values) {
            Some(ends) => format!("{} {unit}", from_to(ends, |v| with_digits(v, 2))),
            None => DASH.to_owned(),
        }
    };
    let unit = view.unit;
    [
        ("tests used", of_all(usable)),
        ("of these slip as a whole", slips.to_string()),
        ("steady cycles", cycles.to_string()),
        ("normal force", range(|e| e.normal_force_n, 1.0, "N")),
        (
            "displacement amplitude",
            range(|e| e.displacement_amplitude_m, unit.per_metre, unit.symbol),
        ),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .to_vec()
}

/// What must be known before a number of the page is used: notes of the identification, tests that it did not use among them,
/// and misfits.
fn notices(view: &View) -> Vec<String> {
    let mut notices = view.found.notes.clone();
    let large = view.estimates().filter(|(_, _, e)| e.misfit.large);
    let large: Vec<&str> = large.map(|(_, test, _)| test.name.as_str()).collect();
    if !large.is_empty() {
        notices.push(format!(
            "The loops of {} are not those of an elastic-Coulomb contact: its two parameters say less of {}, see the residuals.",
            large.join(", "),
            if large.len() == 1 { "it" } else { "them" }
        ));
    }
    notices
}

/// All tests together.
fn table(view: &View, pooled: &Pooled) -> Block {
    let further: &'static [&'static str] = &["further_lower", "further_upper"];
    let mut table = Table::of(
        "Parameters, all tests together",
        "parameters",
        &[
            ("Parameter", &["parameter"]),
            ("Tests", &["tests"]),
            ("Median", &["median", "median_lower", "median_upper"]),
            ("Scatter between contacts", &["log_scatter"]),
            ("Further contact", further),
            ("Factor for few specimens", &["few_tests_factor"]),
        ],
    );
    for found in &pooled.parameters {
        let median = found.median;
        let show_unit = |text: String| with_unit(found.parameter, &text);
        let [low, high] = found.further_contact;
        table.row(vec![
            Cell::text(found.parameter.in_words()).with_class("text brief"),
            Cell::whole(found.tests as u64),
            Cell::number(show_unit(show(median.value)), Some(median.value))
                .with_raw([median.lower, median.upper].map(Some))
                .with_small(from_to([median.lower, median.upper], show)),
            Cell::number(
                found
                    .log_scatter
                    .map_or_else(|| "one test".to_owned(), percent),
                found.log_scatter,
            ),
            Cell::number(show_unit(from_to([low, high], show)), Some(low))
                .with_raw([Some(high)])
                .with_small(format!("{} probability", percent(view.confidence()))),
            Cell::number(show(found.few_tests_factor), Some(found.few_tests_factor)),
        ]);
    }
    table.block()
}
