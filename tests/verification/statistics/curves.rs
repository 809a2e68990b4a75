//! Bands of whole curves, depth, and curves aligned at their peak.

use super::Numbers;
use microslip::statistics::{
    Curve, CurveSet, Envelope, EnvelopeRefusal, MissingPoints, Sorted, depth_band,
    modified_band_depth, pointwise_band, quantile, simultaneous_band,
};
use std::f64::consts::TAU;

const GRID: usize = 48;

fn grid() -> Vec<f64> {
    (0..GRID).map(|i| TAU * i as f64 / GRID as f64).collect()
}

/// Z₁ cos t + Z₂ sin t: of amplitude with the Rayleigh law, so whole curves lie in ±√(−2 ln 0.05) = ±2.4477 with 95 %.
fn waves(seed: u64, n: usize) -> Vec<Option<Vec<f64>>> {
    let mut numbers = Numbers::of(seed);
    (0..n)
        .map(|_| {
            let (a, b) = (numbers.normal(), numbers.normal());
            Some(grid().iter().map(|t| a * t.cos() + b * t.sin()).collect())
        })
        .collect()
}

/// Share of whole curves inside.
fn inside(band: &Envelope, rows: &[Option<Vec<f64>>]) -> f64 {
    let holds = |row: &&Vec<f64>| {
        let mut pairs = band.points.iter().zip(*row);
        pairs.all(|(point, y)| point.is_some_and(|p| p.lower <= *y && *y <= p.upper))
    };
    rows.iter().flatten().filter(holds).count() as f64 / rows.len() as f64
}

/// Simultaneous band: 95 ± 1 % of fresh whole curves, half-width 2.4477; pointwise quantiles hold 85.35 ± 1 %.
/// Seen to fail with the factor left at 1.
#[test]
fn a_simultaneous_band_holds_whole_curves() {
    let set = CurveSet::from_rows(grid(), waves(1, 8000));
    let fresh = waves(2, 8000);
    let band = simultaneous_band(&set, 0.95, 0.95, MissingPoints::Outside).unwrap();
    let held = inside(&band, &fresh);
    assert!((held - 0.95).abs() < 0.01, "{held}");
    assert!(band.expected_coverage >= 0.95 && band.expected_coverage < 0.951);
    let stated = band.calibration;
    assert!(
        stated.lower <= held && held <= stated.upper,
        "{held} {stated:?}"
    );
    assert_eq!(
        (band.shaped_by, stated.total(), band.failed),
        (4000, 4000, 0)
    );
    let widths = band.points.iter().map(|p| {
        let p = p.unwrap();
        (p.upper - p.lower) / 2.0
    });
    let mean = widths.sum::<f64>() / GRID as f64;
    assert!((mean - 2.4477).abs() < 0.06, "{mean}");
    let pointwise = pointwise_band(&set, &[0.025, 0.975], 0.95);
    let whole = pointwise.whole_curves_inside.unwrap().known.unwrap();
    assert!((whole.estimate - 0.8535).abs() < 0.01, "{whole:?}");
}

/// The band of the deepest curves holds the stated share too.
/// Seen to fail with the curves in the order of their index.
#[test]
fn a_depth_band_holds_whole_curves() {
    let set = CurveSet::from_rows(grid(), waves(3, 8000));
    let band = depth_band(&set, 0.9, 0.95, MissingPoints::Outside).unwrap();
    let held = inside(&band, &waves(4, 8000));
    assert!((held - 0.9).abs() < 0.015, "{held}");
    let stated = band.calibration;
    assert!(
        stated.lower - 0.005 <= held && held <= stated.upper + 0.005,
        "{stated:?}"
    );
    let middle = band.points.iter().map(|p| p.unwrap().centre.abs());
    assert!(
        middle.fold(0.0, f64::max) < 0.2,
        "the deepest curve is close to 0"
    );
    let few = CurveSet::from_rows(grid(), waves(5, 60));
    let refusal = depth_band(&few, 0.95, 0.95, MissingPoints::Outside).unwrap_err();
    assert!(matches!(
        refusal,
        EnvelopeRefusal::NotEnclosed {
            calibrating: 30,
            needed: 30,
            ..
        }
    ));
}

/// Depth by the definition: the share of pairs (own ones included) that enclose the curve, averaged over the grid.
/// Seen to fail with ranks that count ties as above.
#[test]
fn depth_is_the_share_of_enclosing_pairs() {
    let mut rows = waves(6, 30);
    rows[4] = rows[3].clone();
    rows[7] = None;
    rows[9].as_mut().unwrap()[5] = f64::NAN;
    let depths = modified_band_depth(&CurveSet::from_rows(grid(), rows.clone()));
    assert_eq!((depths[7], depths[9]), (None, None));
    let kept: Vec<&Vec<f64>> = [0..7, 8..9, 10..30]
        .into_iter()
        .flatten()
        .map(|i| rows[i].as_ref().unwrap())
        .collect();
    let known: Vec<f64> = depths.into_iter().flatten().collect();
    for (row, depth) in kept.iter().zip(known) {
        let (mut held, mut pairs) = (0, 0);
        for j in 0..kept.len() {
            for k in 0..j {
                for t in 0..GRID {
                    let (a, b) = (kept[j][t], kept[k][t]);
                    held += usize::from(a.min(b) <= row[t] && row[t] <= a.max(b));
                    pairs += 1;
                }
            }
        }
        assert!((depth - held as f64 / pairs as f64).abs() < 1e-12);
    }
}

