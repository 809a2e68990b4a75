//! Latin hypercube, correlated inputs, grids and nested designs.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot set up its design fails"
)]

use statrs::distribution::{ContinuousCDF, Normal};

use microslip::sampling::{
    CorrelationTable, Design, DesignSettings, DesignTable, Distribution, DistributionTable,
    EpistemicTable, Growth, Input, SampleTable, Uncertainty,
};

const INPUTS: &str = r#"
[stiffness_scale]
distribution = "log-uniform"
low = 0.1
high = 10.0
[friction_coefficient]
distribution = "uniform"
low = 0.1
high = 0.8
[static_load_scale]
distribution = "lognormal"
median = 1.0
log_standard_deviation = 0.1
"#;

fn inputs(text: &str) -> Vec<(Input, Uncertainty)> {
    let tables: std::collections::BTreeMap<String, DistributionTable> =
        toml::from_str(text).unwrap();
    (tables.iter())
        .map(|(name, table)| {
            (
                Input::from_name(name).unwrap(),
                table.uncertainty().unwrap(),
            )
        })
        .collect()
}

fn settings(design: &str, samples: u64) -> DesignSettings {
    DesignSettings {
        seed: 4,
        samples: Some(samples),
        design: toml::from_str::<DesignTable>(design).unwrap(),
        inputs: inputs(INPUTS),
        ..DesignSettings::default()
    }
}

fn correlated(kind: &str, value: f64) -> Option<CorrelationTable> {
    let text = format!(
        "kind = \"{kind}\"\npairs = [{{ inputs = [\"stiffness_scale\", \"friction_coefficient\"], value = {value} }}]"
    );
    Some(toml::from_str(&text).unwrap())
}

/// F_j(x_ij). Shape: samples × inputs.
fn places(design: &Design) -> Vec<Vec<f64>> {
    let cdf = |((_, d), x): (&(Input, Distribution), f64)| d.cdf(x);
    (0..design.samples())
        .map(|i| {
            design
                .inputs()
                .iter()
                .zip(design.sample(i))
                .map(cdf)
                .collect()
        })
        .collect()
}

fn column(places: &[Vec<f64>], j: usize) -> Vec<f64> {
    places.iter().map(|row| row[j]).collect()
}

