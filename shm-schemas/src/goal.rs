//! Goals: requests of clients and the updates that answer them.

use crate::capacity::FINGERS;
use crate::code::code;
use crate::payload::payload;
use crate::reason_record::ReasonRecord;
use crate::stamp::{Hand, Stamp};
use crate::text::Text;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

code! {
    /// Task of a goal.
    GoalKind as "atas.GoalKind.v1" {
        /// Grasps, lifts and holds the object at `from_m` (paper II.b (1)).
        GRASP = 1, "grasp";
        /// Grasps at `from_m` and places at `to_m` (paper II.b (3)).
        PICK_PLACE = 2, "pick-place";
        /// Screws the cap at `from_m` (paper II.b (2)).
        SCREW = 3, "screw";
        /// Takes the cap from `from_m` and screws it onto the bottle at `to_m`, with both hands
        /// (paper II.c).
        ASSEMBLE = 4, "assemble";
        /// Opens the hand in place and moves it home.
        RELEASE = 5, "release";
        /// User-defined task, named by [`GoalRequest::task`].
        CUSTOM = 6, "custom";
        /// Teleoperation: the acting hand tracks the targets streamed by the client
        /// ([`crate::GraspTarget`]).
        TELEOP = 7, "teleop";
        /// Teleoperation of both hands.
        TELEOP_BOTH = 8, "teleop-both";
    }
}

code! {
    /// Reaction to the disconnection of the client.
    GoalPolicy as "atas.GoalPolicy.v1" {
        /// The goal continues.
        DETACHED = 0, "detached";
        /// The robot enters HOLD within 100 ticks.
        ATTACHED = 1, "attached";
    }
}

code! {
    /// Direction in which a cap is turned, seen from above.
    Turn as "atas.Turn.v1" {
        /// Closes a standard right-hand thread.
        CLOCKWISE = 0, "clockwise";
        /// Closes a left-hand thread, opens a right-hand one.
        ANTICLOCKWISE = 1, "anticlockwise";
    }
}

impl Turn {
    /// Returns the sign of the rotation about the upward axis: 1 anticlockwise, −1 clockwise.
    #[must_use]
    pub fn sign(self) -> f64 {
        if self == Self::ANTICLOCKWISE {
            1.0
        } else {
            -1.0
        }
    }
}

code! {
    /// State of a goal.
    GoalState as "atas.GoalState.v1" {
        /// Validated and queued for the next tick.
        ACCEPTED = 1, "accepted";
        /// Rejected before any motion; see `reason`.
        REJECTED = 2, "rejected";
        /// In progress.
        RUNNING = 3, "running";
        /// Completed.
        SUCCEEDED = 4, "succeeded";
        /// Ended by the robot during the attempt because of the object (for example too heavy),
        /// with a safe recovery.
        REFUSED = 5, "refused";
        /// Ended without success; see `reason`.
        FAILED = 6, "failed";
        /// Cancelled by the client.
        CANCELLED = 7, "cancelled";
    }
}

impl GoalKind {
    /// Returns true if the client streams targets (teleoperation).
    #[must_use]
    pub fn is_stream(self) -> bool {
        matches!(self, Self::TELEOP | Self::TELEOP_BOTH)
    }
}

impl GoalState {
    /// Returns true if no further update follows.
    #[must_use]
    pub fn is_final(self) -> bool {
        !matches!(self, Self::ACCEPTED | Self::RUNNING)
    }
}

