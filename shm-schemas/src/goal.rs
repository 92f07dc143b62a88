//! Goals: what a client asks for, and what it hears back.

use crate::capacity::FINGERS;
use crate::code::code;
use crate::payload::payload;
use crate::reason::Reason;
use crate::stamp::{Hand, Stamp};
use crate::text::Text;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

code! {
    /// Which task.
    GoalKind as "atas.GoalKind.v1" {
        /// Grasp, lift and hold the object at `from_m` (paper II.b (1)).
        GRASP = 1, "grasp";
        /// Grasp at `from_m`, set down at `to_m` (paper II.b (3)).
        PICK_PLACE = 2, "pick-place";
        /// Screw the cap at `from_m` (paper II.b (2)).
        SCREW = 3, "screw";
        /// Cap from `from_m` onto the bottle at `to_m`, with both hands (paper II.c).
        ASSEMBLE = 4, "assemble";
        /// Open the hand where it is and move it home.
        RELEASE = 5, "release";
        /// A user's own task, by [`GoalRequest::task`].
        CUSTOM = 6, "custom";
        /// The acting hand follows the targets that this goal's client streams ([`crate::GraspTarget`]).
        FOLLOW = 7, "follow";
        /// Both hands do.
        FOLLOW_BOTH = 8, "follow-both";
    }
}

code! {
    /// What happens to a goal when its client goes away.
    GoalPolicy as "atas.GoalPolicy.v1" {
        /// The goal goes on to its end.
        DETACHED = 0, "detached";
        /// The goal is held: HOLD within 100 ticks.
        ATTACHED = 1, "attached";
    }
}

code! {
    /// Which way a cap is turned, seen from above.
    Turn as "atas.Turn.v1" {
        /// Closes a standard right-hand thread.
        CLOCKWISE = 0, "clockwise";
        /// Closes a left-hand thread, opens a right-hand one.
        ANTICLOCKWISE = 1, "anticlockwise";
    }
}

impl Turn {
    /// Sign of the turn about the upward axis: 1 anticlockwise, −1 clockwise.
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
    /// Where a goal stands.
    GoalState as "atas.GoalState.v1" {
        /// Checked and queued for the next tick.
        ACCEPTED = 1, "accepted";
        /// Refused before anything moved; `reason` says why.
        REJECTED = 2, "rejected";
        /// In progress.
        RUNNING = 3, "running";
        /// Done as asked.
        SUCCEEDED = 4, "succeeded";
        /// The robot refused the object while trying, and backed out safely (for example: too heavy for the hand).
        REFUSED = 5, "refused";
        /// Ended without success; `reason` says why.
        FAILED = 6, "failed";
        /// Ended by the client.
        CANCELLED = 7, "cancelled";
    }
}

impl GoalKind {
    /// Whether its client leads the hand by a stream of targets.
    #[must_use]
    pub fn is_stream(self) -> bool {
        matches!(self, Self::FOLLOW | Self::FOLLOW_BOTH)
    }
}

impl GoalState {
    /// Whether no further update follows.
    #[must_use]
    pub fn is_final(self) -> bool {
        !matches!(self, Self::ACCEPTED | Self::RUNNING)
    }
}

payload! {
    /// One goal. Frame: base of the robot (x forward, y left, z up, origin on the table top under the torso).
    GoalRequest as "atas.GoalRequest.v3" {
        /// `captured_ns` is when the client sent it.
        pub stamp: Stamp,
        /// Chosen by the client; repeated in every update.
        pub goal_id: u64,
        /// Which task.
        pub kind: GoalKind,
        /// Which hand acts; for assembly, which hand screws.
        pub hand: Hand,
        /// What happens when the client goes away.
        pub policy: GoalPolicy,
        /// Which way to turn a cap; not used by GRASP and PICK_PLACE.
        pub turn: Turn,
        /// Where the fingertips shall close, m. The true object may be off by some millimetres.
        pub from_m: [f64; 3],
        /// Direction of the closing axis at `from_m`, from finger 2's side to finger 1's, rad from +x towards +y.
        pub from_yaw_rad: f64,
        /// Where the object shall stand afterwards, m; not used by GRASP.
        pub to_m: [f64; 3],
        /// Direction of the closing axis at `to_m`, rad; not used by GRASP.
        pub to_yaw_rad: f64,
        /// Expected width of the object along the closing axis, m. The hand opens a little wider.
        pub width_m: f64,
        /// How far to lift, m.
        pub lift_m: f64,
        /// How long to hold the lifted object before the goal counts as reached, s.
        pub hold_s: f64,
        /// Expected width of what the other hand holds, m; only used by ASSEMBLE: the bottle's.
        pub helper_width_m: f64,
        /// How far the object reaches above where the fingertips close, m: the hand comes from above that. Zero if unknown.
        pub top_m: f64,
        /// What one side of the hand may press the object with at most, N: F_2, instead of what its stiffness allows. Zero if
        /// unknown.
        pub max_force_n: f64,
        /// Name of the task for `CUSTOM`.
        pub task: Text<32>,
    }
}

impl GoalRequest {
    /// Names of [`GoalRequest::values`], in order; a [`Reason`] about a goal refers to them by index.
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

    /// Every number of the goal, in the order of [`GoalRequest::VALUE_NAMES`], SI units.
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
    /// What the hand learnt about the object, SI units, zero where not (yet) known.
    GraspFigures as "atas.GraspFigures.v1" {
        /// Normal force per finger, N.
        pub normal_n: [f32; FINGERS],
        /// Tangential force per finger, N.
        pub tangential_n: [f32; FINGERS],
        /// F_1, the minimum grasping force, N.
        pub f1_n: f32,
        /// F_2, the maximum grasping force, N.
        pub f2_n: f32,
        /// Object stiffness from the stiffness probe, N/m.
        pub stiffness_n_m: f32,
        /// How far the stiffness may be trusted, 0 to 1.
        pub stiffness_confidence: f32,
        /// Estimated friction coefficient, the lowest of the fingers.
        pub friction: f32,
        /// How far the hand has lifted the object, m.
        pub lifted_m: f32,
    }
}

payload! {
    /// One step of a goal's story.
    GoalUpdate as "atas.GoalUpdate.v1" {
        /// `captured_ns` is the tick's time.
        pub stamp: Stamp,
        /// Echo of [`GoalRequest::goal_id`].
        pub goal_id: u64,
        /// Tick of this update.
        pub tick: u64,
        /// Where the goal stands.
        pub state: GoalState,
        /// Fraction done, 0 to 1.
        pub progress: f32,
        /// Why, when rejected, refused, failed or held.
        pub reason: Reason,
        /// Name of the task's step, for example `lift`; of a goal that names an unknown task, that name.
        pub step: Text<16>,
        /// What the hand learnt so far.
        pub figures: GraspFigures,
    }
}
