//! Room `fe`.
