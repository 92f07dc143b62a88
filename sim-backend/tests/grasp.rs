//! The world under a scripted squeeze and lift.

mod common;

use common::Script;
use robot_model::Side;
use sim_backend::{Object, Scene};

#[test]
fn probe() {
    for name in Object::names() {
        let object = Object::built_in(name).unwrap();
        for factor in [0.8, 1.3] {
            let need = object.needed_n();
            let mut s = Script::around(Scene::grasp(object.clone(), Side::Right), Side::Right, 1);
            let t0 = std::time::Instant::now();
            s.close_to(need * factor);
            let f0 = s.normal_n();
            s.lift(0.03);
            s.ticks(500, |_| ());
            let t = s.world.truth();
            let o = &t.objects[0];
            let n = s.world.tick();
            println!(
                "{name:18} x{factor} need {need:.2} F {f0:.2} -> {:.2} lifted {:.2} mm tilt {:.4} slip {:.3} {:.3} mm crushed {} dropped {} max {:.2} ticks {n} {:.1} us/tick fault {:?}",
                s.normal_n(),
                o.lifted_m * 1e3,
                o.tilt_rad,
                t.slip_m[1][0] * 1e3,
                t.slip_m[1][1] * 1e3,
                o.crushed,
                o.dropped,
                o.max_force_n,
                t0.elapsed().as_secs_f64() * 1e6 / n as f64,
                s.world.fault()
            );
        }
    }
}
