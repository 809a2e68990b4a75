//! The virtual rig: its physics against independent formulas, its files, and what an identification finds in them.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot set up its rig fails"
)]

mod blade;
mod closed_loop;
mod command;
mod instruments;
mod loading;
mod motion;
#[path = "../common/program.rs"]
mod program;
mod response;
mod signals;
mod step_sine;

use microslip::rig::{Rig, VirtualTest};
use std::path::Path;

/// A rig from its text.
fn rig(text: &str) -> Rig {
    Rig::parse(Path::new("rig.toml"), text).unwrap()
}

/// A rig without any error of its instruments, with further sections.
fn exact(sections: &str) -> Rig {
    let text = format!(
        "name = \"exact\"\n{sections}
        [support]
        k12_n_per_um = 0
        decoupling = [1, 1]
        [force_cells]
        error_percent = 0
        noise_n = 0
        drift_n_per_s = 0
        [vibrometer]
        resolution_um = 0
        noise_um = 0
        drift_um_per_s = 0"
    );
    rig(&text)
}

const STEADY_AIR: &str = "[loading]\nkind = \"air\"\nregulator_noise_percent = 0\n";

fn first_test(rig: &Rig) -> VirtualTest {
    rig.test(&rig.stand().unwrap(), 0)
}
