//! Controller state between two ticks of a recorded run. A recorder writes it at the start of each
//! continuation file, so that this file can be replayed alone.
//!
//! * **Input:** a [`Controller`] and the sequence number of its next part. **Output:** bytes in
//!   `MessagePack`, and back.
//! * **Invariants:** fields are stored by name, so the state of a controller with other fields is
//!   rejected, not misread. Decoding restores every bit.
//! * **Not included:** files; `atas-recording` stores the bytes.
//!
//! This is a package of its own because the code that serde generates for a controller takes longer
//! to optimise than the whole evaluation. The dev profile optimises it little.

use anyhow::Context;
use atas_core::Controller;
use serde::{Deserialize, Serialize};

#[derive(Serialize)]
struct Saved<'a> {
    version: &'a str,
    next_sequence: u64,
    controller: &'a Controller,
}

#[derive(Deserialize)]
struct SavedVersion<'a> {
    version: &'a str,
}

#[derive(Deserialize)]
struct Decoded {
    next_sequence: u64,
    controller: Controller,
}

/// Encodes the controller and the sequence number of the next part.
///
/// # Errors
/// A value cannot be serialised.
pub fn encode(controller: &Controller, next_sequence: u64) -> anyhow::Result<Vec<u8>> {
    let saved = Saved {
        version: atas_core::VERSION,
        next_sequence,
        controller,
    };
    rmp_serde::to_vec_named(&saved).context("could not save the controller's state")
}

/// Stack of the decoding thread. serde builds the controller on the stack several times over, which
/// exceeds the default stack.
const STACK_BYTES: usize = 64 << 20;

/// Decodes the controller and the sequence number of the next part.
///
/// # Errors
/// The state has another version, or is damaged.
pub fn decode(state: &[u8]) -> anyhow::Result<(Controller, u64)> {
    let made: SavedVersion<'_> = rmp_serde::from_slice(state)
        .context("could not read the controller's state: the recording is damaged")?;
    let ours = atas_core::VERSION;
    anyhow::ensure!(
        made.version == ours,
        "could not read the controller's state: it was recorded by version {}, this is {ours}; \
         replay with that version, or from the first file of the run",
        made.version
    );
    let read = std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK_BYTES);
        let read = || rmp_serde::from_slice::<Box<Decoded>>(state);
        let read = thread.spawn_scoped(scope, read)?.join();
        read.map_err(|_| {
            anyhow::anyhow!("could not read the controller's state: the reader panicked")
        })
    })?;
    let read = read.context(
        "could not read the controller's state: another controller recorded it; replay with the \
         version that recorded it, or from the first file of the run",
    )?;
    Ok((read.controller, read.next_sequence))
}

#[cfg(test)]
mod tests {
    use atas_core::{SensorSetup, Settings};
    use robot_model::RobotModel;

    use super::*;

    #[test]
    fn foreign_or_damaged_state_is_rejected() {
        let robot = RobotModel::two_hand_arm().expect("built in");
        let controller = Controller::new(&robot, SensorSetup::default(), Settings::default());
        let saved = encode(&controller, 7).expect("encoded");
        let (read, next_sequence) = decode(&saved).expect("decoded");
        assert_eq!(next_sequence, 7);
        assert!(encode(&read, 7).expect("encoded") == saved, "every bit");
        let check = |state: Vec<u8>, part: &str| {
            let error = format!("{:#}", decode(&state).expect_err("must be refused"));
            assert!(error.contains(part), "{error}");
        };
        let replaced = |from: &str, to: &str| {
            let at = saved.windows(from.len()).position(|w| w == from.as_bytes());
            let mut state = saved.clone();
            let at = at.expect("in it");
            state[at..at + to.len()].copy_from_slice(to.as_bytes());
            state
        };
        check(replaced(atas_core::VERSION, "9"), "by version 9");
        check(
            replaced("stall_detector", "stall_inspector"),
            "another controller",
        );
        check(saved[..saved.len() / 2].to_vec(), "damaged");
        check(b"nonsense".to_vec(), "damaged");
    }
}
