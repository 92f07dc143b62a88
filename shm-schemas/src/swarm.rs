//! Sensor rows and wheel commands of the swarm agents (paper III).

use crate::capacity::AGENTS;
use crate::payload::payload;
use crate::stamp::Stamp;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

payload! {
    /// Sensor rows of all agents at the start of one field frame.
    AgentSensors as "atas.AgentSensors.v2" {
        /// `captured_ns` is the time of the frame.
        pub stamp: Stamp,
        /// Index of the field frame within the trial.
        pub frame: u64,
        /// Index of the trial (goal position).
        pub trial: u32,
        /// Number of used entries in `row`, at most [`AGENTS`].
        pub agent_count: u32,
        /// Hash of the field parameters. Agents reject a field for which their tables were not
        /// evolved.
        pub field_hash: u64,
        /// Per agent: table row selected by the sensors; bit 0 is S1, bit 4 is S5.
        pub row: [u32; AGENTS],
    }
}

payload! {
    /// Wheel commands of all agents for one field frame.
    WheelCommands as "atas.WheelCommands.v1" {
        /// `captured_ns` is copied from the sensors that this command answers.
        pub stamp: Stamp,
        /// Field frame that this command answers.
        pub frame: u64,
        /// Trial that this command answers.
        pub trial: u32,
        /// Number of used entries in `output`.
        pub agent_count: u32,
        /// First 8 bytes of the hash of the behaviour table in use; a change shows a table swap.
        pub table_hash: u64,
        /// Per agent: output bits of the table; L1 bit 0, L2 bit 1, R1 bit 2, R2 bit 3.
        pub output: [u32; AGENTS],
    }
}
