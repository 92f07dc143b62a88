use std::collections::BTreeMap;
use std::fs::File;

use ::mcap::MessageStream;
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::record::Field;
use robot_model::{RobotFiles, SHIPPED, TWO_HAND_ARM};
use shm_schemas::{
    EventKind, GoalKind, GoalRequest, GoalState, Hand, HandFrame, HandWiringRecord, JointState,
    Layout, ModuleEvent, ModuleId, OrderKind, RunHeader, Stamp, Text, TickInputs, TickReport,
};

use super::*;
use crate::rotation::{Bounds, Recording};

const TICKS: u64 = 300;
const BEGIN_NS: u64 = 5_000_000_000;
/// Tick of the goal's request.
const GOAL_TICK: u64 = 50;
/// Force on the pressed element at the pole, whose normal is z.
const FORCE_N: [f32; 3] = [2.0, 0.5, -0.25];

fn stamp(sequence: u64) -> Stamp {
    Stamp {
        sequence,
        captured_ns: BEGIN_NS + sequence * 1_000_000,
        writer_epoch: 1,
    }
}

fn wiring(fingers: u32) -> HandWiringRecord {
    let dome = Layout::dome_41();
    HandWiringRecord {
        fingers,
        element_count: 41,
        normal: dome.normal,
        tangent1: dome.tangent1,
        tangent2: dome.tangent2,
        position_m: dome.position_m,
        ..HandWiringRecord::default()
    }
}

/// Records a run: the left hand has a frame every tenth tick, the right hand none; tick 7 has no
/// report.
fn recorded(folder: &Path) -> PathBuf {
    recorded_of(folder, &TWO_HAND_ARM, 2)
}

/// Records such a run of a robot with this number of fingertips per hand.
fn recorded_of(folder: &Path, robot: &RobotFiles, fingers: u32) -> PathBuf {
    let out = folder.join("run.mcap");
    let bounds = Bounds {
        file_bytes: None,
        files: None,
        total_bytes: None,
    };
    let mut recording = Recording::create(&out, bounds, BTreeMap::new(), None).expect("made");
    let mut header: Box<RunHeader> = Box::default();
    header.robot = Text::new(&robot.name);
    header.robot_hash = robot.hash();
    header.version = Text::new("0.1");
    header.hands = [wiring(fingers), wiring(fingers)];
    recording.begin_run(header).expect("begun");
    for tick in 0..TICKS {
        let mut inputs = Box::new(TickInputs {
            stamp: stamp(tick),
            tick,
            parts: 1,
            has_frame: [u32::from(tick.is_multiple_of(10)), 0],
            has_joints: 1,
            ..TickInputs::default()
        });
        inputs.frames[0] = HandFrame {
            stamp: stamp(tick),
            finger_count: 2,
            valid_mask: [1, 0, 0, 0],
            ..HandFrame::default()
        };
        inputs.frames[0].force_n[0][0] = FORCE_N;
        inputs.joints = JointState {
            stamp: stamp(tick),
            joint_count: 22,
            ..JointState::default()
        };
        inputs.joints.position[3] = tick as f64 * 1e-3;
        inputs.command.joint_count = 22;
        if tick == GOAL_TICK {
            inputs.order.kind = OrderKind::START;
            inputs.order.goal = GoalRequest {
                kind: GoalKind::GRASP,
                hand: Hand::RIGHT,
                from_m: [0.32, -0.15, 0.04],
                width_m: 0.05,
                ..GoalRequest::default()
            };
        }
        recording.inputs(&inputs).expect("written");
        let mut report = TickReport {
            stamp: stamp(tick),
            tick,
            ..TickReport::default()
        };
        report.hands[1].fingers[0].normal_n = 1.5;
        report.hands[1].fingers[0].tangential_n = tick as f32;
        report.hands[1].modules_active = u32::from(tick >= 100) << ModuleId::SLIP.0;
        if tick != 7 {
            recording.writer().write(&report).expect("written");
        }
        let mut write_event = |kind, text: &str| {
            let event = ModuleEvent {
                stamp: stamp(tick),
                tick,
                kind,
                hand: Hand::RIGHT,
                text: Text::new(text),
                ..ModuleEvent::default()
            };
            recording.writer().write(&event).expect("written");
        };
        match tick {
            100 => write_event(EventKind::WARNING, ""),
            120 => write_event(EventKind::STEP, "lift"),
            130 => write_event(EventKind::GOAL, GoalState::SUCCEEDED.name()),
            _ => {}
        }
    }
    recording.finish().expect("finished");
    out
}

