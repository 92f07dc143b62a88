//! Learning environments with simple scripted policies.

use atas_learning::{ACTIONS, Batch, End, Environment, LearningError, Outcome, Task, observation};
use robot_model::{RobotFiles, SHIPPED};

const LIFT: usize = 2;
const CLOSE: [usize; 2] = [3, 4];

fn environment(task: Task, objects: &[&str]) -> Environment {
    let objects: Vec<String> = objects.iter().map(|name| (*name).to_owned()).collect();
    Environment::new(task, &objects, 1.0).expect("built-in objects")
}

fn observed(environment: &Environment) -> Vec<f32> {
    let mut row = vec![0.0; environment.layout().size()];
    environment.observe(&mut row);
    row
}

/// Numbers of the last part: hand.
const HAND: usize = 8;

/// Returns F_n of two fingertips on opposite grasp sides, N.
fn pressed_n(row: &[f32]) -> [f32; 2] {
    side_forces_n(row, &[0, 1])
}

/// Returns F_n per grasp side, N; `sides` has the grasp side of each fingertip.
fn side_forces_n(row: &[f32], sides: &[usize]) -> [f32; 2] {
    let begin = row.len() - HAND - observation::MODULES.len() - sides.len() * observation::PERCEPT;
    let mut forces_n = [0.0; 2];
    for (finger, side) in sides.iter().enumerate() {
        forces_n[*side] += row[begin + finger * observation::PERCEPT];
    }
    forces_n
}

/// Closes until both grasp sides reach `force_n`, then lifts with action value `lift`.
fn grip(row: &[f32], force_n: f32, lift: f32) -> [f32; ACTIONS] {
    grip_with(pressed_n(row), force_n, lift)
}

fn grip_with(pressed_n: [f32; 2], force_n: f32, lift: f32) -> [f32; ACTIONS] {
    let mut action = [0.0; ACTIONS];
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
        let lifted_m = row[row.len() - 6];
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
    let (outcome, worth, _) = play(&mut environment, 2, |row, step| {
        let place = row.len() - 3;
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
        let size = like.layout().size();
        let mut rows = vec![0.0; seeds.len() * size];
        batch.reset(&seeds.map(Some), &mut rows).expect("scenes");
        let mut together = vec![Vec::new(); seeds.len()];
        for step in 0..100 {
            let each = rows.chunks_exact(size);
            for (row, bits) in each.clone().zip(&mut together) {
                bits.extend(row.iter().map(|value| value.to_bits()));
            }
            let actions: Vec<_> = each.map(|row| policy(row, step)).collect();
            batch.step(&actions, &mut rows).expect("worlds");
        }
        for (alone, together) in alone.iter().zip(&together) {
            let both = alone.len().min(together.len());
            assert!(both > 10 * size);
            assert_eq!(alone[..both], together[..both], "{threads} threads");
        }
    }
}

/// The observation has the sizes of the robot's hand, and a scripted grip lifts the object.
#[test]
fn every_built_in_robot_grasps_in_its_environment() {
    for files in SHIPPED {
        let name = files.name.clone();
        let objects = ["slippery-50".to_owned()];
        let environment = Environment::with_robot(files, Task::Grasp, Some(&objects), 1.0);
        let mut environment = environment.expect("built-in robot and object");
        let robot = environment.robot();
        let hand = robot.hand(robot.acting_side());
        let [taxels, joints, percept, ..] = environment.layout().parts();
        assert_eq!(taxels.shape[0], hand.fingertip_count(), "{name}");
        assert_eq!(joints.shape, [hand.joints().len(), 3], "{name}");
        assert_eq!(percept.shape[0], hand.fingertip_count(), "{name}");
        let tips = 0..hand.fingertip_count();
        let sides: Vec<usize> = tips.map(|finger| hand.grasp_side(finger).index()).collect();
        let policy = |row: &[f32], _| grip_with(side_forces_n(row, &sides), 3.0, 0.5);
        let (outcome, ..) = play(&mut environment, 1, policy);
        assert_eq!(outcome.end, End::Success, "{name}: {outcome:?}");
    }
}

#[test]
fn object_wider_than_the_hand_is_rejected_with_limit() {
    let objects = ["wood".to_owned()];
    let narrow = robot_with_opening(0.04);
    let refused = Environment::with_robot(narrow.clone(), Task::Grasp, Some(&objects), 1.0);
    let text = refused.err().expect("too wide").to_string();
    assert!(
        text.contains("50 mm wide") && text.contains("at most"),
        "{text}"
    );
    let rest = Environment::with_robot(narrow, Task::Grasp, None, 1.0);
    let text = rest.err().expect("no built-in object fits").to_string();
    assert!(text.contains("empty"), "{text}");
}

/// Returns the test bench with jaws that open to about this width.
fn robot_with_opening(opening_m: f64) -> RobotFiles {
    let bench = SHIPPED.into_iter().find(|files| files.name == "test-bench");
    let mut files = bench.expect("built-in");
    let upper = opening_m / 2.0;
    let text = files.robot_file.replace(
        "rest_m = 0.035",
        &format!("rest_m = {upper}, upper = {upper}"),
    );
    files.robot_file = text.into();
    files
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
        let bounds = environment
            .layout()
            .parts()
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
