//! Checksum of tactile frames: up to three flipped bits are always found.
//!
//! `ATAS_FLIPS=10000000 cargo test --release -p atas-fuzz --test bit_flips` runs more cases.

use atas_core::intake::FrameIntake;
use atas_core::{HandSensorSetup, Settings, Tick};
use atas_fuzz::Random;
use shm_schemas::{Hand, HandFrame, Layout, Stamp};
use zerocopy::IntoBytes;

/// Cases of the ordinary test.
const CASES: u64 = 100_000;
const NOW_NS: u64 = 1_000_000_000;

/// Returns a sealed frame with random forces.
fn frame(random: &mut Random) -> HandFrame {
    let layout = Layout::dome_41();
    let mut frame = HandFrame {
        stamp: Stamp {
            sequence: random.next() >> 1,
            captured_ns: NOW_NS,
            writer_epoch: random.next(),
        },
        layout_hash: layout.hash(),
        hand: Hand::LEFT,
        finger_count: 2,
        valid_mask: [(1 << layout.count) - 1, (1 << layout.count) - 1, 0, 0],
        ..HandFrame::default()
    };
    for finger in &mut frame.force_n[..2] {
        for element in &mut finger[..layout.count] {
            *element = [0; 3].map(|_: i32| random.below(1_000) as f32 * 1e-3);
        }
    }
    frame.seal();
    frame
}

fn accepts(frame: &HandFrame) -> bool {
    let mut intake = FrameIntake::new(Hand::LEFT, &HandSensorSetup::default());
    let tick = Tick {
        index: 0,
        now_ns: NOW_NS,
    };
    intake.begin();
    intake
        .validate(frame, tick, &Settings::default().intake)
        .is_some()
}

#[test]
fn three_flipped_bits_are_always_refused() {
    let cases = std::env::var("ATAS_FLIPS")
        .ok()
        .and_then(|cases| cases.parse().ok());
    let bits = 8 * size_of::<HandFrame>();
    for case in 0..cases.unwrap_or(CASES) {
        let mut random = Random::new(36, case);
        let good = frame(&mut random);
        assert!(accepts(&good), "case {case}: an intact frame is refused");
        let mut flipped = [usize::MAX; 3];
        let count = 1 + random.below(3);
        let mut damaged = good;
        for n in 0..count {
            let bit = loop {
                let bit = random.below(bits);
                if !flipped.contains(&bit) {
                    break bit;
                }
            };
            flipped[n] = bit;
            damaged.as_mut_bytes()[bit / 8] ^= 1 << (bit % 8);
        }
        assert!(
            !accepts(&damaged),
            "case {case}: flipped bits {flipped:?} are accepted"
        );
    }
}
