//! Exchange of tables: offers and takes in all interleavings.
#![cfg(loom)]

use atas_loom::Lookup;
use atas_loom::exchange::Exchange;
use loom::sync::Arc;
use loom::thread;

#[test]
fn newest_offer_is_taken_once() {
    loom::model(|| {
        let exchange = Arc::new(Exchange::default());
        let offering = Arc::clone(&exchange);
        let operator = thread::spawn(move || {
            offering.offer(Lookup(1));
            offering.offer(Lookup(2));
        });
        let (mut current, mut taken) = (Lookup(0), Vec::new());
        for _ in 0..2 {
            if exchange.take(&mut current) {
                taken.push(current.0);
            }
        }
        operator.join().unwrap();
        if exchange.take(&mut current) {
            taken.push(current.0);
        }
        assert!(!exchange.take(&mut current), "taken already");
        assert!(taken.is_sorted_by(|a, b| a < b), "{taken:?}");
        assert_eq!(taken.last(), Some(&2));
        assert_eq!(current, Lookup(2));
    });
}