payload! {
    /// A goal request. All poses are in the robot base frame (x forward, y left, z up, origin on
    /// the table top under the torso).
    GoalRequest as "atas.GoalRequest.v3" {
        /// `captured_ns` is when the client sent it.
        pub stamp: Stamp,
        /// Id chosen by the client; repeated in every update.
        pub goal_id: u64,
        /// Task.
        pub kind: GoalKind,
        /// Acting hand; for assembly, the hand that screws.
        pub hand: Hand,
        /// Reaction to the disconnection of the client.
        pub policy: GoalPolicy,
        /// Direction in which a cap is turned; not used by GRASP and PICK_PLACE.
        pub turn: Turn,
        /// Grasp point, m. The object may be some millimetres off.
        pub from_m: [f64; 3],
        /// Direction of the closing axis at `from_m`, from the side of finger 2 to that of finger
        /// 1, rad from +x towards +y.
        pub from_yaw_rad: f64,
        /// Place position of the object, m; not used by GRASP.
        pub to_m: [f64; 3],
        /// Direction of the closing axis at `to_m`, rad; not used by GRASP.
        pub to_yaw_rad: f64,
        /// Expected object width along the closing axis, m. The hand opens slightly wider.
        pub width_m: f64,
        /// Lift height, m.
        pub lift_m: f64,
        /// Hold time after the lift before the goal succeeds, s.
        pub hold_s: f64,
        /// Expected width of the object in the other hand, m; only used by ASSEMBLE (bottle).
        pub helper_width_m: f64,
        /// Height of the object above the grasp point, m; the hand approaches from above it. Zero
        /// if unknown.
        pub top_m: f64,
        /// Largest force per grasp side, N; it replaces the stiffness-based force limit F_2. Zero
        /// if unknown.
        pub max_force_n: f64,
        /// Task name for `CUSTOM`.
        pub task: Text<32>,
    }
}

impl GoalRequest {
    /// Names of [`GoalRequest::values`], in order. [`crate::GoalField`] is the index of a
    /// name.
    pub const VALUE_NAMES: [&'static str; 14] = [
        "from x",
        "from y",
        "from z",
        "from yaw",
        "to x",
        "to y",
        "to z",
        "to yaw",
        "width",
        "lift",
        "hold",
        "helper width",
        "top",
        "maximum force",
    ];

    /// Returns all numbers of the goal, in the order of [`GoalRequest::VALUE_NAMES`], SI units.
    #[must_use]
    pub fn values(&self) -> [f64; 14] {
        let [from_x, from_y, from_z] = self.from_m;
        let [to_x, to_y, to_z] = self.to_m;
        let (from_yaw, to_yaw) = (self.from_yaw_rad, self.to_yaw_rad);
        [
            from_x,
            from_y,
            from_z,
            from_yaw,
            to_x,
            to_y,
            to_z,
            to_yaw,
            self.width_m,
            self.lift_m,
            self.hold_s,
            self.helper_width_m,
            self.top_m,
            self.max_force_n,
        ]
    }
}

payload! {
    /// Estimates of the grasp and the object, SI units; zero while unknown.
    GraspFigures as "atas.GraspFigures.v1" {
        /// Normal force per fingertip, N.
        pub normal_n: [f32; FINGERS],
        /// Tangential force per fingertip, N.
        pub tangential_n: [f32; FINGERS],
        /// Minimum grip force F_1, N.
        pub f1_n: f32,
        /// Force limit F_2, N.
        pub f2_n: f32,
        /// Object stiffness from the stiffness probe, N/m.
        pub stiffness_n_m: f32,
        /// Confidence of the stiffness, 0 to 1.
        pub stiffness_confidence: f32,
        /// Estimated friction coefficient, lowest of all fingertips.
        pub friction: f32,
        /// Height by which the hand has lifted the object, m.
        pub lifted_m: f32,
    }
}

payload! {
    /// Progress report of a goal.
    GoalUpdate as "atas.GoalUpdate.v1" {
        /// `captured_ns` is the time of the tick.
        pub stamp: Stamp,
        /// Echo of [`GoalRequest::goal_id`].
        pub goal_id: u64,
        /// Tick of this update.
        pub tick: u64,
        /// State of the goal.
        pub state: GoalState,
        /// Fraction done, 0 to 1.
        pub progress: f32,
        /// Reason of a rejection, refusal, failure or hold.
        pub reason: ReasonRecord,
        /// Name of the task step, for example `lift`. If the task is unknown: the requested task
        /// name.
        pub step: Text<16>,
        /// Present estimates of the grasp and the object.
        pub figures: GraspFigures,
    }
}
