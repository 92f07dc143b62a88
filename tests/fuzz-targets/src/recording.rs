//! Recordings: check, repair, rows, frames, comparison, export, controller states, replay.
//!
//! `recording` builds a file from the instructions of an input, and then changes its bytes.
//! `recording-bytes` changes the bytes of whole files. Both repair checksums on request.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use atas_core::record::Replay;
use atas_core::record::{read_origin, read_settings, write_origin};
use atas_core::{Controller, SensorSetup, Settings};
use atas_recording::{Choices, Frames, Kind, Recorded, Rows};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, WriteOptions, Writer};
use shm_schemas::{
    HandFrame, ModuleEvent, OrderKind, RunHeader, SensorStatus, Stamp, Status, Text, TickInputs,
    TickReport,
};

use crate::bus::ROBOT;
use crate::input::Input;
use crate::target::Target;

/// Most memory of a reader of a small file: a chunk of 16 MiB, its copies and its content.
const MEMORY: u64 = 96 << 20;

/// Targets of this file.
pub(crate) const TARGETS: [Target; 4] = [
    Target::new("recording", recording, seeds)
        .memory(MEMORY)
        .executions(200),
    Target::new("recording-bytes", recording_bytes, byte_seeds)
        .length(64 << 10)
        .memory(MEMORY)
        .executions(300),
    Target::new("controller-state", controller_state, state_seeds)
        .length(256 << 10)
        .executions(100),
    Target::new("replay", replay, replay_seeds).executions(1_000),
];

/// Topic of controller states.
const STATE_TOPIC: &str = "controller-state";

/// A file being built.
struct Draft {
    mcap: Writer<Cursor<Vec<u8>>>,
    sequence: u64,
}

impl Draft {
    fn new(options: u8) -> Self {
        let compression = match options % 4 {
            0 => Some(Compression::Zstd),
            _ => None,
        };
        let write = WriteOptions::new()
            .profile("atas")
            .compression(compression)
            .chunk_size((options % 8 < 6).then_some(4 << 10));
        Self {
            mcap: write.create(Cursor::new(Vec::new())).expect("memory"),
            sequence: 0,
        }
    }

    fn stamp(&self) -> Stamp {
        Stamp {
            sequence: self.sequence,
            captured_ns: 1_000_000_000 + self.sequence * 1_000_000,
            writer_epoch: 1,
        }
    }

    fn message(&mut self, topic: &str, schema: &str, data: &[u8]) {
        let stamp = self.stamp();
        let write = |mcap: &mut Writer<_>| {
            let schema = mcap.add_schema(schema, "atas-pod", b"")?;
            let channel_id = mcap.add_channel(schema, topic, "atas-pod", &BTreeMap::new())?;
            let header = MessageHeader {
                channel_id,
                sequence: stamp.sequence as u32,
                log_time: stamp.captured_ns,
                publish_time: stamp.captured_ns,
            };
            mcap.write_to_known_channel(&header, data)
        };
        write(&mut self.mcap).expect("memory");
    }

    /// Writes a payload: changed, of another version, or with a wrong length.
    fn payload<T: Recorded>(&mut self, mut payload: T, input: &mut Input<'_>) {
        let kind = input.byte();
        input.patch(&mut payload);
        let bytes = payload.as_bytes();
        match kind {
            0 => self.message(T::TOPIC, T::TYPE_NAME, &bytes[..bytes.len() / 2]),
            1 => self.message(T::TOPIC, &format!("{}9", T::TYPE_NAME), bytes),
            2 => self.message("other", T::TYPE_NAME, bytes),
            _ => self.message(T::TOPIC, T::TYPE_NAME, bytes),
        }
    }

    fn attachment(&mut self, input: &mut Input<'_>) {
        let length = usize::from(input.byte() % 32);
        let attachment = mcap::Attachment {
            log_time: 0,
            create_time: 0,
            name: "a".to_owned(),
            media_type: "b".to_owned(),
            data: input.bytes(length).into(),
        };
        self.mcap.attach(&attachment).expect("memory");
    }

    fn metadata(&mut self, input: &mut Input<'_>) {
        const NAMES: [&str; 4] = ["atas.run", "atas.robot", "atas.notes", "x"];
        const KEYS: [&str; 5] = [
            "unix_over_monotonic_ns",
            "file_begun_unix_s",
            "name",
            "urdf",
            "robot_file",
        ];
        let name = NAMES[usize::from(input.byte()) % NAMES.len()];
        let texts = KEYS.map(|key| {
            let length = usize::from(input.byte() % 32);
            let value = match input.byte() {
                0..=99 => (input.u64() as i64).to_string(),
                _ => String::from_utf8_lossy(input.bytes(length)).into_owned(),
            };
            (key.to_owned(), value)
        });
        let metadata = Metadata {
            name: name.to_owned(),
            metadata: texts.into(),
        };
        self.mcap.write_metadata(&metadata).expect("memory");
    }
}

