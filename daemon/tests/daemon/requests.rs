//! Many requests while ticks and supervisor share one core: neither may wait for the other.

use shm_bus::FreshBus;
use shm_schemas::{ControlOp, ControlOutcome, Mode};

use crate::goals::grasp;
use crate::support::{Daemon, TOLERANT, World};

/// Close to the number that stopped a daemon with lock-free instead of wait-free queues;
/// `ATAS_ORDERS=5000` runs more.
const REQUESTS: u32 = 500;

fn request_count() -> u32 {
    let asked = std::env::var("ATAS_ORDERS").ok();
    asked.map_or(REQUESTS, |count| {
        count.parse().expect("ATAS_ORDERS is a number")
    })
}

#[test]
fn many_requests_on_one_core_do_not_block() {
    let bus = FreshBus::new("orders");
    let mut world = World::open(&bus);
    let mut daemon = Daemon::start_under(&["taskset", "-c", "0"], &bus, TOLERANT, &[], |_| ());
    world.until_mode(Mode::READY);
    let goals = world.bus.goal_client().expect("there is room");
    for order in 0..request_count() {
        world.publish(shm_bus::now_ns());
        world.receive();
        // The goal stays pending, as with a client that waits for its end.
        let _pending = goals.send(&grasp(u64::from(order) + 1)).ok();
        let value = 0.06 + 0.01 * f64::from(order % 2);
        let reply = world.control(ControlOp::PARAM_SET, "grasp.dr_n", value);
        let known = [ControlOutcome::DONE, ControlOutcome::REFUSED];
        assert!(known.contains(&reply.outcome), "{order}: {}", reply.text);
        if order % 100 == 0 {
            daemon.signal(rustix::process::Signal::HUP);
        }
    }
    assert!(daemon.is_running(), "{}", daemon.log());
    let stopped = world.control(ControlOp::ESTOP, "", 0.0);
    assert_eq!(stopped.outcome, ControlOutcome::DONE);
    world.until_mode(Mode::SAFE_STOP);
}