fn exported(folder: &Path, kind: Kind, elements: bool) -> PathBuf {
    exported_of(folder, &[recorded(folder)], kind, elements)
}

fn exported_of(folder: &Path, files: &[PathBuf], kind: Kind, elements: bool) -> PathBuf {
    let out = folder.join("out");
    let choices = Choices {
        kind,
        pictures_hz: 100.0,
        elements,
    };
    let exported = export(files, &out, &choices, &AtomicBool::new(false)).expect("exported");
    assert_eq!(exported.ticks, TICKS);
    assert!((exported.seconds - 0.299).abs() < 1e-9);
    out
}

#[test]
fn exported_mcap_has_every_stream_as_ros_2_messages() {
    let folder = tempfile::tempdir().expect("a folder");
    let bytes = std::fs::read(exported(folder.path(), Kind::Mcap, false)).expect("readable");
    let mut topics: BTreeMap<String, Vec<(u64, Vec<u8>)>> = BTreeMap::new();
    for message in MessageStream::new(&bytes).expect("MCAP") {
        let message = message.expect("whole");
        let schema = message.channel.schema.as_ref().expect("a schema");
        let encodings = (
            message.channel.message_encoding.as_str(),
            schema.encoding.as_str(),
        );
        assert_eq!(encodings, ("cdr", "ros2msg"), "{}", schema.name);
        let sent = (message.log_time, message.data.to_vec());
        topics
            .entry(message.channel.topic.clone())
            .or_default()
            .push(sent);
    }
    let count = |topic: &str| topics.get(topic).map_or(0, Vec::len);
    let ticks = TICKS as usize;
    assert_eq!(count("/joint_states"), ticks);
    assert_eq!(count("/joint_commands"), ticks);
    // Changing values come with every report, constant ones with every picture.
    assert_eq!(count("/right/finger1/tangential"), ticks - 1);
    assert_eq!(count("/right/finger1/normal"), 30);
    assert_eq!(count("/left/finger1/wrench"), ticks / 10);
    assert_eq!(count("/left/finger1/elements"), ticks / 10);
    assert_eq!(
        (count("/tf"), count("/events"), count("/robot_description")),
        (30, 3, 1)
    );
    assert_eq!(count("/right/finger1/wrench"), 0, "no invented data");
    // Activated between two pictures or with one: both states are present, in this order.
    let slip: Vec<f64> = topics["/right/module/slip"]
        .iter()
        .map(|(_, data)| last_f64(data))
        .collect();
    let first_on = slip
        .iter()
        .position(|active| *active == 1.0)
        .expect("switched on");
    assert!(first_on > 0 && slip[..first_on].iter().all(|active| *active == 0.0));
    // Wall-clock time: after 2020, with the spacing of the ticks.
    let times: Vec<u64> = topics["/joint_states"]
        .iter()
        .map(|(time, _)| *time)
        .collect();
    assert!(times[0] > 1_577_836_800_000_000_000 && times[1] - times[0] == 1_000_000);
    // The pole is pressed along −z; its tangents are those of the layout.
    let (_, wrench) = &topics["/left/finger1/wrench"][0];
    let dome = Layout::dome_41();
    let numbers: Vec<f64> = wrench[wrench.len() - 48..]
        .chunks(8)
        .map(last_f64)
        .collect();
    for (axis, found) in numbers[..3].iter().enumerate() {
        let [n, t1, t2] = [dome.normal, dome.tangent1, dome.tangent2].map(|of| of[0][axis]);
        assert!(
            (found - (0.5 * t1 - 0.25 * t2 - 2.0 * n)).abs() < 1e-6,
            "{numbers:?}"
        );
    }
}