/// Failed curves count as outside: few of them widen the band, many refuse it; none vanishes from the counts.
/// Seen to fail with the calibrating curves that exist as m.
#[test]
fn failed_and_incomplete_curves_count() {
    let complete = waves(7, 800);
    let mut holed = complete.clone();
    for i in (1..800).step_by(80) {
        holed[i] = None;
    }
    let build = |rows: &[Option<Vec<f64>>], missing| {
        let set = CurveSet::from_rows(grid(), rows.to_vec());
        simultaneous_band(&set, 0.95, 0.95, missing)
    };
    let whole = build(&complete, MissingPoints::Outside).unwrap();
    let band = build(&holed, MissingPoints::Outside).unwrap();
    assert_eq!((band.failed, band.calibration.unknown), (10, 10));
    let pairs = band.points.iter().zip(&whole.points);
    assert!(
        pairs
            .into_iter()
            .all(|(b, w)| b.unwrap().upper >= w.unwrap().upper)
    );
    let mut short = complete.clone();
    for row in short.iter_mut().skip(1).step_by(2).take(100) {
        row.as_mut().unwrap()[3] = f64::NAN;
    }
    let refused = build(&short, MissingPoints::Outside).unwrap_err();
    let expected = EnvelopeRefusal::NotEnclosed {
        inside: 300,
        calibrating: 400,
        needed: 381,
    };
    assert_eq!(refused, expected);
    let seen = build(&short, MissingPoints::NotJudged).unwrap();
    assert_eq!(
        (seen.incomplete, seen.failed, seen.calibration.unknown),
        (100, 0, 0)
    );
    assert_eq!(
        build(&[None, None], MissingPoints::Outside),
        Err(EnvelopeRefusal::NoCurve)
    );
    // The pointwise quantiles: 100 missing at point 3 are missing there and nowhere else.
    let set = CurveSet::from_rows(grid(), short);
    let point = |i: usize| pointwise_band(&set, &[0.5], 0.95).points[i].clone();
    assert_eq!((point(3).present, point(2).present), (700, 800));
    let column: Vec<f64> = complete.iter().flatten().map(|row| row[2]).collect();
    let median = quantile(&Sorted::finite(column), 0.5).unwrap();
    assert_eq!(point(2).quantiles, Some(vec![median]));
    let no_level = simultaneous_band(&set, 1.0, 0.95, MissingPoints::Outside);
    assert_eq!(no_level, Err(EnvelopeRefusal::Probability));
}

/// Peaks that differ in frequency alone coincide on f / f_res: the aligned band has no width, the plain one has.
/// Seen to fail with the slopes not scaled.
#[test]
fn aligned_curves_share_their_peak() {
    let mut numbers = Numbers::of(8);
    let peaks: Vec<f64> = (0..200)
        .map(|_| 100.0 * (1.0 + 0.02 * numbers.normal()))
        .collect();
    let response = |f: f64, peak: f64| 1.0 / ((1.0 - (f / peak).powi(2)).powi(2) + 1e-3).sqrt();
    let curve = |peak: &f64| {
        let frequencies = (0..=200).map(|i| peak * (0.8 + 0.002 * f64::from(i)));
        Curve::through(frequencies.map(|f| (f, response(f, *peak))))
    };
    let plain: Vec<Option<Curve>> = peaks.iter().map(curve).collect();
    let aligned: Vec<Option<Curve>> = plain
        .iter()
        .zip(&peaks)
        .map(|(curve, peak)| curve.as_ref()?.aligned(*peak))
        .collect();
    let width = |curves: &[Option<Curve>], grid: &[f64]| {
        let set = CurveSet::of(curves, grid);
        let band = simultaneous_band(&set, 0.9, 0.95, MissingPoints::Outside);
        let widths = band.unwrap().points.into_iter().map(|p| {
            let p = p.unwrap();
            p.upper - p.lower
        });
        widths.fold(0.0, f64::max)
    };
    let relative: Vec<f64> = (0..=50).map(|i| 0.9 + 0.004 * f64::from(i)).collect();
    let hertz: Vec<f64> = relative.iter().map(|x| 100.0 * x).collect();
    assert!(width(&aligned, &relative) < 1e-9);
    assert!(width(&plain, &hertz) > 10.0);
    let first = aligned[0].as_ref().unwrap();
    let at = |x: f64| first.at(x).unwrap();
    assert!((at(1.0) - 1.0 / 1e-3_f64.sqrt()).abs() < 1e-9);
    assert!((at(0.9511) - plain[0].as_ref().unwrap().at(0.9511 * peaks[0]).unwrap()).abs() < 1e-9);
    assert_eq!(first.aligned(0.0), None);
}
