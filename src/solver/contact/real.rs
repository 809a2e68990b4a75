//! The floating-point numbers that the contact law is written for.

use pulp::Simd;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A binary floating-point number: `f32` or `f64`.
pub trait Real:
    Copy
    + Default
    + PartialOrd
    + Send
    + Sync
    + std::fmt::Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + 'static
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// Distance from 1 to the next larger number.
    const EPSILON: Self;

    /// The nearest number to `x`.
    #[must_use]
    fn from_f64(x: f64) -> Self;

    /// The same number in double precision.
    #[must_use]
    fn to_f64(self) -> f64;

    /// |x|.
    #[must_use]
    fn abs(self) -> Self;

    /// √x.
    #[must_use]
    fn sqrt(self) -> Self;

    /// Sine and cosine, with the same bits on every machine.
    #[must_use]
    fn sine_cosine(self) -> (Self, Self);

    /// `out[r]` = Σ `table[r][k]` `x[k]`, in the order of k, with the vector instructions `simd`; `onto` goes on with the
    /// sum that `out[r]` holds.
    ///
    /// Every product is added without rounding it first, which gives the same bits on every instruction set.
    ///
    /// Shape: `table` `[row][k]`, `x` `[k]`, `out` `[row]`.
    fn table_product<S: Simd, const W: usize>(
        simd: S,
        table: &[Self],
        x: &[[Self; W]],
        out: &mut [[Self; W]],
        onto: bool,
    );

    /// The larger of two numbers, `other` if one of them is not a number: one instruction where `f64::max` takes several.
    #[inline(always)]
    #[must_use]
    fn or_larger(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
}

/// Rows and vectors of a table product that are summed together: as many sums as hide the time that one fused
/// multiply-add takes and fit into sixteen registers with what they are made of.
const ROWS: usize = 4;
const VECTORS: usize = 3;

/// Parts of [`Real::table_product`]; as there, `onto` goes on with the sums that `out` holds.
trait TableRows: Sized {
    /// The V vectors of R rows from the vector `first` on.
    fn block<S: Simd, const W: usize, const R: usize, const V: usize>(
        simd: S,
        table: &[Self],
        x: &[[Self; W]],
        first: usize,
        out: &mut [[Self; W]],
        onto: bool,
    );

    /// R whole rows.
    fn rows<S: Simd, const W: usize, const R: usize>(
        simd: S,
        table: &[Self],
        x: &[[Self; W]],
        out: &mut [[Self; W]],
        onto: bool,
    );
}

macro_rules! real {
    (
        $type:ident, $sine_cosine:ident, $vector:ident, $lanes:ident, $vectors:ident, $vectors_mut:ident, $splat:ident, $mul_add:ident, $load:ident, $store:ident
    ) => {
        impl TableRows for $type {
            #[inline(always)]
            fn block<S: Simd, const W: usize, const R: usize, const V: usize>(
                simd: S,
                table: &[Self],
                x: &[[Self; W]],
                first: usize,
                out: &mut [[Self; W]],
                onto: bool,
            ) {
                let depth = x.len();
                let mut rows = [&table[..depth]; R];
                for (r, row) in rows.iter_mut().enumerate() {
                    *row = &table[r * depth..][..depth];
                }
                let load = |x: &[Self; W]| -> [S::$vector; V] {
                    let (vectors, rest) = S::$vectors(x);
                    std::array::from_fn(|v| match vectors.get(first + v) {
                        Some(&vector) => vector,
                        None => simd.$load(rest),
                    })
                };
                let mut sums = [[simd.$splat(0.0); V]; R];
                if onto {
                    for (sums, out) in sums.iter_mut().zip(&*out) {
                        *sums = load(out);
                    }
                }
                for (k, x) in x.iter().enumerate() {
                    let x = load(x);
                    for (sums, row) in sums.iter_mut().zip(rows) {
                        let factor = simd.$splat(row[k]);
                        for (sum, x) in sums.iter_mut().zip(x) {
                            *sum = simd.$mul_add(factor, x, *sum);
                        }
                    }
                }
                for (out, sums) in out.iter_mut().zip(sums) {
                    let (vectors, rest) = S::$vectors_mut(out);
                    for (v, sum) in sums.into_iter().enumerate() {
                        match vectors.get_mut(first + v) {
                            Some(vector) => *vector = sum,
                            None => simd.$store(rest, sum),
                        }
                    }
                }
            }

            #[inline(always)]
            fn rows<S: Simd, const W: usize, const R: usize>(
                simd: S,
                table: &[Self],
                x: &[[Self; W]],
                out: &mut [[Self; W]],
                onto: bool,
            ) {
                let vectors = W.div_ceil(S::$lanes);
                let whole = vectors - vectors % VECTORS;
                for first in (0..whole).step_by(VECTORS) {
                    Self::block::<S, W, R, VECTORS>(simd, table, x, first, out, onto);
                }
                match vectors - whole {
                    2 => Self::block::<S, W, R, 2>(simd, table, x, whole, out, onto),
                    1 => Self::block::<S, W, R, 1>(simd, table, x, whole, out, onto),
                    _ => {}
                }
            }
        }

        impl Real for $type {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const EPSILON: Self = $type::EPSILON;

            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                x as $type
            }

            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }

            #[inline(always)]
            fn abs(self) -> Self {
                $type::abs(self)
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                $type::sqrt(self)
            }

            #[inline(always)]
            fn sine_cosine(self) -> (Self, Self) {
                libm::$sine_cosine(self)
            }

            #[inline(always)]
            fn table_product<S: Simd, const W: usize>(
                simd: S,
                table: &[Self],
                x: &[[Self; W]],
                out: &mut [[Self; W]],
                onto: bool,
            ) {
                let depth = x.len();
                assert_eq!(table.len(), out.len() * depth, "one row per output");
                // Blocks of about the same size: few rows have too few sums.
                let n = out.len().max(1);
                let block = n.div_ceil(n.div_ceil(ROWS));
                let tables = table.chunks(block * depth);
                for (table, out) in tables.zip(out.chunks_mut(block)) {
                    match out.len() {
                        ROWS => Self::rows::<S, W, ROWS>(simd, table, x, out, onto),
                        3 => Self::rows::<S, W, 3>(simd, table, x, out, onto),
                        2 => Self::rows::<S, W, 2>(simd, table, x, out, onto),
                        _ => Self::rows::<S, W, 1>(simd, table, x, out, onto),
                    }
                }
            }
        }
    };
}

real!(
    f32,
    sincosf,
    f32s,
    F32_LANES,
    as_simd_f32s,
    as_mut_simd_f32s,
    splat_f32s,
    mul_add_f32s,
    partial_load_f32s,
    partial_store_f32s
);
real!(
    f64,
    sincos,
    f64s,
    F64_LANES,
    as_simd_f64s,
    as_mut_simd_f64s,
    splat_f64s,
    mul_add_f64s,
    partial_load_f64s,
    partial_store_f64s
);
