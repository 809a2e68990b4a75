//! From outcomes to files: Parquet, summary and page.
#![expect(
    clippy::unwrap_used,
    reason = "a helper of tests may panic like a test"
)]

mod assessment;
mod columns;
mod comparison;
mod contact_grid;
mod control_variate;
mod epistemic;
mod identification;
mod modes;
mod page;
#[path = "../common/page_rules.rs"]
mod page_rules;
mod performance;
mod record;
mod sensitivity;
mod store;
mod summary;
mod synthetic;
mod synthetic_contact;
mod verdict_points;
mod verdict_sentences;
mod verdicts;
