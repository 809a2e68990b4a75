//! All modes of the band followed, from the study file to table, summary and page.

use crate::bad_input::disk_cases::{DISK, DISK_FILES};
use crate::disk_page::figure;
use crate::{microslip, reference_study};
use microslip::ensemble::outcome::{LevelOutcome, SampleOutcome};
use microslip::ensemble::store::read_samples;
use microslip::hb::Status;
use parquet::file::reader::{FileReader, SerializedFileReader};
use serde_json::Value;
use tempfile::TempDir;

/// A run of two lumped blades with this `peak`, on so many threads.
fn run(peak: &str, threads: &str) -> TempDir {
    let (folder, study) = reference_study("two-peaks-7dof");
    let study = format!("{study}peak = {peak}\n").replace("[1.0, 50.0]", "[1.0]");
    std::fs::write(folder.path().join("study.toml"), study).unwrap();
    let run = ["run", "study.toml", "--output", "out", "--threads", threads];
    let output = microslip(folder.path(), &run);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    folder
}

fn samples(folder: &TempDir) -> Vec<SampleOutcome> {
    let path = folder.path().join("out/samples.parquet");
    read_samples(&path).unwrap().outcomes
}

fn columns(folder: &TempDir) -> Vec<String> {
    let file = std::fs::File::open(folder.path().join("out/samples.parquet")).unwrap();
    let reader = SerializedFileReader::new(file).unwrap();
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let roots = schema.root_schema().get_fields().iter();
    roots.map(|field| field.name().to_owned()).collect()
}

