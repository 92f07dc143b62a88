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
    let mut goals = Goals::open(&mut node, namespace)?;
    let mut topics = Topics::open(&mut node, arguments)?;
    std::thread::scope(|threads| {
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
    });
    Ok(())
}
