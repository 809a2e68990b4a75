//! What the criteria say of each engine order.

use super::DiskView;
use crate::page::block::{Block, Cell, Section, Table, Verdict};
use crate::report::disk::summary::OrderSummary;
use crate::report::verdict::criterion_result::CriterionResult;
use crate::report::verdict::sentence::word;
use crate::statistics::Judgement;

/// What the probabilities depend on: once where it is the same for all orders.
fn conditions(orders: &[OrderSummary]) -> String {
    let of_all = orders.first().map(|order| &order.condition);
    if orders.iter().all(|order| Some(&order.condition) == of_all) {
        return of_all.cloned().unwrap_or_default();
    }
    let of_order = |order: &OrderSummary| format!("EO {}: {}", order.engine_order, order.condition);
    let each: Vec<String> = orders.iter().map(of_order).collect();
    each.join(" ")
}

pub(super) fn section(view: &DiskView) -> Section {
    let orders = &view.disk.orders;
    let mut blocks = Vec::new();
    match orders.iter().any(|order| !order.criteria.is_empty()) {
        true => blocks.extend([criteria(orders), Block::Verdicts(sentences(orders))]),
        false => blocks.push(Block::Sentence("The studies state no criteria.".to_owned())),
    }
    let hint = format!(
        "Engine order r excites the nodal diameter that r leaves modulo {0} sectors, or {0} minus it. All sectors are equal: \
         what scatters is common to the whole disk. {1}",
        view.disk.sectors,
        conditions(orders)
    );
    blocks.push(Block::Hint(hint));
    Section {
        id: "verdict",
        title: "Verdict by engine order".to_owned(),
        blocks,
    }
}

/// The word of a judgement and the class of its badge.
fn badge(result: &CriterionResult) -> (&'static str, &'static str) {
    let class = match result.judgement {
        Judgement::Pass => "pass",
        Judgement::Fail => "fail",
        Judgement::Undecided => "undecided",
    };
    (word(result.judgement), class)
}

/// The judgements of all orders at a glance; narrow, so that a phone shows all of it. The sentences are in the download.
fn criteria(orders: &[OrderSummary]) -> Block {
    let mut table = Table::of(
        "Criteria by engine order",
        "disk-criteria",
        &[
            ("Order", &["engine_order", "nodal_diameter"]),
            ("Criterion", &["criterion"]),
            ("Verdict", &["verdict", "sentence"]),
        ],
    );
    for order in orders {
        for result in &order.criteria {
            let (word, class) = badge(result);
            let nodal_diameter = Some(order.nodal_diameter as f64);
            table.row(vec![
                Cell::whole(u64::from(order.engine_order))
                    .with_raw([nodal_diameter])
                    .with_small(format!("nodal diameter {}", order.nodal_diameter))
                    .with_class("text brief"),
                Cell::text(&result.criterion.name).with_class("text brief"),
                Cell::text(word)
                    .with_badge(class)
                    .with_raw_text(&result.sentence)
                    .with_class("text"),
            ]);
        }
    }
    table.block()
}

/// What each judgement says, order by order.
fn sentences(orders: &[OrderSummary]) -> Vec<Verdict> {
    let of_order = |order: &OrderSummary| -> Vec<Verdict> {
        let verdict = |result: &CriterionResult| {
            let (word, class) = badge(result);
            Verdict {
                word: word.to_owned(),
                class,
                name: format!(
                    "Engine order {}: {}",
                    order.engine_order, result.criterion.name
                ),
                sentence: order.sentence(result),
            }
        };
        order.criteria.iter().map(verdict).collect()
    };
    orders.iter().flat_map(of_order).collect()
}
