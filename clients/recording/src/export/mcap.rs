//! An MCAP file of the profile `ros2`: what other people's viewers open.
//!
//! | topic | type | when |
//! |---|---|---|
//! | `/joint_states`, `/joint_commands` | sensor_msgs/JointState | every tick |
//! | `/HAND/fingerN/wrench` | geometry_msgs/WrenchStamped, frame of the fingertip | every frame |
//! | `/HAND/fingerN/elements` | sensor_msgs/PointCloud2: x y z, fx fy fz, force; frame of the fingertip | with each picture |
//! | `/tf` | tf2_msgs/TFMessage: every link | with each picture |
//! | `/HAND/f1`, `/HAND/fingerN/normal`, ... | std_msgs/Float64 | every tick |
//! | `/HAND/module/NAME` | std_msgs/Float64, 1 while active | when it changes, and with each picture |
//! | `/mode`, `/tick/wake_late` | std_msgs/Float64 | every tick |
//! | `/events` | rcl_interfaces/Log | when it happens |
//! | `/robot_description` | std_msgs/String: the URDF | once |

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::BufWriter;

use atas_client::words;
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};
use shm_schemas::{
    EventKind, FingerReport, GoalState, Hand, HandFrame, HandReport, JointCommand, JointState,
    Mode, ModuleEvent, ModuleId, TickReport,
};

use super::cdr::Cdr;
use super::ros::{self, Level, Type};
use super::{Sink, Subject};
use crate::rows::Row;

/// Level of zstd (ours: the fastest).
const LEVEL: u32 = 1;
/// Frame of the robot's base where the URDF names none.
const BASE: &str = "base";

/// A named number of a report with its unit.
type Scalar<T> = (&'static str, &'static str, fn(&T) -> f32);

const OF_HAND: [Scalar<HandReport>; 3] = [
    ("f1", "N", |hand| hand.f1_n),
    ("f2", "N", |hand| hand.f2_n),
    ("stiffness", "N/m", |hand| hand.stiffness_n_m),
];
const OF_FINGER: [Scalar<FingerReport>; 6] = [
    ("normal", "N", |finger| finger.normal_n),
    ("tangential", "N", |finger| finger.tangential_n),
    ("tangential_increment", "N", |finger| {
        finger.tangential_increment_n
    }),
    ("utilisation", "1", |finger| finger.utilisation),
    ("friction", "1", |finger| finger.friction),
    ("closing", "m/s", |finger| finger.closing_m_s),
];

/// The file.
pub(super) struct Mcap {
    mcap: mcap::Writer<BufWriter<File>>,
    subject: Subject,
    channels: HashMap<String, u16>,
    cdr: Cdr,
    picture_ns: u64,
    next_picture_ns: u64,
    next_cloud_ns: [u64; 2],
    /// Joint positions that the transforms follow from, rad.
    q_rad: Vec<f64>,
    modules_active: [u32; 2],
    has_description: bool,
}

