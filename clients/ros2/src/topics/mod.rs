//! Topics: data of the daemon as ROS 2 messages.
//!
//! | topic | type | rate |
//! |---|---|---|
//! | `/joint_states` | sensor_msgs/JointState | `--joint-rate` |
//! | `/tf` | tf2_msgs/TFMessage: every link | `--state-rate` |
//! | `/robot_description` | std_msgs/String: the URDF | once, latched |
//! | `/diagnostics` | diagnostic_msgs/DiagnosticArray | 1 Hz |
//! | `/atas/state` | atas_msgs/DaemonState | 10 Hz and on change |
//! | `/atas/events` | rcl_interfaces/Log | on change |
//! | `/atas/HAND/state` | atas_msgs/HandState | `--state-rate` |
//! | `/atas/HAND/fingerN/wrench` | geometry_msgs/WrenchStamped | `--state-rate` |
//! | `/atas/HAND/fingerN/elements` | sensor_msgs/PointCloud2 | `--cloud-rate` |

mod daemon;
mod hands;
mod joints;
mod pace;
mod tactile;

use std::time::{Duration, Instant};

use atas_client::{Observer, Session};
use shm_bus::Subscriber;
use shm_schemas::{JointState, service};

use crate::arguments::Arguments;
use crate::clock::Clock;
use crate::link::BusLink;
use crate::middleware::Node;
use crate::robot::RobotWatch;

use daemon::DaemonTopics;
use hands::HandTopics;
use joints::JointTopics;
use pace::Pace;

/// Silence of the daemon after which the bus is opened again.
const SILENCE: Duration = Duration::from_secs(2);

/// Publishers of all topics.
pub(crate) struct Topics {
    joints: JointTopics,
    daemon: DaemonTopics,
    hands: [HandTopics; 2],
    interval: Duration,
    state_pace: Pace,
    cloud_pace: Pace,
}

/// Observation of one daemon.
struct Watch {
    observer: Observer,
    joints: Subscriber<JointState>,
    newest: Box<JointState>,
    robot: RobotWatch,
    since: Instant,
}

impl Watch {
    fn join(session: &Session) -> anyhow::Result<Self> {
        Ok(Self {
            observer: Observer::join(session)?,
            joints: session.bus().subscriber(service::JOINT_STATE)?,
            newest: Box::default(),
            robot: RobotWatch::default(),
            since: Instant::now(),
        })
    }
}

impl Topics {
    /// Opens the topics that do not depend on the robot.
    ///
    /// # Errors
    /// The middleware fails.
    pub(crate) fn open(node: &mut Node, arguments: &Arguments) -> anyhow::Result<Self> {
        let namespace = &arguments.namespace;
        Ok(Self {
            joints: JointTopics::open(node, arguments.drive.is_none())?,
            daemon: DaemonTopics::open(node, namespace)?,
            hands: [
                HandTopics::open(node, namespace, 0)?,
                HandTopics::open(node, namespace, 1)?,
            ],
            interval: Duration::from_secs_f64(1.0 / arguments.joint_rate),
            state_pace: Pace::new(arguments.state_rate),
            cloud_pace: Pace::new(arguments.cloud_rate),
        })
    }

    /// Publishes until `is_over`. A missing daemon is a published state, not an error.
    pub(crate) fn run(&mut self, link: &mut BusLink, is_over: impl Fn() -> bool) {
        let mut watch = None;
        let mut due = Instant::now();
        while !is_over() {
            if watch.is_none() {
                watch = link.poll().and_then(|session| Watch::join(session).ok());
            }
            let done = match (&mut watch, link.poll()) {
                (Some(watch), Some(session)) => self.poll(watch, session),
                _ => self.daemon.absent(),
            };
            let is_silent =
                |watch: &Watch| !watch.observer.is_alive() && watch.since.elapsed() > SILENCE;
            if let Err(error) = done {
                tracing::warn!("could not publish: {error:#}");
                (watch, due) = (None, Instant::now());
                link.close();
            } else if watch.as_ref().is_some_and(is_silent) {
                watch = None;
                link.close();
            }
            due = (due + self.interval).max(Instant::now() - self.interval);
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
        }
    }

    fn poll(&mut self, watch: &mut Watch, session: &Session) -> anyhow::Result<()> {
        let mut events = Vec::new();
        watch.observer.poll(|_| (), |event| events.push(*event))?;
        let observer = &watch.observer;
        if observer.is_alive() {
            watch.since = Instant::now();
        }
        let clock = Clock::now(&observer.status);
        let is_other = watch.robot.poll(session.bus(), &observer.status)?;
        self.daemon.publish(observer, &clock, &events)?;
        let has_joints = watch.joints.newest(&mut watch.newest)?;
        let Some(robot) = watch.robot.robot() else {
            return Ok(());
        };
        if is_other {
            self.joints.describe(robot)?;
        }
        if has_joints {
            self.joints.publish(robot, &watch.newest, &clock)?;
        }
        if observer.is_alive() && self.state_pace.is_due() {
            self.joints.transforms(robot, &watch.newest, &clock)?;
            let clouds = self.cloud_pace.is_due();
            for hand in &mut self.hands {
                hand.publish(robot, observer, &watch.newest, &clock, clouds)?;
            }
        }
        Ok(())
    }
}
