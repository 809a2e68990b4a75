//! Room `statistics`.
