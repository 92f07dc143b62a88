//! Allocations: answering a frame allocates once, inside the transport, even when tables are
//! exchanged. Lookup never allocates.

use allocation_counter::measure;
use ebts::agents::{Exchange, FieldPolicy, Lookup, TeamController, field_hash};
use ebts::built_in;
use shm_bus::{Bus, FreshBus, Realtime, now_ns};
use shm_schemas::capacity::AGENTS;
use shm_schemas::{AgentSensors, WheelCommands, service};

#[test]
fn answering_a_frame_allocates_once() {
    const FRAMES: u64 = 500;
    let file = built_in::table("r3-two-agents").expect("built in");
    let [first, second] = [1, 2].map(|n| Lookup::new(&vec![file.clone(); n]));
    let bus = FreshBus::new("allocation");
    let (controllers, hosts) = (open(&bus, "controller"), open(&bus, "host"));
    let mut controller =
        TeamController::open(&controllers, first, FieldPolicy::SameField).expect("a controller");
    let publisher = hosts
        .publisher::<AgentSensors>(service::AGENT_SENSORS)
        .expect("a publisher");
    let mut answers = hosts
        .subscriber::<WheelCommands>(service::WHEEL_COMMANDS)
        .expect("a subscriber");
    let (exchange, mut answer) = (Exchange::default(), WheelCommands::default());
    let mut sensors = AgentSensors {
        agent_count: AGENTS as u32,
        field_hash: field_hash(&file),
        ..AgentSensors::default()
    };
    let (mut allocations, mut kept, mut hashes) = (0, 0, Vec::with_capacity(4));
    let mut next = Some(second);
    for frame in 0..FRAMES {
        if frame == FRAMES / 2 {
            next.take()
                .into_iter()
                .for_each(|lookup| exchange.offer(lookup));
        }
        sensors.frame = frame;
        sensors.stamp.sequence = frame;
        sensors.stamp.captured_ns = now_ns();
        publisher.send(&sensors).expect("sent");
        let mut answered = false;
        let cost = measure(|| answered = controller.answer(&exchange).expect("the bus works"));
        assert!(answered && answers.newest(&mut answer).expect("the bus works"));
        assert_eq!(answer.frame, frame);
        hashes.push(answer.table_hash);
        hashes.dedup();
        // The first frame maps the shared memory of the peers.
        if frame > 0 {
            allocations += cost.count_total;
            kept += cost.count_current;
        }
    }
    assert_eq!(
        (allocations, kept),
        (FRAMES - 1, 0),
        "one allocation and one release per frame"
    );
    assert_eq!(
        (controller.counts().answered, hashes.len()),
        (FRAMES, 2),
        "two tables, one after the other"
    );
}

fn open(bus: &FreshBus, role: &str) -> Bus {
    Bus::open(bus, role, Realtime::Yes).expect("a bus")
}
