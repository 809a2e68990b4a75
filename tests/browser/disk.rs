//! The page of a disk in a real browser.

use crate::synthetic::SyntheticStudy;
use crate::{PAPER, assert_sound, browser, measure, on_paper};
use microslip::hb::Status;
use microslip::report::StoredRun;
use microslip::report::disk::{DiskSummary, write};
use microslip::report::run::record::{DiskRecord, NodalRecord};
use std::path::Path;

const SECTORS: usize = 48;
const ORDERS: [u32; 4] = [3, 6, 9, 12];

/// The run of an engine order: resonances rise with the nodal diameter, and some peaks of the highest level are unstable.
fn run(folder: &Path, engine_order: u32) -> StoredRun {
    let mut study = SyntheticStudy::new(60);
    let nodal = |nodal_diameter: usize| NodalRecord {
        nodal_diameter,
        rigid_modes: 0,
        free_hz: vec![2960.0 + nodal_diameter as f64],
        stuck_hz: vec![2968.0 + nodal_diameter as f64],
    };
    study.record.disk = Some(DiskRecord {
        sectors: SECTORS,
        engine_order,
        nodal_diameter: engine_order as usize,
        nodal_diameters: (0..=SECTORS / 2).map(nodal).collect(),
        sector: None,
    });
    if let Some(operation) = &mut study.record.requirements.operation {
        operation.engine_orders = vec![engine_order];
    }
    for outcome in &mut study.outcomes {
        for level in &mut outcome.levels {
            if let Some(peak) = &mut level.peak {
                peak.frequency_hz += f64::from(engine_order);
            }
        }
        let top = outcome.levels.len() - 1;
        let highest = &mut outcome.levels[top];
        if let Some(peak) = highest.peak.as_mut().filter(|_| outcome.index % 9 == 0) {
            peak.multiplier_real = Some(-1.1).into();
            peak.multiplier_imaginary = Some(0.0).into();
            highest.status = Status::Unstable;
        }
    }
    study.store(folder);
    StoredRun::read(folder).unwrap()
}

/// Seen to fail with paragraphs of 3000 px.
#[test]
fn a_disk_is_drawn_and_nothing_overflows() {
    let Some(browser) = browser() else { return };
    let folder = tempfile::tempdir().unwrap();
    let places = ORDERS.map(|order| folder.path().join(format!("order-{order}")));
    let runs: Vec<StoredRun> = (places.iter().zip(ORDERS))
        .map(|(place, order)| {
            std::fs::create_dir(place).unwrap();
            run(place, order)
        })
        .collect();
    let places: Vec<&Path> = places.iter().map(|place| place.as_path()).collect();
    let disk = DiskSummary::of(&places, &runs).unwrap();
    write(folder.path(), &disk, &runs).unwrap();
    let page = std::fs::read_to_string(folder.path().join("disk.html")).unwrap();
    let figures = page.matches("<figure>").count();
    assert_eq!(figures, 3, "figures of the page");
    for width in [390, 1024, 1920] {
        let found = measure(&browser, &page, width);
        assert_sound(&found, width, figures, &format!("{width} px"));
    }
    let found = measure(&browser, &on_paper(&page), PAPER);
    assert_sound(&found, PAPER, figures, "print");
}
