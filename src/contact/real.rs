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

    /// Sine and cosine.
    #[must_use]
    fn sin_cos(self) -> (Self, Self);

    /// `out[r]` = Σ `table[r][k]` `x[k]`, in the order of k, with the vector instructions `simd`.
    ///
    /// Multiplication and addition round one by one, so that every instruction set gives the same bits.
    ///
    /// Shape: `table` `[row][k]`, `x` `[k]`, `out` `[row]`.
    fn table_product<S: Simd, const W: usize>(
        simd: S,
        table: &[Self],
        x: &[[Self; W]],
        out: &mut [[Self; W]],
    );

    /// The larger of two numbers, `other` if one of them is not a number: one instruction where `f64::max` takes several.
    #[inline(always)]
    #[must_use]
    fn or_larger(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
}

/// Rows of a table product that are summed together: enough to hide the time that one addition takes.
const ROWS: usize = 4;

macro_rules! real {
    (
        $type:ident, $lanes:ident, $vectors:ident, $vectors_mut:ident, $splat:ident, $mul:ident, $add:ident, $load:ident,
        $store:ident
    ) => {
        impl Real for $type {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const EPSILON: Self = $type::EPSILON;

            #[inline(always)]
            #[allow(clippy::cast_possible_truncation, reason = "rounding to f32 is meant")]
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
            fn sin_cos(self) -> (Self, Self) {
                $type::sin_cos(self)
            }

            #[inline(always)]
            fn table_product<S: Simd, const W: usize>(
                simd: S,
                table: &[Self],
                x: &[[Self; W]],
                out: &mut [[Self; W]],
            ) {
                #[inline(always)]
                fn rows_product<S: Simd, const W: usize, const R: usize>(
                    simd: S,
                    table: &[$type],
                    x: &[[$type; W]],
                    out: &mut [[$type; W]; R],
                ) {
                    let depth = x.len();
                    let rows: [&[$type]; R] = std::array::from_fn(|r| &table[r * depth..][..depth]);
                    let whole = W / S::$lanes;
                    for column in 0..W.div_ceil(S::$lanes) {
                        let mut sums = [simd.$splat(0.0); R];
                        for (k, x) in x.iter().enumerate() {
                            let (vectors, rest) = S::$vectors(x);
                            let x = if column < whole {
                                vectors[column]
                            } else {
                                simd.$load(rest)
                            };
                            for r in 0..R {
                                let product = simd.$mul(simd.$splat(rows[r][k]), x);
                                sums[r] = simd.$add(sums[r], product);
                            }
                        }
                        for (out, sum) in out.iter_mut().zip(sums) {
                            let (vectors, rest) = S::$vectors_mut(out);
                            if column < whole {
                                vectors[column] = sum;
                            } else {
                                simd.$store(rest, sum);
                            }
                        }
                    }
                }

                let depth = x.len();
                assert_eq!(table.len(), out.len() * depth, "one row per output");
                let (blocks, rest) = out.as_chunks_mut::<ROWS>();
                let (head, tail) = table.split_at(blocks.len() * ROWS * depth);
                for (rows, out) in head.chunks_exact(ROWS * depth).zip(blocks) {
                    rows_product::<S, W, ROWS>(simd, rows, x, out);
                }
                for (row, out) in tail.chunks_exact(depth).zip(rest) {
                    rows_product::<S, W, 1>(simd, row, x, std::array::from_mut(out));
                }
            }
        }
    };
}

real!(
    f32,
    F32_LANES,
    as_simd_f32s,
    as_mut_simd_f32s,
    splat_f32s,
    mul_f32s,
    add_f32s,
    partial_load_f32s,
    partial_store_f32s
);
real!(
    f64,
    F64_LANES,
    as_simd_f64s,
    as_mut_simd_f64s,
    splat_f64s,
    mul_f64s,
    add_f64s,
    partial_load_f64s,
    partial_store_f64s
);
