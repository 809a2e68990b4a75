//! Monte Carlo design: the inputs of sample i.

use super::distribution::Distribution;
use super::input::Input;
use super::stream::uniform;
use crate::setting::BadSetting;

/// Independent random inputs and the seed that all samples come from.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    seed: u64,
    inputs: Vec<(Input, Distribution)>,
}

impl Design {
    /// A design of the given inputs, put in the order of [`Input::ALL`].
    ///
    /// # Errors
    /// [`BadSetting`] on `<input>` or `<input>.<parameter>`: an input twice, or a distribution that gives it values without meaning.
    pub fn new(seed: u64, mut inputs: Vec<(Input, Distribution)>) -> Result<Self, BadSetting> {
        inputs.sort_by_key(|(input, _)| *input);
        for pair in inputs.windows(2) {
            let twice = pair[0].0 == pair[1].0;
            BadSetting::unless(!twice, pair[0].0.name(), "twice", "must be given once")?;
        }
        for (input, distribution) in &inputs {
            input
                .accepts(distribution)
                .map_err(|bad| bad.under(input.name()))?;
        }
        Ok(Self { seed, inputs })
    }

    /// The seed.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// The inputs with their distributions, in the order of the values of a sample.
    #[must_use]
    pub fn inputs(&self) -> &[(Input, Distribution)] {
        &self.inputs
    }

    /// Values of sample `i`, in the order of [`Design::inputs`]: F_j⁻¹(u(seed, i, j)).
    #[must_use]
    pub fn sample(&self, i: u64) -> Vec<f64> {
        self.inputs
            .iter()
            .map(|(input, distribution)| {
                distribution.quantile(uniform(self.seed, i, input.dimension()))
            })
            .collect()
    }
}