/// Header of a run of the built-in robot.
fn header() -> Box<RunHeader> {
    let mut header = Box::<RunHeader>::default();
    write_origin(
        &mut header,
        &ROBOT,
        &SensorSetup::default(),
        &Settings::default(),
    );
    header.robot = Text::new("two-hand-arm");
    header.robot_hash = robot_model::TWO_HAND_ARM.hash();
    header.rate_hz = 1000;
    header
}

fn build(input: &mut Input<'_>) -> Vec<u8> {
    let options = input.byte();
    let mut draft = Draft::new(options);
    for _ in 0..32 {
        let stamp = draft.stamp();
        let tick = draft.sequence;
        match input.byte() % 16 {
            0 => draft.payload(*header(), input),
            1..=4 => {
                let part = TickInputs {
                    stamp,
                    tick,
                    parts: 1,
                    ..TickInputs::default()
                };
                draft.payload(part, input);
                draft.sequence += 1;
            }
            5 | 6 => {
                let report = TickReport {
                    stamp,
                    tick,
                    ..TickReport::default()
                };
                draft.payload(report, input);
                draft.sequence += 1;
            }
            7 | 8 => {
                let event = ModuleEvent {
                    stamp,
                    tick,
                    ..ModuleEvent::default()
                };
                draft.payload(event, input);
            }
            9 => draft.payload(
                Status {
                    stamp,
                    ..Status::default()
                },
                input,
            ),
            10 => draft.payload(
                SensorStatus {
                    stamp,
                    ..SensorStatus::default()
                },
                input,
            ),
            11 => draft.metadata(input),
            12 => {
                let length = usize::from(input.byte());
                draft.message(STATE_TOPIC, "atas.ControllerState", input.bytes(length));
            }
            13 => draft.attachment(input),
            _ => draft.mcap.flush().expect("memory"),
        }
        if input.is_empty() {
            break;
        }
    }
    if options & 0x80 == 0 {
        draft.mcap.finish().expect("memory");
    }
    draft.mcap.into_inner().into_inner()
}

fn recording(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let options = input.byte();
    let mut file = build(&mut input);
    if options & 1 == 1 {
        input.patch_bytes(&mut file);
        repair_checksums(&mut file, options);
    }
    read(&file, options);
}

fn recording_bytes(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let options = input.byte();
    let mut file = input.rest().to_vec();
    repair_checksums(&mut file, options);
    read(&file, options);
}

/// Repairs the checksums of chunks and sections, unless the options say otherwise.
fn repair_checksums(file: &mut [u8], options: u8) {
    if options & 2 == 2 {
        return;
    }
    let mut begin = 8;
    while let Some(length) = number::<8>(file, begin + 1) {
        let content = begin + 9;
        let Some(end) = usize::try_from(length)
            .ok()
            .and_then(|length| content.checked_add(length))
        else {
            return;
        };
        match file[begin] {
            0x06 => repair_chunk(file, content, end),
            0x0F => put(file, content, &[0; 4]),
            0x02 => put(file, content + 16, &[0; 4]),
            _ => {}
        }
        begin = end;
    }
}

fn repair_chunk(file: &mut [u8], content: usize, end: usize) {
    let name_length = number::<4>(file, content + 28).unwrap_or(0) as usize;
    let records = content.saturating_add(40).saturating_add(name_length);
    let sum = match file.get(records..end) {
        Some(records) if name_length == 0 => crc32fast::hash(records),
        // 0 means: no checksum.
        _ => 0,
    };
    put(file, content + 24, &sum.to_le_bytes());
}

fn number<const N: usize>(file: &[u8], place: usize) -> Option<u64> {
    let bytes = file.get(place..)?.get(..N)?;
    let mut number = [0; 8];
    number[..N].copy_from_slice(bytes);
    Some(u64::from_le_bytes(number))
}

fn put(file: &mut [u8], place: usize, bytes: &[u8]) {
    if let Some(place) = file
        .get_mut(place..)
        .and_then(|rest| rest.get_mut(..bytes.len()))
    {
        place.copy_from_slice(bytes);
    }
}

/// Folder in memory, if the system has one.
fn folder() -> tempfile::TempDir {
    let memory = Path::new("/dev/shm");
    let made = if memory.is_dir() {
        tempfile::tempdir_in(memory)
    } else {
        tempfile::tempdir()
    };
    made.expect("a temporary folder")
}

