//! A disk under several engine orders: a study of its own for each.

use super::document::Document;
use super::read::Study;
use crate::Error;
use crate::setting::BadSetting;

/// Key of the engine orders.
const KEY: &str = "operation.engine_orders";

impl Study {
    /// The engine orders that excite a disk where the study names several. Each excites a nodal diameter of its own; `run` of the
    /// program takes one after the other ([`Study::of_engine_order`]).
    #[must_use]
    pub fn several_engine_orders(&self) -> Option<&[u32]> {
        let operation = self.requirements.operation.as_ref()?;
        let orders = &operation.engine_orders;
        (self.is_cyclic() && orders.len() > 1).then_some(orders)
    }

    /// The study of one engine order: the same text with this order alone.
    ///
    /// # Errors
    /// [`Error::Study`] if the text makes no study with it.
    pub fn of_engine_order(&self, order: u32) -> Result<Self, Error> {
        let text = Document::parse(&self.path, &self.text)?;
        Self::parse(&self.path, &text.with_value(KEY, &format!("[{order}]")))
    }

    /// Refuses several engine orders of a disk.
    ///
    /// # Errors
    /// [`Error::Study`] on their key.
    pub(in crate::study) fn one_engine_order(&self) -> Result<(), Error> {
        let Some(orders) = self.several_engine_orders() else {
            return Ok(());
        };
        let rule = "must be one engine order here: each excites another nodal diameter; the command `run` takes several, one after the other";
        Err(self.bad_setting(&BadSetting::new(KEY, format!("{orders:?}"), rule)))
    }
}