fn pearson(a: &[f64], b: &[f64]) -> f64 {
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    let sum =
        |f: &dyn Fn(f64, f64) -> f64| a.iter().zip(b).map(|(a, b)| f(a - ma, b - mb)).sum::<f64>();
    sum(&|a, b| a * b) / (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt()
}

/// Every input has one value in each of 100 strata, correlated or not.
///
/// Seen to fail with the copula applied to the hypercube's numbers.
#[test]
fn a_latin_hypercube_has_one_value_per_stratum() {
    for correlation in [None, correlated("normal-scores", -0.7)] {
        let mut settings = settings("kind = \"latin-hypercube\"", 100);
        settings.correlation = correlation;
        let places = places(&settings.build().unwrap());
        for j in 0..3 {
            let mut seen = [false; 100];
            column(&places, j)
                .iter()
                .for_each(|u| seen[(u * 100.0 + 1e-9) as usize] = true);
            assert!(seen.iter().all(|s| *s), "input {j}");
        }
    }
}

/// Chance correlations of the normal scores of 50 strata are about 0.14; controlled ones stay below 0.03, and a wanted
/// one is met as well: Spearman's 0.6 is 2 sin(0.1 π) of the scores.
///
/// Seen to fail with the order of the Monte Carlo numbers left as it is.
#[test]
fn correlations_of_a_latin_hypercube_are_controlled() {
    for seed in 0..20 {
        for wanted in [0.0, 0.6] {
            let mut settings = settings("kind = \"latin-hypercube\"", 50);
            settings.seed = seed;
            if wanted != 0.0 {
                settings.correlation = correlated("spearman", wanted);
            }
            let places = places(&settings.build().unwrap());
            let normal = Normal::standard();
            let scores = |j: usize| -> Vec<f64> {
                let u = column(&places, j).into_iter();
                u.map(|u| normal.inverse_cdf(((50.0 * u + 1e-9).floor() + 0.5) / 50.0))
                    .collect()
            };
            let of_scores = 2.0 * (std::f64::consts::PI * wanted / 6.0).sin();
            for (i, j) in [(0, 1), (0, 2), (1, 2)] {
                let r = pearson(&scores(i), &scores(j));
                let expected = if (i, j) == (0, 1) { of_scores } else { 0.0 };
                assert!(
                    (r - expected).abs() < 0.03,
                    "seed {seed}, {i} {j}: {r}, not {expected}"
                );
            }
        }
    }
}

/// Monte Carlo and Sobol' points with a copula: Spearman's correlation as asked for (closed form between it and that of
/// the scores), the third input untouched to the bit, and each input's own distribution kept.
///
/// Seen to fail with scores correlated 10 % less.
#[test]
fn the_copula_has_the_correlation_asked_for() {
    let n = 1 << 13;
    for design in ["kind = \"monte-carlo\"", "kind = \"sobol\""] {
        for (kind, value) in [("spearman", 0.5), ("normal-scores", 0.5)] {
            let mut with = settings(design, n);
            with.correlation = correlated(kind, value);
            let (with, without) = (with.build().unwrap(), settings(design, n).build().unwrap());
            let u = places(&with);
            let rank = match kind {
                "spearman" => value,
                _ => 6.0 / std::f64::consts::PI * (0.5 * value).asin(),
            };
            let r = pearson(&column(&u, 0), &column(&u, 1));
            // standard error below 1/√n = 0.011
            assert!((r - rank).abs() < 0.03, "{design} {kind}: {r}, not {rank}");
            let mean = column(&u, 1).iter().sum::<f64>() / n as f64;
            assert!((mean - 0.5).abs() < 0.01, "{design}: mean {mean}");
            for i in [0, 1, 77] {
                assert_eq!(with.sample(i)[2], without.sample(i)[2]);
            }
        }
    }
}

/// Three correlations of -0.9 contradict each other.
#[test]
fn contradicting_correlations_are_refused() {
    let text = r#"pairs = [
        { inputs = ["stiffness_scale", "friction_coefficient"], value = -0.9 },
        { inputs = ["stiffness_scale", "static_load_scale"], value = -0.9 },
        { inputs = ["friction_coefficient", "static_load_scale"], value = -0.9 } ]"#;
    let mut settings = settings("kind = \"monte-carlo\"", 10);
    settings.correlation = Some(toml::from_str(text).unwrap());
    let error = settings.build().unwrap_err();
    assert_eq!(error.key, "correlation.pairs");
    assert!(error.rule.contains("positive definite"), "{error}");
    assert!(error.rule.contains("static_load_scale"), "{error}");
}

/// Middles of cells of equal probability, the first input fastest; the number of samples follows.
#[test]
fn a_grid_has_every_combination_once() {
    let text = "kind = \"grid\"\npoints = { stiffness_scale = 3, friction_coefficient = 2, static_load_scale = 1 }";
    let mut settings = settings(text, 1);
    settings.samples = None;
    let design = settings.build().unwrap();
    let expected = [
        [1.0, 1.0],
        [3.0, 1.0],
        [5.0, 1.0],
        [1.0, 3.0],
        [3.0, 3.0],
        [5.0, 3.0],
    ];
    let places = places(&design);
    assert_eq!(places.len(), 6);
    for (row, [a, b]) in places.iter().zip(expected) {
        let expected = [a / 6.0, b / 4.0, 0.5];
        assert!(
            row.iter().zip(expected).all(|(u, e)| (u - e).abs() < 1e-12),
            "{row:?}"
        );
    }
}

const INTERVAL: &str = "[stiffness_scale]\nkind = \"epistemic\"\nlower = 0.1\nupper = 10.0\n";

fn nested(epistemic: &str, samples: u64, more: &str) -> Design {
    let mut settings = settings("kind = \"monte-carlo\"", samples);
    let others = INPUTS.split("[friction").nth(1).unwrap();
    settings.inputs = inputs(&format!("{INTERVAL}{more}[friction{others}"));
    settings.epistemic = Some(toml::from_str::<EpistemicTable>(epistemic).unwrap());
    settings.build().unwrap()
}

