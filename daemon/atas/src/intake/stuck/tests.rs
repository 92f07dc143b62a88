//! Tests of the detection of stuck elements.

use super::*;

/// Returns the frame, of 3000, at which the element becomes stuck.
fn stuck_after(reading: impl Fn(u16) -> f32) -> Option<u16> {
    let mut watch = StuckDetector::default();
    let mut before_n = [[0.0; 3]; ELEMENTS];
    (0..3000).find(|frame| {
        let mut now_n = before_n;
        now_n[3] = [reading(*frame), 0.0, 0.0];
        now_n[1] = [working_reading(*frame), 0.0, 0.0];
        let stuck = watch.update(&before_n, &now_n, 5);
        before_n = now_n;
        assert!(stuck == 0 || stuck == 1 << 3, "{stuck:b}");
        stuck != 0
    })
}

/// Working element: a reading that changes in every frame.
fn working_reading(frame: u16) -> f32 {
    0.2 + f32::from(frame % 7) * 1e-3
}

#[test]
fn working_element_is_stuck_when_constant_non_zero() {
    let check = |name: &str, reading: &dyn Fn(u16) -> f32, expected: Option<u16>| {
        assert_eq!(stuck_after(reading), expected, "{name}");
    };
    check("working", &working_reading, None);
    check(
        "constant from frame 1000",
        &|frame| working_reading(frame.min(1000)),
        Some(1250),
    );
    check("never changed", &|_| 0.2, None);
    let at_zero = |frame: u16| {
        if frame < 1000 {
            working_reading(frame)
        } else {
            0.0
        }
    };
    check("constant zero", &at_zero, None);
    // Changes only every hundredth frame, which is below four times its longest pause.
    check(
        "coarsely quantised",
        &|frame| working_reading(frame / 100),
        None,
    );
    let coarse = |frame: u16| working_reading(frame.min(1000) / 2);
    check("coarsely quantised, then constant", &coarse, Some(1250));
    let back = |frame: u16| {
        if frame < 1240 {
            working_reading(frame.min(1000))
        } else {
            working_reading(frame)
        }
    };
    check("recovers in time", &back, None);
}

/// Returns, for each of five elements, the first frame at which it is stuck.
fn stuck_at(readings: [&dyn Fn(u16) -> [f32; 3]; 5]) -> [Option<u16>; 5] {
    let mut watch = StuckDetector::default();
    let (mut before_n, mut found) = ([[0.0; 3]; ELEMENTS], [None; 5]);
    for frame in 0..3000 {
        let mut now_n = before_n;
        for (now_n, reading) in now_n.iter_mut().zip(readings) {
            *now_n = reading(frame);
        }
        let stuck = watch.update(&before_n, &now_n, 5);
        for (element, found) in found.iter_mut().enumerate() {
            if stuck >> element & 1 == 1 {
                found.get_or_insert(frame);
            }
        }
        before_n = now_n;
    }
    found
}

fn works(frame: u16) -> [f32; 3] {
    [working_reading(frame), 0.0, 0.0]
}

fn stops(frame: u16) -> [f32; 3] {
    works(frame.min(1000))
}

#[test]
fn elements_are_stuck_while_half_of_the_others_change() {
    const AT: Option<u16> = Some(1250);
    let all_stop = stuck_at([&stops, &stops, &stops, &stops, &stops]);
    assert_eq!(all_stop, [None; 5], "none changes");
    let most_stop = stuck_at([&works, &stops, &stops, &works, &stops]);
    assert_eq!(most_stop, [None; 5], "two of five change");
    let few_stop = stuck_at([&works, &stops, &works, &works, &stops]);
    assert_eq!(few_stop, [None, AT, None, None, AT], "three of five change");
}

/// Elements that began to change lately do not yet show that the sensor works.
#[test]
fn new_elements_have_no_vote() {
    let begins = |frame: u16| works(frame.max(1000));
    let found = stuck_at([&stops, &stops, &begins, &begins, &begins]);
    assert_eq!(found, [Some(1499), Some(1499), None, None, None]);
}

