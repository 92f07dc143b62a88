//! Wheeled base: state of the base, and commands from the robot coordinator.

use crate::code::code;
use crate::payload::payload;
use crate::stamp::Stamp;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

code! {
    /// Light that the photo sensors of a base detect.
    Light as "atas.Light.v1" {
        /// Light of the object.
        OBJECT = 0, "object";
        /// Light of the goal.
        GOAL = 1, "goal";
    }
}

code! {
    /// Subsystem that controls the robot.
    ControlOwner as "atas.ControlOwner.v1" {
        /// No owner: the base brakes and stands.
        NONE = 0, "none";
        /// The behaviour table drives the base.
        TABLE = 1, "table";
        /// The hand works; the base stands.
        HAND = 2, "hand";
        /// The course is over: the base brakes and stays.
        OVER = 3, "over";
    }
}

code! {
    /// Incident that ended the course of a base.
    Mishap as "atas.Mishap.v1" {
        /// No incident.
        NONE = 0, "none";
        /// The base came too close to a wall.
        LEFT_FIELD = 1, "left the field";
        /// The base collided with another robot.
        MET_ROBOT = 2, "met another robot";
        /// The base drove over an object.
        MET_OBJECT = 3, "drove over an object";
    }
}

payload! {
    /// State of a base at the start of a frame. Positions are relative to the base centre, m:
    /// ahead, left.
    BaseState as "atas.BaseState.v1" {
        /// `captured_ns` is the time of the frame.
        pub stamp: Stamp,
        /// Index of the frame.
        pub frame: u64,
        /// Position of the object light, m; undefined while the hand holds the object.
        pub object_m: [f64; 2],
        /// Position of the goal light, m.
        pub goal_m: [f64; 2],
        /// Distance to the robot with the right of way, m; infinite if this robot has it or no
        /// robot needs it.
        pub right_of_way_m: f64,
        /// 1 while the object stands on the ground and its light is visible.
        pub object_stands: u32,
        /// 1 while the wheels are stopped.
        pub wheels_stopped: u32,
        /// Incident that ended the course.
        pub mishap: Mishap,
        /// Written as zero.
        pub pad: u32,
    }
}

payload! {
    /// Command to a base for one frame.
    BaseCommand as "atas.BaseCommand.v1" {
        /// `captured_ns` is copied from the state that this command answers.
        pub stamp: Stamp,
        /// Frame that this command answers.
        pub frame: u64,
        /// Control owner.
        pub owner: ControlOwner,
        /// Light that the base detects. With the goal light the base drives gently, because the
        /// robot carries the object.
        pub light: Light,
    }
}
