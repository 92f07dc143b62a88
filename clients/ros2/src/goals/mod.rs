//! Actions: goals of ROS 2 clients as goals of the daemon.
//!
//! | action below the namespace | type |
//! |---|---|
//! | `HAND/gripper_cmd` | control_msgs/action/GripperCommand |
//! | `HAND/parallel_gripper_cmd` | control_msgs/action/ParallelGripperCommand |
//! | `grasp`, `pick_place`, `screw`, `assemble`, `release` | atas_msgs/action/… |

mod follow;
mod gripper;
mod gripper_action;
mod grippers;
mod limits;
mod runner;
mod scene;
mod server;
mod stream;
mod tasks;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::arguments::Arguments;
use crate::clock::present;
use crate::link::BusLink;
use crate::middleware::{Node, Publish, Quality};
use crate::wire::action::{Assemble, Grasp, PickPlace, Release, Screw};
use crate::wire::atas::GoalEvent;
use crate::wire::standard::{Header, Uuid};

use follow::Follow;
use grippers::Grippers;
use runner::TaskServer;
use scene::Scene;

/// Poll interval. Design choice: a tenth of the delay that a person notices.
const POLL: Duration = Duration::from_millis(5);
/// Silence of the daemon after which the bus is opened again.
const SILENCE: Duration = Duration::from_secs(2);

/// Publisher of the changes of goals with their causes.
struct Journal(Box<dyn Publish<GoalEvent>>);

impl Journal {
    fn write(&self, action: &str, id: &Uuid, status: i8, step: &str, cause: &str) {
        if !cause.is_empty() {
            tracing::info!("{action}: {cause}");
        }
        let event = GoalEvent {
            header: Header {
                stamp: present(),
                frame_id: String::new(),
            },
            action: action.to_owned(),
            goal_id: id.clone(),
            status,
            step: step.to_owned(),
            cause: cause.to_owned(),
        };
        if let Err(error) = self.0.publish(event) {
            tracing::warn!("goal event not published: {error:#}");
        }
    }
}

/// Servers of all actions.
pub(crate) struct Goals {
    journal: Journal,
    grippers: Grippers,
    /// Joint commands of ros2_control for one hand.
    follow: Option<Follow>,
    grasp: TaskServer<Grasp>,
    pick_place: TaskServer<PickPlace>,
    screw: TaskServer<Screw>,
    assemble: TaskServer<Assemble>,
    release: TaskServer<Release>,
}

impl Goals {
    /// Opens all actions.
    ///
    /// # Errors
    /// The middleware fails.
    pub(crate) fn open(node: &mut Node, arguments: &Arguments) -> anyhow::Result<Self> {
        let namespace = &arguments.namespace;
        let followed = arguments
            .follow
            .map(|hand| Follow::open(node, namespace, hand.into()));
        let events = node.publisher(&format!("{namespace}/goal_events"), Quality::EVENTS)?;
        Ok(Self {
            journal: Journal(events),
            grippers: Grippers::open(node, namespace)?,
            follow: followed.transpose()?,
            grasp: TaskServer::open(node, namespace)?,
            pick_place: TaskServer::open(node, namespace)?,
            screw: TaskServer::open(node, namespace)?,
            assemble: TaskServer::open(node, namespace)?,
            release: TaskServer::open(node, namespace)?,
        })
    }

    /// Continues with another participant.
    ///
    /// # Errors
    /// The middleware fails.
    pub(crate) fn reopen(&mut self, node: &mut Node, arguments: &Arguments) -> anyhow::Result<()> {
        let namespace = &arguments.namespace;
        let events = node.publisher(&format!("{namespace}/goal_events"), Quality::EVENTS)?;
        self.journal = Journal(events);
        self.grippers.reopen(node)?;
        if let Some(follow) = &mut self.follow {
            follow.reopen(node, namespace)?;
        }
        self.grasp.reopen(node)?;
        self.pick_place.reopen(node)?;
        self.screw.reopen(node)?;
        self.assemble.reopen(node)?;
        self.release.reopen(node)
    }

    /// Executes goals until `stop` is set, or until the node must join again and no goal runs.
    pub(crate) fn run(&mut self, node: &mut Node, link: &mut BusLink, stop: &AtomicBool) {
        let (mut scene, mut heard) = (None, Instant::now());
        while !stop.load(Ordering::Relaxed) {
            self.poll(link, &mut scene);
            if node.must_rejoin() && self.is_idle() {
                return;
            }
            let is_silent = scene.as_ref().is_some_and(|of: &Scene| !of.is_fresh());
            if !is_silent {
                heard = Instant::now();
            } else if heard.elapsed() > SILENCE && self.is_idle() {
                // A new daemon may use a new bus.
                scene = None;
                self.grippers.forget();
                link.close();
            }
            std::thread::sleep(POLL);
        }
    }

    fn is_idle(&self) -> bool {
        self.grippers.is_idle()
            && self.grasp.is_idle()
            && self.pick_place.is_idle()
            && self.screw.is_idle()
            && self.assemble.is_idle()
            && self.release.is_idle()
    }

    fn poll(&mut self, link: &mut BusLink, scene: &mut Option<Scene>) {
        if scene.is_none()
            && let Some(session) = link.poll()
        {
            *scene = Scene::join(session).ok();
        }
        if let (Some(scene), Some(session)) = (&mut *scene, link.poll())
            && let Err(error) = scene.poll(session)
        {
            tracing::warn!("could not read the bus: {error}");
        }
        let (scene, journal) = (scene.as_ref(), &self.journal);
        let grippers = &mut self.grippers;
        grippers.poll(link, scene, journal);
        if let Some(follow) = &mut self.follow {
            follow.poll(link, scene, grippers);
        }
        self.grasp.poll(link, scene, journal, grippers);
        self.pick_place.poll(link, scene, journal, grippers);
        self.screw.poll(link, scene, journal, grippers);
        self.assemble.poll(link, scene, journal, grippers);
        self.release.poll(link, scene, journal, grippers);
    }
}