/// Corners, centre and space-filling points; the same random numbers at each of them, and those of the design without
/// the epistemic input.
///
/// Seen to fail with the sample's own number in place of the inner one.
#[test]
fn a_nested_design_repeats_its_random_numbers_at_every_outer_point() {
    let design = nested("points = 4", 7 * 5, "");
    assert_eq!(design.outer_points(), 7);
    let plain = settings("kind = \"monte-carlo\"", 5).build().unwrap();
    let mut outer = [f64::NAN; 7];
    for i in 0..35 {
        let sample = design.sample(i);
        let (inner, at) = (i / 7, (i % 7) as usize);
        assert_eq!(design.group(i).outer, Some((i % 7) as u32));
        assert_eq!(sample[1..], plain.sample(inner)[1..]);
        if inner == 0 {
            outer[at] = sample[0];
        }
        assert_eq!(sample[0], outer[at], "sample {i}");
    }
    assert_eq!(outer[..2], [0.1, 10.0]);
    // ends a factor of ten apart or more: even in the logarithm
    assert!((outer[2] - 1.0).abs() < 1e-12);
    let mut quarter: Vec<_> = outer[3..]
        .iter()
        .map(|x| (2.0 * (x / 0.1).log10()) as usize)
        .collect();
    quarter.sort_unstable();
    assert_eq!(quarter, [0, 1, 2, 3]);
}

/// A grid over two intervals holds all combinations with their ends.
#[test]
fn an_outer_grid_has_the_ends() {
    let more = "[normal_stiffness_scale]\nkind = \"epistemic\"\nlower = 1.0\nupper = 3.0\n";
    let design = nested("kind = \"grid\"\npoints = 3", 9, more);
    let found: Vec<_> = (0..9).map(|i| design.sample(i)[..2].to_vec()).collect();
    let stiffness = [0.1, 1.0, 10.0];
    let normal = [1.0, 2.0, 3.0]; // ends less than a factor of ten apart: even as they are
    for (k, row) in found.iter().enumerate() {
        let expected = [stiffness[k % 3], normal[k / 3]];
        let close = row
            .iter()
            .zip(expected)
            .all(|(x, e)| (x / e - 1.0).abs() < 1e-12);
        assert!(close, "{row:?} {expected:?}");
    }
}

/// Designs that can grow do: the samples of a small one are the first of a large one.
#[test]
fn growing_designs_keep_their_first_samples() {
    let cases = [
        ("kind = \"monte-carlo\"", 24),
        ("kind = \"sobol\"\nreplicates = 3", 24),
        ("kind = \"pick-freeze\"", 20),
    ];
    for (text, n) in cases {
        let (few, many) = (settings(text, n), settings(text, 4 * n));
        let (few, many) = (few.build().unwrap(), many.build().unwrap());
        assert_ne!(few.growth(), Growth::Fixed);
        for i in 0..n {
            assert_eq!(few.sample(i), many.sample(i), "{text}, sample {i}");
            assert_eq!(few.group(i), many.group(i));
        }
    }
    let hypercube = settings("kind = \"latin-hypercube\"", 20).build().unwrap();
    assert_eq!(hypercube.growth(), Growth::Fixed);
}

/// Each replicate is a whole sequence of its own.
#[test]
fn replicates_are_told_apart() {
    let design = settings("kind = \"sobol\"\nreplicates = 3", 24)
        .build()
        .unwrap();
    for replicate in 0..3 {
        let mut seen = [false; 8];
        for i in (0..24).filter(|i| design.group(*i).replicate == Some(replicate)) {
            let u = design.inputs()[1].1.cdf(design.sample(i)[1]);
            seen[(8.0 * u) as usize] = true;
        }
        assert!(seen.iter().all(|s| *s), "replicate {replicate}");
    }
    assert_ne!(design.sample(0), design.sample(1));
}

