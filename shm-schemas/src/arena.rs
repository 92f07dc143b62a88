//! What the host of the swarm's fields knows and no agent senses: the onlooker's view.
//!
//! Lengths are the field's own, px of the paper's 800 × 800 (III.b.3); headings are 1/64 turns; times are frames.

use crate::capacity::{AGENTS, GOALS, OBSTACLES, TEAM};
use crate::payload::payload;
use crate::stamp::Stamp;
use crate::text::Text;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

payload! {
    /// One agent in one frame: where it is, what it senses there, and what it does about it.
    AgentTruth as "atas.AgentTruth.v1" {
        /// Its centre, to the right of the field's and above it, px.
        pub position_px: [f32; 2],
        /// Where it looks, counter-clockwise from +x, 1/64 turns.
        pub heading_steps: u32,
        /// The table row that its sensors select here: bit 0 is S1, bit 4 is S5.
        pub row: u32,
        /// What it does in this frame, its table's output bits: L1 bit 0, L2 bit 1, R1 bit 2, R2 bit 3. It stands still (0) where
        /// nothing was answered and when a trial is over.
        pub output: u32,
        /// 1 if it pressed against the object in the frame before.
        pub touches: u32,
    }
}

payload! {
    /// One field: an object, a goal, and how well the object is on its way.
    FieldTruth as "atas.FieldTruth.v1" {
        /// Centre of the object, px.
        pub object_px: [f32; 2],
        /// Centre of the goal, px.
        pub goal_px: [f32; 2],
        /// From the object to the goal, px.
        pub distance_px: f32,
        /// E1 (Eq. 2) of that distance, points.
        pub e1_points: f32,
        /// E2 (Eq. 3), points; 0 before the object was within the goal's radius.
        pub e2_points: f32,
        /// What the trial is worth by the field's rule, points of 100; 0 before it is over.
        pub points: f32,
        /// The first frame, from 1, after which the object was within the goal's radius; 0 before.
        pub reached_frame: u32,
        /// 1 once the trial is over and the object was carried to its goal.
        pub solved: u32,
    }
}

payload! {
    /// What a trial that is over came to, on field 0.
    TrialTruth as "atas.TrialTruth.v1" {
        /// Index of the trial.
        pub trial: u32,
        /// Its goal, 1 to 8; 0 in a place that holds no trial yet.
        pub goal: u32,
        /// From the object to the goal in the end, px.
        pub distance_px: f32,
        /// The first frame, from 1, after which the object was within the goal's radius; 0 if it never was.
        pub reached_frame: u32,
        /// What it is worth by the field's rule, points of 100.
        pub points: f32,
        /// Fields, of all side by side, whose object was carried to its goal.
        pub solved_fields: u32,
        /// Frames in which the agents stood still because no answer came in time.
        pub missed_frames: u32,
        /// Frames in which they stood still because the answer was malformed.
        pub refused_frames: u32,
    }
}

payload! {
    /// A straight wall inside a field.
    WallTruth as "atas.WallTruth.v1" {
        /// Where it begins, px.
        pub from_px: [f32; 2],
        /// Where it ends, px.
        pub to_px: [f32; 2],
    }
}

payload! {
    /// A round post inside a field.
    PostTruth as "atas.PostTruth.v1" {
        /// Its centre, px.
        pub at_px: [f32; 2],
        /// Its radius, px.
        pub radius_px: f32,
    }
}

payload! {
    /// The true state of the swarm's fields in one frame.
    ArenaTruth as "atas.ArenaTruth.v2" {
        /// `captured_ns` is the frame's time, as in the agents' sensors.
        pub stamp: Stamp,
        /// Index of the frame within the trial; as many as a trial has when it is over.
        pub frame: u64,
        /// Names the field's numbers, as in the agents' sensors.
        pub field_hash: u64,
        /// First 8 bytes of the hash of the table that is looked up in this frame; 0 if nothing was answered.
        pub table_hash: u64,
        /// Index of the trial (goal position).
        pub trial: u32,
        /// Trials of the session.
        pub trial_count: u32,
        /// Goal of the trial on field 0, 1 to 8, counter-clockwise from +x.
        pub goal: u32,
        /// Frames of the task execution time (paper III.b.3).
        pub execution_frames: u32,
        /// Frames of a trial: the execution time and the evaluation time after it.
        pub trial_frames: u32,
        /// 1 if the agents were told what to do in this frame.
        pub is_driven: u32,
        /// Agents that carry data, at most [`AGENTS`]: those of field 0 first.
        pub agent_count: u32,
        /// Fields that carry data, at most [`AGENTS`].
        pub field_count: u32,
        /// Agents on each field.
        pub team: u32,
        /// Angle of the side IR sensors to straight ahead, 1/64 turns.
        pub ir_angle_steps: u32,
        /// Angle of the photo sensors' axes to straight ahead, 1/64 turns.
        pub photo_angle_steps: u32,
        /// Cosine of half a photo sensor's opening angle: 0 sees a half-plane, towards 1 sees a ray.
        pub photo_half_angle_cosine: f32,
        /// Half the side of a field: its border, px.
        pub half_side_px: f32,
        /// Radius of an agent, px.
        pub agent_radius_px: f32,
        /// Radius of an object, px.
        pub object_radius_px: f32,
        /// An object has arrived when its centre is this close to the goal's, px.
        pub goal_radius_px: f32,
        /// Reach of an IR sensor from the agent's centre, px.
        pub ir_range_px: f32,
        /// Distance within which the object's light is seen, px.
        pub object_light_px: f32,
        /// Distance within which the goal's light is seen, px.
        pub goal_light_px: f32,
        /// Friction of the object over the force at which one agent stalls; 0 in a field whose `yielding` was fitted.
        pub friction_stall_forces: f32,
        /// The part of an overlap by which one, two, three and four agents move the object.
        pub yielding: [f32; TEAM],
        /// Walls that carry data, at most [`OBSTACLES`].
        pub wall_count: u32,
        /// Posts that carry data, at most [`OBSTACLES`].
        pub post_count: u32,
        /// The walls inside every field.
        pub walls: [WallTruth; OBSTACLES],
        /// The posts inside every field.
        pub posts: [PostTruth; OBSTACLES],
        /// How the field's preset is called.
        pub preset: Text<32>,
        /// The newest trials that are over, that of index t in place t modulo 8.
        pub trials: [TrialTruth; GOALS],
        /// The fields.
        pub fields: [FieldTruth; AGENTS],
        /// The agents.
        pub agents: [AgentTruth; AGENTS],
    }
}
