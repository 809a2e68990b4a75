//! Room `linalg`.
