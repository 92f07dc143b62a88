//! Ground truth of the swarm fields, published by the field process for observers. Agents do not
//! read it.
//!
//! Lengths are field pixels (px) of the paper's 800 × 800 field (III.b.3), headings are 1/64 turns,
//! times are frames.

use crate::capacity::{AGENTS, GOALS, OBSTACLES, TEAM};
use crate::payload::payload;
use crate::stamp::Stamp;
use crate::text::Text;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

payload! {
    /// Pose, sensor row and output of one agent in one frame.
    AgentTruth as "atas.AgentTruth.v1" {
        /// Centre relative to the field centre, x right and y up, px.
        pub position_px: [f32; 2],
        /// Heading, counter-clockwise from +x, 1/64 turns.
        pub heading_steps: u32,
        /// Table row selected by the sensors: bit 0 is S1, bit 4 is S5.
        pub row: u32,
        /// Output bits of the table in this frame: L1 bit 0, L2 bit 1, R1 bit 2, R2 bit 3. 0
        /// (standing) without a command and after a trial.
        pub output: u32,
        /// 1 if the agent pushed the object in the previous frame.
        pub touches: u32,
    }
}

payload! {
    /// State of one field: object, goal and score.
    FieldTruth as "atas.FieldTruth.v1" {
        /// Centre of the object, px.
        pub object_px: [f32; 2],
        /// Centre of the goal, px.
        pub goal_px: [f32; 2],
        /// Distance from the object to the goal, px.
        pub distance_px: f32,
        /// E1 (Eq. 2) of that distance, points.
        pub e1_points: f32,
        /// E2 (Eq. 3), points; 0 until the object is within the goal radius.
        pub e2_points: f32,
        /// Score of the trial by the rule of the field, of 100 points; 0 until the trial is over.
        pub points: f32,
        /// First frame, from 1, after which the object is within the goal radius; 0 until then.
        pub reached_frame: u32,
        /// 1 once the trial is over and the object has reached its goal.
        pub solved: u32,
    }
}

payload! {
    /// Result of a completed trial on field 0.
    TrialTruth as "atas.TrialTruth.v1" {
        /// Index of the trial.
        pub trial: u32,
        /// Goal of the trial, 1 to 8; 0 in an unused entry.
        pub goal: u32,
        /// Final distance from the object to the goal, px.
        pub distance_px: f32,
        /// First frame, from 1, after which the object was within the goal radius; 0 if never.
        pub reached_frame: u32,
        /// Score by the rule of the field, of 100 points.
        pub points: f32,
        /// Number of parallel fields in which the object reached its goal.
        pub solved_fields: u32,
        /// Frames in which the agents stood still because the command was late.
        pub missed_frames: u32,
        /// Frames in which the agents stood still because the command was malformed.
        pub refused_frames: u32,
    }
}

payload! {
    /// A straight wall inside a field.
    WallTruth as "atas.WallTruth.v1" {
        /// Start point, px.
        pub from_px: [f32; 2],
        /// End point, px.
        pub to_px: [f32; 2],
    }
}

payload! {
    /// A cylindrical post inside a field.
    PostTruth as "atas.PostTruth.v1" {
        /// Centre, px.
        pub at_px: [f32; 2],
        /// Radius, px.
        pub radius_px: f32,
    }
}

payload! {
    /// Ground truth of all fields in one frame.
    ArenaTruth as "atas.ArenaTruth.v2" {
        /// `captured_ns` is the time of the frame, as in [`crate::AgentSensors`].
        pub stamp: Stamp,
        /// Index of the frame within the trial; equals `trial_frames` when the trial is over.
        pub frame: u64,
        /// Hash of the field parameters, as in [`crate::AgentSensors`].
        pub field_hash: u64,
        /// First 8 bytes of the hash of the behaviour table in use; 0 without a command.
        pub table_hash: u64,
        /// Index of the trial (goal position).
        pub trial: u32,
        /// Number of trials in the session.
        pub trial_count: u32,
        /// Goal of the trial on field 0, 1 to 8, counter-clockwise from +x.
        pub goal: u32,
        /// Frames of the task execution time (paper III.b.3).
        pub execution_frames: u32,
        /// Frames of a trial: execution time plus evaluation time.
        pub trial_frames: u32,
        /// 1 if the agents received a command for this frame.
        pub is_driven: u32,
        /// Number of used entries in `agents`, at most [`AGENTS`]; the agents of field 0 come
        /// first.
        pub agent_count: u32,
        /// Number of used entries in `fields`, at most [`AGENTS`].
        pub field_count: u32,
        /// Agents per field.
        pub team: u32,
        /// Angle between the side IR sensors and straight ahead, 1/64 turns.
        pub ir_angle_steps: u32,
        /// Angle between the photo sensor axes and straight ahead, 1/64 turns.
        pub photo_angle_steps: u32,
        /// Cosine of half the opening angle of a photo sensor: 0 for a half-plane, 1 for a ray.
        pub photo_half_angle_cosine: f32,
        /// Half the side length of a field, px.
        pub half_side_px: f32,
        /// Radius of an agent, px.
        pub agent_radius_px: f32,
        /// Radius of an object, px.
        pub object_radius_px: f32,
        /// Largest distance between object and goal centres at which the object counts as
        /// delivered, px.
        pub goal_radius_px: f32,
        /// Range of an IR sensor from the agent centre, px.
        pub ir_range_px: f32,
        /// Distance within which the object light is visible, px.
        pub object_light_px: f32,
        /// Distance within which the goal light is visible, px.
        pub goal_light_px: f32,
        /// Object friction divided by the stall force of one agent; 0 in a field with a fitted
        /// `yielding`.
        pub friction_stall_forces: f32,
        /// Share of an overlap by which one, two, three and four agents move the object.
        pub yielding: [f32; TEAM],
        /// Number of used entries in `walls`, at most [`OBSTACLES`].
        pub wall_count: u32,
        /// Number of used entries in `posts`, at most [`OBSTACLES`].
        pub post_count: u32,
        /// Walls inside every field.
        pub walls: [WallTruth; OBSTACLES],
        /// Posts inside every field.
        pub posts: [PostTruth; OBSTACLES],
        /// Name of the field preset.
        pub preset: Text<32>,
        /// Most recent completed trials; trial t is at index t modulo 8.
        pub trials: [TrialTruth; GOALS],
        /// The fields.
        pub fields: [FieldTruth; AGENTS],
        /// The agents.
        pub agents: [AgentTruth; AGENTS],
    }
}
