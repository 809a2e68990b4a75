//! TDMS files: channels one behind the other and by turns, in one and in several segments.

use crate::contact::RECORDS;
use crate::contact::{SAMPLES, contact, read_as, whole_contact};
use crate::matlab::assert_near;
use microslip::record::HysteresisRecord;

/// Types of numbers and texts.
const I32: u32 = 3;
const SINGLE: u32 = 9;
pub(crate) const DOUBLE: u32 = 10;
const TEXT: u32 = 0x20;
/// Flags of a segment.
const METADATA: u32 = 2;
const NEW_LIST: u32 = 4;
const SAMPLED: u32 = 8;
const BY_TURNS: u32 = 32;

/// A property: name, type, bytes.
type Property = (&'static str, u32, Vec<u8>);

pub(crate) fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

pub(crate) fn real(value: f64) -> Vec<u8> {
    value.to_le_bytes().to_vec()
}

/// An object with its properties; `samples` are their type and number.
fn object(path: &str, samples: Option<(u32, usize)>, properties: &[Property]) -> Vec<u8> {
    let mut bytes = text(path);
    match samples {
        None => bytes.extend(u32::MAX.to_le_bytes()),
        Some((kind, count)) => {
            for word in [20, kind, 1] {
                bytes.extend(word.to_le_bytes());
            }
            bytes.extend((count as u64).to_le_bytes());
        }
    }
    bytes.extend((properties.len() as u32).to_le_bytes());
    for (name, kind, value) in properties {
        bytes.extend(text(name));
        bytes.extend(kind.to_le_bytes());
        bytes.extend(value);
    }
    bytes
}

fn segment(flags: u32, objects: &[Vec<u8>], samples: &[u8]) -> Vec<u8> {
    let mut metadata = Vec::new();
    if flags & METADATA != 0 {
        metadata.extend((objects.len() as u32).to_le_bytes());
        metadata.extend(objects.concat());
    }
    let mut bytes = b"TDSm".to_vec();
    bytes.extend(flags.to_le_bytes());
    bytes.extend(4713_u32.to_le_bytes());
    bytes.extend(((metadata.len() + samples.len()) as u64).to_le_bytes());
    bytes.extend((metadata.len() as u64).to_le_bytes());
    [bytes, metadata, samples.to_vec()].concat()
}

/// A channel: name, unit, type, values in that unit.
type Channel = (&'static str, &'static str, u32, Vec<f64>);

fn bytes_of(kind: u32, value: f64) -> Vec<u8> {
    match kind {
        I32 => (value.round() as i32).to_le_bytes().to_vec(),
        SINGLE => (value as f32).to_le_bytes().to_vec(),
        _ => real(value),
    }
}

/// Doubles, singles and whole numbers; the time is that of the waveforms.
fn channels(test: &HysteresisRecord) -> Vec<Channel> {
    let scaled = |signal: &[f64], factor: f64| signal.iter().map(|x| x * factor).collect();
    vec![
        (
            "Relative displacement",
            "um",
            DOUBLE,
            scaled(&test.displacement, 1e6),
        ),
        ("Temperature", "K", SINGLE, scaled(&test.normal_force, 1.0)),
        ("T [mN]", "", I32, scaled(&test.tangential_force, 1e3)),
        ("Normal load", "N", SINGLE, scaled(&test.normal_force, 1.0)),
        (
            "Normal displacement",
            "nm",
            DOUBLE,
            scaled(test.approach.as_ref().unwrap(), 1e9),
        ),
    ]
}

fn objects(channels: &[Channel], group: &str, count: usize) -> Vec<Vec<u8>> {
    let conditions: [Property; 2] = [
        ("specimen", TEXT, text("A")),
        ("frequency [Hz]", DOUBLE, real(100.0)),
    ];
    let mut objects = vec![
        object(
            "/",
            None,
            &[("name", TEXT, text("rig")), ("started", 0x44, vec![0; 16])],
        ),
        object(&format!("/'{group}'"), None, &conditions),
    ];
    for (name, unit, kind, _) in channels {
        let mut properties = vec![
            ("wf_increment", DOUBLE, real(1.0 / 6400.0)),
            ("wf_start_offset", DOUBLE, real(0.0)),
            ("wf_samples", I32, 1_i32.to_le_bytes().to_vec()),
        ];
        if !unit.is_empty() {
            properties.push(("unit_string", TEXT, text(unit)));
        }
        objects.push(object(
            &format!("/'{group}'/'{name}'"),
            Some((*kind, count)),
            &properties,
        ));
    }
    objects
}

/// Samples `from` to `to` of all channels, one channel behind the other.
fn chunk(channels: &[Channel], from: usize, to: usize) -> Vec<u8> {
    let own = channels.iter().map(|(_, _, kind, values)| {
        let bytes = values[from..to].iter().map(|value| bytes_of(*kind, *value));
        bytes.flatten().collect::<Vec<_>>()
    });
    own.flatten().collect()
}

/// One segment, one chunk.
pub(crate) fn whole() -> Vec<u8> {
    let channels = channels(&whole_contact("rig"));
    let objects = objects(&channels, "rig''s first", SAMPLES);
    segment(
        METADATA | NEW_LIST | SAMPLED,
        &objects,
        &chunk(&channels, 0, SAMPLES),
    )
}

/// Two chunks, then a segment without metadata, then one whose objects are as before, then one of another length.
pub(crate) fn in_segments() -> Vec<u8> {
    let channels = channels(&whole_contact("rig"));
    let first = [chunk(&channels, 0, 20), chunk(&channels, 20, 40)].concat();
    let as_before = [text("/'rig'/'T [mN]'"), vec![0; 8]].concat();
    let no_samples = object("/'rig'", None, &[("note", TEXT, text("later"))]);
    let longer = objects(&channels, "rig", SAMPLES - 80);
    [
        segment(
            METADATA | NEW_LIST,
            &objects(&channels, "rig", 20)[..2],
            b"",
        ),
        segment(METADATA | SAMPLED, &objects(&channels, "rig", 20), &first),
        segment(SAMPLED, &[], &chunk(&channels, 40, 60)),
        segment(
            METADATA | SAMPLED,
            &[as_before, no_samples],
            &chunk(&channels, 60, 80),
        ),
        segment(
            METADATA | NEW_LIST | SAMPLED,
            &longer,
            &chunk(&channels, 80, SAMPLES),
        ),
    ]
    .concat()
}

fn by_turns() -> Vec<u8> {
    let channels = channels(&whole_contact("rig"));
    let rows = (0..SAMPLES).flat_map(|at| chunk(&channels, at, at + 1));
    let rows: Vec<u8> = rows.collect();
    let objects = objects(&channels, "rig", SAMPLES);
    segment(METADATA | NEW_LIST | SAMPLED | BY_TURNS, &objects, &rows)
}

/// Seen to fail with the chunks of a segment read as one.
#[test]
fn segments_of_every_form_are_read() {
    for (what, bytes) in [
        ("whole", whole()),
        ("segments", in_segments()),
        ("turns", by_turns()),
    ] {
        let found = read_as("rig.any", &bytes).unwrap();
        assert_eq!(found.len(), 1, "{what}");
        assert_eq!(found[0].name, "rig", "{what}");
        assert_near(&found[0], &whole_contact("rig"), 1e-6, what);
    }
    let found = read_as("rig.tdms", &[in_segments(), whole()].concat()).unwrap();
    let names: Vec<_> = found.iter().map(|test| test.name.as_str()).collect();
    assert_eq!(names, ["rig rig", "rig rig's first"]);
}

/// A channel of times, and no properties of waveforms.
fn with_time(time: &[f64]) -> Vec<u8> {
    let test = contact("rig");
    let signals = [
        ("Time_ms", 1e3, time),
        ("x [m]", 1.0, &test.displacement),
        ("T_kN", 1e-3, &test.tangential_force),
        ("N [N]", 1.0, &test.normal_force),
    ];
    let objects = signals.map(|(name, _, values)| {
        object(&format!("/'g'/'{name}'"), Some((DOUBLE, values.len())), &[])
    });
    let samples = signals
        .iter()
        .flat_map(|(_, factor, values)| values.iter().flat_map(move |v| real(v * factor)));
    segment(
        METADATA | NEW_LIST | SAMPLED,
        &objects,
        &samples.collect::<Vec<_>>(),
    )
}

/// Seen to fail with the time taken from waveforms alone.
#[test]
fn the_time_may_be_a_channel() {
    let test = contact("rig");
    let found = read_as("rig.tdms", &with_time(&test.time)).unwrap();
    assert_near(&found[0], &test, 1e-14, "time");
    RECORDS.refuse_bytes(
        "rig.tdms",
        &with_time(&test.time[1..]),
        "short",
        "relative displacement has 128 samples and time 127",
    );
    let mut time = test.time.clone();
    time[7] = time[6];
    RECORDS.refuse_bytes(
        "rig.tdms",
        &with_time(&time),
        "standing",
        "test g: sample 8: time =",
    );
}

/// Bytes of the whole file, what they become, and what the message must hold.
type Damages = Vec<(Vec<u8>, Vec<u8>, &'static str)>;

pub(crate) fn word(value: u32) -> Vec<u8> {
    value.to_le_bytes().to_vec()
}

/// Of the beginning of the segment.
fn segment_damages() -> Damages {
    let flags = |flags: u32| [b"TDSm".to_vec(), word(flags)].concat();
    let usual = flags(METADATA | NEW_LIST | SAMPLED);
    let with = |new: u32, rule| (usual.clone(), flags(new), rule);
    vec![
        with(0, "has no group with channels such as tangential force"),
        with(METADATA | NEW_LIST, "has no group with channels such as"),
        with(SAMPLED, "segment 1: has "),
        with(
            14 | 64,
            "segment 1: has the greatest byte first, which is not",
        ),
        with(
            14 | 128,
            "segment 1: has raw samples of DAQmx, which are not",
        ),
        (
            word(4713),
            word(4711),
            "segment 1: is of version 4711: must be",
        ),
    ]
}

/// Of the description of samples.
fn description_damages() -> Damages {
    let x = |words: [u32; 3]| {
        let words = words.map(u32::to_le_bytes).concat();
        [&b"Relative displacement'"[..], &words].concat()
    };
    let own = x([20, DOUBLE, 1]);
    let with = |words: [u32; 3], rule| (own.clone(), x(words), rule);
    let counted = |count: u64| [&own[..], &count.to_le_bytes()].concat();
    let count = |count: u64, rule| (counted(128), counted(count), rule);
    vec![
        with(
            [21, DOUBLE, 1],
            "describes its samples in 21 bytes: must be 20 or 28",
        ),
        with([0x1269, DOUBLE, 1], "raw samples of DAQmx are not read"),
        with(
            [0, DOUBLE, 1],
            "has samples as before, but there are none before",
        ),
        with([20, DOUBLE, 2], "has 2 dimensions: must have 1"),
        with([20, 99, 1], "has data of type 0x63, which is none"),
        with([20, SINGLE, 1], "must be whole chunks of"),
        with([20, 8, 1], "relative displacement"),
        with([20, 0x44, 1], "must be whole chunks of"),
        with([20, TEXT, 1], "segment 1: "),
        count(127, "must be whole chunks of"),
        count(1 << 40, "must be whole chunks of"),
        count(u64::MAX, "states more bytes than there are"),
    ]
}

/// Of texts.
fn text_damages() -> Damages {
    let bytes = |text: &str| text.as_bytes().to_vec();
    let path = |new: &str, rule| (bytes("/'rig''s first'/'T"), bytes(new), rule);
    let unit = |new: &str, rule| (bytes("um"), bytes(new), rule);
    let not_closed = [word(4), vec![0xff; 4]].concat();
    vec![
        (
            text("unit_string"),
            text("unit_strong"),
            "displacement: has no unit",
        ),
        unit(
            "mN",
            "relative displacement [mN]: must be in a unit of length",
        ),
        unit("  ", "relative displacement: has no unit"),
        (
            text("name"),
            [word(70_000), bytes("name")].concat(),
            "must have at most 65536",
        ),
        (text("name"), not_closed, "has a text that is no UTF-8"),
        path(
            "/'rig''s first' 'T",
            "must be / or /'group' or /'group'/'channel'",
        ),
        path("/'rigs' 'first'/'T", "must be / or /'group'"),
        path("/'rig''s first'//T", "must be / or /'group'"),
        (
            bytes("'Normal load'"),
            bytes("'Normal lood'"),
            "signal normal force",
        ),
        (
            bytes("'Temperature'"),
            bytes("'Normal-load'"),
            "normal force [K]: must",
        ),
        (
            bytes("'T [mN]'"),
            bytes("'T [MN]'"),
            "tangential force [MN]: must be",
        ),
        (
            bytes("'T [mN]'"),
            bytes("'T [s ]'"),
            "tangential force [s]: must be",
        ),
    ]
}

/// Of properties. The last ones leave a file that can be read.
fn property_damages() -> Damages {
    let number = |name: &str, value: f64| [text(name), word(DOUBLE), real(value)].concat();
    let step = 1.0 / 6400.0;
    let other_step = number("wf_increment", 0.1);
    let frequency = |value: f64, rule| {
        let own = number("frequency [Hz]", 100.0);
        (own, number("frequency [Hz]", value), rule)
    };
    let started = |kind: u32| [text("started"), word(kind)].concat();
    let a = |new: &str| [word(TEXT), text(new)].concat();
    let samples = |name: &str| [text(name), word(I32), word(1)].concat();
    vec![
        (
            number("wf_increment", step),
            other_step,
            "must be those of the other channels",
        ),
        frequency(-1.0, "frequency = -1 Hz: must be a finite number > 0"),
        frequency(f64::NAN, "frequency = NaN Hz: must be a finite number > 0"),
        frequency(3200.0, "frequency = 3200 Hz: must be below half of the"),
        (
            started(0x44),
            started(0x45),
            "property started: has the type 0x45, which",
        ),
        (a("A"), a(" "), "specimen: must not be empty"),
        (a("A"), a("\n"), "specimen: must"),
        (
            samples("wf_samples"),
            samples("NI_Number_Of_Scales"),
            "samples to be scaled",
        ),
        (text("wf_increment"), text("wf_incroment"), ""),
        (text("wf_samples"), text("wf_sample"), ""),
        (text("specimen"), text("frequenc"), ""),
    ]
}

/// Damages after which the file is still a test: another name of a property that is not used.
const HARMLESS: usize = 3;

/// Seen to fail with parts of chunks, samples to be scaled and the other byte order taken, one after the other.
#[test]
fn damaged_files_are_refused() {
    let whole = whole();
    let damages = [
        segment_damages(),
        description_damages(),
        text_damages(),
        property_damages(),
    ];
    let damages = damages.concat();
    let (mut refused, all) = (0, damages.len());
    for (from, to, fragment) in damages {
        let at = whole.windows(from.len()).position(|bytes| bytes == from);
        let at = at.unwrap_or_else(|| panic!("{fragment}: no such bytes"));
        let mut file = whole.clone();
        file.splice(at..at + from.len(), to.iter().copied());
        // lengths of the segment follow those of its texts
        let grown = to.len() as i64 - from.len() as i64;
        for place in [12, 20] {
            let old = i64::from_le_bytes(whole[place..place + 8].try_into().unwrap());
            file[place..place + 8].copy_from_slice(&(old + grown).to_le_bytes());
        }
        match read_as("rig.tdms", &file) {
            read if fragment.is_empty() => assert!(read.is_ok(), "{read:?}"),
            _ => {
                RECORDS.refuse_bytes("rig.tdms", &file, &format!("{fragment} at {at}"), fragment);
                refused += 1;
            }
        }
    }
    assert!(
        refused + HARMLESS == all && refused >= 30,
        "{refused} damages"
    );
    RECORDS.refuse_cuts(
        "rig.tdms",
        &whole,
        &[0.001, 0.002, 0.005, 0.05, 0.1, 0.5, 0.9, 0.999],
        "segment 1: ",
    );
    let mut open = whole.clone();
    open[12..20].fill(0xff);
    RECORDS.refuse_bytes(
        "rig.tdms",
        &open,
        "not closed",
        "segment 1: was not closed: its writer was stopped",
    );
    let twice = [&whole[..], b"TDSx"].concat();
    RECORDS.refuse_bytes(
        "rig.tdms",
        &twice,
        "second",
        "segment 2: must begin with TDSm",
    );
}
