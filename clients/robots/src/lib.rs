//! Robot processes for real servos.
//!
//! One process drives all servos of one robot, over one or more serial ports:
//!
//! ```text
//! servos ◀─▶ port (driver: registers; wire: frames) ─reports─▶ robot ─JointState─▶ bus ─▶ daemon
//! servos ◀─▶ ...     one thread per port            ◀─orders──   └◀─JointCommand── bus ◀──┘
//! ```
//!
//! * **In:** serial terminals, [`JointCommand`](shm_schemas::JointCommand)s, a [servo map](map). **Out:**
//!   [`JointState`](shm_schemas::JointState)s, goals in the servos; a log on standard error, an [exit code](failure).
//! * **Invariants**
//!   * A command that breaks the contract moves nothing: [`Obedience`](shm_schemas::Obedience), the simulator's own judge.
//!   * Whatever ends (commands, this process, a port), the servos hold their last goals, with torque: nothing here lets go but
//!     `atas-robot relax` and `calibrate`, which are asked to.
//!   * A servo gets torque only with a goal where it stands, and after trouble the robot begins anew from where it is ([`port`],
//!     [`robot`], `tests/trouble.rs`): nothing jumps.
//!   * A joint state says that every joint was read and holds; while one is in doubt there is none ([`robot`]).
//! * **Time:** the bus of the servos sets the rate of the states, some hundreds per second; the daemon goes on ticking at its own, and
//!   each cycle takes the newest command. A state is stamped when the question went out.
//! * **Absent on purpose:** trajectories, force control and limits of what a hand may do: that is the daemon's; the servos' own
//!   bus watchdogs, which end the hold that shall outlive this process.
//!
//! A further family of servos is one file in [`drivers`] and one line in [`drivers::DRIVERS`]. [`emulator`] plays servos for the
//! tests, and for who has none yet.

pub mod cli;
pub mod commands;
pub mod drivers;
pub mod emulator;
pub mod failure;
pub mod joints;
pub mod map;
pub mod port;
pub mod robot;
