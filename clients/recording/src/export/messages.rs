//! ROS 2 messages of a run, for any receiver.
//!
//! | topic | type | when |
//! |---|---|---|
//! | `/joint_states`, `/joint_commands` | sensor_msgs/JointState (m if prismatic) | every tick |
//! | `/HAND/fingerN/wrench` | geometry_msgs/WrenchStamped, frame of the fingertip | every frame |
//! | `/HAND/fingerN/elements` | sensor_msgs/PointCloud2, frame of the fingertip | each picture |
//! | `/tf` | tf2_msgs/TFMessage: every link | each picture |
//! | `/HAND/f1`, `/HAND/fingerN/normal`, ... | std_msgs/Float64 | on change, each picture |
//! | `/HAND/module/NAME` | std_msgs/Float64, 1 while active | on change, each picture |
//! | `/mode`, `/tick/wake_late` | std_msgs/Float64 | on change, each picture |
//! | `/events` | rcl_interfaces/Log | when it happens |
//! | `/robot_description` | std_msgs/String: the URDF | once |
//!
//! A tick has up to forty messages, so topic names are stored once, not per message.

use std::borrow::Cow;

use atas_client::{contact, text};
use robot_model::JointKind;
use shm_schemas::{
    EventKind, FingerReport, GoalState, Hand, HandFrame, HandReport, JointCommand, JointState,
    Mode, ModuleEvent, ModuleId, TickReport,
};

use super::cdr::Cdr;
use super::ros::{self, Level, MessageType};
use super::subject::Subject;
use crate::rows::Row;

/// Frame of the robot's base if the URDF names none.
const BASE: &str = "base";

/// Named number of a report with its unit.
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

/// Receiver of the messages.
pub trait Outlet {
    /// Opens a topic for messages of one type; `unit` is empty for numbers without unit.
    ///
    /// # Errors
    /// The topic cannot be opened.
    fn open(&mut self, topic: &str, of: &MessageType, unit: &str) -> anyhow::Result<u16>;

    /// Receives a message as CDR.
    ///
    /// # Errors
    /// The message cannot be written.
    fn send(&mut self, channel: u16, unix_ns: u64, cdr: &[u8]) -> anyhow::Result<()>;
}

/// Topic, opened with its first message.
struct Topic {
    name: String,
    of: &'static MessageType,
    unit: Cow<'static, str>,
    channel: Option<u16>,
    /// Last number sent, if the topic carries numbers.
    last: Option<f64>,
}

struct OfFinger {
    tip: String,
    elements: Topic,
    wrench: Topic,
    scalars: [Topic; OF_FINGER.len()],
}

struct OfHand {
    scalars: [Topic; OF_HAND.len()],
    modules: Vec<(ModuleId, Topic)>,
    fingers: Vec<OfFinger>,
}

struct Topics {
    description: Topic,
    joints: Topic,
    commands: Topic,
    transforms: Topic,
    mode: Topic,
    wake_late: Topic,
    events: Topic,
    hands: [OfHand; 2],
}

/// Converter of a run to messages.
pub struct Messages<O> {
    outlet: O,
    subject: Subject,
    topics: Topics,
    cdr: Cdr,
    picture_ns: u64,
    next_picture_ns: u64,
    next_transforms_ns: u64,
    next_cloud_ns: [u64; 2],
    /// Joint positions for the transforms.
    q: Vec<f64>,
    has_description: bool,
}

impl Topic {
    fn new(
        name: impl Into<String>,
        of: &'static MessageType,
        unit: impl Into<Cow<'static, str>>,
    ) -> Self {
        Self {
            name: name.into(),
            of,
            unit: unit.into(),
            channel: None,
            last: None,
        }
    }

    fn send(&mut self, outlet: &mut impl Outlet, unix_ns: u64, cdr: &Cdr) -> anyhow::Result<()> {
        let channel = match self.channel {
            Some(channel) => channel,
            None => outlet.open(&self.name, self.of, &self.unit)?,
        };
        self.channel = Some(channel);
        outlet.send(channel, unix_ns, cdr.bytes())
    }
}

impl OfHand {
    fn of(subject: &Subject, hand: usize) -> Self {
        let place = Hand::BOTH[hand];
        let scalar = |name, unit| Topic::new(name, &ros::SCALAR, unit);
        let named = ModuleId::ALL.iter().filter(|id| **id != ModuleId::NONE);
        Self {
            scalars: OF_HAND.map(|(name, unit, _)| scalar(format!("/{place}/{name}"), unit)),
            modules: named
                .map(|id| (*id, scalar(format!("/{place}/module/{}", word(*id)), "")))
                .collect(),
            fingers: (0..subject.fingers[hand])
                .map(|finger| {
                    let place = format!("/{place}/finger{}", finger + 1);
                    let tip = subject.tips[hand].get(finger).cloned();
                    OfFinger {
                        tip: tip.unwrap_or_else(|| BASE.to_owned()),
                        elements: Topic::new(format!("{place}/elements"), &ros::CLOUD, "m, N"),
                        wrench: Topic::new(format!("{place}/wrench"), &ros::WRENCH, "N, N·m"),
                        scalars: OF_FINGER
                            .map(|(name, unit, _)| scalar(format!("{place}/{name}"), unit)),
                    }
                })
                .collect(),
        }
    }
}

