//! One case per interval, law and number of samples: does the interval of a repetition hold the truth?

mod case;
mod control_variate;
mod independent;
mod pooled;
mod sensitivity;
mod verdicts;

use case::Cases;
pub(crate) use case::{Case, Statement};

/// All cases.
pub(crate) fn all() -> Vec<Case> {
    let mut cases = Cases(Vec::new());
    independent::order_statistics(&mut cases);
    independent::pairs(&mut cases);
    independent::moments(&mut cases);
    independent::curves(&mut cases);
    independent::weights(&mut cases);
    control_variate::control_variates(&mut cases);
    pooled::pooled_tests(&mut cases);
    sensitivity::replicates(&mut cases);
    sensitivity::given_data(&mut cases);
    sensitivity::pick_freeze(&mut cases);
    sensitivity::surrogates(&mut cases);
    verdicts::verdicts_over_a_box(&mut cases);
    verdicts::stopped_studies(&mut cases);
    cases.0
}
