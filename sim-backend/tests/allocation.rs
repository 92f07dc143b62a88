//! Simulated ticks do not allocate: in free air or in a grasp, with or without faults and sensor
//! effects.

mod common;

use allocation_counter::measure;
use common::Script;
use robot_model::HandSide;
use sim_backend::faults::FaultPipeline;
use sim_backend::{Errors, Object, Scene, SensorErrors};

#[test]
fn a_tick_allocates_nothing() {
    let part = |name| Object::built_in(name).expect("built-in object");
    let bottle = Scene::grasp(part("bottle"), HandSide::Right);
    let screw = Scene::screw(part("cap"), part("open-bottle"), HandSide::Right);
    // Every effect of the sensor model.
    let sensor = SensorErrors::SIZES;
    let errors = Errors {
        sensor,
        ..Errors::NONE
    };
    let corrupted = bottle.with_errors(&errors, 1);
    [bottle, screw, corrupted]
        .into_iter()
        .for_each(allocates_nothing);
}

fn allocates_nothing(scene: Scene) {
    let mut script = Script::from_nominal_grasp(scene, HandSide::Right, 1);
    let faults = ["drop=0.1@0", "delay=5@0:left", "corrupt=0.1@0"]
        .map(|text| text.parse().expect("valid fault"));
    let (mut injector, mut delivered) = (FaultPipeline::new(&faults, 1), 0);
    // The first draw initialises the noise tables.
    script.tick();
    let cost = measure(|| {
        script.close_to(6.0);
        script.lift(0.0005);
        for _ in 0..100 {
            injector.pass(script.world.tick(), &script.sensed, |_| delivered += 1);
            script.tick();
        }
    });
    assert_eq!(
        cost.count_total,
        0,
        "allocations in {} ticks",
        script.world.tick()
    );
    assert!(
        script.normal_n() > 5.0 && delivered > 100,
        "the ticks had an effect"
    );
}
