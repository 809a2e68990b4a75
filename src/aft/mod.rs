//! Room `aft`.
