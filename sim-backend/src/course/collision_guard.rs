//! Collision guard below the behaviour table: a base stays clear of walls, objects and other bases
//! under any command.
//!
//! ```text
//!  levels ─▶ predict one frame, then braking ─▶ clear, and room to turn? ─▶ execute
//!                                              └─ no ─▶ turn about one wheel ─ no ─▶ brake
//! ```
//!
//! It works like the protective field of a mobile robot, with the smallest horizon: one frame plus
//! braking. A base cannot drive backwards, so its stopping position must leave room to turn about
//! one wheel.
//!
//! * **Inputs:** bases with their commands, and the objects on the floor. **Output:** the allowed
//!   command.
//! * **Invariant:** every base can brake at any time without a collision, because each accepted
//!   command was predicted to end so, together with the commands of the others. If no command is
//!   clear, the previous one expires and the base brakes.
//! * **Excluded by design:** floor and noise. Bases match the prediction exactly in simulation;
//!   [`CLEAR_M`] is the margin for real ones.

use field::Wheels;

use super::FRAME_STEPS;
use super::base::{Base, HALF_TRACK_M, Pace};
use super::layout::{BASE_M, HALF_SIDE_M, OBJECT_M, ROBOT_M};

/// Clearance, m.
const CLEAR_M: f64 = 0.01;
/// Distance beyond which a base cannot hit anything before it stops and turns, m: 0.18 for a frame
/// and gentle braking from full speed, 0.30 for a turn.
const FAR_M: f64 = 0.5;

/// Wheel levels and pace for the remaining steps, then braking.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FrameCommand {
    wheels: Wheels,
    pace: Pace,
    steps_left: u64,
}

impl FrameCommand {
    pub(super) fn new(wheels: Wheels, pace: Pace) -> Self {
        Self {
            wheels,
            pace,
            steps_left: FRAME_STEPS,
        }
    }

    pub(super) fn step(&mut self, base: &mut Base) {
        let obeyed = self.steps_left > 0;
        self.steps_left = self.steps_left.saturating_sub(1);
        let wheels = if obeyed { self.wheels } else { Wheels::STOP };
        base.step(wheels, self.pace);
    }

    pub(super) fn stop(&mut self) {
        self.steps_left = 0;
    }

    /// True if expired and at rest.
    fn is_finished(&self, base: &Base) -> bool {
        self.steps_left == 0 && base.is_at_rest()
    }
}

/// Obstacles of a base.
pub(super) struct Surroundings {
    /// Other bases with their commands.
    pub(super) others: Vec<(Base, FrameCommand)>,
    /// Objects on the floor, m.
    pub(super) objects_m: Vec<[f64; 2]>,
}

impl Surroundings {
    /// Returns the first clear command: the requested one, else a turn about a wheel.
    pub(super) fn allow(&self, base: &Base, wheels: Wheels, pace: Pace) -> Option<FrameCommand> {
        let reported = FrameCommand::new(wheels, pace);
        if self.is_far(base) {
            return Some(reported);
        }
        let turn = |left, right| FrameCommand::new(Wheels { left, right }, pace);
        let turns = match wheels.left > wheels.right {
            true => [turn(2, 0), turn(0, 2)],
            false => [turn(0, 2), turn(2, 0)],
        };
        let orders = [reported, turns[0], turns[1]];
        orders.into_iter().find(|order| self.is_clear(base, *order))
    }

    fn is_far(&self, base: &Base) -> bool {
        let at_m = base.pose().position_m;
        let apart =
            |other: &Base| are_apart(at_m, other.pose().position_m, 2.0 * (ROBOT_M + FAR_M));
        self.has_room(at_m, FAR_M) && self.others.iter().all(|(other, _)| apart(other))
    }

    /// Predicts if the command ends at rest without a collision, with room for all bases to turn.
    fn is_clear(&self, base: &Base, mut order: FrameCommand) -> bool {
        let mut base = base.on_even_floor();
        let mut others = self.others.clone();
        while !order.is_finished(&base)
            || others
                .iter()
                .any(|(other, order)| !order.is_finished(other))
        {
            order.step(&mut base);
            for (other, order) in &mut others {
                order.step(other);
            }
            let at_m = base.pose().position_m;
            let apart =
                |other: &Base| are_apart(at_m, other.pose().position_m, 2.0 * ROBOT_M + CLEAR_M);
            if !(self.has_room(at_m, CLEAR_M) && others.iter().all(|(other, _)| apart(other))) {
                return false;
            }
        }
        self.pivots(&base).any(|own_m| {
            let apart =
                |pivot_m| are_apart(own_m, pivot_m, 2.0 * (ROBOT_M + HALF_TRACK_M) + CLEAR_M);
            others
                .iter()
                .all(|(other, _)| self.pivots(other).any(apart))
        })
    }

    /// Wheel positions, m, about which a base at rest can turn without meeting a wall or an object.
    fn pivots(&self, base: &Base) -> impl Iterator<Item = [f64; 2]> {
        let wheels_m =
            [HALF_TRACK_M, -HALF_TRACK_M].map(|left_m| base.pose().point_m([0.0, left_m]));
        let room = |wheel_m: &[f64; 2]| self.has_room(*wheel_m, HALF_TRACK_M + CLEAR_M);
        wheels_m.into_iter().filter(room)
    }

    /// True if a robot within `by_m` of this position meets no wall and no object.
    fn has_room(&self, at_m: [f64; 2], by_m: f64) -> bool {
        at_m.iter().all(|m| m.abs() <= HALF_SIDE_M - ROBOT_M - by_m)
            && self
                .objects_m
                .iter()
                .all(|object_m| are_apart(at_m, *object_m, BASE_M + OBJECT_M + by_m))
    }
}

pub(super) fn are_apart(a_m: [f64; 2], b_m: [f64; 2], by_m: f64) -> bool {
    let [dx, dy] = [a_m[0] - b_m[0], a_m[1] - b_m[1]];
    dx * dx + dy * dy >= by_m * by_m
}
