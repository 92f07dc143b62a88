//! Causes of a rejection, a hold or a stop: the codes of a [`crate::Reason`] on the wire.

use crate::code::code;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

code! {
    /// Cause of a rejection, a hold or a stop.
    Cause as "atas.Cause.v1" {
        /// No cause.
        NONE = 0, "none";
        /// A value of the goal is not finite.
        NOT_FINITE = 1, "not-finite";
        /// A value of the goal is out of its range.
        OUT_OF_RANGE = 2, "out-of-range";
        /// The position is outside the workspace.
        UNREACHABLE = 3, "unreachable";
        /// The goal's kind, hand or policy is unknown.
        UNKNOWN_GOAL = 4, "unknown-goal";
        /// Another goal is active.
        BUSY = 5, "busy";
        /// The daemon is not in mode READY.
        NOT_READY = 6, "not-ready";
        /// The hand still holds an object.
        HAND_FULL = 7, "hand-full";
        /// The hand has no tactile sensor.
        NO_SENSOR = 8, "no-sensor";
        /// The clearance between the two arms would be too small.
        ARMS_COLLIDE = 9, "arms-collide";
        /// The hand closed without contact.
        NOTHING_TOUCHED = 10, "nothing-touched";
        /// The object needs more force than the configured maximum (`grasp.f2_max_n`).
        TOO_HEAVY = 11, "too-heavy";
        /// The hand no longer feels the object, or no longer its load.
        LOST_OBJECT = 12, "lost-object";
        /// The object slips although the grip force has reached its limit.
        OUT_OF_FORCE = 13, "out-of-force";
        /// A step exceeded its time limit.
        TIMED_OUT = 14, "timed-out";
        /// The client cancelled.
        CANCELLED = 15, "cancelled";
        /// The client of an attached goal disconnected.
        CLIENT_GONE = 16, "client-gone";
        /// No support was detected at the place position; the hand has lifted the object again.
        NO_SUPPORT = 17, "no-support";
        /// A fingertip touched an obstacle during free motion; the hand has moved back.
        OBSTRUCTED = 18, "obstructed";
        /// The goal names a task that is not configured.
        UNKNOWN_TASK = 19, "unknown-task";
        /// Tactile frames have stopped arriving.
        FRAMES_STOPPED = 20, "frames-stopped";
        /// The time stamp of a frame is too old.
        FRAME_STALE = 21, "frame-stale";
        /// The time stamp of a frame is in the future.
        FRAME_FUTURE = 22, "frame-future";
        /// Too many consecutive frames were lost.
        FRAMES_LOST = 23, "frames-lost";
        /// A frame failed its checksum.
        FRAME_CORRUPT = 24, "frame-corrupt";
        /// A frame comes from a writer other than the pinned one, or uses another layout.
        FRAME_FOREIGN = 25, "frame-foreign";
        /// Too many elements are invalid.
        ELEMENTS_INVALID = 26, "elements-invalid";
        /// The readings are constant although the frame counter advances.
        FRAMES_FROZEN = 27, "frames-frozen";
        /// The sensor process restarted during a task.
        SENSOR_RESTARTED = 28, "sensor-restarted";
        /// A held object slides between the fingertips.
        SLIDING = 29, "sliding";
        /// Joint states have stopped arriving.
        JOINTS_STOPPED = 30, "joints-stopped";
        /// A joint state is not finite, out of range or jumps. With the index 4294967295, it has
        /// another number of joints than the robot.
        JOINTS_INVALID = 31, "joints-invalid";
        /// A joint does not follow its command.
        FOLLOWING_ERROR = 32, "following-error";
        /// A command is not finite.
        COMMAND_NOT_FINITE = 33, "command-not-finite";
        /// The step between two commands is too large.
        COMMAND_STEP = 34, "command-step";
        /// A grip force exceeds its limit.
        GRIP_CEILING = 35, "grip-ceiling";
        /// The robot process restarted.
        ROBOT_RESTARTED = 36, "robot-restarted";
        /// The force reported for a fingertip exceeds the largest force that a hand can exert.
        FORCE_IMPLAUSIBLE = 37, "force-implausible";
        /// The request is not allowed now: the robot moves, or the hand is not empty.
        NOT_NOW = 38, "not-now";
        /// The daemon runs in sense-only mode and commands no robot.
        SENSE_ONLY = 39, "sense-only";
        /// A module panicked.
        MODULE_PANICKED = 40, "module-panicked";
        /// The control loop stalled.
        LOOP_STALLED = 41, "loop-stalled";
        /// An operator stopped the robot with `atas estop`.
        ESTOP = 42, "estop";
        /// The daemon is shutting down.
        SHUTDOWN = 43, "shutdown";
        /// The supervisor, which serves requests and reports, does not respond.
        SUPERVISOR_SILENT = 44, "supervisor-silent";
        /// Some elements of a fingertip report a constant value although frames arrive; they are
        /// masked.
        ELEMENT_STUCK = 45, "element-stuck";
        /// The tactile force of a hand disagrees with its joint-estimated force.
        FORCE_AGAINST_JOINTS = 46, "force-against-joints";
        /// The tactile force of a grip does not match its opening: the zero of a sensor drifts.
        FORCE_AGAINST_OPENING = 47, "force-against-opening";
        /// The object needs more force than its stiffness allows (`grasp.compression_m`).
        TOO_SOFT = 50, "too-soft";
        /// The daemon found the hand gripping an object at start; it keeps and monitors the grip.
        GRIP_FOUND = 51, "grip-found";
        /// The object rotated about the closing axis while held.
        TURNED_IN_HAND = 52, "turned-in-hand";
        /// The object slipped between the fingertips and was held again.
        SLIPPED_IN_HAND = 53, "slipped-in-hand";
        /// The object needs more force than the goal allows ([`crate::GoalRequest`]).
        ABOVE_MAX_FORCE = 54, "above-max-force";
        /// The paths of the task, or their combinations for both hands, are too long to be checked.
        TASK_TOO_LONG = 60, "task-too-long";
        /// The robot has no such hand.
        NO_HAND = 61, "no-hand";
        /// The hand cannot turn a cap because its fingertips cannot pass each other.
        CANNOT_TURN = 62, "cannot-turn";
        /// The robot file of the hand has no workspace, which teleoperation requires.
        NO_WORKSPACE = 63, "no-workspace";
        /// The hand holds no object, which the task requires.
        HAND_EMPTY = 64, "hand-empty";
        /// At this width the fingertips would be too misaligned for tactile sensing.
        FINGERTIPS_MISALIGNED = 65, "fingertips-misaligned";
        /// The target stream of the client has ended or pauses; the hand stops and keeps its grip.
        TARGETS_STOPPED = 70, "targets-stopped";
        /// A target failed its checksum.
        TARGET_CORRUPT = 71, "target-corrupt";
        /// A target comes from a writer other than the one that opened the stream.
        TARGET_FOREIGN = 72, "target-foreign";
        /// A target is out of order, predates its goal, is stamped in the future, or has expired.
        TARGET_STALE = 73, "target-stale";
        /// A target names a hand outside its goal, or an unknown grip command.
        TARGET_UNKNOWN = 74, "target-unknown";
        /// A value of a target is not finite.
        TARGET_NOT_FINITE = 75, "target-not-finite";
        /// A value of a target is out of its range.
        TARGET_OUT_OF_RANGE = 76, "target-out-of-range";
        /// An arm crosses the middle plane, which both arms must avoid during teleoperation.
        ACROSS_THE_MIDDLE = 77, "across-the-middle";
    }
}
