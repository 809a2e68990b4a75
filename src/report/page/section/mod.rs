//! The sections of the page, from what a designer signs to what an auditor asks.

mod amplification;
mod audit;
mod campbell;
mod control_variate;
mod convergence;
mod curve_bands;
mod decision;
mod distribution;
mod envelope;
mod epistemic;
mod error_budget;
mod failure;
mod influence;
mod modes;
mod one_at_a_time;
mod performance;
mod response;
mod response_frame;
mod several_answers;
mod stress;
mod surrogate;
mod verdict;
mod worst_case;

use super::view::View;
use crate::page::block::Section;

/// All sections that the study has something for, in the order of the page.
pub(super) fn sections(view: &View) -> Vec<Section> {
    let all = [
        Some(verdict::section(view)),
        campbell::section(view),
        stress::section(view),
        epistemic::section(view),
        envelope::section(view),
        modes::section(view),
        amplification::section(view),
        performance::section(view),
        Some(response::section(view)),
        distribution::section(view),
        influence::section(view),
        one_at_a_time::section(view),
        surrogate::section(view),
        control_variate::section(view),
        convergence::section(view),
        Some(error_budget::section(view)),
        Some(failure::section(view)),
        Some(audit::section(view)),
    ];
    all.into_iter().flatten().collect()
}
