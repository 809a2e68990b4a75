//! Contacts whose friction coefficient and stiffness scatter together.

/// Medians of friction coefficient and tangential stiffness (N/µm).
pub(crate) const MEDIANS: [f64; 2] = [0.5, 40.0];
/// Scatter of their logarithms between contacts, and its correlation.
pub(crate) const SCATTER: [f64; 2] = [0.1, 0.4];
pub(crate) const CORRELATION: f64 = -0.6;

/// Deviations of the logarithms with this scatter, from two normal numbers.
pub(crate) fn deviations([a, b]: [f64; 2], scatter: [f64; 2]) -> [f64; 2] {
    let second = CORRELATION * a + (1.0 - CORRELATION * CORRELATION).sqrt() * b;
    [scatter[0] * a, scatter[1] * second]
}
