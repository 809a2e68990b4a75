//! The joint distribution that a study reads, from what is pooled.

use crate::identify::found::identified::IdentifiedInput;
use crate::identify::found::parameter::ContactParameter;
use crate::identify::found::pooled_result::{Pooled, PooledParameter, Trend, TrendOver};
use crate::identify::settings::IdentifySettings;
use crate::sampling::Shape;
use crate::setting::BadSetting;

/// Standard deviation of a logarithm from which on a distribution says nothing: one of them is a factor of 22000.
const LARGEST_LOG_DEVIATION: f64 = 10.0;
/// Standard deviation of a logarithm below which a value is fixed.
const SMALLEST_LOG_DEVIATION: f64 = 1e-9;
/// Specimens up to which the factor for few of them is told.
const FEW: usize = 10;

/// Parameters with their distributions, their correlation, and what a reader should know.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::identify) struct Joint {
    pub(in crate::identify) inputs: Vec<IdentifiedInput>,
    pub(in crate::identify) correlation: Vec<Vec<f64>>,
    pub(in crate::identify) notes: Vec<String>,
}

/// Lognormal distributions of a further contact.
///
/// # Errors
/// [`BadSetting`] if the greatest friction coefficient that is stated is below one that the tests have reached.
pub(in crate::identify) fn joint(
    pooled: &Pooled,
    settings: &IdentifySettings,
) -> Result<Joint, BadSetting> {
    let (mut inputs, mut places, mut notes) = (Vec::new(), Vec::new(), Vec::new());
    for (row, parameter) in pooled.parameters.iter().enumerate() {
        if let Some(shape) = shape(parameter, settings) {
            inputs.push(IdentifiedInput {
                parameter: parameter.parameter,
                shape,
            });
            places.push(row);
        } else {
            let (name, tests) = (parameter.parameter.name(), parameter.tests);
            notes.push(format!(
                "{name}: {tests} tests leave it unknown by a factor of thousands: it is not in the distributions"
            ));
        }
        notes.extend(of_scatter(parameter));
    }
    let row = |i: &usize| places.iter().map(|j| pooled.correlation[*i][*j]).collect();
    let correlation: Vec<Vec<f64>> = places.iter().map(row).collect();
    let mut joint = Joint {
        inputs,
        correlation,
        notes,
    };
    if let Some(at_least) = pooled.friction_at_least {
        of_bound(pooled, at_least, settings, &mut joint)?;
    }
    if settings.interface_area_ratio != 1.0 {
        let ratio = settings.interface_area_ratio;
        joint.notes.push(format!(
            "stiffness in the distributions is that of the tested contact times {ratio}, the area of the study's interface over that of the tested contact"
        ));
    }
    joint.notes.extend(of_trends(pooled));
    Ok(joint)
}

fn shape(parameter: &PooledParameter, settings: &IdentifySettings) -> Option<Shape> {
    let ratio = match parameter.parameter {
        ContactParameter::FrictionCoefficient => 1.0,
        _ => settings.interface_area_ratio,
    };
    let median = ratio * parameter.median.value;
    let deviation = parameter.predictive_log_standard_deviation;
    match deviation {
        d if d <= SMALLEST_LOG_DEVIATION => Some(Shape::Fixed { value: median }),
        d if d < LARGEST_LOG_DEVIATION => Some(Shape::Lognormal {
            median,
            log_standard_deviation: d,
        }),
        _ => None,
    }
}

fn of_scatter(parameter: &PooledParameter) -> Option<String> {
    let (name, factor) = (parameter.parameter.name(), parameter.few_tests_factor);
    match (parameter.tests, parameter.specimens) {
        (1, _) => Some(format!(
            "{name}: one test, so the distribution is that of the tested contact: the scatter between contacts is not in it"
        )),
        (_, 1) => Some(format!(
            "{name}: tests of one specimen, so the distribution holds the scatter between its tests, not that between specimens"
        )),
        // many tests of few specimens tell the scatter between specimens no better
        (_, specimens) => (specimens <= FEW).then(|| {
            format!("{name}: {specimens} specimens, so the standard deviation of its logarithm is {factor:.2} times the estimated one")
        }),
    }
}

/// What tests say that never slip.
fn of_bound(
    pooled: &Pooled,
    at_least: f64,
    settings: &IdentifySettings,
    joint: &mut Joint,
) -> Result<(), BadSetting> {
    let friction = ContactParameter::FrictionCoefficient;
    if let Some(found) = pooled.parameters.iter().find(|p| p.parameter == friction) {
        let [_, upper] = found.further_contact;
        joint.notes.extend((at_least > upper).then(|| {
            format!("a test that does not slip has a friction coefficient of at least {at_least:.3}, above the interval {upper:.3} of the others")
        }));
        return Ok(());
    }
    let Some(most) = settings.friction_at_most else {
        joint.notes.push(format!(
            "friction_coefficient: no test slips, so it is at least {at_least:.3} and has no upper bound: it is not in the distributions"
        ));
        return Ok(());
    };
    let rule = format!("must be above {at_least:.4}, which the tests reach without slip");
    BadSetting::unless(most > at_least, "friction_at_most", most, &rule)?;
    joint.notes.push(format!(
        "friction_coefficient: no test slips, so it is uniform from the lower bound {at_least:.3} to {most}, which is stated"
    ));
    joint.inputs.insert(
        0,
        IdentifiedInput {
            parameter: friction,
            shape: Shape::Uniform {
                low: at_least,
                high: most,
            },
        },
    );
    for row in &mut joint.correlation {
        row.insert(0, 0.0);
    }
    let mut first = vec![0.0; joint.inputs.len()];
    first[0] = 1.0;
    joint.correlation.insert(0, first);
    Ok(())
}

fn of_trends(pooled: &Pooled) -> Vec<String> {
    let depends = |trend: &&Trend| trend.interval[0] * trend.interval[1] > 0.0;
    let sentence = |trend: &Trend| {
        let over = match trend.over {
            TrendOver::NormalForce => "normal force",
            TrendOver::Frequency => "frequency",
        };
        let (name, exponent, [low, high]) =
            (trend.parameter.name(), trend.exponent, trend.interval);
        format!(
            "{name} depends on the {over}: exponent {exponent:.3} ({low:.3} to {high:.3}); the distribution is that over the tested ones"
        )
    };
    pooled.trends.iter().filter(depends).map(sentence).collect()
}

#[cfg(test)]
mod tests {
    use super::of_scatter;
    use crate::identify::found::parameter::ContactParameter;
    use crate::identify::found::pooled_result::PooledParameter;
    use crate::identify::found::uncertain::Uncertain;

    fn note(tests: usize, specimens: usize) -> Option<String> {
        of_scatter(&PooledParameter {
            parameter: ContactParameter::FrictionCoefficient,
            tests,
            specimens,
            median: Uncertain::new(0.5, [0.01, 0.0], 1.0, 0.95),
            log_scatter: Some(0.1),
            predictive_log_standard_deviation: 0.1,
            few_tests_factor: 6.48,
            further_contact: [0.3, 0.7],
        })
    }

    /// Seen to fail with the note on few tests.
    #[test]
    fn many_tests_of_few_specimens_have_the_note() {
        let told = note(16, 2);
        assert!(
            told.as_ref()
                .is_some_and(|n| n.contains("2 specimens") && n.contains("6.48")),
            "{told:?}"
        );
        assert_eq!(note(16, 16), None);
    }
}