impl Mcap {
    pub(super) fn new(
        file: BufWriter<File>,
        subject: Subject,
        pictures_hz: f64,
    ) -> anyhow::Result<Self> {
        let options = WriteOptions::new()
            .profile("ros2")
            .library(concat!("atas ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            .compression_level(LEVEL)
            .compression_threads(1);
        let mut mcap = options.create(file)?;
        let made_by = subject.made_by.iter();
        mcap.write_metadata(&mcap::records::Metadata {
            name: crate::rotation::ORIGIN.to_owned(),
            metadata: made_by.map(|(k, v)| ((*k).to_owned(), v.clone())).collect(),
        })?;
        Ok(Self {
            mcap,
            subject,
            channels: HashMap::new(),
            cdr: Cdr::new(),
            picture_ns: (1e9 / pictures_hz) as u64,
            next_picture_ns: 0,
            next_cloud_ns: [0; 2],
            q_rad: Vec::new(),
            modules_active: [0; 2],
            has_description: false,
        })
    }

    /// Sends what was just written into `self.cdr`.
    fn send(&mut self, unix_ns: u64, topic: &str, of: &Type, unit: &str) -> anyhow::Result<()> {
        let channel_id = match self.channels.get(topic) {
            Some(channel) => *channel,
            None => self.open(topic, of, unit)?,
        };
        let header = MessageHeader {
            channel_id,
            sequence: 0,
            log_time: unix_ns,
            publish_time: unix_ns,
        };
        self.mcap
            .write_to_known_channel(&header, self.cdr.bytes())?;
        Ok(())
    }

    fn open(&mut self, topic: &str, of: &Type, unit: &str) -> anyhow::Result<u16> {
        let schema = self
            .mcap
            .add_schema(of.name, "ros2msg", of.schema().as_bytes())?;
        let unit = (!unit.is_empty()).then(|| ("unit".to_owned(), unit.to_owned()));
        let described = unit.into_iter().collect::<BTreeMap<_, _>>();
        let channel = self.mcap.add_channel(schema, topic, "cdr", &described)?;
        self.channels.insert(topic.to_owned(), channel);
        Ok(channel)
    }

    fn scalar(&mut self, unix_ns: u64, topic: &str, unit: &str, value: f64) -> anyhow::Result<()> {
        self.cdr.scalar(value);
        self.send(unix_ns, topic, &ros::SCALAR, unit)
    }

    fn describe_robot(&mut self, unix_ns: u64, urdf: &str) -> anyhow::Result<()> {
        self.cdr.begin().text(urdf);
        self.send(unix_ns, "/robot_description", &ros::TEXT, "")
    }

    fn joints(&mut self, unix_ns: u64, joints: &JointState) -> anyhow::Result<()> {
        let count = (joints.joint_count as usize).min(self.subject.skeleton.joint_names().len());
        let names = &self.subject.skeleton.joint_names()[..count];
        let values = [
            &joints.position_rad[..count],
            &joints.velocity_rad_s[..count],
            &joints.effort_n_m[..count],
        ];
        self.cdr.joints(unix_ns, names, values);
        self.q_rad.clear();
        self.q_rad.extend_from_slice(values[0]);
        self.send(
            unix_ns,
            "/joint_states",
            &ros::JOINT_STATE,
            "rad, rad/s, N·m",
        )
    }

    fn command(&mut self, unix_ns: u64, command: &JointCommand) -> anyhow::Result<()> {
        let count = (command.joint_count as usize).min(self.subject.skeleton.joint_names().len());
        let names = &self.subject.skeleton.joint_names()[..count];
        let values = [
            &command.position_rad[..count],
            &command.velocity_rad_s[..count],
            &[],
        ];
        self.cdr.joints(unix_ns, names, values);
        self.send(unix_ns, "/joint_commands", &ros::JOINT_STATE, "rad, rad/s")
    }

    /// Where every link is, as far as joints are known.
    fn transforms(&mut self, unix_ns: u64) -> anyhow::Result<()> {
        let limbs = self.subject.skeleton.limbs();
        let carried: Vec<_> = limbs
            .iter()
            .filter_map(|limb| {
                let parent = limbs[limb.parent?].name.as_str();
                Some((parent, limb.name.as_str(), limb.placed(&self.q_rad)))
            })
            .collect();
        self.cdr.transforms(unix_ns, carried.into_iter());
        self.send(unix_ns, "/tf", &ros::TRANSFORMS, "m")
    }

    fn frame(&mut self, unix_ns: u64, hand: usize, frame: &HandFrame) -> anyhow::Result<()> {
        let is_due = unix_ns >= self.next_cloud_ns[hand];
        if is_due {
            self.next_cloud_ns[hand] = unix_ns.saturating_add(self.picture_ns);
        }
        for finger in 0..self.subject.fingers[hand].min(frame.finger_count as usize) {
            let (valid, force_n) = (frame.valid_mask[finger], &frame.force_n[finger]);
            let layout = &self.subject.layouts[hand];
            let tips = &self.subject.tips[hand];
            let tip = &tips.get(finger).cloned().unwrap_or_else(|| BASE.to_owned());
            let place = format!("/{}/finger{}", Hand::BOTH[hand], finger + 1);
            let [force, torque] = ros::wrench(layout, valid, force_n);
            if is_due {
                let points = ros::points(layout, valid, force_n);
                self.cdr.cloud(unix_ns, tip, &points);
                self.send(unix_ns, &format!("{place}/elements"), &ros::CLOUD, "m, N")?;
            }
            self.cdr.wrench(unix_ns, tip, force, torque);
            self.send(unix_ns, &format!("{place}/wrench"), &ros::WRENCH, "N, N·m")?;
        }
        Ok(())
    }

    fn report(
        &mut self,
        unix_ns: u64,
        report: &TickReport,
        is_picture: bool,
    ) -> anyhow::Result<()> {
        self.scalar(unix_ns, "/mode", "", f64::from(report.mode.0))?;
        let late_s = f64::from(report.wake_late_ns) * 1e-9;
        self.scalar(unix_ns, "/tick/wake_late", "s", late_s)?;
        for (index, hand) in report.hands.iter().enumerate() {
            let place = Hand::BOTH[index];
            for (name, unit, value) in OF_HAND {
                self.scalar(
                    unix_ns,
                    &format!("/{place}/{name}"),
                    unit,
                    value(hand).into(),
                )?;
            }
            for (finger, report) in hand.fingers[..self.subject.fingers[index]]
                .iter()
                .enumerate()
            {
                for (name, unit, value) in OF_FINGER {
                    let topic = format!("/{place}/finger{}/{name}", finger + 1);
                    self.scalar(unix_ns, &topic, unit, value(report).into())?;
                }
            }
            self.modules(unix_ns, index, hand.modules_active, is_picture)?;
        }
        Ok(())
    }

    fn modules(
        &mut self,
        unix_ns: u64,
        hand: usize,
        active: u32,
        is_picture: bool,
    ) -> anyhow::Result<()> {
        let before = std::mem::replace(&mut self.modules_active[hand], active);
        for id in ModuleId::ALL.iter().filter(|id| **id != ModuleId::NONE) {
            let [was, is] = [before, active].map(|bits| bits >> id.0 & 1);
            if was != is || is_picture {
                let topic = format!("/{}/module/{}", Hand::BOTH[hand], word(*id));
                self.scalar(unix_ns, &topic, "", f64::from(is))?;
            }
        }
        Ok(())
    }

    fn event(&mut self, unix_ns: u64, event: &ModuleEvent) -> anyhow::Result<()> {
        let sentence = words::event(event);
        self.cdr
            .log(unix_ns, level(event), event.kind.name(), sentence.trim());
        self.send(unix_ns, "/events", &ros::LOG, "")
    }
}

impl Sink for Mcap {
    fn row(&mut self, row: &Row) -> anyhow::Result<()> {
        let unix_ns = self.subject.clock.unix_ns(row.captured_ns);
        let is_picture = unix_ns >= self.next_picture_ns;
        if is_picture {
            self.next_picture_ns = unix_ns.saturating_add(self.picture_ns);
        }
        if !std::mem::replace(&mut self.has_description, true) {
            let urdf = self.subject.urdf.clone();
            self.describe_robot(unix_ns, &urdf)?;
        }
        if let Some(inputs) = &row.inputs {
            if let Some(joints) = &inputs.joints {
                self.joints(self.subject.clock.unix_ns(joints.stamp.captured_ns), joints)?;
            }
            self.command(unix_ns, &inputs.command)?;
            for (hand, frame) in inputs.frames.iter().enumerate() {
                if let Some(frame) = frame {
                    let at_ns = self.subject.clock.unix_ns(frame.stamp.captured_ns);
                    self.frame(at_ns, hand, frame)?;
                }
            }
            if is_picture && !self.q_rad.is_empty() {
                self.transforms(unix_ns)?;
            }
        }
        if let Some(report) = &row.report {
            self.report(unix_ns, report, is_picture)?;
        }
        row.events
            .iter()
            .try_for_each(|event| self.event(unix_ns, event))
    }

    fn finish(mut self: Box<Self>) -> anyhow::Result<()> {
        self.mcap.finish()?;
        Ok(())
    }
}

/// A module's name as a word of a topic: `slip` for `module 2, slip`.
pub(super) fn word(id: ModuleId) -> String {
    let name = id.name();
    let own = name.split_once(", ").map_or(name, |(_, own)| own);
    own.replace(' ', "_")
}

fn level(event: &ModuleEvent) -> Level {
    let is_stop = matches!(event.mode, Mode::HOLD | Mode::SAFE_STOP | Mode::FAULT);
    match event.kind {
        EventKind::WARNING => Level::Warning,
        EventKind::MODE if is_stop => Level::Error,
        EventKind::GOAL if event.text.as_str() == GoalState::FAILED.name() => Level::Error,
        _ => Level::Info,
    }
}
