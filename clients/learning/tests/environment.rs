//! Learning environments with simple scripted policies.

use atas_learning::{ACTIONS, Batch, End, Environment, LearningError, Outcome, Task, observation};

const LIFT: usize = 2;
const CLOSE: [usize; 2] = [3, 4];

fn environment(task: Task, objects: &[&str]) -> Environment {
    let objects: Vec<String> = objects.iter().map(|name| (*name).to_owned()).collect();
    Environment::new(task, &objects, 1.0).expect("built-in objects")
}

fn observed(environment: &Environment) -> Vec<f32> {
    let mut row = vec![0.0; observation::SIZE];
    environment.observe(&mut row);
    row
}

/// Returns F_n of both grasp sides, N.
fn pressed_n(row: &[f32]) -> [f32; 2] {
    let first = observation::PARTS[0].len() + observation::PARTS[1].len();
    [row[first], row[first + observation::PERCEPT]]
}

/// Closes until both grasp sides reach `force_n`, then lifts with action value `lift`.
fn grip(row: &[f32], force_n: f32, lift: f32) -> [f32; ACTIONS] {
    let mut action = [0.0; ACTIONS];
    let pressed_n = pressed_n(row);
    for (index, pressed_n) in CLOSE.into_iter().zip(pressed_n) {
        action[index] = (0.3 * (force_n - pressed_n) / force_n).clamp(-0.3, 0.3);
    }
    if pressed_n.iter().all(|it| *it > 0.8 * force_n) {
        action[LIFT] = lift;
    }
    action
}

/// Runs an episode with a policy that receives observation and step number; returns outcome, total
/// reward, observation bits.
fn play(
    environment: &mut Environment,
    seed: u64,
    policy: impl Fn(&[f32], usize) -> [f32; ACTIONS],
) -> (Outcome, f64, Vec<u32>) {
    let mut outcome = environment.reset(Some(seed)).expect("a scene");
    let (mut worth, mut bits, mut step) = (0.0, Vec::new(), 0);
    while outcome.end == End::None && !outcome.truncated {
        let row = observed(environment);
        bits.extend(row.iter().map(|value| value.to_bits()));
        outcome = environment.step(&policy(&row, step)).expect("a world");
        worth += outcome.reward;
        step += 1;
    }
    (outcome, worth, bits)
}

#[test]
fn suitable_force_grasps_every_object() {
    // Between required and crush force of each object, with the family's ±20 %.
    let forces_n = [6.0, 6.0, 2.5, 0.6, 0.4, 7.5];
    for (object, force_n) in Task::OBJECTS.into_iter().zip(forces_n) {
        let mut environment = environment(Task::Grasp, &[object]);
        let (outcome, worth, _) = play(&mut environment, 1, |row, _| grip(row, force_n, 0.5));
        assert_eq!(outcome.end, End::Success, "{object}: {outcome:?}");
        assert!(worth > 10.0, "{object}: {worth}");
    }
}

#[test]
fn episode_end_follows_ground_truth() {
    let mut paper = environment(Task::Grasp, &["paper-box"]);
    let (outcome, worth, _) = play(&mut paper, 1, |row, _| grip(row, 6.0, 0.5));
    assert_eq!(outcome.end, End::Crushed, "{outcome:?}");
    assert!(worth < 0.0, "{worth}");
    let mut wood = environment(Task::Grasp, &["wood"]);
    let (outcome, ..) = play(&mut wood, 1, |row, _| {
        let lifted_m = row[observation::SIZE - 6];
        if lifted_m > 0.03 {
            [0.0, 0.0, 0.0, -1.0, -1.0]
        } else {
            grip(row, 6.0, 0.5)
        }
    });
    assert_eq!(outcome.end, End::Dropped, "{outcome:?}");
    let (outcome, worth, _) = play(&mut wood, 1, |_, _| [0.0; ACTIONS]);
    assert!(outcome.truncated && outcome.end == End::None, "{outcome:?}");
    assert!(worth.abs() < 1e-3, "no reward without motion: {worth}");
}