/// Passes a file to all readers.
fn read(file: &[u8], options: u8) {
    let folder = folder();
    let path = folder.path().join("fuzz.mcap");
    std::fs::write(&path, file).expect("a written file");
    let found = atas_recording::check(&path);
    let repaired = folder.path().join("repaired.mcap");
    if let Ok((_, saved)) = atas_recording::repair(&path, Some(&repaired)) {
        let found = found.expect("a file that can be repaired can be checked");
        assert_eq!((saved.messages, saved.parts), (found.messages, found.parts));
        let again = atas_recording::check(&repaired).expect("a readable file");
        assert_eq!(again.damage, None, "a repaired file is damaged");
        assert_eq!((again.messages, again.parts), (found.messages, found.parts));
    }
    let files = [path.clone()];
    if let Ok(rows) = Rows::open(&files) {
        let clock = rows.clock();
        for row in rows.take(100).flatten() {
            let _time = clock.unix_ns(row.captured_ns);
        }
    }
    let _frames = Frames::open(&files).take(100).count();
    if options & 0x04 != 0 {
        let _difference = atas_recording::diff(&path, &repaired);
        let _runs = atas_recording::runs(&files);
    }
    if options & 0x38 == 0x38 {
        export(&files, folder.path(), options);
    }
}

fn export(files: &[PathBuf], folder: &Path, options: u8) {
    let choices = Choices {
        kind: [Kind::Csv, Kind::Mcap, Kind::Parquet][usize::from(options >> 6) % 3],
        pictures_hz: 60.0,
        elements: options & 0x40 != 0,
    };
    let out = folder.join("exported");
    let _exported = atas_recording::export(files, &out, &choices, &AtomicBool::new(false));
}

fn seeds() -> Vec<Vec<u8>> {
    let mut seeds = Vec::new();
    for options in [0, 4, 0x3C, 0xBC, 1, 5] {
        for build in [0_u8, 1, 6, 0x81] {
            let mut seed = vec![options, build];
            for kind in [11, 0, 1, 5, 7, 13, 9, 10, 12, 2, 6, 8, 15] {
                seed.extend([kind, 9, 0]);
            }
            seeds.push(seed);
        }
    }
    seeds
}

fn byte_seeds() -> Vec<Vec<u8>> {
    let build = |options: u8, kinds: &[u8]| {
        let mut instructions = vec![options];
        instructions.extend(kinds.iter().flat_map(|kind| [*kind, 9, 0]));
        build(&mut Input::new(&instructions))
    };
    let mut seeds = Vec::new();
    for options in [0, 1, 6, 0x81] {
        for kinds in [&[7, 9, 7, 11][..], &[5, 8, 5], &[13, 15, 7]] {
            let file = build(options, kinds);
            seeds.extend([0, 2, 4].map(|options| [&[options][..], &file].concat()));
        }
    }
    seeds
}

/// Encoded state of a controller.
fn state_seeds() -> Vec<Vec<u8>> {
    let controller = Controller::new(&ROBOT, SensorSetup::default(), Settings::default());
    vec![atas_controller_state::encode(&controller, 7).expect("an encoded state")]
}

fn controller_state(bytes: &[u8]) {
    let _read = atas_controller_state::decode(bytes);
}

fn replay_seeds() -> Vec<Vec<u8>> {
    let mut seeds = vec![vec![0; 8], vec![0; 200]];
    for kind in 0..=OrderKind::ALL.len() as u8 {
        seeds.push(
            [
                vec![0, 0],
                vec![kind, 0, 0, 1, 2, 0, 9, 200, 1, 2, 3, 4, 5, 6, 7, 8].repeat(4),
            ]
            .concat(),
        );
    }
    seeds
}

/// Replay of a recorded run whose header and inputs are changed.
fn replay(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let mut header = header();
    if input.byte() >= 64 {
        input.patch(&mut *header);
    }
    let _settings = read_settings(&header.settings);
    let Ok(controller) = read_origin(&header, &ROBOT) else {
        return;
    };
    let frames = || vec![HandFrame::default(); 4];
    let mut replay = Replay::new(controller, [frames(), frames()]);
    for sequence in 0..16 {
        let mut part = Box::new(TickInputs {
            stamp: Stamp {
                sequence,
                captured_ns: 1_000_000_000 + sequence * 1_000_000,
                writer_epoch: 1,
            },
            tick: sequence,
            parts: 1,
            ..TickInputs::default()
        });
        part.order.settings = header.settings;
        part.order.kind = OrderKind(u32::from(input.byte()));
        if input.byte() >= 128 {
            part.frames[0].seal();
            part.joints.seal();
        }
        input.patch(&mut *part);
        if replay.feed(&part).is_err() {
            return;
        }
        if input.is_empty() {
            break;
        }
    }
}
