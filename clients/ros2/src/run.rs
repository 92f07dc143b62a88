//! Threads of the bridge.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::arguments::Arguments;
use crate::goals::Goals;
use crate::link::BusLink;
use crate::middleware::Node;
use crate::parameters::Parameters;
use crate::requests::{ControlServices, StopService};
use crate::ros2_control::Drive;
use crate::topics::Topics;

/// Poll interval of services and parameters. Design choice: not perceptible to a person.
const CONTROL_POLL: Duration = Duration::from_millis(10);

/// Runs the bridge until `stop` is set.
///
/// # Errors
/// The ROS graph cannot be joined, or the driven robot fails.
pub fn run(arguments: &Arguments, stop: &Arc<AtomicBool>) -> anyhow::Result<()> {
    let mut link = BusLink::new(&arguments.bus);
    let mut node = Node::join(&arguments.node())?;
    let mut goals = Goals::open(&mut node, arguments)?;
    loop {
        serve(arguments, &mut node, &mut goals, &mut link, stop)?;
        if stop.load(Ordering::Relaxed) {
            // RustDDS reports writers that end after their participant.
            log::set_max_level(log::LevelFilter::Off);
            return Ok(());
        }
        tracing::warn!("the lease of a peer expired; the bridge joins the ROS graph again");
        let mut next = Node::join(&arguments.node())?;
        goals.reopen(&mut next, arguments)?;
        node = next;
    }
}

/// Serves one participant until `stop` is set or it must be replaced.
fn serve(
    arguments: &Arguments,
    node: &mut Node,
    goals: &mut Goals,
    link: &mut BusLink,
    stop: &AtomicBool,
) -> anyhow::Result<()> {
    let (bus, namespace) = (&arguments.bus, &arguments.namespace);
    let mut stopping = StopService::open(node, namespace)?;
    let mut control = ControlServices::open(node, namespace)?;
    let mut parameters = Parameters::open(node, namespace)?;
    let mut topics = Topics::open(node, arguments)?;
    let mut drive = match arguments.drive {
        Some(controller) => Some(Drive::open(node, arguments, controller)?),
        None => None,
    };
    let ends = AtomicBool::new(false);
    let is_over = || stop.load(Ordering::Relaxed) || ends.load(Ordering::Relaxed);
    std::thread::scope(|threads| {
        let driven = drive.as_mut().map(|drive| {
            threads.spawn(|| {
                let ended = drive.run(arguments, is_over);
                if ended.is_err() {
                    // Without its robot the bridge is of no use.
                    stop.store(true, Ordering::Relaxed);
                }
                ended
            })
        });
        threads.spawn(|| stopping.run(bus, is_over));
        threads.spawn(|| topics.run(&mut BusLink::new(bus), is_over));
        threads.spawn(|| {
            let mut link = BusLink::new(bus);
            while !is_over() {
                control.poll(&mut link);
                parameters.poll(&mut link);
                std::thread::sleep(CONTROL_POLL);
            }
        });
        // Open goals belong to the thread that sent them.
        goals.run(node, link, stop);
        ends.store(true, Ordering::Relaxed);
        match driven.map(std::thread::ScopedJoinHandle::join) {
            Some(Ok(ended)) => ended,
            Some(Err(_)) => anyhow::bail!("the robot's thread panicked; report this as an error"),
            None => Ok(()),
        }
    })
}
