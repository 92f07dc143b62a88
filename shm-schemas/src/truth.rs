//! Ground truth of the simulator, for evaluation only. The daemon never opens this service.

use crate::capacity::{FINGERS, HANDS};
use crate::payload::payload;
use crate::stamp::Stamp;
use crate::text::Text;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

payload! {
    /// Ground truth of one simulated object.
    ObjectTruth as "atas.ObjectTruth.v5" {
        /// Object name, as in its data file.
        pub name: Text<32>,
        /// Centre of its shape, base frame, m.
        pub position_m: [f64; 3],
        /// Orientation, base frame, quaternion w, x, y, z.
        pub orientation: [f64; 4],
        /// Height of the centre above its initial rest height, m.
        pub lifted_m: f64,
        /// Tilt of the upright axis, rad.
        pub tilt_rad: f64,
        /// Minimum force per grasp side to carry the object, m·g / (2·μ), N.
        pub needed_n: f64,
        /// Force at which the object is crushed, N; infinite if never.
        pub crush_n: f64,
        /// Largest force applied so far, N.
        pub max_force_n: f64,
        /// Sum of the support forces of the table or another base, N.
        pub table_n: f64,
        /// Simulated time of the first landing after the last lift, ns; 0 if never.
        pub landed_ns: u64,
        /// Simulated time at which the support first carries the object after that landing, ns; 0
        /// if never. The threshold is the larger of 0.2 N and a tenth of its weight, so a grazing
        /// corner does not count.
        pub carried_ns: u64,
        /// Simulated time at which the last fingertip released the object after the last lift, ns;
        /// 0 if never. It is the first release after landing, else the most recent one.
        pub released_ns: u64,
        /// Clearance under the object at that moment, m.
        pub released_above_m: f64,
        /// Largest excess of the support force over the weight from that landing until the release,
        /// N, low-passed with 10 ms against impacts: the hand presses the object onto its support.
        pub pressed_down_n: f64,
        /// Largest slip along the fingertips in any hold so far, m. Measured while the support does
        /// not carry the whole weight.
        pub slip_in_hand_m: f64,
        /// Largest rotation in any of these holds, rad.
        pub turn_in_hand_rad: f64,
        /// Horizontal distance from the initial position, m.
        pub displaced_m: f64,
        /// Rotation of a cap since thread engagement, rad, positive closing. This and the following
        /// cap fields are 0 for other objects.
        pub cap_angle_rad: f64,
        /// Angle at which the cap is closed, rad.
        pub cap_closing_rad: f64,
        /// Thread friction torque before the cap closes, N·m.
        pub cap_friction_n_m: f64,
        /// Present torque on the thread, N·m.
        pub cap_torque_n_m: f64,
        /// Torque needed to turn the cap further (tightness), N·m.
        pub cap_holding_n_m: f64,
        /// 1 while the cap is on the neck and its thread is engaged.
        pub cap_engaged: u32,
        /// 1 while the thread is engaged and turned to the closing angle or beyond.
        pub cap_closed: u32,
        /// 1 while the object stands unsupported by a hand, within 5° of upright and 10 mm of its
        /// initial position.
        pub stands: u32,
        /// 1 while a fingertip presses the object.
        pub pressed: u32,
        /// 1 once crushed.
        pub crushed: u32,
        /// 1 once dropped: fallen out of the hand after a lift.
        pub dropped: u32,
        /// 1 once tipped over.
        pub tipped: u32,
        /// 1 once spilt: a bottle tilted while it was not closed.
        pub spilt: u32,
    }
}

payload! {
    /// Ground truth of the simulated world.
    WorldTruth as "atas.WorldTruth.v5" {
        /// `captured_ns` is the simulated time.
        pub stamp: Stamp,
        /// Milliseconds of real time skipped so far because the simulator was late; 0 in lock-step.
        pub missed_ticks: u64,
        /// Number of used entries in `objects`.
        pub object_count: u32,
        /// Commands rejected or expired so far.
        pub expired_commands: u32,
        /// Objects.
        pub objects: [ObjectTruth; 4],
        /// Sliding distance of each fingertip on the touched surface since its first contact, m.
        pub slip_m: [[f64; FINGERS]; HANDS],
        /// Normal force of each fingertip, N.
        pub normal_n: [[f64; FINGERS]; HANDS],
    }
}
