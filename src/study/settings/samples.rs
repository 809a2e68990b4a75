//! `samples` of a study file: a number, or as many as a rule takes.

use super::document::Document;
use crate::Error;
use crate::report::asked::Requirements;
use crate::report::asked::{Stopping, StoppingTable};
use crate::sampling::design_settings::MOST_SAMPLES;
use crate::sampling::{Design, DesignKind};
use crate::setting::BadSetting;

/// What the study file says.
pub(super) enum Samples {
    /// So many; absent where the design decides it.
    Number(Option<u64>),
    /// Until a rule is met.
    Until(StoppingTable),
}

impl Samples {
    /// Takes the key out of the study file.
    ///
    /// # Errors
    /// [`Error::Study`] if it is neither a number nor such a table.
    pub(super) fn take(document: &mut Document<'_>) -> Result<Self, Error> {
        if !document.is_table("samples") {
            return document.take("samples").map(Self::Number);
        }
        let table: Option<StoppingTable> = document.take("samples")?;
        let most = table.as_ref().map_or(1, |table| table.at_most);
        let few = (1..=MOST_SAMPLES).contains(&most);
        let rule = format!("must be from 1 to {MOST_SAMPLES}");
        document.checked(BadSetting::unless(few, "samples.at_most", most, &rule))?;
        Ok(table.map_or(Self::Number(None), Self::Until))
    }

    /// Samples that the design must have room for.
    pub(super) fn most(&self) -> Option<u64> {
        match self {
            Self::Number(number) => *number,
            Self::Until(table) => Some(table.at_most),
        }
    }

    /// The looks of a rule; absent for a number.
    ///
    /// # Errors
    /// [`BadSetting`] with a key relative to the study file: also where the samples are no independent draws of one
    /// population, because a rule keeps its confidence for such alone.
    pub(super) fn plan(
        &self,
        requirements: &Requirements,
        design: &Design,
    ) -> Result<Option<Stopping>, BadSetting> {
        let Self::Until(table) = self else {
            return Ok(None);
        };
        let plan = table.plan(&requirements.criteria);
        let plan = plan.map_err(|bad| bad.under("samples"))?;
        let kind = design.kind();
        let rule = format!(
            "must be a number in a design of kind {:?}: a rule keeps its confidence for independent samples alone",
            kind.name()
        );
        let independent = kind == DesignKind::MonteCarlo;
        BadSetting::unless(independent, "samples", "(table)", &rule)?;
        let rule = "must be a number with epistemic inputs: their search judges places that no look has seen";
        BadSetting::unless(design.outer().is_none(), "samples", "(table)", rule)?;
        Ok(Some(plan))
    }
}
