//! Whether the numbers of a test can be used.

use crate::identify::found::parameter::ContactParameter;
use crate::identify::found::result::TestResult;
use crate::setting::FRICTION;

/// The result, if its numbers and their intervals are finite, and its friction coefficient is one that can be meant. Cycles that differ by
/// many orders of magnitude leave none. A force in a wrong unit makes the coefficient a thousand times as large.
pub(super) fn known(result: TestResult) -> Result<TestResult, String> {
    let estimate = result.estimate.as_ref();
    let unknown = ContactParameter::ALL.into_iter().find(|parameter| {
        let found = estimate.and_then(|e| e.value(*parameter));
        found.is_some_and(|found| {
            ![found.value, found.lower, found.upper]
                .iter()
                .all(|x| x.is_finite())
        })
    });
    if let Some(parameter) = unknown {
        return Err(format!(
            "has cycles so different from each other that nothing is known of the {}",
            parameter.in_words()
        ));
    }
    let [_, most] = FRICTION;
    let coefficient = estimate.and_then(|e| e.friction.map(|f| f.coefficient.value));
    let ratio = coefficient.or_else(|| estimate.and_then(|e| e.friction_at_least));
    match ratio.filter(|ratio| *ratio > most) {
        None => Ok(result),
        Some(ratio) => Err(format!(
            "has a tangential over normal force of {ratio:.4}: must be at most {most}; is the unit of one wrong?"
        )),
    }
}
