//! What sending and receiving allocate: the tick depends on it.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use shm_bus::{Bus, FreshBus, Realtime};
use shm_schemas::HandFrame;
use shm_schemas::service::HAND_FRAME;

struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call goes to the system's allocator unchanged; counting touches no allocated memory.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // A thread that is ending has no counter any more, and is not measured.
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are passed on.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations(mut work: impl FnMut()) -> usize {
    let before = ALLOCATIONS.get();
    for _ in 0..1000 {
        work();
    }
    ALLOCATIONS.get() - before
}

#[test]
fn sending_allocates_once_and_receiving_never() {
    let name = FreshBus::new("alloc");
    let bus = Bus::open(&name, "both", Realtime::Yes).expect("the bus opens");
    let publisher = bus
        .publisher::<HandFrame>(HAND_FRAME[0])
        .expect("publisher");
    let mut subscriber = bus
        .subscriber::<HandFrame>(HAND_FRAME[0])
        .expect("subscriber");
    let mut frame = HandFrame::default();
    publisher.send(&frame).expect("sent");
    assert!(subscriber.newest(&mut frame).expect("read"));

    let check = |what: &str, expected: usize, work: &mut dyn FnMut()| {
        assert_eq!(allocations(work), expected, "{what}");
    };
    let sent = HandFrame::default();
    check("send", 1000, &mut || publisher.send(&sent).expect("sent"));
    check("send_with", 1000, &mut || {
        publisher
            .send_with(|frame| frame.stamp.sequence = 1)
            .expect("sent")
    });
    check("newest of many", 0, &mut || {
        let _any = subscriber.newest(&mut frame).expect("read");
    });
    check("newest of none", 0, &mut || {
        assert!(!subscriber.newest(&mut frame).expect("read"))
    });
    (0..64).for_each(|_| publisher.send(&sent).expect("sent"));
    check("drain", 0, &mut || {
        let _count = subscriber.drain(8, |_| {}).expect("read");
    });
}
