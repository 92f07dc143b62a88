//! Tests of the robot model through its public interface only.

mod any;
mod capsules;
mod forward;
mod ik;
mod jacobian;
mod path;
mod skeleton;
mod support;
mod tilt;
mod unreachable;
mod urdf;
mod workspace;