fn last_f64(data: &[u8]) -> f64 {
    f64::from_le_bytes(*data.last_chunk().expect("eight bytes"))
}

#[test]
fn csv_and_parquet_have_equal_rows_without_invented_data() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = exported(folder.path(), Kind::Csv, true);
    let mut csv = ::csv::Reader::from_path(&out).expect("CSV");
    let names: Vec<String> = csv
        .headers()
        .expect("names")
        .iter()
        .map(str::to_owned)
        .collect();
    let rows: Vec<::csv::StringRecord> = csv.records().map(|row| row.expect("whole")).collect();
    assert_eq!(rows.len() as u64, TICKS);
    let cell = |row: usize, name: &str| {
        let column = names
            .iter()
            .position(|n| n == name)
            .unwrap_or_else(|| panic!("{name}"));
        rows[row][column].to_owned()
    };
    assert_eq!(cell(20, "tick"), "20");
    assert_eq!(cell(20, "sensor_ns"), "5020000000");
    assert_eq!(cell(20, "left_wrist_pitch_position_rad"), "0.02");
    assert_eq!(cell(20, "right_finger1_normal_n"), "1.5");
    assert_eq!(
        cell(7, "right_finger1_normal_n"),
        "",
        "tick 7 was not reported"
    );
    assert_eq!(cell(20, "left_finger1_element0_ft1_n"), "0.5");
    assert_eq!(
        cell(20, "left_finger1_element1_fn_n"),
        "",
        "an element that is not valid"
    );
    assert_eq!(
        cell(21, "left_finger1_element0_ft1_n"),
        "",
        "a tick without a frame"
    );
    assert_eq!(
        (
            cell(99, "right_module_slip"),
            cell(100, "right_module_slip")
        ),
        ("0".into(), "1".into())
    );
    let steps = [119, 120, 129, 130].map(|row| cell(row, "right_step"));
    assert_eq!(
        steps,
        ["", "lift", "lift", ""],
        "the step's name during the goal"
    );

    let folder = tempfile::tempdir().expect("a folder");
    let out = exported(folder.path(), Kind::Parquet, true);
    let reader = SerializedFileReader::new(File::open(out).expect("opened")).expect("Parquet");
    let noted = reader
        .metadata()
        .file_metadata()
        .key_value_metadata()
        .expect("noted");
    assert!(noted.iter().any(|noted| noted.key == "atas.daemon_version"));
    for (index, row) in reader.get_row_iter(None).expect("rows").enumerate() {
        let row = row.expect("whole");
        let columns: Vec<(&String, &Field)> = row.get_column_iter().collect();
        assert_eq!(columns.len(), names.len());
        for (column, (name, field)) in columns.into_iter().enumerate() {
            assert_eq!(*name, names[column]);
            let text = &rows[index][column];
            let same = match field {
                Field::Null => text.is_empty(),
                Field::Long(value) => *name == "unix_ns" || *text == value.to_string(),
                Field::Double(value) => text.parse() == Ok(*value),
                Field::Float(value) => text.parse() == Ok(*value),
                Field::Str(value) => text == value,
                other => panic!("{name}: {other:?}"),
            };
            assert!(same, "row {index}, {name}: {text:?} and {field:?}");
        }
    }
}

