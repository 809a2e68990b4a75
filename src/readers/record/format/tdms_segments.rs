//! The segments of a TDMS file: which objects there are, and the samples of those that are asked for.
//!
//! Format: "TDMS File Format Internal Structure" (National Instruments). Read are files of DAQmx or LabVIEW with the least byte
//! first; samples of DAQmx that are not scaled yet and segments that were not closed are refused.

use std::collections::BTreeMap;

use super::super::channels::MOST_NUMBERS;
use super::tdms_bytes::{Bytes, TEXT, Value, other_width, real};
use crate::file::binary::{Kind, number};

/// How a segment begins.
pub(super) const TAG: &[u8; 4] = b"TDSm";
/// Versions of the format.
const VERSIONS: [u32; 2] = [4712, 4713];
/// Segments of a file at most: a day with one for each second.
const MOST_SEGMENTS: usize = 100_000;
/// Objects of a file at most, and properties of an object.
const MOST_OBJECTS: usize = 1_000;
/// Bit of a segment with metadata.
const HAS_METADATA: u32 = 1 << 1;
/// Bit of a segment whose list of objects is new.
const NEW_LIST: u32 = 1 << 2;
/// Bit of a segment with samples.
const HAS_SAMPLES: u32 = 1 << 3;
/// Bit of a segment with samples of all channels by turns.
const BY_TURNS: u32 = 1 << 5;
/// Bit of a segment with the greatest byte first.
const BIG_ENDIAN: u32 = 1 << 6;
/// Bit of a segment with samples of DAQmx.
const DAQMX: u32 = 1 << 7;
/// Where an object has no samples.
const NO_SAMPLES: u32 = u32::MAX;
/// Where the samples of an object are stored as before.
const AS_BEFORE: u32 = 0;
/// Bytes of the description of samples: of numbers, and of texts.
const DESCRIPTION: [usize; 2] = [20, 28];

/// A file, a group or a channel.
#[derive(Debug, Default)]
pub(super) struct Object {
    /// Names of group and channel.
    pub(super) path: Vec<String>,
    pub(super) properties: BTreeMap<String, Value>,
    /// Samples of a channel that is asked for.
    pub(super) samples: Vec<f64>,
    wanted: bool,
    stored: Option<Stored>,
}

/// How the samples of a channel are stored in a chunk.
#[derive(Debug, Clone, Copy)]
struct Stored {
    bytes: usize,
    count: usize,
    /// Width and kind of numbers.
    real: Option<(usize, Kind)>,
    data_type: u32,
}

/// What has been read.
#[derive(Debug, Default)]
struct SegmentReader {
    objects: Vec<Object>,
    by_path: BTreeMap<Vec<String>, usize>,
    /// Objects with samples in the segment, in their order.
    active: Vec<usize>,
    numbers: usize,
}

/// All objects, with the samples of channels that are `wanted` by their names.
///
/// # Errors
/// The rule that the file breaks.
pub(super) fn read(bytes: &[u8], wanted: fn(&str) -> bool) -> Result<Vec<Object>, String> {
    let mut reader = SegmentReader::default();
    let mut rest = Bytes { rest: bytes };
    let mut segments = 0;
    while !rest.rest.is_empty() {
        segments += 1;
        if segments > MOST_SEGMENTS {
            return Err(format!("has more than {MOST_SEGMENTS} segments"));
        }
        let read = reader.segment(&mut rest, wanted);
        read.map_err(|rule| format!("segment {segments}: {rule}"))?;
    }
    Ok(reader.objects)
}

