//! Robot process for real servos.
//!
//! One process drives all servos of one robot, over one or more serial ports:
//!
//! ```text
//! servos ◀─▶ port (driver: registers; wire: frames) ─reports─▶ robot ─JointState─▶ bus ─▶ daemon
//! servos ◀─▶ ...     one thread per port         ◀─set-points─  └◀─JointCommand── bus ◀──┘
//! ```
//!
//! * **Input:** serial ports, [`JointCommand`](shm_schemas::JointCommand)s, a [servo map](map).
//!   **Output:** [`JointState`](shm_schemas::JointState)s, servo goals, a log on standard error, an
//!   [exit code](failure).
//! * **Invariants:** the next four items.
//! * Invalid commands cause no motion: [`CommandValidator`](shm_schemas::CommandValidator), which
//!   the simulator uses as well.
//! * When commands, this process or a port end, the servos hold their last goals with torque. Only
//!   `atas-robot relax` and `calibrate` switch torque off.
//! * A servo gets torque only with its current position as goal. After a failure, the robot
//!   restarts from its current position ([`port`], [`robot`], `tests/robots/trouble.rs`), so no
//!   joint jumps.
//! * A joint state implies that every joint was read and holds ([`robot`]).
//! * **Timing:** the servo bus determines the rate of joint states, some hundred per second. The
//!   daemon keeps its own tick rate; each cycle uses the newest command. The stamp of a state is
//!   the time of the request to the servos.
//! * **Not included:** trajectories, force control and limits of the hand (daemon); the servos' own
//!   bus watchdogs, which would end the hold after this process.
//!
//! To add a servo family, add a file in [`drivers`] and an entry in [`drivers::DRIVERS`]. The
//! [`emulator`] replaces servos in tests and without hardware.

pub mod cli;
pub mod commands;
pub mod drivers;
pub mod emulator;
pub mod failure;
pub mod joints;
pub mod map;
pub mod port;
pub mod robot;