impl<O: Outlet> Messages<O> {
    /// Creates a converter into `outlet` with `pictures_hz` transforms and point clouds per second.
    #[must_use]
    pub fn new(outlet: O, subject: Subject, pictures_hz: f64) -> Self {
        let topics = Topics {
            description: Topic::new("/robot_description", &ros::TEXT, ""),
            joints: Topic::new(
                "/joint_states",
                &ros::JOINT_STATE,
                units(&subject, ["rad, rad/s, N·m", "m, m/s, N"]),
            ),
            commands: Topic::new(
                "/joint_commands",
                &ros::JOINT_STATE,
                units(&subject, ["rad, rad/s", "m, m/s"]),
            ),
            transforms: Topic::new("/tf", &ros::TRANSFORMS, "m"),
            mode: Topic::new("/mode", &ros::SCALAR, ""),
            wake_late: Topic::new("/tick/wake_late", &ros::SCALAR, "s"),
            events: Topic::new("/events", &ros::LOG, ""),
            hands: [0, 1].map(|hand| OfHand::of(&subject, hand)),
        };
        Self {
            outlet,
            subject,
            topics,
            cdr: Cdr::new(),
            picture_ns: (1e9 / pictures_hz) as u64,
            next_picture_ns: 0,
            next_transforms_ns: 0,
            next_cloud_ns: [0; 2],
            q: Vec::new(),
            has_description: false,
        }
    }

    /// Returns the receiver.
    pub(super) fn into_outlet(self) -> O {
        self.outlet
    }

    /// Sends all data of a tick.
    ///
    /// # Errors
    /// The receiver fails.
    pub fn row(&mut self, row: &Row) -> anyhow::Result<()> {
        let unix_ns = self.subject.clock.unix_ns(row.captured_ns);
        let is_picture = unix_ns >= self.next_picture_ns;
        if is_picture {
            self.next_picture_ns = unix_ns.saturating_add(self.picture_ns);
        }
        if !self.has_description {
            self.describe(row.captured_ns)?;
        }
        if let Some(inputs) = &row.inputs {
            if let Some(joints) = &inputs.joints {
                self.joints(joints)?;
            }
            if inputs.command.joint_count > 0 {
                self.command(unix_ns, &inputs.command)?;
            }
            for (hand, frame) in inputs.frames.iter().enumerate() {
                if let Some(frame) = frame {
                    self.frame(hand, frame)?;
                }
            }
            // Rows without joints do not count towards the rate: live, only the newest of several
            // rows has joints.
            if unix_ns >= self.next_transforms_ns && !self.q.is_empty() {
                self.next_transforms_ns = unix_ns.saturating_add(self.picture_ns);
                self.transforms(unix_ns)?;
            }
        }
        if let Some(report) = &row.report {
            self.report(unix_ns, report, is_picture)?;
        }
        let mut events = row.events.iter();
        events.try_for_each(|event| self.event(unix_ns, event))
    }

    /// Sends the robot's URDF, like the first row; again for late viewers.
    ///
    /// # Errors
    /// The receiver fails.
    pub fn describe(&mut self, captured_ns: u64) -> anyhow::Result<()> {
        self.has_description = true;
        if self.subject.urdf.is_empty() {
            return Ok(());
        }
        self.cdr.begin().text(&self.subject.urdf);
        let unix_ns = self.subject.clock.unix_ns(captured_ns);
        self.topics
            .description
            .send(&mut self.outlet, unix_ns, &self.cdr)
    }

    fn joints(&mut self, joints: &JointState) -> anyhow::Result<()> {
        let unix_ns = self.subject.clock.unix_ns(joints.stamp.captured_ns);
        let count = (joints.joint_count as usize).min(self.subject.skeleton.joint_names().len());
        let names = &self.subject.skeleton.joint_names()[..count];
        if names.is_empty() {
            return Ok(());
        }
        let values = [
            &joints.position[..count],
            &joints.velocity[..count],
            &joints.effort[..count],
        ];
        self.cdr.joints(unix_ns, names, values);
        self.q.clear();
        self.q.extend_from_slice(values[0]);
        self.topics
            .joints
            .send(&mut self.outlet, unix_ns, &self.cdr)
    }

