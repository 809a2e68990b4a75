//! Intervals of contacts that several tests are pooled for.

#[path = "../../../tests/identify/population.rs"]
mod population;
#[path = "../../../tests/identify/synthetic.rs"]
mod synthetic;

use super::super::functions::Numbers;
use super::case::Cases;
use microslip::identify::{IdentifySettings, identify_test, pool};
use population::{MEDIANS, SCATTER, deviations};
use synthetic::Bench;

/// Scatter of the logarithms between the tests of a specimen; that between specimens is [`SCATTER`].
const WITHIN: [f64; 2] = [0.05, 0.1];

/// Specimens, and tests of each.
const POPULATIONS: [(usize, usize); 4] = [(3, 1), (5, 1), (20, 1), (5, 3)];

/// Deviations of a specimen or of one of its tests.
fn drawn(numbers: &mut Numbers, scatter: [f64; 2]) -> [f64; 2] {
    deviations([numbers.normal(), numbers.normal()], scatter)
}

/// Parameters of a contact of a specimen that lies so far from the medians.
fn contact(numbers: &mut Numbers, of_specimen: [f64; 2]) -> [f64; 2] {
    let of_test = drawn(numbers, WITHIN);
    [0, 1].map(|k| MEDIANS[k] * (of_specimen[k] + of_test[k]).exp())
}

/// The median of contacts and the interval of a further one, on specimens that were never tested.
pub(crate) fn pooled_tests(cases: &mut Cases) {
    for (specimens, tests) in POPULATIONS {
        let samples = format!("{specimens} specimens, {tests} tests of each");
        let statement = |of: &'static str, parameter: &str| (of, format!("{samples}, {parameter}"));
        let statements = ["median of contacts", "further contact"]
            .into_iter()
            .flat_map(|of| ["friction", "stiffness"].map(|parameter| statement(of, parameter)));
        cases.add_several(statements.collect(), move |numbers, seed| {
            let mut all = Vec::new();
            for specimen in 0..specimens {
                let of_specimen = drawn(numbers, SCATTER);
                for _ in 0..tests {
                    let [friction, stiffness] = contact(numbers, of_specimen);
                    let bench = Bench {
                        friction,
                        stiffness: [stiffness * 1e6; 2],
                        amplitude: 8e-6,
                        per_cycle: 120.0,
                        cycles: 6,
                        noise: [0.0, 0.5, 0.5],
                        seed: 100 * seed + all.len() as u64,
                        ..Bench::default()
                    };
                    let settings = IdentifySettings::default();
                    let mut test = identify_test(&bench.record(), &settings);
                    test.conditions.specimen = Some(specimen.to_string());
                    all.push(test);
                }
            }
            let further = drawn(numbers, SCATTER);
            let further = contact(numbers, further);
            let found = pool(&all, &IdentifySettings::default()).parameters;
            let medians = [0, 1].map(|k| {
                let median = found[k].median;
                median.lower <= MEDIANS[k] && MEDIANS[k] <= median.upper
            });
            let contacts = [0, 1].map(|k| {
                let [lower, upper] = found[k].further_contact;
                lower <= further[k] && further[k] <= upper
            });
            [medians, contacts].concat()
        });
    }
}