#[test]
fn carried_and_released_object_counts_as_placed() {
    let mut environment = environment(Task::PickPlace, &["wood"]);
    let place = observation::SIZE - 3;
    let (outcome, worth, _) = play(&mut environment, 2, |row, step| {
        let [x, y, z] = [row[place], row[place + 1], row[place + 2]];
        let over = x.hypot(y) < 0.003;
        let mut action = grip(row, 6.0, 0.3);
        if step > 120 && !over {
            // Velocity towards the target, as a share of the maximum.
            action[..3].copy_from_slice(&[10.0 * x, 10.0 * y, 0.0]);
        } else if over && step < 400 {
            action[LIFT] = -0.1;
            let stands = z > -0.012 && step > 330;
            CLOSE
                .into_iter()
                .filter(|_| stands)
                .for_each(|index| action[index] = -0.5);
        } else if step > 90 {
            action[LIFT] = 0.0;
        }
        action
    });
    assert_eq!(outcome.end, End::Success, "{outcome:?} {worth}");
}

#[test]
fn batch_equals_single_environments_bit_for_bit() {
    let policy = |row: &[f32], step: usize| {
        let mut action = grip(row, 1.0, 0.4);
        action[0] = ((step * 7 % 11) as f32 - 5.0) / 20.0;
        action
    };
    let like = environment(Task::Grasp, &Task::OBJECTS);
    let seeds = [3, 4, 5_u64];
    let alone: Vec<Vec<u32>> = seeds
        .iter()
        .map(|seed| play(&mut like.fork(), *seed, policy).2)
        .collect();
    assert_ne!(alone[0], alone[1], "seeds differ");
    for threads in [1, 3] {
        let mut batch = Batch::new(&like, seeds.len(), threads, true).expect("threads");
        let mut rows = vec![0.0; seeds.len() * observation::SIZE];
        batch.reset(&seeds.map(Some), &mut rows).expect("scenes");
        let mut together = vec![Vec::new(); seeds.len()];
        for step in 0..100 {
            let each = rows.chunks_exact(observation::SIZE);
            for (row, bits) in each.clone().zip(&mut together) {
                bits.extend(row.iter().map(|value| value.to_bits()));
            }
            let actions: Vec<_> = each.map(|row| policy(row, step)).collect();
            batch.step(&actions, &mut rows).expect("worlds");
        }
        for (alone, together) in alone.iter().zip(&together) {
            let both = alone.len().min(together.len());
            assert!(both > 10 * observation::SIZE);
            assert_eq!(alone[..both], together[..both], "{threads} threads");
        }
    }
}

#[test]
fn non_finite_action_is_rejected_without_motion() {
    let mut environment = environment(Task::Grasp, &["wood"]);
    assert!(matches!(
        environment.step(&[0.0; ACTIONS]),
        Err(LearningError::NotBegun)
    ));
    environment.reset(Some(1)).expect("a scene");
    let before = observed(&environment);
    for value in [f32::NAN, f32::INFINITY] {
        let mut action = [0.0; ACTIONS];
        action[3] = value;
        let refused = environment.step(&action);
        assert!(
            matches!(refused, Err(LearningError::Action { index: 3, .. })),
            "{refused:?}"
        );
    }
    assert_eq!(observed(&environment), before);
}

#[test]
fn observations_stay_within_bounds() {
    let mut environment = environment(Task::Grasp, &["bottle"]);
    environment.reset(Some(9)).expect("a scene");
    for step in 0..200 {
        let sign = if step / 20 % 2 == 0 { 1e30 } else { -1e30 };
        let outcome = environment
            .step(&[sign, -sign, sign, 1e30, sign])
            .expect("a world");
        let row = observed(&environment);
        let bounds = observation::PARTS
            .iter()
            .flat_map(observation::Part::each_bound);
        for (value, (low, high)) in row.iter().zip(bounds) {
            assert!((low..=high).contains(value), "{value} of {low} to {high}");
        }
        if outcome.end != End::None || outcome.truncated {
            break;
        }
    }
}
