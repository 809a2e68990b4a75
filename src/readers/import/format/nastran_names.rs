//! Names of the rows of OP4 matrices, from the bulk data beside them (`.pch`, `.asm`): EXTRN, else the a-set, else grid and
//! scalar points.

use std::collections::BTreeSet;
use std::path::Path;

use super::super::dof::Dof;
use super::super::lines::{MOST_ROWS, whole};
use super::super::matrix::Naming;
use super::nastran_cards::{Card, each_card};
use crate::file::FileError;

const CARDS: [&str; 8] = [
    "EXTRN", "ASET", "QSET", "ASET1", "QSET1", "GRID", "SPOINT", "SEQGP",
];

/// Lists of names, by where they come from.
#[derive(Default)]
struct Lists {
    extrn: Naming,
    /// Nastran orders the a-set by number and component.
    a_set: BTreeSet<Dof>,
    /// Grid and scalar points.
    points: Naming,
}

/// The names that the entries of a file give, if there are any.
pub(in crate::import) fn read(path: &Path, text: &str) -> Result<Option<Vec<Dof>>, FileError> {
    let mut lists = Lists::default();
    each_card(path, text, &CARDS, |card| {
        lists
            .add(&card)
            .map_err(|(at, rule)| card.fault(path, at, rule))
    })?;
    let Lists {
        extrn,
        a_set,
        points,
    } = lists;
    if extrn.len() > 0 {
        return Ok(Some(extrn.names()));
    }
    if !a_set.is_empty() {
        return Ok(Some(a_set.into_iter().collect()));
    }
    // Nastran orders these, too, by their numbers, grid and scalar points together
    let mut names = points.names();
    names.sort();
    Ok(Some(names).filter(|names| !names.is_empty()))
}

/// Index of a field and the rule that it breaks.
type Fault = (usize, String);

impl Lists {
    fn add(&mut self, card: &Card<'_>) -> Result<(), Fault> {
        match card.name.as_str() {
            "EXTRN" => pairs(card, &mut |dof| self.extrn.add(dof)),
            "ASET" | "QSET" => pairs(card, &mut |dof| insert(&mut self.a_set, dof)),
            "ASET1" | "QSET1" => {
                let components = components(card.field(0)).map_err(|rule| (0, rule))?;
                points(card, 1, &mut |point| {
                    let mut dofs = components.iter().map(|c| Dof::new(point, *c));
                    dofs.try_for_each(|dof| insert(&mut self.a_set, dof))
                })
            }
            "SPOINT" => points(card, 0, &mut |point| self.points.add(Dof::new(point, 0))),
            "SEQGP" => Err((
                0,
                "SEQGP: must be absent: it gives points another order than that of their numbers, so that rows would have wrong names"
                    .to_owned(),
            )),
            _ => {
                let point = whole("grid point", card.field(0), 1, i64::from(i32::MAX));
                let point = point.map_err(|rule| (0, rule))?;
                let mut dofs = (1..=6).map(|component| Dof::new(point, component));
                let added = dofs.try_for_each(|dof| self.points.add(dof));
                added.map_err(|rule| (0, rule))
            }
        }
    }
}

fn insert(set: &mut BTreeSet<Dof>, dof: Dof) -> Result<(), String> {
    set.insert(dof);
    match set.len() > MOST_ROWS {
        true => Err(format!("has more than {MOST_ROWS} degrees of freedom")),
        false => Ok(()),
    }
}

/// `point components point components ...`.
fn pairs(card: &Card<'_>, add: &mut dyn FnMut(Dof) -> Result<(), String>) -> Result<(), Fault> {
    for at in (0..card.fields.len()).step_by(2) {
        if card.field(at).is_empty() && card.field(at + 1).is_empty() {
            continue;
        }
        let fault = |rule| (at, rule);
        let point = whole("grid point", card.field(at), 1, i64::from(i32::MAX)).map_err(fault)?;
        for component in components(card.field(at + 1)).map_err(fault)? {
            add(Dof::new(point, component)).map_err(fault)?;
        }
    }
    Ok(())
}

/// `point point ...`, or `point THRU point`.
fn points(
    card: &Card<'_>,
    first: usize,
    add: &mut dyn FnMut(i64) -> Result<(), String>,
) -> Result<(), Fault> {
    let number = |at: usize| {
        let point = whole("point", card.field(at), 1, i64::from(i32::MAX));
        point.map_err(|rule| (at, rule))
    };
    if card.field(first + 1).eq_ignore_ascii_case("THRU") {
        let (from, to) = (number(first)?, number(first + 2)?);
        if to < from || to - from >= MOST_ROWS as i64 {
            let rule = format!("{from} THRU {to}: must ascend, by less than {MOST_ROWS}");
            return Err((first, rule));
        }
        return (from..=to).try_for_each(|point| add(point).map_err(|rule| (first, rule)));
    }
    for at in first..card.fields.len() {
        if !card.field(at).is_empty() {
            let point = number(at)?;
            add(point).map_err(|rule| (at, rule))?;
        }
    }
    Ok(())
}

/// `123456` is six components; 0 or blank is a scalar point.
fn components(text: &str) -> Result<Vec<u32>, String> {
    if matches!(text, "" | "0") {
        return Ok(vec![0]);
    }
    let digit = |c: char| c.to_digit(10).filter(|digit| (1..=6).contains(digit));
    let digits: Option<Vec<u32>> = text.chars().map(digit).collect();
    digits.ok_or_else(|| format!("components {text:.20}: must be digits from 1 to 6, or 0"))
}
