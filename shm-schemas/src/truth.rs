//! What the simulator knows and the robot does not: the judge's view. The daemon never opens this service.

use crate::capacity::{FINGERS, HANDS};
use crate::payload::payload;
use crate::stamp::Stamp;
use crate::text::Text;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

payload! {
    /// The true state of one simulated object.
    ObjectTruth as "atas.ObjectTruth.v4" {
        /// Name of the object, as in its data file.
        pub name: Text<32>,
        /// Middle of its shape, base frame, m.
        pub position_m: [f64; 3],
        /// Orientation, base frame, quaternion w, x, y, z.
        pub orientation: [f64; 4],
        /// How far its middle is above where it rested at the start, m.
        pub lifted_m: f64,
        /// Tilt of its upright axis, rad.
        pub tilt_rad: f64,
        /// Force each finger must press with to carry it, m·g / (2·μ), N.
        pub needed_n: f64,
        /// Force at which it crushes, N; infinite if it does not.
        pub crush_n: f64,
        /// Largest force it has felt, N.
        pub max_force_n: f64,
        /// Sum of the forces of the table, or of what else it stands on, N.
        pub table_n: f64,
        /// When it first stood again after it had been lifted last, simulated time, ns; 0 if never.
        pub landed_ns: u64,
        /// When what it stands on first truly carried it after that: with 0.2 N or a tenth of its weight, whichever is more, where a
        /// first corner that grazes carries less; simulated time, ns; 0 if never.
        pub carried_ns: u64,
        /// When the last fingertip let go of it after it had been lifted last: for the first time after it landed, else most
        /// recently; simulated time, ns; 0 if never.
        pub released_ns: u64,
        /// Its height above what was under it at that moment, m.
        pub released_above_m: f64,
        /// Greatest slip along the fingertips in any hold of a hand so far, while its support did not carry all of it, m.
        pub slip_in_hand_m: f64,
        /// Greatest turn in any of these holds, rad.
        pub turn_in_hand_rad: f64,
        /// How far it is from where it stood at the start, over the table, m.
        pub displaced_m: f64,
        /// How far a cap has been turned since the threads met, rad, positive closing. This and the following are 0 for
        /// other objects.
        pub cap_angle_rad: f64,
        /// Angle at which a cap is closed, rad.
        pub cap_closing_rad: f64,
        /// Friction torque of a cap's thread before it closes, N·m.
        pub cap_friction_n_m: f64,
        /// Torque on a cap's thread now, N·m.
        pub cap_torque_n_m: f64,
        /// Torque that it takes to turn a cap any further, N·m: how tight it is.
        pub cap_holding_n_m: f64,
        /// 1 while a cap is on the neck and its thread engaged.
        pub cap_engaged: u32,
        /// 1 while it is engaged and turned to its closing angle or beyond.
        pub cap_closed: u32,
        /// 1 while it stands by itself, upright within 5° and within 10 mm of where it stood at the start.
        pub stands: u32,
        /// 1 while a fingertip presses it.
        pub pressed: u32,
        /// 1 once crushed.
        pub crushed: u32,
        /// 1 once dropped: it fell out of the hand after it had been lifted.
        pub dropped: u32,
        /// 1 once it tipped over.
        pub tipped: u32,
        /// 1 once spilt: a bottle that tilted while it was not closed.
        pub spilt: u32,
    }
}

payload! {
    /// The true state of the simulated world.
    WorldTruth as "atas.WorldTruth.v4" {
        /// `captured_ns` is the simulated time.
        pub stamp: Stamp,
        /// Milliseconds of the machine's clock that were skipped so far because the simulator came late; 0 in lock-step.
        pub missed_ticks: u64,
        /// Objects that carry data.
        pub object_count: u32,
        /// Commands refused or expired so far.
        pub expired_commands: u32,
        /// The objects.
        pub objects: [ObjectTruth; 4],
        /// True sliding distance of each fingertip on what it touches since its first touch, m.
        pub slip_m: [[f64; FINGERS]; HANDS],
        /// True normal force of each fingertip, N.
        pub normal_n: [[f64; FINGERS]; HANDS],
    }
}