    fn command(&mut self, unix_ns: u64, command: &JointCommand) -> anyhow::Result<()> {
        let count = (command.joint_count as usize).min(self.subject.skeleton.joint_names().len());
        let names = &self.subject.skeleton.joint_names()[..count];
        if names.is_empty() {
            return Ok(());
        }
        let values = [&command.position[..count], &command.velocity[..count], &[]];
        self.cdr.joints(unix_ns, names, values);
        self.topics
            .commands
            .send(&mut self.outlet, unix_ns, &self.cdr)
    }

    /// Sends the pose of every link, as far as joints are known.
    fn transforms(&mut self, unix_ns: u64) -> anyhow::Result<()> {
        let limbs = self.subject.skeleton.limbs();
        let carried: Vec<_> = limbs
            .iter()
            .filter_map(|limb| {
                let parent = limbs[limb.parent?].name.as_str();
                Some((parent, limb.name.as_str(), limb.placed(&self.q)))
            })
            .collect();
        self.cdr.transforms(unix_ns, carried.into_iter());
        self.topics
            .transforms
            .send(&mut self.outlet, unix_ns, &self.cdr)
    }

    fn frame(&mut self, hand: usize, frame: &HandFrame) -> anyhow::Result<()> {
        let unix_ns = self.subject.clock.unix_ns(frame.stamp.captured_ns);
        let is_due = unix_ns >= self.next_cloud_ns[hand];
        if is_due {
            self.next_cloud_ns[hand] = unix_ns.saturating_add(self.picture_ns);
        }
        let layout = &self.subject.layouts[hand];
        let count = frame.finger_count as usize;
        let fingers = self.topics.hands[hand].fingers.iter_mut().take(count);
        for (finger, topics) in fingers.enumerate() {
            let (valid, force_n) = (frame.valid_mask[finger], &frame.force_n[finger]);
            if is_due {
                let points: Vec<_> = contact::points(layout, valid, force_n).collect();
                self.cdr.cloud(unix_ns, &topics.tip, &points);
                topics.elements.send(&mut self.outlet, unix_ns, &self.cdr)?;
            }
            let [force, torque] = contact::wrench(layout, valid, force_n);
            self.cdr.wrench(unix_ns, &topics.tip, force, torque);
            topics.wrench.send(&mut self.outlet, unix_ns, &self.cdr)?;
        }
        Ok(())
    }

    fn report(
        &mut self,
        unix_ns: u64,
        report: &TickReport,
        is_picture: bool,
    ) -> anyhow::Result<()> {
        let Self {
            outlet,
            topics,
            cdr,
            subject,
            ..
        } = self;
        // Between two messages of a topic its number is unchanged.
        let mut scalar = |topic: &mut Topic, value: f64| {
            let is_known = topic.last.replace(value) == Some(value);
            if is_known && !is_picture {
                return Ok(());
            }
            cdr.scalar(value);
            topic.send(outlet, unix_ns, cdr)
        };
        scalar(&mut topics.mode, f64::from(report.mode.0))?;
        let late_s = f64::from(report.wake_late_ns) * 1e-9;
        scalar(&mut topics.wake_late, late_s)?;
        let hands = report.hands.iter().enumerate();
        for (index, hand) in hands.filter(|(index, _)| subject.fingers[*index] > 0) {
            let topics = &mut topics.hands[index];
            for (topic, (_, _, value)) in topics.scalars.iter_mut().zip(OF_HAND) {
                scalar(topic, value(hand).into())?;
            }
            for (topics, finger) in topics.fingers.iter_mut().zip(&hand.fingers) {
                for (topic, (_, _, value)) in topics.scalars.iter_mut().zip(OF_FINGER) {
                    scalar(topic, value(finger).into())?;
                }
            }
            for (id, topic) in &mut topics.modules {
                scalar(topic, f64::from(hand.modules_active >> id.0 & 1))?;
            }
        }
        Ok(())
    }

    fn event(&mut self, unix_ns: u64, event: &ModuleEvent) -> anyhow::Result<()> {
        let sentence = text::event(event);
        self.cdr
            .log(unix_ns, level(event), event.kind.name(), sentence.trim());
        self.topics
            .events
            .send(&mut self.outlet, unix_ns, &self.cdr)
    }
}

/// Returns the units of joint values: of revolute joints, and with prismatic joints the unit of
/// each.
fn units(subject: &Subject, [turning, sliding]: [&'static str; 2]) -> Cow<'static, str> {
    let slide = subject
        .joints()
        .filter(|(_, kind)| *kind == JointKind::Prismatic);
    let names: Vec<&str> = slide.map(|(name, _)| name).collect();
    if names.is_empty() {
        return turning.into();
    }
    format!("{turning}; {sliding} of {}", names.join(", ")).into()
}

/// Returns a module's name as a word of a topic: `slip` for `module 2, slip`.
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
