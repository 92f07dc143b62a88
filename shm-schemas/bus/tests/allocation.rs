//! Allocations of sending and receiving; the tick depends on these counts.

use allocation_counter::measure;
use shm_bus::{Bus, FreshBus, Realtime};
use shm_schemas::HandFrame;
use shm_schemas::service::HAND_FRAME;

fn allocations(mut work: impl FnMut()) -> u64 {
    measure(|| (0..1000).for_each(|_| work())).count_total
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

    let check = |what: &str, expected: u64, work: &mut dyn FnMut()| {
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
