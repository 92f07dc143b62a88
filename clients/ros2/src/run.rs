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
/// The ROS graph cannot be joined.
pub fn run(arguments: &Arguments, stop: &Arc<AtomicBool>) -> anyhow::Result<()> {
    let (bus, namespace) = (&arguments.bus, &arguments.namespace);
    let mut node = Node::join(&arguments.node())?;
    let mut stopping = StopService::open(&mut node, namespace)?;
    let mut control = ControlServices::open(&mut node, namespace)?;
    let mut parameters = Parameters::open(&mut node, namespace)?;
    let mut goals = Goals::open(&mut node, arguments)?;
    let mut topics = Topics::open(&mut node, arguments)?;
    let mut drive = match arguments.drive {
        Some(controller) => Some(Drive::open(&mut node, arguments, controller)?),
        None => None,
    };
    std::thread::scope(|threads| {
        let driven = drive.as_mut().map(|drive| {
            threads.spawn(|| {
                let ended = drive.run(arguments, stop);
                // Without its robot the bridge is of no use.
                stop.store(true, Ordering::Relaxed);
                ended
            })
        });
        threads.spawn(|| stopping.run(bus, stop));
        threads.spawn(|| topics.run(&mut BusLink::new(bus), stop));
        threads.spawn(|| {
            let mut link = BusLink::new(bus);
            while !stop.load(Ordering::Relaxed) {
                control.poll(&mut link);
                parameters.poll(&mut link);
                std::thread::sleep(CONTROL_POLL);
            }
        });
        // Open goals belong to the thread that sent them.
        goals.run(&mut BusLink::new(bus), stop);
        // RustDDS reports writers that end after their participant.
        log::set_max_level(log::LevelFilter::Off);
        match driven.map(std::thread::ScopedJoinHandle::join) {
            Some(Ok(ended)) => ended,
            Some(Err(_)) => anyhow::bail!("the robot's thread panicked; report this as an error"),
            None => Ok(()),
        }
    })
}
