//! A robot's wheeled base: what it sees from where it is, and what whoever coordinates the robot tells it.

use crate::code::code;
use crate::payload::payload;
use crate::stamp::Stamp;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

code! {
    /// Which light a base's photo sensors look for.
    Light as "atas.Light.v1" {
        /// The object's.
        OBJECT = 0, "object";
        /// The goal's.
        GOAL = 1, "goal";
    }
}

code! {
    /// Who has the say over a robot.
    Say as "atas.Say.v1" {
        /// Nobody: the base brakes and stands.
        NOBODY = 0, "nobody";
        /// The behaviour table: the base drives.
        TABLE = 1, "table";
        /// The hand: it works, the base stands.
        HAND = 2, "hand";
        /// Nobody any more: the course is over, the base brakes and stays.
        OVER = 3, "over";
    }
}

code! {
    /// What ended a base's course at once.
    Mishap as "atas.Mishap.v1" {
        /// Nothing did.
        NONE = 0, "none";
        /// It came too near to a wall.
        LEFT_FIELD = 1, "left the field";
        /// It met another robot.
        MET_ROBOT = 2, "met another robot";
        /// It drove over an object.
        MET_OBJECT = 3, "drove over an object";
    }
}

payload! {
    /// What a base sees at the start of a frame. Places are metres ahead of its middle and to the left.
    BaseState as "atas.BaseState.v1" {
        /// `captured_ns` is the frame's time.
        pub stamp: Stamp,
        /// Index of the frame.
        pub frame: u64,
        /// Where the object's light is, m; means nothing while the hand has the object.
        pub object_m: [f64; 2],
        /// Where the goal's light is, m.
        pub goal_m: [f64; 2],
        /// Distance to the robot that has the right of way, m; infinite if this one has it, or nobody needs it.
        pub first_m: f64,
        /// 1 while the object stands, so that its light is seen.
        pub object_stands: u32,
        /// 1 while the wheels stand.
        pub stands: u32,
        /// What ended the course at once.
        pub mishap: Mishap,
        /// Written as zero.
        pub pad: u32,
    }
}

payload! {
    /// What a base is told for that frame.
    BaseCommand as "atas.BaseCommand.v1" {
        /// `captured_ns` is copied from the state that it answers.
        pub stamp: Stamp,
        /// The frame that it answers.
        pub frame: u64,
        /// Who has the say.
        pub say: Say,
        /// Which light counts. The base drives gently once it is the goal's: its robot carries the object then.
        pub light: Light,
    }
}
