//! Vectors in the plane of a contact.

use crate::contact::Real;

/// a · b.
#[inline(always)]
pub(super) fn dot<T: Real>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[0] + a[1] * b[1]
}

/// The unit vector a quarter turn ahead of `e`.
#[inline(always)]
pub(super) fn normal<T: Real>(e: [T; 2]) -> [T; 2] {
    [-e[1], e[0]]
}

#[inline(always)]
pub(super) fn size<T: Real>(x: [T; 2]) -> T {
    dot(x, x).sqrt()
}
