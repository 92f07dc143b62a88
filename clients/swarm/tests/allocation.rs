//! Answering a frame allocates once, inside the transport, also when tables are exchanged; looking tables up never does.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use ebts::agents::{Exchange, Fields, Lookup, TeamController, field_hash};
use ebts::built_in;
use shm_bus::{Bus, FreshBus, Realtime, now_ns};
use shm_schemas::capacity::AGENTS;
use shm_schemas::{AgentSensors, WheelCommands, service};

thread_local! {
    /// Allocations and releases of this thread.
    static COUNTS: Cell<[u64; 2]> = const { Cell::new([0; 2]) };
}

struct Counting;

fn count(which: usize) {
    // At the end of a thread there is nobody left to count for.
    let _ = COUNTS.try_with(|counts| {
        let mut now = counts.get();
        now[which] += 1;
        counts.set(now);
    });
}

// SAFETY: every call is passed on unchanged to the system's allocator, which fulfils the contract; counting touches only a
// thread-local that needs no allocation.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(0);
        // SAFETY: the caller's promise about `layout` is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(1);
        // SAFETY: the pointer came from `alloc` above, with this layout.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_frame_costs_the_transports_one_allocation_and_no_other() {
    const FRAMES: u64 = 500;
    let file = built_in::table("r3-two-agents").expect("built in");
    let [first, second] = [1, 2].map(|n| Lookup::new(&vec![file.clone(); n]));
    let bus = FreshBus::new("allocation");
    let (controllers, hosts) = (open(&bus, "controller"), open(&bus, "host"));
    let mut controller =
        TeamController::open(&controllers, first, Fields::TheirOwn).expect("a controller");
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
    let (mut spent, mut hashes) = ([0; 2], Vec::with_capacity(4));
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
        let before = COUNTS.get();
        let answered = controller.answer(&exchange).expect("the bus works");
        let after = COUNTS.get();
        assert!(answered && answers.newest(&mut answer).expect("the bus works"));
        assert_eq!(answer.frame, frame);
        hashes.push(answer.table_hash);
        hashes.dedup();
        // The peers map each other's memory with the first frame.
        if frame > 0 {
            spent = [
                spent[0] + after[0] - before[0],
                spent[1] + after[1] - before[1],
            ];
        }
    }
    assert_eq!(
        spent,
        [FRAMES - 1; 2],
        "one allocation and one release a frame"
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
