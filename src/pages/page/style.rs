//! Style sheets of the figures, with a colour for each level.

use super::level_mark::{Ground, colours};

/// Style sheet of the figures, with a colour for each of so many levels.
pub fn figure_style(n_levels: usize) -> String {
    include_str!("look/figure.css").to_owned() + &colours(n_levels, Ground::White)
}

/// What differs from it in a window with a dark scheme.
pub fn dark_style(n_levels: usize) -> String {
    include_str!("look/dark.css").to_owned() + &colours(n_levels, Ground::Dark)
}
