//! The product with the compliance of the stuck structure, which the solver never forms alone.

use microslip::hb::Balance;
use microslip::hb::newton::Iterate;
use microslip::linalg::vector::axpy;

/// y += G x, harmonic by harmonic.
pub(crate) fn add_compliance(
    iterate: &Iterate<'_>,
    balance: &Balance<'_>,
    x: &[f64],
    y: &mut [f64],
) {
    let n = balance.layout.n_relative();
    let at_rest = &balance.problem.stuck_static.compliance;
    for (j, &x) in x[..n].iter().enumerate() {
        axpy(x, at_rest.col_as_slice(j), &mut y[..n]);
    }
    let harmonics = x[n..]
        .chunks_exact(2 * n)
        .zip(y[n..].chunks_exact_mut(2 * n));
    for (h, (x, y)) in iterate.compliance.harmonics.iter().zip(harmonics) {
        h.add_real(x.split_at(n), y.split_at_mut(n));
    }
}
