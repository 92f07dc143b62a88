//! The guard beneath a table: whatever a base is told, it keeps clear of walls, objects and other bases.
//!
//! ```text
//!  told levels ─▶ foreseen: a frame with them, then braking ─▶ clear all the way, and room to turn where it stands? ─▶ obeyed
//!                                                               └─ no ─▶ a turn about one wheel ─ no ─▶ brakes on
//! ```
//!
//! As mobile robots' protective fields, and no longer than it must be: a frame, and what braking takes. A base cannot drive back,
//! so where it comes to stand it must also have room to turn about one of its wheels.
//!
//! * **In:** bases with their orders, and what stands on the floor. **Out:** the order that a base may have.
//! * **Invariants:** every base can brake at any time without meeting anything, because each order was seen to end so, beside
//!   those of the others (robots tell each other theirs). Where nothing is clear, the order before, which has run out, brakes.
//! * **Absent on purpose:** floor and noise: a base does what is foreseen to the bit, [`CLEAR_M`] is for those that do not.

use field::Wheels;

use super::FRAME_STEPS;
use super::base::{Base, HALF_TRACK_M, Pace};
use super::layout::{BASE_M, HALF_SIDE_M, OBJECT_M, ROBOT_M};

/// What is kept between a base and everything else, m.
const CLEAR_M: f64 = 0.01;
/// Beyond this nothing can be met before a base stands and turns, m: a frame and braking gently from full speed 0.18, a turn 0.30.
const FAR_M: f64 = 0.5;

/// What a base was told: these levels at this pace for so many more steps, then braking.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Order {
    wheels: Wheels,
    pace: Pace,
    steps_left: u64,
}

impl Order {
    /// An order for a frame that begins.
    pub(super) fn for_a_frame(wheels: Wheels, pace: Pace) -> Self {
        Self {
            wheels,
            pace,
            steps_left: FRAME_STEPS,
        }
    }

    /// Lets a base do a step of it.
    pub(super) fn step(&mut self, base: &mut Base) {
        let obeyed = self.steps_left > 0;
        self.steps_left = self.steps_left.saturating_sub(1);
        let wheels = if obeyed { self.wheels } else { Wheels::STOP };
        base.step(wheels, self.pace);
    }

    /// Brakes from now on.
    pub(super) fn stop(&mut self) {
        self.steps_left = 0;
    }

    /// Whether a base with this order stays where it is.
    fn ends(&self, base: &Base) -> bool {
        self.steps_left == 0 && base.stands()
    }
}

/// What a base must keep clear of.
pub(super) struct Surroundings {
    /// The others, with what they were told.
    pub(super) others: Vec<(Base, Order)>,
    /// Where objects stand on the floor, m.
    pub(super) objects_m: Vec<[f64; 2]>,
}

impl Surroundings {
    /// The order that a base may have, of those that it was told and turns about a wheel; `None` if nothing is clear.
    pub(super) fn allow(&self, base: &Base, wheels: Wheels, pace: Pace) -> Option<Order> {
        let told = Order::for_a_frame(wheels, pace);
        if self.is_far(base) {
            return Some(told);
        }
        let turn = |left, right| Order::for_a_frame(Wheels { left, right }, pace);
        let turns = match wheels.left > wheels.right {
            true => [turn(2, 0), turn(0, 2)],
            false => [turn(0, 2), turn(2, 0)],
        };
        let orders = [told, turns[0], turns[1]];
        orders.into_iter().find(|order| self.clears(base, *order))
    }

    /// Whether everything is too far to matter.
    fn is_far(&self, base: &Base) -> bool {
        let at_m = base.place().at_m;
        let apart = |other: &Base| apart(at_m, other.place().at_m, 2.0 * (ROBOT_M + FAR_M));
        self.has_room(at_m, FAR_M) && self.others.iter().all(|(other, _)| apart(other))
    }

    /// Whether a base that does this meets nothing until it stands, and it and the others can turn there.
    fn clears(&self, base: &Base, mut order: Order) -> bool {
        let mut base = base.on_even_floor();
        let mut others = self.others.clone();
        while !order.ends(&base) || others.iter().any(|(other, order)| !order.ends(other)) {
            order.step(&mut base);
            for (other, order) in &mut others {
                order.step(other);
            }
            let at_m = base.place().at_m;
            let apart = |other: &Base| apart(at_m, other.place().at_m, 2.0 * ROBOT_M + CLEAR_M);
            if !(self.has_room(at_m, CLEAR_M) && others.iter().all(|(other, _)| apart(other))) {
                return false;
            }
        }
        self.pivots(&base).any(|own_m| {
            let apart = |pivot_m| apart(own_m, pivot_m, 2.0 * (ROBOT_M + HALF_TRACK_M) + CLEAR_M);
            others
                .iter()
                .all(|(other, _)| self.pivots(other).any(apart))
        })
    }

    /// Those wheels of a base that stands about which it can turn, as far as the field and objects go, m.
    fn pivots(&self, base: &Base) -> impl Iterator<Item = [f64; 2]> {
        let wheels_m =
            [HALF_TRACK_M, -HALF_TRACK_M].map(|left_m| base.place().point_m([0.0, left_m]));
        let room = |wheel_m: &[f64; 2]| self.has_room(*wheel_m, HALF_TRACK_M + CLEAR_M);
        wheels_m.into_iter().filter(room)
    }

    /// Whether a robot that is nowhere farther than `by_m` from here meets neither a wall nor an object.
    fn has_room(&self, at_m: [f64; 2], by_m: f64) -> bool {
        at_m.iter().all(|m| m.abs() <= HALF_SIDE_M - ROBOT_M - by_m)
            && self
                .objects_m
                .iter()
                .all(|object_m| apart(at_m, *object_m, BASE_M + OBJECT_M + by_m))
    }
}

/// Whether two points are at least so far apart, m.
pub(super) fn apart(a_m: [f64; 2], b_m: [f64; 2], by_m: f64) -> bool {
    let [dx, dy] = [a_m[0] - b_m[0], a_m[1] - b_m[1]];
    dx * dx + dy * dy >= by_m * by_m
}