fn summary(folder: &TempDir) -> Value {
    let text = std::fs::read_to_string(folder.path().join("out/summary.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// Every mode has its rows, from the maxima of the samples; the peaks keep their bits; without the setting nothing is added. Seen to fail
/// with the lower maximum of a mode counted in place of the highest, and with the columns in every table.
#[test]
fn every_mode_has_its_statistics() {
    let (all, highest) = (run("\"all\"", "1"), run("\"highest\"", "1"));
    let (of_all, of_highest) = (samples(&all), samples(&highest));
    for (a, b) in of_all.iter().zip(&of_highest) {
        let [a, b] = [a, b].map(|o| o.levels[0].peak.unwrap());
        assert_eq!(a.frequency_hz.to_bits(), b.frequency_hz.to_bits());
        assert_eq!(a.amplitude_m.to_bits(), b.amplitude_m.to_bits());
    }
    let added = [
        "mode",
        "mode_share",
        "other_modes",
        "other_mode_shares",
        "unfinished_modes",
    ];
    let [more, fewer] = [&all, &highest].map(columns);
    assert!(
        added.iter().all(|name| more.iter().any(|c| c == name)),
        "{more:?}"
    );
    assert_eq!(more.len(), fewer.len() + added.len(), "{fewer:?}");
    assert!(summary(&highest)["levels"][0]["modes"].is_null());
    let page = |of: &TempDir| std::fs::read_to_string(of.path().join("out/report.html")).unwrap();
    assert!(page(&all).contains("Resonances of all modes"));
    assert!(!page(&highest).contains("Resonances of all modes"));

    let found = summary(&all)["levels"][0]["modes"]
        .as_array()
        .unwrap()
        .clone();
    assert!(found.len() > 1, "{found:?}");
    let mut peaks = 0;
    for mode in &found {
        let number = mode["mode"].as_u64().unwrap();
        // the highest maximum of this mode in every sample that has one
        let own = of_all.iter().filter_map(|o| {
            let level = &o.levels[0];
            let others = level.around.others().iter().map(|other| other.frequency_hz);
            let places = std::iter::once(level.peak.unwrap().frequency_hz).chain(others);
            let modes = &level.around.modes().unwrap().of_maxima;
            let mut of_mode = places
                .zip(modes)
                .filter(|(_, of)| u64::from(of.number) == number);
            of_mode.next().map(|(hz, _)| hz)
        });
        let own: Vec<f64> = own.collect();
        assert_eq!(mode["present"]["yes"], own.len(), "{mode}");
        assert_eq!(mode["frequency_hz"]["valid"], own.len(), "{mode}");
        if own.is_empty() {
            continue;
        }
        let mean = mode["frequency_hz"]["moments"]["mean"].as_f64().unwrap();
        let expected = own.iter().sum::<f64>() / own.len() as f64;
        assert!((mean / expected - 1.0).abs() < 1e-12, "{mode}");
        peaks += mode["highest"].as_u64().unwrap();
    }
    assert_eq!(peaks, of_all.len() as u64, "every peak is of one mode");
}

/// The modes are a function of the samples alone. Seen to fail with the number of the thread in place of that of the mode.
#[test]
fn modes_do_not_depend_on_threads() {
    let [one, two] = ["1", "2"].map(|threads| run("\"all\"", threads));
    let table = |of: &TempDir| std::fs::read(of.path().join("out/samples.parquet")).unwrap();
    assert!(table(&one) == table(&two), "other bytes");
}

/// Both modes of a travelling wave in the band, stuck: they resonate where the stuck frequencies of its nodal diameter lie. Seen to fail with
/// the highest maximum alone.
#[test]
fn every_mode_of_a_nodal_diameter_is_followed() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in DISK_FILES {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let study = DISK
        .replace("levels = [1.0]", "levels = [1e-3]\nsamples = 3")
        .replace("modal_damping_ratio = 0.01", "modal_damping_ratio = 0.001")
        .replace("[100, 400]", "[100, 700]\npeak = \"all\"")
        + "\n[solver]\nharmonics = 3\nalert = false\n\n[inputs.friction_coefficient]\ndistribution = \"uniform\"\nlow = 0.3\nhigh = 0.4\n";
    std::fs::write(folder.path().join("study.toml"), study).unwrap();
    let output = microslip(folder.path(), &["run", "study.toml", "--output", "out"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let record = std::fs::read_to_string(folder.path().join("out/run.json")).unwrap();
    let record: Value = serde_json::from_str(&record).unwrap();
    let of_three = &record["disk"]["nodal_diameters"][3];
    assert_eq!(of_three["nodal_diameter"], 3);
    let stuck: Vec<f64> = (of_three["stuck_hz"].as_array().unwrap().iter())
        .map(|hz| hz.as_f64().unwrap())
        .filter(|hz| (100.0..700.0).contains(hz))
        .collect();
    assert_eq!(stuck.len(), 2, "{stuck:?}");
    for sample in samples(&folder) {
        let level = &sample.levels[0];
        let others = level.around.others().iter().map(|other| other.frequency_hz);
        let mut found: Vec<f64> = others.chain([level.peak.unwrap().frequency_hz]).collect();
        found.sort_by(f64::total_cmp);
        assert_eq!(found.len(), 2, "{found:?}");
        for (found, stuck) in found.iter().zip(&stuck) {
            assert!((found / stuck - 1.0).abs() < 1e-4, "{found} {stuck}");
        }
    }
    assert_eq!(
        summary(&folder)["levels"][0]["modes"]
            .as_array()
            .unwrap()
            .len(),
        2
    );
    let page = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(page.contains("Resonances of all modes"));
}

/// Two modes, at 100 Hz and higher; the excited body has 0.02 times the amplitude of the first in the second or less, so that the maximum
/// of that one is low beside the flank of the other, or drowned in it.
fn weak_second_mode(stiffness: [f64; 3], peak: &str) -> (LevelOutcome, TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let [k11, k12, k22] = stiffness;
    let head = "%%MatrixMarket matrix coordinate real symmetric\n3 3";
    let files = [
        ("mass.mtx", format!("{head} 3\n1 1 1\n2 2 1\n3 3 1e-3\n")),
        (
            "stiffness.mtx",
            format!("{head} 3\n1 1 {k11}\n2 1 {k12}\n2 2 {k22}\n"),
        ),
    ];
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let study = format!(
        "name = \"weak\"\nlevels = [1e-3]\n\n[model]\nkind = \"matrices\"\nmass = \"mass.mtx\"\nstiffness = \"stiffness.mtx\"\n\
         modal_damping_ratio = 0.02\ndof_names = [\"a.x\", \"b.x\", \"c.z\"]\nstatic_force = {{ \"c.z\" = 5.0 }}\n\
         cosine_force = {{ \"a.x\" = 1.0 }}\nresponses = [\"a.x\"]\n\n[[model.contact]]\nname = \"c\"\nt1 = {{ \"b.x\" = 1.0 }}\n\
         n = {{ \"c.z\" = 1.0 }}\nk_t1 = 100.0\nk_n = 1e6\nmu = 0.5\n\n[solver]\nharmonics = 1\nalert = false\n\n\
         [frequency]\nband_hz = [50, 500]\npeak = {peak}\n\n[output]\ncurve_samples = 0\n"
    );
    std::fs::write(folder.path().join("study.toml"), study).unwrap();
    let output = microslip(folder.path(), &["run", "study.toml", "--output", "out"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    (samples(&folder)[0].levels[0].clone(), folder)
}

/// Largest of |H| beside `around` (Hz), with the same damping ratio in both modes.
fn linear_maximum([k11, k12, k22]: [f64; 3], around: [f64; 2]) -> f64 {
    let k22 = k22 + 100.0;
    let (mean, half) = (
        0.5 * (k11 + k22),
        (0.25 * (k11 - k22).powi(2) + k12 * k12).sqrt(),
    );
    let squares = [mean - half, mean + half];
    let size = |hz: f64| {
        let w = std::f64::consts::TAU * hz;
        // the share of each mode at the first body
        let share = |square: f64| k12 * k12 / (k12 * k12 + (square - k11).powi(2));
        let part = |square: f64| {
            let (re, im) = (square - w * w, 0.04 * square.sqrt() * w);
            let norm = re * re + im * im;
            [share(square) * re / norm, share(square) * im / norm]
        };
        let [a, b] = squares.map(part);
        (a[0] + b[0]).hypot(a[1] + b[1])
    };
    let [low, high] = around;
    let place = |i: u32| low + (high - low) * f64::from(i) / 1e5;
    let places = (0..=100_000).map(place);
    places.fold(
        low,
        |best, hz| if size(hz) > size(best) { hz } else { best },
    )
}

/// Newton's method leads from the resonance of a weak mode to the maximum of the strong one beside it. A number names the maximum of its own
/// mode, which is searched uphill along the branch; where there is none, it is not known, and "all" counts none. Seen to fail with the
/// program before, which gave 99.96 Hz as `converged` for mode 2 of both models, and no maximum of mode 2 with "all".
#[test]
fn a_weak_mode_beside_a_strong_one_keeps_its_own_maximum() {
    let weak = [409_360.822_543_64, 72_883.232_500_35, 759_200.338_545_34];
    let expected = linear_maximum(weak, [135.0, 150.0]);
    assert!((141.0..142.0).contains(&expected), "{expected}");
    for peak in ["2", "\"all\""] {
        let (level, _) = weak_second_mode(weak, peak);
        assert_eq!(level.status, Status::Converged);
        let others = level.around.others().iter().map(|o| o.frequency_hz);
        let mut found: Vec<f64> = others.chain([level.peak.unwrap().frequency_hz]).collect();
        found.sort_by(f64::total_cmp);
        let own = found.pop().unwrap();
        assert!((own / expected - 1.0).abs() < 1e-6, "{own} {expected}");
        assert_eq!(found.len(), usize::from(peak != "2"), "{found:?}");
    }
    let (level, _) = weak_second_mode(weak, "1");
    let first = linear_maximum(weak, [95.0, 105.0]);
    assert_eq!(level.status, Status::Converged);
    assert!((level.peak.unwrap().frequency_hz / first - 1.0).abs() < 1e-6);

    let drowned = [395_631.180_405_75, 12_100.062_316_79, 567_642.209_140_57];
    assert_eq!(linear_maximum(drowned, [105.0, 150.0]), 105.0, "it falls");
    let (level, _) = weak_second_mode(drowned, "2");
    assert!(level.status == Status::StepTooSmall && level.peak.is_none());
    let (level, folder) = weak_second_mode(drowned, "\"all\"");
    assert_eq!(level.status, Status::Converged);
    let modes = summary(&folder)["levels"][0]["modes"].clone();
    let present = |i: usize| modes[i]["present"]["yes"].as_u64().unwrap();
    assert_eq!([present(0), present(1)], [1, 0], "{modes}");
}

/// A band may hold a mode of the stuck structure alone, or one of the free structure alone: the other limit has no resonance, and its largest
/// amplitude in the band is that of none. A band without either is refused, and `inspect` says so. Seen to fail with the program before, which
/// refused the first two, and with the amplitude at the end of the band as that of a limit.
#[test]
fn a_band_with_modes_of_one_kind_is_enough() {
    let limits = |band: &str, expected: [bool; 2]| {
        let folder = crate::folder("study.toml", "[100, 200]", band);
        let output = microslip(folder.path(), &["run", "study.toml", "--output", "out"]);
        assert_eq!(output.status.code(), Some(0), "{band}: {output:?}");
        let page = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
        assert!(page.contains("none in the band"), "{band}");
        let figure = figure(&page, "Amplitude per excitation");
        let drawn =
            ["free", "stuck"].map(|limit| figure.contains(&format!("class=\"line {limit}\"")));
        assert_eq!(drawn, expected, "{band}");
        let summary = summary(&folder);
        ["free_frequency_hz", "stuck_frequency_hz"].map(|limit| summary[limit].as_f64())
    };
    let [free, stuck] = limits("[170, 250]", [false, true]);
    assert!(free.is_none() && (stuck.unwrap() - 185.83).abs() < 0.01);
    let [free, stuck] = limits("[100, 120]", [true, false]);
    assert!(stuck.is_none() && (free.unwrap() - 110.48).abs() < 0.01);
    let folder = crate::folder("study.toml", "[100, 200]", "[500, 540]");
    let facts = microslip(folder.path(), &["inspect", "study.toml"]);
    let text = String::from_utf8_lossy(&facts.stderr);
    assert!(text.contains("`run` refuses the study"), "{text}");
}