#[test]
fn existing_file_is_kept_and_stop_leaves_complete_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let files = [recorded(folder.path())];
    let choices = Choices {
        kind: Kind::Mcap,
        pictures_hz: 100.0,
        elements: false,
    };
    let before = std::fs::read(&files[0]).expect("readable");
    let refused = export(&files, &files[0], &choices, &AtomicBool::new(false));
    assert!(refused.is_err());
    assert_eq!(std::fs::read(&files[0]).expect("readable"), before);
    let out = folder.path().join("stopped.mcap");
    let exported = export(&files, &out, &choices, &AtomicBool::new(true)).expect("stopped");
    assert_eq!(exported.ticks, 0);
    let bytes = std::fs::read(out).expect("readable");
    assert_eq!(MessageStream::new(&bytes).expect("MCAP").count(), 0);
}

/// Returns the column names of a table for a robot with this number of fingertips per hand.
fn names(robot: &str, fingers: u32) -> Vec<String> {
    let robot = SHIPPED.into_iter().find(|shipped| shipped.name == robot);
    let folder = tempfile::tempdir().expect("a folder");
    let files = [recorded_of(
        folder.path(),
        &robot.expect("it ships"),
        fingers,
    )];
    let out = exported_of(folder.path(), &files, Kind::Csv, false);
    let mut csv = ::csv::Reader::from_path(out).expect("CSV");
    let names = csv.headers().expect("names");
    names.iter().map(str::to_owned).collect()
}

#[test]
fn prismatic_joint_is_exported_in_metres() {
    let names = names("test-bench", 2);
    for name in [
        "stage_position_m",
        "stage_velocity_m_s",
        "stage_effort_n",
        "stage_commanded_m",
    ] {
        assert!(
            names.iter().any(|found| found == name),
            "{name} in {names:?}"
        );
    }
    assert!(!names.iter().any(|name| name == "stage_position_rad"));
    let folder = tempfile::tempdir().expect("a folder");
    let [.., bench] = SHIPPED;
    let files = [recorded_of(folder.path(), &bench, 2)];
    let bytes = std::fs::read(exported_of(folder.path(), &files, Kind::Mcap, false));
    let bytes = bytes.expect("readable");
    let mut units: BTreeMap<String, String> = BTreeMap::new();
    for message in MessageStream::new(&bytes).expect("MCAP") {
        let channel = message.expect("whole").channel;
        let unit = channel.metadata.get("unit").cloned().unwrap_or_default();
        units.insert(channel.topic.clone(), unit);
    }
    let output = &units["/joint_states"];
    assert!(output.contains("m, m/s, N of stage"), "{output}");
}

#[test]
fn every_fingertip_is_exported_without_missing_hands() {
    let names = names("three-finger", 3);
    let has = |name: &str| names.iter().any(|found| found == name);
    assert!(
        has("right_finger3_normal_n") && has("right_step") && has("finger1_knuckle_position_rad")
    );
    let of_left: Vec<_> = names
        .iter()
        .filter(|name| name.starts_with("left_"))
        .collect();
    assert!(of_left.is_empty(), "{of_left:?}");
}

#[test]
fn failed_export_leaves_no_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = recorded(folder.path());
    let whole = std::fs::read(&file).expect("readable");
    std::fs::write(&file, &whole[..whole.len() / 2]).expect("cut");
    for kind in [Kind::Mcap, Kind::Csv, Kind::Parquet] {
        let choices = Choices {
            kind,
            pictures_hz: 100.0,
            elements: false,
        };
        let out = folder.path().join("out");
        let files = [file.clone()];
        let failed = export(&files, &out, &choices, &AtomicBool::new(false));
        assert!(failed.is_err(), "{kind:?}");
        let left = std::fs::read_dir(folder.path()).expect("a folder");
        let left: Vec<_> = left.map(|entry| entry.expect("one").file_name()).collect();
        assert_eq!(left, ["run.mcap"], "{kind:?}");
    }
}

fn choices(fps: u32, hand: Option<Hand>) -> DatasetChoices {
    DatasetChoices {
        fps,
        hand,
        task: None,
        elements: true,
    }
}

