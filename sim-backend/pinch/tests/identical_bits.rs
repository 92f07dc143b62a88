//! All engines give identical bits; basic grasp behaviour.

use pinch::{Bit, End, Engine, Interface, Object, Outcome, Rows, TimeLimit, Trial};

const BITS: [Bit; 5] = [
    Bit::Touching,
    Bit::AboveF1,
    Bit::Slipping,
    Bit::AboveF2,
    Bit::Spare,
];
const OBJECTS: [Object; 4] = [
    object(0.3, 0.5, 1e6, f32::INFINITY),
    object(0.02, 0.4, 1500.0, 1.5),
    object(0.5, 0.5, 3e4, 15.0),
    object(1.5, 0.4, 1e6, f32::INFINITY),
];

const fn object(mass_kg: f32, friction: f32, stiffness_n_m: f32, crush_n: f32) -> Object {
    Object {
        mass_kg,
        friction,
        stiffness_n_m,
        crush_n,
    }
}

fn interface(force_limit: bool, time_limit: TimeLimit) -> Interface<'static> {
    Interface {
        bits: &BITS,
        fingers_m_s: [0.0, -0.001, 0.002, 0.004],
        hand: [0.0, -0.1, 0.1, 1.0],
        force_limit,
        time_limit,
    }
}

fn rows(row: impl Fn([bool; 5]) -> [u64; 2]) -> Rows {
    let mut rows = [0; 4];
    for number in 0..32_usize {
        let [fingers, hand] = row(core::array::from_fn(|bit| number >> bit & 1 == 1));
        rows[number / 16] |= (fingers | hand << 2) << (number % 16 * 4);
    }
    rows
}

/// Modules 1, 2 and 3 of the paper; refuses if slip persists above F_2.
fn modules([touching, above_f1, slipping, above_f2, _]: [bool; 5]) -> [u64; 2] {
    match (touching && above_f1, slipping, above_f2) {
        (false, ..) => [2, 0],
        (_, true, true) => [0, 1],
        (_, true, false) => [2, 2],
        _ => [0, 3],
    }
}

fn run(engine: Engine, interface: &Interface<'_>, trials: &[Trial]) -> Vec<Outcome> {
    let mut outcomes = Vec::new();
    engine.run(interface, trials, &mut outcomes);
    outcomes
}

#[test]
fn bits_are_independent_of_engine_and_order() {
    // Arbitrary tables from a multiplicative hash.
    let any = |seed: u64| {
        core::array::from_fn(|word| {
            (seed * 4 + word as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        })
    };
    let trial = |seed: u32| Trial {
        object: OBJECTS[seed as usize % OBJECTS.len()],
        rows: if seed.is_multiple_of(3) {
            rows(modules)
        } else {
            any(seed.into())
        },
        seed,
    };
    let trials: Vec<Trial> = (0..37).map(trial).collect();
    for force_limit in [false, true] {
        let interface = interface(force_limit, TimeLimit::SHORT);
        let expected = run(Engine::all()[0], &interface, &trials);
        for engine in Engine::all() {
            assert_eq!(
                run(engine, &interface, &trials),
                expected,
                "{}",
                engine.name()
            );
            let mut turned = trials.clone();
            turned.reverse();
            let mut outcomes = run(engine, &interface, &turned);
            outcomes.reverse();
            assert_eq!(outcomes, expected, "{}, reversed order", engine.name());
        }
    }
}

#[test]
fn paper_modules_hold_only_feasible_objects() {
    let trials = OBJECTS.map(|object| Trial {
        object,
        rows: rows(modules),
        seed: 1,
    });
    let outcomes = run(
        Engine::fastest(),
        &interface(false, TimeLimit::SHORT),
        &trials,
    );
    for (trial, outcome) in trials.iter().zip(&outcomes) {
        let feasible = trial.object.is_feasible();
        let expected = if feasible { End::Arrived } else { End::Refused };
        assert_eq!(outcome.end, expected, "{trial:?}: {outcome:?}");
        assert_eq!(outcome.raised_m[1] > 0.035, feasible, "{outcome:?}");
        let needed_n = trial.object.required_n();
        assert!(!feasible || outcome.normal_n > needed_n, "{outcome:?}");
    }
}

#[test]
fn excess_force_crushes_and_opening_loses() {
    let ends = |row: fn([bool; 5]) -> [u64; 2], force_limit| {
        let trials = [Trial {
            object: OBJECTS[1],
            rows: rows(row),
            seed: 1,
        }];
        let interface = interface(force_limit, TimeLimit::LONG);
        run(Engine::fastest(), &interface, &trials)[0].end
    };
    let weak = object(0.02, 0.4, 1500.0, 0.9);
    let trials = [Trial {
        object: weak,
        rows: rows(|_| [3, 3]),
        seed: 1,
    }];
    let crushed = run(
        Engine::fastest(),
        &interface(false, TimeLimit::LONG),
        &trials,
    );
    assert_eq!(crushed[0].end, End::Crushed);
    assert_eq!(ends(|_| [1, 3], false), End::Lost);
    assert_eq!(ends(|_| [0, 0], false), End::TimedOut);
    assert_eq!(
        ends(|_| [3, 3], true),
        End::Arrived,
        "Module 3 limits the force"
    );
}