/// Rows are A, B and A with one column of B at a time, and every sample knows its place. A and B depend on each other in no
/// pair of columns. Seen to fail with two points of one sequence as A and B, and with the next column of B.
#[test]
fn pick_freeze_rows_are_those_of_the_indices() {
    let rows = 64;
    let design = settings("kind = \"pick-freeze\"", 5 * rows)
        .build()
        .unwrap();
    assert_eq!(design.mixed_inputs(), [0, 1, 2]);
    let u = places(&design);
    let table: Vec<Vec<f64>> = u
        .chunks_exact(5)
        .map(|row| [row[0].clone(), row[1].clone()].concat())
        .collect();
    for (i, found) in u.iter().enumerate() {
        let (a, b) = table[i / 5].split_at(3);
        let mixed = |j: usize| i % 5 == 1 || i % 5 == 2 + j;
        for j in 0..3 {
            let expected = if mixed(j) { b[j] } else { a[j] };
            assert!((found[j] - expected).abs() < 1e-12, "sample {i}");
        }
        let group = design.group(i as u64);
        assert_eq!(group.place, Some(i as u32 % 5));
        assert_eq!(group.of_population(), i % 5 < 2);
    }
    // Points of a sequence differ by fixed binary digits: taken for A and B some pair is at 1/2 or more.
    for (j, k) in (0..3).flat_map(|j| (3..6).map(move |k| (j, k))) {
        let together = pearson(&column(&table, j), &column(&table, k)).abs();
        assert!(together < 0.49, "columns {j} and {k}: {together}");
    }
    // each column of A and of B has one value in each of the strata
    for j in 0..6 {
        let mut seen = vec![false; rows as usize];
        for row in &table {
            seen[(row[j] * rows as f64) as usize] = true;
        }
        assert!(seen.iter().all(|s| *s), "column {j}");
    }
    let monte_carlo = settings("kind = \"monte-carlo\"", 10).build().unwrap();
    assert!(monte_carlo.mixed_inputs().is_empty() && monte_carlo.group(7).of_population());
}

/// What a report says of an input is what the study states, of every family, of an interval and of a file. Seen to fail
/// without the truncation, and with an interval as the scale that stands for it.
#[test]
fn assumptions_are_stated_in_words() {
    let words = |table: &str| {
        let table: DistributionTable = toml::from_str(table).unwrap();
        table.distribution().unwrap().to_string()
    };
    for (table, expected) in [
        ("distribution = \"fixed\"\nvalue = 2", "fixed: value 2.0"),
        (
            "distribution = \"uniform\"\nhigh = 0.8\nlow = 0.1",
            "uniform: low 0.1, high 0.8",
        ),
        (
            "distribution = \"log-uniform\"\nlow = 0.1\nhigh = 10.0\ntruncation = [0.5, 2]",
            "log-uniform: low 0.1, high 10.0, truncation [0.5, 2.0]",
        ),
        (
            "distribution = \"normal\"\nmean = 1\nstandard_deviation = 0.2",
            "normal: mean 1.0, standard deviation 0.2",
        ),
        (
            "distribution = \"lognormal\"\nmedian = 1\nlog_standard_deviation = 0.2",
            "lognormal: median 1.0, log standard deviation 0.2",
        ),
        (
            "distribution = \"triangular\"\nlow = 0\nhigh = 3\nmode = 1",
            "triangular: low 0.0, mode 1.0, high 3.0",
        ),
        (
            "distribution = \"beta\"\nalpha = 2\nbeta = 3\nlow = 0\nhigh = 1",
            "beta: alpha 2.0, beta 3.0, low 0.0, high 1.0",
        ),
    ] {
        assert_eq!(words(table), expected);
    }
    let mut settings = settings("kind = \"file\"\npath = \"x.csv\"", 4);
    settings.inputs = inputs(INTERVAL);
    settings.samples = None;
    settings.file = Some(SampleTable {
        inputs: vec![Input::FrictionCoefficient],
        rows: vec![vec![0.3]],
    });
    let design = settings.build().unwrap();
    let of = |wanted: Input| {
        let inputs = design.inputs().iter();
        let j = inputs.clone().position(|(input, _)| *input == wanted);
        design.assumption(j.unwrap())
    };
    assert_eq!(
        of(Input::StiffnessScale),
        "known to an interval only: lower 0.1, upper 10.0, points even in the logarithm"
    );
    assert_eq!(of(Input::FrictionCoefficient), "values of a file");
}