fn table(path: &Path) -> Vec<BTreeMap<String, Field>> {
    let reader = SerializedFileReader::new(File::open(path).expect("opened")).expect("Parquet");
    let rows = reader.get_row_iter(None).expect("rows");
    rows.map(|row| row.expect("whole").into_columns().into_iter().collect())
        .collect()
}

fn floats(field: &Field) -> Vec<f32> {
    let Field::ListInternal(list) = field else {
        panic!("a list, not {field:?}");
    };
    let each = list.elements().iter().map(|value| match value {
        Field::Float(value) => *value,
        other => panic!("a number, not {other:?}"),
    });
    each.collect()
}

#[test]
fn dataset_has_one_episode_per_goal() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, out) = (recorded(folder.path()), folder.path().join("set"));
    let never = AtomicBool::new(false);
    let exported = export_dataset(&[file], &out, &choices(100, None), &never).expect("exported");
    let counts = (
        exported.episodes,
        exported.successes,
        exported.frames,
        exported.skipped,
    );
    // From the request in tick 50 to the end in tick 130.
    assert_eq!(counts, (1, 1, 9, 0));
    let rows = table(&out.join("data/chunk-000/file-000.parquet"));
    assert_eq!(rows.len(), 9);
    let info = std::fs::read_to_string(out.join("meta/info.json")).expect("readable");
    let info: serde_json::Value = serde_json::from_str(&info).expect("JSON");
    assert_eq!(info["codebase_version"], "v3.0");
    for (name, feature) in info["features"].as_object().expect("features") {
        let width = feature["shape"][0].as_u64().expect("a width") as usize;
        if width > 1 {
            assert_eq!(floats(&rows[0][name]).len(), width, "{name}");
            assert_eq!(
                feature["names"].as_array().map(Vec::len),
                Some(width),
                "{name}"
            );
        }
    }
    let names = &info["features"]["observation.state"]["names"];
    let at = |what: &str| {
        let names = names.as_array().expect("names");
        names
            .iter()
            .position(|name| name == what)
            .expect("a known name")
    };
    for (index, row) in rows.iter().enumerate() {
        assert_eq!(row["timestamp"], Field::Float(index as f32 / 100.0));
        assert_eq!(row["next.success"], Field::Bool(index == 8), "{index}");
        let state = floats(&row["observation.state"]);
        let tick = 50 + 10 * index;
        assert_eq!(state[at("finger1.tangential_n")], tick as f32);
        assert_eq!(state[at("module.slip")], f32::from(u8::from(tick >= 100)));
    }
    assert_eq!(
        floats(&rows[0]["observation.environment_state"])[..5],
        [0.32, -0.15, 0.04, 0.0, 0.05]
    );
    let episodes = table(&out.join("meta/episodes/chunk-000/file-000.parquet"));
    assert_eq!(episodes[0]["length"], Field::Long(9));
    assert_eq!(
        episodes[0]["goal_state"],
        Field::Str("succeeded".to_owned())
    );
    let tasks = table(&out.join("meta/tasks.parquet"));
    assert_eq!(
        tasks[0]["task"],
        Field::Str("Grasp the object and lift it.".to_owned())
    );
}

#[test]
fn dataset_without_episode_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, out) = (recorded(folder.path()), folder.path().join("set"));
    let never = AtomicBool::new(false);
    for (choices, says) in [
        (choices(100, Some(Hand::LEFT)), "no goal of the hand"),
        (choices(30, None), "do not divide"),
        (choices(0, None), "do not divide"),
    ] {
        let refused = export_dataset(std::slice::from_ref(&file), &out, &choices, &never);
        let says_so = format!("{:#}", refused.expect_err("refused"));
        assert!(says_so.contains(says), "{says_so}");
        let left = std::fs::read_dir(folder.path()).expect("a folder");
        let left: Vec<_> = left.map(|entry| entry.expect("one").file_name()).collect();
        assert_eq!(left, ["run.mcap"]);
    }
}
