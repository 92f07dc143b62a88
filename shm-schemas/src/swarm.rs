//! The swarm: what the agents of methodology 2 sense and what they do (paper III).

use crate::capacity::AGENTS;
use crate::payload::payload;
use crate::stamp::Stamp;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

payload! {
    /// What every agent senses at the start of one field frame.
    AgentSensors as "atas.AgentSensors.v2" {
        /// `captured_ns` is the frame's time.
        pub stamp: Stamp,
        /// Index of the field frame within the trial.
        pub frame: u64,
        /// Index of the trial (goal position).
        pub trial: u32,
        /// Agents that carry data, at most [`AGENTS`].
        pub agent_count: u32,
        /// Names the field's numbers, so that agents can refuse a field that their tables were not evolved for.
        pub field_hash: u64,
        /// Per agent the table row that its sensors select: bit 0 is S1, bit 4 is S5.
        pub row: [u32; AGENTS],
    }
}

payload! {
    /// What every agent does in that field frame.
    WheelCommands as "atas.WheelCommands.v1" {
        /// `captured_ns` is copied from the sensors that it answers.
        pub stamp: Stamp,
        /// The field frame that it answers.
        pub frame: u64,
        /// The trial that it answers.
        pub trial: u32,
        /// Agents that carry data.
        pub agent_count: u32,
        /// First 8 bytes of the hash of the table that was looked up, so that a swap is visible.
        pub table_hash: u64,
        /// Per agent the table's output bits: L1 bit 0, L2 bit 1, R1 bit 2, R2 bit 3.
        pub output: [u32; AGENTS],
    }
}
