//! Files that other libraries wrote: SciPy, npTDMS and pyuff. `written/write.py` made them, and says with which versions.

use microslip::record::read_hysteresis;
use std::f64::consts::TAU;
use std::path::Path;

/// Seen to fail where the reader of binary universal files leaves the unit of the file.
#[test]
fn files_of_other_writers_are_read() {
    for name in [
        "scipy.mat",
        "scipy-compressed.mat",
        "nptdms.tdms",
        "pyuff.uff",
        "pyuff-58b.uff",
    ] {
        let path = Path::new("tests/record/written").join(name);
        let tests = read_hysteresis(&[path]).unwrap();
        assert_eq!(tests.len(), 1, "{name}");
        let record = &tests[0].record;
        assert_eq!(record.time.len(), 60, "{name}");
        // text in pyuff's E20.11 has twelve digits, its step of time six
        let near = |found: f64, expected: f64, size: f64| (found - expected).abs() < 1e-6 * size;
        for i in 0..60 {
            let phase = TAU * f64::from(i) / 20.0;
            let at = i as usize;
            let tangential = 30.0 * (4.0 * phase.cos()).clamp(-1.0, 1.0) + 6.0 * phase.sin();
            assert!(
                near(record.time[at], f64::from(i) * 1e-4, 1e-2),
                "{name}: {i}"
            );
            assert!(
                near(record.displacement[at], 4e-6 * phase.sin(), 1e-5),
                "{name}: {i}"
            );
            assert!(
                near(record.tangential_force[at], tangential, 10.0),
                "{name}: {i}"
            );
            let normal = 100.0 + 2.0 * phase.cos();
            assert!(near(record.normal_force[at], normal, 100.0), "{name}: {i}");
        }
    }
}

/// A complex spectrum beside the signals is a function of the frequency, and passed over. Seen to fail where every complex
/// dataset is refused: "is complex: must be real".
#[test]
fn complex_spectra_beside_signals_are_passed_over() {
    let signals = std::fs::read_to_string("tests/record/written/pyuff.uff").unwrap();
    let spectrum = "    -1\n    58\nspectrum\nA1\nNONE\nNONE\nNONE\n    4         0    0         0       NONE         1   1       NONE         1   1\n         \
        5         2         1  0.00000e+00  1.00000e+00  0.00000e+00\n        18    0    0    0 Frequency            Hz                  \n        \
        12    0    0    0 acceleration         m/s^2               \n         0    0    0    0 NONE                 NONE                \n         \
        0    0    0    0 NONE                 NONE                \n  1.00000e+00  2.00000e+00  3.00000e+00  4.00000e+00\n    -1\n";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("both.uff");
    std::fs::write(&path, format!("{spectrum}{signals}")).unwrap();
    assert_eq!(
        read_hysteresis(std::slice::from_ref(&path)).unwrap().len(),
        1
    );
    // the same of a signal over time is refused, with its line
    let complex = signals.replacen("         4        60", "         5        60", 1);
    std::fs::write(&path, complex).unwrap();
    let message = read_hysteresis(&[path]).unwrap_err().to_string();
    assert!(
        message.contains("both.uff:9: is complex: must be real"),
        "{message}"
    );
}