impl SegmentReader {
    fn segment(&mut self, rest: &mut Bytes<'_>, wanted: fn(&str) -> bool) -> Result<(), String> {
        if rest.take(4).ok() != Some(TAG) {
            return Err("must begin with TDSm".to_owned());
        }
        let (flags, version) = (rest.u32()?, rest.u32()?);
        // the version has the greatest byte first then, too
        if flags & BIG_ENDIAN != 0 {
            return Err("has the greatest byte first, which is not read".to_owned());
        }
        if !VERSIONS.contains(&version) {
            return Err(format!("is of version {version}: must be 4712 or 4713"));
        }
        if flags & DAQMX != 0 {
            return Err(
                "has raw samples of DAQmx, which are not read: save scaled ones".to_owned(),
            );
        }
        let (length, metadata) = (rest.u64()?, rest.u64()?);
        if length == u64::MAX {
            return Err("was not closed: its writer was stopped".to_owned());
        }
        let whole = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
        let mut inside = Bytes {
            rest: rest.take(whole(length))?,
        };
        let mut metadata = Bytes {
            rest: inside.take(whole(metadata))?,
        };
        if flags & HAS_METADATA != 0 {
            if flags & NEW_LIST != 0 {
                self.active.clear();
            }
            self.metadata(&mut metadata, wanted)?;
        }
        match flags & HAS_SAMPLES {
            0 => Ok(()),
            _ => self.samples(inside.rest, flags & BY_TURNS != 0),
        }
    }

    fn metadata(&mut self, bytes: &mut Bytes<'_>, wanted: fn(&str) -> bool) -> Result<(), String> {
        for _ in 0..bytes.u32()? {
            let path = bytes.text()?;
            let at = |rule: String| format!("object {path:.60}: {rule}");
            let names = names(&path).map_err(at)?;
            let object = match self.by_path.get(&names) {
                Some(object) => *object,
                None if self.objects.len() == MOST_OBJECTS => {
                    return Err(format!("has more than {MOST_OBJECTS} objects"));
                }
                None => {
                    let wanted = names.len() == 2 && wanted(&names[1]);
                    self.by_path.insert(names.clone(), self.objects.len());
                    self.objects.push(Object {
                        path: names,
                        wanted,
                        ..Object::default()
                    });
                    self.objects.len() - 1
                }
            };
            self.stored(object, bytes).map_err(at)?;
            for _ in 0..bytes.u32()? {
                let (name, value) = bytes.property().map_err(at)?;
                let properties = &mut self.objects[object].properties;
                if properties.len() == MOST_OBJECTS {
                    return Err(at(format!("has more than {MOST_OBJECTS} properties")));
                }
                properties.insert(name, value);
            }
        }
        Ok(())
    }

    /// How the samples of an object are stored from this segment on.
    fn stored(&mut self, object: usize, bytes: &mut Bytes<'_>) -> Result<(), String> {
        let length = bytes.u32()?;
        if length == NO_SAMPLES {
            self.active.retain(|other| *other != object);
            return Ok(());
        }
        if length == AS_BEFORE {
            if self.objects[object].stored.is_none() {
                return Err("has samples as before, but there are none before".to_owned());
            }
        } else {
            if !DESCRIPTION.contains(&(length as usize)) {
                return Err(format!(
                    "describes its samples in {length} bytes: must be {} or {}; raw samples of DAQmx are not read",
                    DESCRIPTION[0], DESCRIPTION[1]
                ));
            }
            let stored = Stored::read(bytes)?;
            let before = self.objects[object].stored.replace(stored);
            if before.is_some_and(|before| before.data_type != stored.data_type) {
                return Err("changes the type of its samples".to_owned());
            }
        }
        if !self.active.contains(&object) {
            self.active.push(object);
        }
        Ok(())
    }

    /// Samples of a segment: chunks with the samples of all active objects, until its end.
    fn samples(&mut self, bytes: &[u8], by_turns: bool) -> Result<(), String> {
        let stored = self.active.iter().filter_map(|object| {
            let stored = self.objects[*object]
                .stored
                .filter(|stored| stored.bytes > 0);
            Some((*object, stored?))
        });
        let stored: Vec<_> = stored.collect();
        let chunk = stored
            .iter()
            .try_fold(0_usize, |sum, (_, stored)| sum.checked_add(stored.bytes));
        let chunk = chunk.ok_or("states more bytes than there are")?;
        if bytes.is_empty() {
            return Ok(());
        }
        if chunk == 0 || !bytes.len().is_multiple_of(chunk) {
            let n = bytes.len();
            return Err(format!(
                "has {n} bytes of samples: must be whole chunks of {chunk} bytes"
            ));
        }
        for mut rest in bytes.chunks_exact(chunk) {
            if by_turns {
                self.by_turns(rest, &stored)?;
                continue;
            }
            for (object, stored) in &stored {
                let (own, after) = rest.split_at(stored.bytes);
                rest = after;
                self.take(*object, *stored, own, 0, 1)?;
            }
        }
        Ok(())
    }

