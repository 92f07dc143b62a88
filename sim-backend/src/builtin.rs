//! Built-in physics: contact, drives and objects in four substeps per tick.

use robot_model::HandVector;
use shm_schemas::JointSetpoints;
use shm_schemas::capacity::JOINTS;

use crate::base_motion::BaseMotion;
use crate::clock::{SUBSTEP_S, SUBSTEPS, TICK_S};
use crate::hand::Hand;
use crate::sensed_hand::SensedHand;
use crate::support::{Ground, Plate};
use crate::threaded_cap::ThreadedCap;
use crate::world_object::WorldObject;

#[derive(Clone, Debug)]
pub(crate) struct BuiltIn {
    pub(crate) hands: [Hand; 2],
    pub(crate) threaded_cap: Option<ThreadedCap>,
}

impl BuiltIn {
    /// Simulates one tick towards the set-points.
    pub(crate) fn simulate(
        &mut self,
        orders: &JointSetpoints,
        objects: &mut [WorldObject],
        plates: &[Plate],
        ride: &mut BaseMotion,
    ) {
        let [left, right] = self
            .hands
            .each_ref()
            .map(|hand| hand.model().joints().len());
        let per_hand = |values: &[f64; JOINTS]| {
            [0..left, left..left + right].map(|range| HandVector::from_slice(&values[range]))
        };
        let (target, feed_forward_rad_s) = (per_hand(&orders.position), per_hand(&orders.velocity));
        for hand in &mut self.hands {
            hand.begin_tick(objects, TICK_S);
        }
        for substep in 0..SUBSTEPS {
            for hand in &mut self.hands {
                hand.compute_contacts(objects, SUBSTEP_S);
            }
            for (index, hand) in self.hands.iter_mut().enumerate() {
                hand.step(
                    &target[index],
                    &feed_forward_rad_s[index],
                    SUBSTEPS - substep,
                    SUBSTEP_S,
                );
            }
            self.move_objects(objects, plates, ride);
        }
    }

    /// Simulates one substep of threaded cap, objects and base motion.
    fn move_objects(
        &mut self,
        objects: &mut [WorldObject],
        plates: &[Plate],
        ride: &mut BaseMotion,
    ) {
        if let Some(closure) = &mut self.threaded_cap {
            closure.apply_load(objects, SUBSTEP_S);
        }
        for index in 0..objects.len() {
            let closure = self.threaded_cap.as_ref();
            if closure.is_some_and(|closure| closure.constrains(index)) {
                continue;
            }
            let rim = closure.and_then(|closure| closure.rim_for(index, objects));
            let ride = *ride;
            objects[index].step(&Ground { plates, rim, ride }, SUBSTEP_S);
        }
        ride.integrate(SUBSTEP_S);
        if let Some(closure) = &mut self.threaded_cap {
            closure.update(objects, SUBSTEP_S);
        }
    }
}