/// Equal changes of two axes do not cancel.
#[test]
fn change_of_any_axis_counts() {
    let axes = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 1.0, 0.0],
        [1.0, 0.0, 1.0],
        [0.0, 1.0, 1.0],
    ];
    for scale in axes {
        let reading = |frame: u16| scale.map(|axis: f32| axis * stops(frame)[0]);
        let found = stuck_at([&works, &works, &works, &works, &reading]);
        assert_eq!(found[4], Some(1250), "{scale:?}");
    }
}

#[test]
fn smallest_non_zero_reading_can_be_stuck() {
    let at = |reading_n: f32| {
        move |frame: u16| {
            if frame < 1000 {
                works(frame)
            } else {
                [0.0, -reading_n, 0.0]
            }
        }
    };
    let (least, less) = (at(ZERO_N), at(ZERO_N.next_down()));
    let found = stuck_at([&works, &works, &works, &least, &less]);
    assert_eq!(found, [None, None, None, Some(1250), None]);
}

/// The permitted pause grows with earlier pauses, but not with those of a stuck element.
#[test]
fn earlier_pauses_extend_the_permitted_pause() {
    // Pauses from frame 1000 for this long, then changes until it stops at frame 2000.
    let reading = |pause: u16, frame: u16| {
        let resting = (1000..1000 + pause).contains(&frame);
        works(if resting { 1000 } else { frame.min(2000) })
    };
    for (pause, expected) in [
        (0, 2250),
        (60, 2250),
        (101, 2400),
        (250, 2996),
        // The pause of a stuck element.
        (251, 1250),
    ] {
        let found = stuck_at([&works, &works, &works, &works, &|frame| {
            reading(pause, frame)
        }]);
        assert_eq!(found[4], Some(expected), "pause of {pause} frames");
    }
}

#[test]
fn pause_of_a_stuck_element_extends_nothing() {
    let mut watch = StuckDetector::default();
    let pauses = [
        (STUCK_FRAMES, STUCK_FRAMES),
        (STUCK_FRAMES - 1, PAUSE_FACTOR * (STUCK_FRAMES - 1)),
    ];
    for (pause, allowed) in pauses {
        watch.pauses[3] = pause;
        watch.end_pause(3);
        let first = (1..2000).find(|_| watch.count_pause(3, true));
        assert_eq!(first, Some(allowed), "after a pause of {pause} frames");
        watch.pauses[3] = 0;
    }
}

/// The end of one pause does not end or extend another.
#[test]
fn pauses_of_elements_are_independent() {
    let rests = |from: u16, to: u16| {
        move |frame: u16| {
            works(if (from..to).contains(&frame) {
                from
            } else {
                frame
            })
        }
    };
    let (early, late) = (rests(1000, 1100), rests(1000, 1200));
    let twice = |frame: u16| {
        works(if (1210..1420).contains(&frame) {
            1210
        } else {
            frame
        })
    };
    let both = |frame: u16| {
        if frame < 1205 {
            late(frame)
        } else {
            twice(frame)
        }
    };
    let found = stuck_at([&works, &works, &works, &early, &both]);
    assert_eq!(found, [None; 5]);
}

proptest::proptest! {
    /// A change of any bit of any axis counts, also of the sign of zero and of NaN.
    #[test]
    fn moved_elements_are_those_with_a_changed_axis(
        changes in proptest::collection::vec((0..ELEMENTS, 0..3_usize, 0..32_u32), 0..40),
        base in proptest::num::f32::ANY,
        count in 1..=ELEMENTS,
    ) {
        let before_n = [[base; 3]; ELEMENTS];
        let mut now_n = before_n;
        for (element, axis, bit) in changes {
            let reading_n = &mut now_n[element][axis];
            *reading_n = f32::from_bits(reading_n.to_bits() ^ 1 << bit);
        }
        let bits = |axes: [f32; 3]| axes.map(f32::to_bits);
        let expected = (0..count)
            .filter(|&element| bits(before_n[element]) != bits(now_n[element]))
            .fold(0, |set, element| set | 1_u64 << element);
        proptest::prop_assert_eq!(moved(&before_n, &now_n, count), expected);
    }
}