    /// One sample of each channel after the other.
    fn by_turns(&mut self, chunk: &[u8], stored: &[(usize, Stored)]) -> Result<(), String> {
        let row = stored
            .iter()
            .map(|(_, stored)| stored.bytes / stored.count.max(1));
        let row: usize = row.sum();
        let equal = stored
            .windows(2)
            .all(|two| two[0].1.count == two[1].1.count);
        if !equal || stored.iter().any(|(_, stored)| stored.real.is_none()) {
            return Err("has samples by turns: all channels must have as many numbers".to_owned());
        }
        let mut offset = 0;
        for (object, stored) in stored {
            self.take(*object, *stored, chunk, offset, row)?;
            offset += stored.bytes / stored.count.max(1);
        }
        Ok(())
    }

    /// Samples of a channel: one behind the other where `step` is 1 byte or less than their width, else so many bytes apart.
    fn take(
        &mut self,
        object: usize,
        stored: Stored,
        bytes: &[u8],
        offset: usize,
        step: usize,
    ) -> Result<(), String> {
        let object = &mut self.objects[object];
        if !object.wanted {
            return Ok(());
        }
        let Some((width, kind)) = stored.real else {
            return Err(format!(
                "channel {:.40}: has data of type {:#x}: must be real numbers",
                object.path[1], stored.data_type
            ));
        };
        self.numbers += stored.count;
        if self.numbers > MOST_NUMBERS {
            return Err(format!("has more than {MOST_NUMBERS} numbers"));
        }
        let rows = bytes.chunks_exact(step.max(width));
        let samples = rows.map(|row| number(&row[offset..offset + width], kind, false));
        object.samples.extend(samples);
        Ok(())
    }
}

impl Stored {
    fn read(bytes: &mut Bytes<'_>) -> Result<Self, String> {
        let (data_type, dimension, count) = (bytes.u32()?, bytes.u32()?, bytes.u64()?);
        if dimension != 1 {
            return Err(format!("has {dimension} dimensions: must have 1"));
        }
        let count = usize::try_from(count).map_err(|_| "states more samples than there are")?;
        let real = real(data_type);
        let width = real.map(|(width, _)| width).or(other_width(data_type));
        let size = match (data_type, width) {
            (TEXT, _) => usize::try_from(bytes.u64()?).ok(),
            (_, Some(width)) => count.checked_mul(width),
            (_, None) => return Err(format!("has data of type {data_type:#x}, which is none")),
        };
        Ok(Self {
            bytes: size.ok_or("states more bytes than there are")?,
            count,
            real,
            data_type,
        })
    }
}

/// Names in a path: `/'group'/'channel'`; a quote in a name is doubled.
fn names(path: &str) -> Result<Vec<String>, String> {
    let wrong = || "must be / or /'group' or /'group'/'channel'".to_owned();
    let mut names = Vec::new();
    let mut rest = path;
    if path == "/" {
        return Ok(names);
    }
    while !rest.is_empty() {
        let quoted = rest.strip_prefix("/'").ok_or_else(wrong)?;
        let mut from = 0;
        let end = loop {
            let at = quoted[from..]
                .find('\'')
                .map(|at| from + at)
                .ok_or_else(wrong)?;
            if !quoted[at + 1..].starts_with('\'') {
                break at;
            }
            from = at + 2;
        };
        names.push(quoted[..end].replace("''", "'"));
        rest = &quoted[end + 1..];
    }
    match names.len() {
        1 | 2 => Ok(names),
        _ => Err(wrong()),
    }
}
