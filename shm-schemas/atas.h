// The payloads of the ATAS bus, for C11 (and C++ from 11 on).
//
// Made from the schema in shm-schemas/src: a test compares, and compiles it. How the payloads travel (services, quality of
// service, lock-step) stands in clients/protocol.md. All numbers are little-endian; there is no padding.
#ifndef ATAS_H
#define ATAS_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
#define _Static_assert static_assert
#define _Alignof alignof
#endif

// CRC-32 (IEEE 802.3, reflected, as in zip and Ethernet) over bytes: the seal of a payload.
static inline uint32_t atas_crc32(const void *bytes, size_t count) {
    const unsigned char *byte = (const unsigned char *)bytes;
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < count; i++) {
        crc ^= byte[i];
        for (int bit = 0; bit < 8; bit++) {
            crc = (crc >> 1) ^ (0xedb88320u & (0u - (crc & 1u)));
        }
    }
    return ~crc;
}

// FNV-1a 64; begin with ATAS_FNV_OFFSET.
#define ATAS_FNV_OFFSET 0xcbf29ce484222325u
static inline uint64_t atas_fnv1a(uint64_t hash, const void *bytes, size_t count) {
    const unsigned char *byte = (const unsigned char *)bytes;
    for (size_t i = 0; i < count; i++) {
        hash = (hash ^ byte[i]) * 0x100000001b3u;
    }
    return hash;
}

// The hash of a layout of `count` elements with their normals and tangents (unit vectors, tip frame): of the count, then
// of every direction in millionths, each as 8 bytes.
static inline uint64_t atas_layout_hash(uint64_t count, double normal[][3], double tangent1[][3], double tangent2[][3]) {
    double(*tables[3])[3] = {normal, tangent1, tangent2};
    uint64_t hash = atas_fnv1a(ATAS_FNV_OFFSET, &count, sizeof count);
    for (int table = 0; table < 3; table++) {
        for (uint64_t element = 0; element < count; element++) {
            for (int axis = 0; axis < 3; axis++) {
                int64_t micro = (int64_t)round(tables[table][element][axis] * 1e6);
                hash = atas_fnv1a(hash, &micro, sizeof micro);
            }
        }
    }
    return hash;
}

// Capacities of the payloads.
#define ATAS_HANDS 2
#define ATAS_FINGERS 4
#define ATAS_ELEMENTS 64
#define ATAS_JOINTS 32
#define ATAS_AGENTS 1024
#define ATAS_STAGES 8
#define ATAS_SETTINGS 96
#define ATAS_STEPS 32

// Services.
#define ATAS_SERVICE_HAND_FRAME_LEFT "atas/v2/hand-frame/left"
#define ATAS_SERVICE_HAND_FRAME_RIGHT "atas/v2/hand-frame/right"
#define ATAS_SERVICE_JOINT_STATE "atas/v3/joint-state"
#define ATAS_SERVICE_JOINT_COMMAND "atas/v2/joint-command"
#define ATAS_SERVICE_GOAL "atas/v3/goal"
#define ATAS_SERVICE_CONTROL "atas/v1/control"
#define ATAS_SERVICE_GRASP_TARGET "atas/v1/grasp-target"
#define ATAS_SERVICE_STATUS "atas/v3/status"
#define ATAS_SERVICE_TICK_REPORT "atas/v1/tick-report"
#define ATAS_SERVICE_VIEW "atas/v2/view"
#define ATAS_SERVICE_MODULE_EVENT "atas/v1/module-event"
#define ATAS_SERVICE_RUN_HEADER "atas/v2/run-header"
#define ATAS_SERVICE_TICK_INPUTS "atas/v7/tick-inputs"
#define ATAS_SERVICE_SENSOR_STATUS "atas/v1/sensor-status"
#define ATAS_SERVICE_WORLD_TRUTH "atas/v3/world-truth"
#define ATAS_SERVICE_AGENT_SENSORS "atas/v1/agent-sensors"
#define ATAS_SERVICE_WHEEL_COMMANDS "atas/v1/wheel-commands"
#define ATAS_SERVICE_BASE_STATE "atas/v1/base-state"
#define ATAS_SERVICE_BASE_COMMAND "atas/v1/base-command"
#define ATAS_SERVICE_ARENA_TRUTH "atas/v2/arena-truth"

// Hashes of the built-in layouts.
#define ATAS_LAYOUT_HASH_DOME_41 0x952863cb70a35143u
#define ATAS_LAYOUT_HASH_DOME_1 0xa5e79ed509103aeau
#define ATAS_LAYOUT_HASH_FLAT_4X4_4_5 0x97e04f9a9ea46b5du
#define ATAS_LAYOUT_HASH_CYLINDER_4X4_4_5_12 0xfe26b6b80fa0ce8du

// Left or right hand.
enum atas_hand {
    // Left hand: joints 0 to 10 of the built-in robot.
    ATAS_HAND_LEFT = 0,
    // Right hand: joints 11 to 21 of the built-in robot.
    ATAS_HAND_RIGHT = 1,
};

// Mode of the daemon, ordered by severity.
enum atas_mode {
    // Waiting for the first valid frames and joint states.
    ATAS_MODE_INIT = 0,
    // All inputs are fresh; no goal.
    ATAS_MODE_READY = 1,
    // A goal is in progress.
    ATAS_MODE_RUN = 2,
    // A fault is present: positions and grip are kept until it clears.
    ATAS_MODE_HOLD = 3,
    // Stopped and latched until a recover request.
    ATAS_MODE_SAFE_STOP = 4,
    // Internal failure of the daemon; latched until restart.
    ATAS_MODE_FAULT = 5,
};

// Task of a goal.
enum atas_goal_kind {
    // Grasps, lifts and holds the object at from_m (paper II.b (1)).
    ATAS_GOAL_KIND_GRASP = 1,
    // Grasps at from_m and places at to_m (paper II.b (3)).
    ATAS_GOAL_KIND_PICK_PLACE = 2,
    // Screws the cap at from_m (paper II.b (2)).
    ATAS_GOAL_KIND_SCREW = 3,
    // Takes the cap from from_m and screws it onto the bottle at to_m, with both hands
    // (paper II.c).
    ATAS_GOAL_KIND_ASSEMBLE = 4,
    // Opens the hand in place and moves it home.
    ATAS_GOAL_KIND_RELEASE = 5,
    // User-defined task, named by GoalRequest::task.
    ATAS_GOAL_KIND_CUSTOM = 6,
    // Teleoperation: the acting hand tracks the targets streamed by the client
    // (GraspTarget).
    ATAS_GOAL_KIND_TELEOP = 7,
    // Teleoperation of both hands.
    ATAS_GOAL_KIND_TELEOP_BOTH = 8,
};

// Reaction to the disconnection of the client.
enum atas_goal_policy {
    // The goal continues.
    ATAS_GOAL_POLICY_DETACHED = 0,
    // The robot enters HOLD within 100 ticks.
    ATAS_GOAL_POLICY_ATTACHED = 1,
};

// State of a goal.
enum atas_goal_state {
    // Validated and queued for the next tick.
    ATAS_GOAL_STATE_ACCEPTED = 1,
    // Rejected before any motion; see reason.
    ATAS_GOAL_STATE_REJECTED = 2,
    // In progress.
    ATAS_GOAL_STATE_RUNNING = 3,
    // Completed.
    ATAS_GOAL_STATE_SUCCEEDED = 4,
    // Ended by the robot during the attempt because of the object (for example too heavy),
    // with a safe recovery.
    ATAS_GOAL_STATE_REFUSED = 5,
    // Ended without success; see reason.
    ATAS_GOAL_STATE_FAILED = 6,
    // Cancelled by the client.
    ATAS_GOAL_STATE_CANCELLED = 7,
};

// Direction in which a cap is turned, seen from above.
enum atas_turn {
    // Closes a standard right-hand thread.
    ATAS_TURN_CLOCKWISE = 0,
    // Closes a left-hand thread, opens a right-hand one.
    ATAS_TURN_ANTICLOCKWISE = 1,
};

// Grip command of a target.
enum atas_grip_order {
    // Moves to opening_m. On contact the fingertips hold the object with the minimum force,
    // until a wider opening is commanded.
    ATAS_GRIP_ORDER_WIDTH = 0,
    // Closes until contact and holds the object.
    ATAS_GRIP_ORDER_HOLD = 1,
};

// Operation of a control request.
enum atas_control_op {
    // Stops immediately and latches SAFE_STOP.
    ATAS_CONTROL_OP_ESTOP = 1,
    // Leaves SAFE_STOP. The robot stays in HOLD until all faults have cleared; HOLD ends by
    // itself.
    ATAS_CONTROL_OP_RECOVER = 2,
    // Reads the parameter name.
    ATAS_CONTROL_OP_PARAM_GET = 3,
    // Sets the parameter name to value.
    ATAS_CONTROL_OP_PARAM_SET = 4,
    // Returns the name of the parameter with the index value.
    ATAS_CONTROL_OP_PARAM_LIST = 5,
    // Takes the present reading of the hand with the index value as zero force.
    ATAS_CONTROL_OP_BIAS = 6,
    // Reloads the configuration files.
    ATAS_CONTROL_OP_RELOAD = 7,
    // Cancels the goal whose decimal id is in name; no effect if the goal has ended.
    ATAS_CONTROL_OP_CANCEL = 8,
    // Lock-step only: advances virtual time to the tick with the index value, even without a
    // goal, and pauses there.
    ATAS_CONTROL_OP_ADVANCE = 9,
};

// Result of a control request.
enum atas_control_outcome {
    // Done.
    ATAS_CONTROL_OUTCOME_DONE = 1,
    // Refused; text has the reason.
    ATAS_CONTROL_OUTCOME_REFUSED = 2,
    // Unknown operation or name.
    ATAS_CONTROL_OUTCOME_UNKNOWN = 3,
};

// Result of a stop request.
enum atas_stop_outcome {
    // A tick processed the stop: commands hold still from that tick on.
    ATAS_STOP_OUTCOME_STOPPED = 1,
    // The stop is pending: the tick is frozen, or virtual time is paused in lock-step.
    ATAS_STOP_OUTCOME_WAITING = 2,
};

// Kind of an event.
enum atas_event_kind {
    // A module became active.
    ATAS_EVENT_KIND_MODULE_ON = 1,
    // A module became inactive.
    ATAS_EVENT_KIND_MODULE_OFF = 2,
    // A fingertip made contact.
    ATAS_EVENT_KIND_TOUCH_ON = 3,
    // A fingertip lost contact.
    ATAS_EVENT_KIND_TOUCH_OFF = 4,
    // The state of a goal changed; value is the new state.
    ATAS_EVENT_KIND_GOAL = 5,
    // A task entered the step named in text.
    ATAS_EVENT_KIND_STEP = 6,
    // The mode changed because of reason.
    ATAS_EVENT_KIND_MODE = 7,
    // The stiffness probe ended; value is in N/m, text is F_2.
    ATAS_EVENT_KIND_STIFFNESS = 8,
    // A tolerated fault, described by reason.
    ATAS_EVENT_KIND_WARNING = 9,
};

// Modules of the paper and additional modules.
enum atas_module_id {
    // No module.
    ATAS_MODULE_ID_NONE = 0,
    // Module 0: square trajectory, adapted by contact (paper II.b (2)).
    ATAS_MODULE_ID_TRAJECTORY = 1,
    // Module 0': moves and places the object (paper II.b (3)).
    ATAS_MODULE_ID_TRANSFER = 2,
    // Module 1: first touch, F_n > F_1 (paper II.b (1)).
    ATAS_MODULE_ID_FIRST_TOUCH = 3,
    // Module 2: slip, dF_t > dr (paper II.b (1)).
    ATAS_MODULE_ID_SLIP = 4,
    // Module 3: force limit, F_n > F_2 (paper II.b (1)).
    ATAS_MODULE_ID_FORCE_LIMIT = 5,
    // Module 4: ends screwing, dF_t > 1.4 dF_max (paper II.b (2)).
    ATAS_MODULE_ID_TERMINATE_SCREW = 6,
    // Module 4: releases on upward tangential force (paper II.b (3)).
    ATAS_MODULE_ID_RELEASE_PLACED = 7,
    // Stiffness probe, 100 ms after the first touch (paper II.b (1)).
    ATAS_MODULE_ID_PROBE = 8,
    // Moves the hand along a planned path.
    ATAS_MODULE_ID_CARRY = 9,
    // Grip relaxation: reduces force that friction does not require.
    ATAS_MODULE_ID_RELAX = 10,
    // Moves the hand back on contact during free motion.
    ATAS_MODULE_ID_CONTACT_GUARD = 11,
    // Lift verification: one pull-back during the lift distinguishes a suspended object from a
    // supported one.
    ATAS_MODULE_ID_LIFT_VERIFICATION = 12,
    // Increases the grip by a fixed share on each slip; a baseline, not used by built-in
    // tasks.
    ATAS_MODULE_ID_SLIP_REACTION = 13,
    // Teleoperation: tracks streamed targets with limited speed, acceleration and jerk.
    ATAS_MODULE_ID_TELEOP = 14,
    // Commands fingers and hand from the behaviour table of the task (paper section III).
    ATAS_MODULE_ID_BEHAVIOUR_TABLE = 15,
};

// Cause of a rejection, a hold or a stop.
enum atas_cause {
    // No cause.
    ATAS_CAUSE_NONE = 0,
    // A value of the goal is not finite.
    ATAS_CAUSE_NOT_FINITE = 1,
    // A value of the goal is out of its range.
    ATAS_CAUSE_OUT_OF_RANGE = 2,
    // The position is outside the workspace.
    ATAS_CAUSE_UNREACHABLE = 3,
    // The goal's kind, hand or policy is unknown.
    ATAS_CAUSE_UNKNOWN_GOAL = 4,
    // Another goal is active.
    ATAS_CAUSE_BUSY = 5,
    // The daemon is not in mode READY.
    ATAS_CAUSE_NOT_READY = 6,
    // The hand still holds an object.
    ATAS_CAUSE_HAND_FULL = 7,
    // The hand has no tactile sensor.
    ATAS_CAUSE_NO_SENSOR = 8,
    // The clearance between the two arms would be too small.
    ATAS_CAUSE_ARMS_COLLIDE = 9,
    // The hand closed without contact.
    ATAS_CAUSE_NOTHING_TOUCHED = 10,
    // The object needs more force than the configured maximum (grasp.f2_max_n).
    ATAS_CAUSE_TOO_HEAVY = 11,
    // The hand no longer feels the object, or no longer its load.
    ATAS_CAUSE_LOST_OBJECT = 12,
    // The object slips although the grip force has reached its limit.
    ATAS_CAUSE_OUT_OF_FORCE = 13,
    // A step exceeded its time limit.
    ATAS_CAUSE_TIMED_OUT = 14,
    // The client cancelled.
    ATAS_CAUSE_CANCELLED = 15,
    // The client of an attached goal disconnected.
    ATAS_CAUSE_CLIENT_GONE = 16,
    // No support was detected at the place position; the hand has lifted the object again.
    ATAS_CAUSE_NO_SUPPORT = 17,
    // A fingertip touched an obstacle during free motion; the hand has moved back.
    ATAS_CAUSE_OBSTRUCTED = 18,
    // The goal names a task that is not configured.
    ATAS_CAUSE_UNKNOWN_TASK = 19,
    // Tactile frames have stopped arriving.
    ATAS_CAUSE_FRAMES_STOPPED = 20,
    // The time stamp of a frame is too old.
    ATAS_CAUSE_FRAME_STALE = 21,
    // The time stamp of a frame is in the future.
    ATAS_CAUSE_FRAME_FUTURE = 22,
    // Too many consecutive frames were lost.
    ATAS_CAUSE_FRAMES_LOST = 23,
    // A frame failed its checksum.
    ATAS_CAUSE_FRAME_CORRUPT = 24,
    // A frame comes from a writer other than the pinned one, or uses another layout.
    ATAS_CAUSE_FRAME_FOREIGN = 25,
    // Too many elements are invalid.
    ATAS_CAUSE_ELEMENTS_INVALID = 26,
    // The readings are constant although the frame counter advances.
    ATAS_CAUSE_FRAMES_FROZEN = 27,
    // The sensor process restarted during a task.
    ATAS_CAUSE_SENSOR_RESTARTED = 28,
    // A held object slides between the fingertips.
    ATAS_CAUSE_SLIDING = 29,
    // Joint states have stopped arriving.
    ATAS_CAUSE_JOINTS_STOPPED = 30,
    // A joint state is not finite, out of range or jumps. With the index 4294967295, it has
    // another number of joints than the robot.
    ATAS_CAUSE_JOINTS_INVALID = 31,
    // A joint does not follow its command.
    ATAS_CAUSE_FOLLOWING_ERROR = 32,
    // A command is not finite.
    ATAS_CAUSE_COMMAND_NOT_FINITE = 33,
    // The step between two commands is too large.
    ATAS_CAUSE_COMMAND_STEP = 34,
    // A grip force exceeds its limit.
    ATAS_CAUSE_GRIP_CEILING = 35,
    // The robot process restarted.
    ATAS_CAUSE_ROBOT_RESTARTED = 36,
    // The force reported for a fingertip exceeds the largest force that a hand can exert.
    ATAS_CAUSE_FORCE_IMPLAUSIBLE = 37,
    // The request is not allowed now: the robot moves, or the hand is not empty.
    ATAS_CAUSE_NOT_NOW = 38,
    // The daemon runs in sense-only mode and commands no robot.
    ATAS_CAUSE_SENSE_ONLY = 39,
    // A module panicked.
    ATAS_CAUSE_MODULE_PANICKED = 40,
    // The control loop stalled.
    ATAS_CAUSE_LOOP_STALLED = 41,
    // An operator stopped the robot with atas estop.
    ATAS_CAUSE_ESTOP = 42,
    // The daemon is shutting down.
    ATAS_CAUSE_SHUTDOWN = 43,
    // The supervisor, which serves requests and reports, does not respond.
    ATAS_CAUSE_SUPERVISOR_SILENT = 44,
    // Some elements of a fingertip report a constant value although frames arrive; they are
    // masked.
    ATAS_CAUSE_ELEMENT_STUCK = 45,
    // The tactile force of a hand disagrees with its joint-estimated force.
    ATAS_CAUSE_FORCE_AGAINST_JOINTS = 46,
    // The tactile force of a grip does not match its opening: the zero of a sensor drifts.
    ATAS_CAUSE_FORCE_AGAINST_OPENING = 47,
    // The object needs more force than its stiffness allows (grasp.compression_m).
    ATAS_CAUSE_TOO_SOFT = 50,
    // The daemon found the hand gripping an object at start; it keeps and monitors the grip.
    ATAS_CAUSE_GRIP_FOUND = 51,
    // The object rotated about the closing axis while held.
    ATAS_CAUSE_TURNED_IN_HAND = 52,
    // The object slipped between the fingertips and was held again.
    ATAS_CAUSE_SLIPPED_IN_HAND = 53,
    // The object needs more force than the goal allows (GoalRequest).
    ATAS_CAUSE_ABOVE_MAX_FORCE = 54,
    // The paths of the task, or their combinations for both hands, are too long to be checked.
    ATAS_CAUSE_TASK_TOO_LONG = 60,
    // The robot has no such hand.
    ATAS_CAUSE_NO_HAND = 61,
    // The hand cannot turn a cap because its fingertips cannot pass each other.
    ATAS_CAUSE_CANNOT_TURN = 62,
    // The robot file of the hand has no workspace, which teleoperation requires.
    ATAS_CAUSE_NO_WORKSPACE = 63,
    // The hand holds no object, which the task requires.
    ATAS_CAUSE_HAND_EMPTY = 64,
    // At this width the fingertips would be too misaligned for tactile sensing.
    ATAS_CAUSE_FINGERTIPS_MISALIGNED = 65,
    // The target stream of the client has ended or pauses; the hand stops and keeps its grip.
    ATAS_CAUSE_TARGETS_STOPPED = 70,
    // A target failed its checksum.
    ATAS_CAUSE_TARGET_CORRUPT = 71,
    // A target comes from a writer other than the one that opened the stream.
    ATAS_CAUSE_TARGET_FOREIGN = 72,
    // A target is out of order, predates its goal, is stamped in the future, or has expired.
    ATAS_CAUSE_TARGET_STALE = 73,
    // A target names a hand outside its goal, or an unknown grip command.
    ATAS_CAUSE_TARGET_UNKNOWN = 74,
    // A value of a target is not finite.
    ATAS_CAUSE_TARGET_NOT_FINITE = 75,
    // A value of a target is out of its range.
    ATAS_CAUSE_TARGET_OUT_OF_RANGE = 76,
    // An arm crosses the middle plane, which both arms must avoid during teleoperation.
    ATAS_CAUSE_ACROSS_THE_MIDDLE = 77,
};

// Request from the supervisor to a tick.
enum atas_order_kind {
    // No request.
    ATAS_ORDER_KIND_NONE = 0,
    // Starts goal.
    ATAS_ORDER_KIND_START = 1,
    // Ends the goal goal_id.
    ATAS_ORDER_KIND_CANCEL = 2,
    // The client of the goal goal_id disconnected.
    ATAS_ORDER_KIND_CLIENT_GONE = 3,
    // Stops and latches because of reason.
    ATAS_ORDER_KIND_STOP = 4,
    // Leaves SAFE_STOP.
    ATAS_ORDER_KIND_RECOVER = 5,
    // Sets the parameter at index to value.
    ATAS_ORDER_KIND_SET_PARAMETER = 6,
    // Replaces all settings by settings.
    ATAS_ORDER_KIND_CONFIGURE = 7,
    // Takes the reading of the hand at index as zero force.
    ATAS_ORDER_KIND_BIAS = 8,
    // Holds in this tick because of reason.
    ATAS_ORDER_KIND_HOLD = 9,
};

// Sensor bit of a behaviour table, evaluated in every tick (paper Table 1, S1 to S5).
enum atas_sensor_bit {
    // No bit.
    ATAS_SENSOR_BIT_NONE = 0,
    // Every fingertip is in contact.
    ATAS_SENSOR_BIT_TOUCHING = 1,
    // The lowest normal force exceeds F_1 (condition of Module 1).
    ATAS_SENSOR_BIT_ABOVE_F1 = 2,
    // The friction utilisation of a fingertip is close to 1, or it slips (condition of Module
    // 2).
    ATAS_SENSOR_BIT_SLIPPING = 3,
    // The highest normal force exceeds F_2 (condition of Module 3).
    ATAS_SENSOR_BIT_ABOVE_F2 = 4,
    // The hand has lifted the object by more than 3 mm.
    ATAS_SENSOR_BIT_LIFTED = 5,
    // Every fingertip has had a friction margin for 100 ms.
    ATAS_SENSOR_BIT_FRICTION_MARGIN = 6,
};

// Light that the photo sensors of a base detect.
enum atas_light {
    // Light of the object.
    ATAS_LIGHT_OBJECT = 0,
    // Light of the goal.
    ATAS_LIGHT_GOAL = 1,
};

// Subsystem that controls the robot.
enum atas_control_owner {
    // No owner: the base brakes and stands.
    ATAS_CONTROL_OWNER_NONE = 0,
    // The behaviour table drives the base.
    ATAS_CONTROL_OWNER_TABLE = 1,
    // The hand works; the base stands.
    ATAS_CONTROL_OWNER_HAND = 2,
    // The course is over: the base brakes and stays.
    ATAS_CONTROL_OWNER_OVER = 3,
};

// Incident that ended the course of a base.
enum atas_mishap {
    // No incident.
    ATAS_MISHAP_NONE = 0,
    // The base came too close to a wall.
    ATAS_MISHAP_LEFT_FIELD = 1,
    // The base collided with another robot.
    ATAS_MISHAP_MET_ROBOT = 2,
    // The base drove over an object.
    ATAS_MISHAP_MET_OBJECT = 3,
};

// Writer, time and sequence number of a payload.
typedef struct atas_stamp {
    // Sequence number of this writer, from 0; a gap means lost payloads.
    uint64_t sequence;
    // Capture time of the content, not its sending time, ns of CLOCK_MONOTONIC.
    uint64_t captured_ns;
    // Random number, drawn at each start of the writer. A reader pins it; a change means that
    // the writer restarted.
    uint64_t writer_epoch;
} atas_stamp;
#define ATAS_STAMP_TYPE "atas.Stamp.v1"
_Static_assert(sizeof(atas_stamp) == 24, "atas_stamp");
_Static_assert(_Alignof(atas_stamp) == 8, "atas_stamp");
_Static_assert(offsetof(atas_stamp, sequence) == 0, "atas_stamp.sequence");
_Static_assert(offsetof(atas_stamp, captured_ns) == 8, "atas_stamp.captured_ns");
_Static_assert(offsetof(atas_stamp, writer_epoch) == 16, "atas_stamp.writer_epoch");

// Tactile frame: readings of all fingertips of one hand.
//
// Forces act from the object **on** the fingertip, resolved along the axes of each element:
// f_n = −F·d (positive under pressure), f_t1 = F·t1, f_t2 = F·t2. The axes d, t1, t2
// come from the Layout that both sides configure; HandFrame::layout_hash
// verifies that the layouts match.
typedef struct atas_hand_frame {
    // captured_ns is the sampling time of the sensor.
    atas_stamp stamp;
    // Layout::hash of the element layout.
    uint64_t layout_hash;
    // Hand of the sensors.
    uint32_t hand; // enum atas_hand
    // Number of fingertips with data, at most FINGERS. Fingertip 0 is finger1 of the
    // URDF.
    uint32_t finger_count;
    // Per fingertip: bit e is set if the reading of element e is valid.
    uint64_t valid_mask[4];
    // Forces, N: force_n[finger][element] = [f_n, f_t1, f_t2].
    float force_n[4][64][3];
    // Written as zero.
    uint32_t pad;
    // CRC-32 (IEEE) of every byte before this field; see HandFrame::seal.
    uint32_t crc32;
} atas_hand_frame;
#define ATAS_HAND_FRAME_TYPE "atas.HandFrame.v1"
_Static_assert(sizeof(atas_hand_frame) == 3152, "atas_hand_frame");
_Static_assert(_Alignof(atas_hand_frame) == 8, "atas_hand_frame");
_Static_assert(offsetof(atas_hand_frame, stamp) == 0, "atas_hand_frame.stamp");
_Static_assert(offsetof(atas_hand_frame, layout_hash) == 24, "atas_hand_frame.layout_hash");
_Static_assert(offsetof(atas_hand_frame, hand) == 32, "atas_hand_frame.hand");
_Static_assert(offsetof(atas_hand_frame, finger_count) == 36, "atas_hand_frame.finger_count");
_Static_assert(offsetof(atas_hand_frame, valid_mask) == 40, "atas_hand_frame.valid_mask");
_Static_assert(offsetof(atas_hand_frame, force_n) == 72, "atas_hand_frame.force_n");
_Static_assert(offsetof(atas_hand_frame, pad) == 3144, "atas_hand_frame.pad");
_Static_assert(offsetof(atas_hand_frame, crc32) == 3148, "atas_hand_frame.crc32");
// Call last, after every other field is final.
static inline void atas_hand_frame_seal(atas_hand_frame *payload) {
    payload->crc32 = atas_crc32(payload, offsetof(atas_hand_frame, crc32));
}
static inline int atas_hand_frame_is_intact(const atas_hand_frame *payload) {
    return payload->crc32 == atas_crc32(payload, offsetof(atas_hand_frame, crc32));
}

// Measured joints (built-in robot: 11 left, then 11 right) and the command in force.
//
// The robot process outlives the daemon, so it reports the command in force and a new daemon
// continues from it. Servos hold a grip by being commanded beyond the measured finger
// positions; restarting from measured positions would release the object.
typedef struct atas_joint_state {
    // captured_ns is the time at which the encoders were read.
    atas_stamp stamp;
    // Number of joints with data, at most JOINTS.
    uint32_t joint_count;
    // Number of valid entries in commanded_position: joint_count, or 0 if the robot cannot
    // report them.
    uint32_t commanded_count;
    // Measured positions, rad or m.
    double position[32];
    // Measured velocities, rad/s or m/s.
    double velocity[32];
    // Measured efforts, N·m or N; zero if the drive does not measure them.
    double effort[32];
    // Positions held by the servos, rad or m: those of the last executed command, even if it
    // has expired.
    double commanded_position[32];
    // JointCommand::grip_limit_n of that command, 0 before the first.
    double grip_limit_n[2];
    // Writer epoch of that command, 0 before the first.
    uint64_t command_epoch;
    // Sequence number of that command.
    uint64_t command_sequence;
    // End of validity of that command, ns.
    uint64_t command_valid_until_ns;
    // Written as zero.
    uint32_t pad;
    // CRC-32 (IEEE) of every byte before this field.
    uint32_t crc32;
} atas_joint_state;
#define ATAS_JOINT_STATE_TYPE "atas.JointState.v3"
_Static_assert(sizeof(atas_joint_state) == 1104, "atas_joint_state");
_Static_assert(_Alignof(atas_joint_state) == 8, "atas_joint_state");
_Static_assert(offsetof(atas_joint_state, stamp) == 0, "atas_joint_state.stamp");
_Static_assert(offsetof(atas_joint_state, joint_count) == 24, "atas_joint_state.joint_count");
_Static_assert(offsetof(atas_joint_state, commanded_count) == 28, "atas_joint_state.commanded_count");
_Static_assert(offsetof(atas_joint_state, position) == 32, "atas_joint_state.position");
_Static_assert(offsetof(atas_joint_state, velocity) == 288, "atas_joint_state.velocity");
_Static_assert(offsetof(atas_joint_state, effort) == 544, "atas_joint_state.effort");
_Static_assert(offsetof(atas_joint_state, commanded_position) == 800, "atas_joint_state.commanded_position");
_Static_assert(offsetof(atas_joint_state, grip_limit_n) == 1056, "atas_joint_state.grip_limit_n");
_Static_assert(offsetof(atas_joint_state, command_epoch) == 1072, "atas_joint_state.command_epoch");
_Static_assert(offsetof(atas_joint_state, command_sequence) == 1080, "atas_joint_state.command_sequence");
_Static_assert(offsetof(atas_joint_state, command_valid_until_ns) == 1088, "atas_joint_state.command_valid_until_ns");
_Static_assert(offsetof(atas_joint_state, pad) == 1096, "atas_joint_state.pad");
_Static_assert(offsetof(atas_joint_state, crc32) == 1100, "atas_joint_state.crc32");
// Call last, after every other field is final.
static inline void atas_joint_state_seal(atas_joint_state *payload) {
    payload->crc32 = atas_crc32(payload, offsetof(atas_joint_state, crc32));
}
static inline int atas_joint_state_is_intact(const atas_joint_state *payload) {
    return payload->crc32 == atas_crc32(payload, offsetof(atas_joint_state, crc32));
}

// Joint command of one tick. It is published every tick, also in HOLD, and serves as
// heartbeat.
//
// The consumer enforces JointCommand::valid_until_ns: on expiry it holds the last
// commanded positions with zero velocity, which keeps the last safe grip force. Opening the
// hand is never the default stop.
typedef struct atas_joint_command {
    // captured_ns is the time of the tick.
    atas_stamp stamp;
    // End of validity, ns of CLOCK_MONOTONIC; the command must not be executed later.
    uint64_t valid_until_ns;
    // Tick that produced the command.
    uint64_t tick;
    // Sequence number of the newest JointState used by the command; lock-step waits for
    // it.
    uint64_t answers_sequence;
    // Mode of the daemon.
    uint32_t mode; // enum atas_mode
    // Number of joints with data, at most JOINTS.
    uint32_t joint_count;
    // Commanded positions, rad or m.
    double position[32];
    // Velocity feed-forward, rad/s or m/s; zero in HOLD.
    double velocity[32];
    // Force limit F_2 per hand for the held object, N; 0 for an empty hand. The robot only
    // copies it to JointState, so that the limit survives a restart of the daemon.
    double grip_limit_n[2];
    // Written as zero.
    uint32_t pad;
    // CRC-32 (IEEE) of every byte before this field.
    uint32_t crc32;
} atas_joint_command;
#define ATAS_JOINT_COMMAND_TYPE "atas.JointCommand.v2"
_Static_assert(sizeof(atas_joint_command) == 592, "atas_joint_command");
_Static_assert(_Alignof(atas_joint_command) == 8, "atas_joint_command");
_Static_assert(offsetof(atas_joint_command, stamp) == 0, "atas_joint_command.stamp");
_Static_assert(offsetof(atas_joint_command, valid_until_ns) == 24, "atas_joint_command.valid_until_ns");
_Static_assert(offsetof(atas_joint_command, tick) == 32, "atas_joint_command.tick");
_Static_assert(offsetof(atas_joint_command, answers_sequence) == 40, "atas_joint_command.answers_sequence");
_Static_assert(offsetof(atas_joint_command, mode) == 48, "atas_joint_command.mode");
_Static_assert(offsetof(atas_joint_command, joint_count) == 52, "atas_joint_command.joint_count");
_Static_assert(offsetof(atas_joint_command, position) == 56, "atas_joint_command.position");
_Static_assert(offsetof(atas_joint_command, velocity) == 312, "atas_joint_command.velocity");
_Static_assert(offsetof(atas_joint_command, grip_limit_n) == 568, "atas_joint_command.grip_limit_n");
_Static_assert(offsetof(atas_joint_command, pad) == 584, "atas_joint_command.pad");
_Static_assert(offsetof(atas_joint_command, crc32) == 588, "atas_joint_command.crc32");
// Call last, after every other field is final.
static inline void atas_joint_command_seal(atas_joint_command *payload) {
    payload->crc32 = atas_crc32(payload, offsetof(atas_joint_command, crc32));
}
static inline int atas_joint_command_is_intact(const atas_joint_command *payload) {
    return payload->crc32 == atas_crc32(payload, offsetof(atas_joint_command, crc32));
}

// A goal request. All poses are in the robot base frame (x forward, y left, z up, origin on
// the table top under the torso).
typedef struct atas_goal_request {
    // captured_ns is when the client sent it.
    atas_stamp stamp;
    // Id chosen by the client; repeated in every update.
    uint64_t goal_id;
    // Task.
    uint32_t kind; // enum atas_goal_kind
    // Acting hand; for assembly, the hand that screws.
    uint32_t hand; // enum atas_hand
    // Reaction to the disconnection of the client.
    uint32_t policy; // enum atas_goal_policy
    // Direction in which a cap is turned; not used by GRASP and PICK_PLACE.
    uint32_t turn; // enum atas_turn
    // Grasp point, m. The object may be some millimetres off.
    double from_m[3];
    // Direction of the closing axis at from_m, from the side of finger 2 to that of finger
    // 1, rad from +x towards +y.
    double from_yaw_rad;
    // Place position of the object, m; not used by GRASP.
    double to_m[3];
    // Direction of the closing axis at to_m, rad; not used by GRASP.
    double to_yaw_rad;
    // Expected object width along the closing axis, m. The hand opens slightly wider.
    double width_m;
    // Lift height, m.
    double lift_m;
    // Hold time after the lift before the goal succeeds, s.
    double hold_s;
    // Expected width of the object in the other hand, m; only used by ASSEMBLE (bottle).
    double helper_width_m;
    // Height of the object above the grasp point, m; the hand approaches from above it. Zero
    // if unknown.
    double top_m;
    // Largest force per grasp side, N; it replaces the stiffness-based force limit F_2. Zero
    // if unknown.
    double max_force_n;
    // Task name for CUSTOM.
    char task[32];
} atas_goal_request;
#define ATAS_GOAL_REQUEST_TYPE "atas.GoalRequest.v3"
_Static_assert(sizeof(atas_goal_request) == 192, "atas_goal_request");
_Static_assert(_Alignof(atas_goal_request) == 8, "atas_goal_request");
_Static_assert(offsetof(atas_goal_request, stamp) == 0, "atas_goal_request.stamp");
_Static_assert(offsetof(atas_goal_request, goal_id) == 24, "atas_goal_request.goal_id");
_Static_assert(offsetof(atas_goal_request, kind) == 32, "atas_goal_request.kind");
_Static_assert(offsetof(atas_goal_request, hand) == 36, "atas_goal_request.hand");
_Static_assert(offsetof(atas_goal_request, policy) == 40, "atas_goal_request.policy");
_Static_assert(offsetof(atas_goal_request, turn) == 44, "atas_goal_request.turn");
_Static_assert(offsetof(atas_goal_request, from_m) == 48, "atas_goal_request.from_m");
_Static_assert(offsetof(atas_goal_request, from_yaw_rad) == 72, "atas_goal_request.from_yaw_rad");
_Static_assert(offsetof(atas_goal_request, to_m) == 80, "atas_goal_request.to_m");
_Static_assert(offsetof(atas_goal_request, to_yaw_rad) == 104, "atas_goal_request.to_yaw_rad");
_Static_assert(offsetof(atas_goal_request, width_m) == 112, "atas_goal_request.width_m");
_Static_assert(offsetof(atas_goal_request, lift_m) == 120, "atas_goal_request.lift_m");
_Static_assert(offsetof(atas_goal_request, hold_s) == 128, "atas_goal_request.hold_s");
_Static_assert(offsetof(atas_goal_request, helper_width_m) == 136, "atas_goal_request.helper_width_m");
_Static_assert(offsetof(atas_goal_request, top_m) == 144, "atas_goal_request.top_m");
_Static_assert(offsetof(atas_goal_request, max_force_n) == 152, "atas_goal_request.max_force_n");
_Static_assert(offsetof(atas_goal_request, task) == 160, "atas_goal_request.task");

// Estimates of the grasp and the object, SI units; zero while unknown.
typedef struct atas_grasp_figures {
    // Normal force per fingertip, N.
    float normal_n[4];
    // Tangential force per fingertip, N.
    float tangential_n[4];
    // Minimum grip force F_1, N.
    float f1_n;
    // Force limit F_2, N.
    float f2_n;
    // Object stiffness from the stiffness probe, N/m.
    float stiffness_n_m;
    // Confidence of the stiffness, 0 to 1.
    float stiffness_confidence;
    // Estimated friction coefficient, lowest of all fingertips.
    float friction;
    // Height by which the hand has lifted the object, m.
    float lifted_m;
} atas_grasp_figures;
#define ATAS_GRASP_FIGURES_TYPE "atas.GraspFigures.v1"
_Static_assert(sizeof(atas_grasp_figures) == 56, "atas_grasp_figures");
_Static_assert(_Alignof(atas_grasp_figures) == 4, "atas_grasp_figures");
_Static_assert(offsetof(atas_grasp_figures, normal_n) == 0, "atas_grasp_figures.normal_n");
_Static_assert(offsetof(atas_grasp_figures, tangential_n) == 16, "atas_grasp_figures.tangential_n");
_Static_assert(offsetof(atas_grasp_figures, f1_n) == 32, "atas_grasp_figures.f1_n");
_Static_assert(offsetof(atas_grasp_figures, f2_n) == 36, "atas_grasp_figures.f2_n");
_Static_assert(offsetof(atas_grasp_figures, stiffness_n_m) == 40, "atas_grasp_figures.stiffness_n_m");
_Static_assert(offsetof(atas_grasp_figures, stiffness_confidence) == 44, "atas_grasp_figures.stiffness_confidence");
_Static_assert(offsetof(atas_grasp_figures, friction) == 48, "atas_grasp_figures.friction");
_Static_assert(offsetof(atas_grasp_figures, lifted_m) == 52, "atas_grasp_figures.lifted_m");

// A cause with its module, value and limit.
typedef struct atas_reason {
    // The cause.
    uint32_t cause; // enum atas_cause
    // The module that reports it; ModuleId::NONE outside the modules.
    uint32_t module; // enum atas_module_id
    // Value that violates the limit, in the unit that Reason's Display prints.
    double value;
    // The violated limit.
    double limit;
    // Index of the field, joint, fingertip or hand; the meaning depends on the cause.
    uint32_t index;
    // Written as zero.
    uint32_t pad;
} atas_reason;
#define ATAS_REASON_TYPE "atas.Reason.v1"
_Static_assert(sizeof(atas_reason) == 32, "atas_reason");
_Static_assert(_Alignof(atas_reason) == 8, "atas_reason");
_Static_assert(offsetof(atas_reason, cause) == 0, "atas_reason.cause");
_Static_assert(offsetof(atas_reason, module) == 4, "atas_reason.module");
_Static_assert(offsetof(atas_reason, value) == 8, "atas_reason.value");
_Static_assert(offsetof(atas_reason, limit) == 16, "atas_reason.limit");
_Static_assert(offsetof(atas_reason, index) == 24, "atas_reason.index");
_Static_assert(offsetof(atas_reason, pad) == 28, "atas_reason.pad");

// Progress report of a goal.
typedef struct atas_goal_update {
    // captured_ns is the time of the tick.
    atas_stamp stamp;
    // Echo of GoalRequest::goal_id.
    uint64_t goal_id;
    // Tick of this update.
    uint64_t tick;
    // State of the goal.
    uint32_t state; // enum atas_goal_state
    // Fraction done, 0 to 1.
    float progress;
    // Reason of a rejection, refusal, failure or hold.
    atas_reason reason;
    // Name of the task step, for example lift. If the task is unknown: the requested task
    // name.
    char step[16];
    // Present estimates of the grasp and the object.
    atas_grasp_figures figures;
} atas_goal_update;
#define ATAS_GOAL_UPDATE_TYPE "atas.GoalUpdate.v1"
_Static_assert(sizeof(atas_goal_update) == 152, "atas_goal_update");
_Static_assert(_Alignof(atas_goal_update) == 8, "atas_goal_update");
_Static_assert(offsetof(atas_goal_update, stamp) == 0, "atas_goal_update.stamp");
_Static_assert(offsetof(atas_goal_update, goal_id) == 24, "atas_goal_update.goal_id");
_Static_assert(offsetof(atas_goal_update, tick) == 32, "atas_goal_update.tick");
_Static_assert(offsetof(atas_goal_update, state) == 40, "atas_goal_update.state");
_Static_assert(offsetof(atas_goal_update, progress) == 44, "atas_goal_update.progress");
_Static_assert(offsetof(atas_goal_update, reason) == 48, "atas_goal_update.reason");
_Static_assert(offsetof(atas_goal_update, step) == 80, "atas_goal_update.step");
_Static_assert(offsetof(atas_goal_update, figures) == 96, "atas_goal_update.figures");

// Target of one hand in the stream of a goal teleop. Frame: robot base (x forward, y left, z
// up, origin on the table top under the torso); the hand points straight down.
//
// The newest target replaces older ones. The hand tracks it within the daemon's own limits;
// the controller alone determines the grip force.
typedef struct atas_grasp_target {
    // writer_epoch is that of the goal request, sequence increases, captured_ns is the
    // creation time of the target.
    atas_stamp stamp;
    // End of validity, ns of the daemon's clock, effective up to two seconds ahead. Without a
    // newer target the hand then stops and keeps its grip.
    uint64_t valid_until_ns;
    // Hand to move.
    uint32_t hand; // enum atas_hand
    // Grip command.
    uint32_t grip; // enum atas_grip_order
    // Point between the fingertips, m.
    double centre_m[3];
    // Direction of the closing axis, rad from +x towards +y. Directions half a turn apart are
    // the same grasp; the hand takes the nearer one.
    double closing_yaw_rad;
    // Distance between the fingertip surfaces, m; not used by HOLD.
    double opening_m;
    // Written as zero.
    uint32_t pad;
    // CRC-32 (IEEE) of every byte before this field.
    uint32_t crc32;
} atas_grasp_target;
#define ATAS_GRASP_TARGET_TYPE "atas.GraspTarget.v1"
_Static_assert(sizeof(atas_grasp_target) == 88, "atas_grasp_target");
_Static_assert(_Alignof(atas_grasp_target) == 8, "atas_grasp_target");
_Static_assert(offsetof(atas_grasp_target, stamp) == 0, "atas_grasp_target.stamp");
_Static_assert(offsetof(atas_grasp_target, valid_until_ns) == 24, "atas_grasp_target.valid_until_ns");
_Static_assert(offsetof(atas_grasp_target, hand) == 32, "atas_grasp_target.hand");
_Static_assert(offsetof(atas_grasp_target, grip) == 36, "atas_grasp_target.grip");
_Static_assert(offsetof(atas_grasp_target, centre_m) == 40, "atas_grasp_target.centre_m");
_Static_assert(offsetof(atas_grasp_target, closing_yaw_rad) == 64, "atas_grasp_target.closing_yaw_rad");
_Static_assert(offsetof(atas_grasp_target, opening_m) == 72, "atas_grasp_target.opening_m");
_Static_assert(offsetof(atas_grasp_target, pad) == 80, "atas_grasp_target.pad");
_Static_assert(offsetof(atas_grasp_target, crc32) == 84, "atas_grasp_target.crc32");
// Call last, after every other field is final.
static inline void atas_grasp_target_seal(atas_grasp_target *payload) {
    payload->crc32 = atas_crc32(payload, offsetof(atas_grasp_target, crc32));
}
static inline int atas_grasp_target_is_intact(const atas_grasp_target *payload) {
    return payload->crc32 == atas_crc32(payload, offsetof(atas_grasp_target, crc32));
}

// A control request.
typedef struct atas_control_request {
    // captured_ns is when the client sent it.
    atas_stamp stamp;
    // Operation.
    uint32_t op; // enum atas_control_op
    // Written as zero.
    uint32_t pad;
    // Numeric argument, if any.
    double value;
    // Name argument, if any.
    char name[64];
} atas_control_request;
#define ATAS_CONTROL_REQUEST_TYPE "atas.ControlRequest.v1"
_Static_assert(sizeof(atas_control_request) == 104, "atas_control_request");
_Static_assert(_Alignof(atas_control_request) == 8, "atas_control_request");
_Static_assert(offsetof(atas_control_request, stamp) == 0, "atas_control_request.stamp");
_Static_assert(offsetof(atas_control_request, op) == 24, "atas_control_request.op");
_Static_assert(offsetof(atas_control_request, pad) == 28, "atas_control_request.pad");
_Static_assert(offsetof(atas_control_request, value) == 32, "atas_control_request.value");
_Static_assert(offsetof(atas_control_request, name) == 40, "atas_control_request.name");

// Reply to a control request: exactly one, sent after the request took effect.
typedef struct atas_control_reply {
    // captured_ns is when the daemon answered.
    atas_stamp stamp;
    // Result.
    uint32_t outcome; // enum atas_control_outcome
    // Written as zero.
    uint32_t pad;
    // Requested value.
    double value;
    // Lower limit of the parameter.
    double lower;
    // Upper limit of the parameter.
    double upper;
    // For a parameter: name, and description on a second line. For a refusal: the reason.
    char text[256];
} atas_control_reply;
#define ATAS_CONTROL_REPLY_TYPE "atas.ControlReply.v1"
_Static_assert(sizeof(atas_control_reply) == 312, "atas_control_reply");
_Static_assert(_Alignof(atas_control_reply) == 8, "atas_control_reply");
_Static_assert(offsetof(atas_control_reply, stamp) == 0, "atas_control_reply.stamp");
_Static_assert(offsetof(atas_control_reply, outcome) == 24, "atas_control_reply.outcome");
_Static_assert(offsetof(atas_control_reply, pad) == 28, "atas_control_reply.pad");
_Static_assert(offsetof(atas_control_reply, value) == 32, "atas_control_reply.value");
_Static_assert(offsetof(atas_control_reply, lower) == 40, "atas_control_reply.lower");
_Static_assert(offsetof(atas_control_reply, upper) == 48, "atas_control_reply.upper");
_Static_assert(offsetof(atas_control_reply, text) == 56, "atas_control_reply.text");

// A stop request. Any other data at the stop socket also stops the robot, without a reason.
typedef struct atas_stop_request {
    // captured_ns is when the client sent it.
    atas_stamp stamp;
    // Reason, for the log.
    char reason[96];
} atas_stop_request;
#define ATAS_STOP_REQUEST_TYPE "atas.StopRequest.v1"
_Static_assert(sizeof(atas_stop_request) == 120, "atas_stop_request");
_Static_assert(_Alignof(atas_stop_request) == 8, "atas_stop_request");
_Static_assert(offsetof(atas_stop_request, stamp) == 0, "atas_stop_request.stamp");
_Static_assert(offsetof(atas_stop_request, reason) == 24, "atas_stop_request.reason");

// The answer to a stop.
typedef struct atas_stop_answer {
    // captured_ns is the arrival time of the stop; sequence counts received stops.
    atas_stamp stamp;
    // Result.
    uint32_t outcome; // enum atas_stop_outcome
    // Process id of the daemon.
    uint32_t pid;
} atas_stop_answer;
#define ATAS_STOP_ANSWER_TYPE "atas.StopAnswer.v1"
_Static_assert(sizeof(atas_stop_answer) == 32, "atas_stop_answer");
_Static_assert(_Alignof(atas_stop_answer) == 8, "atas_stop_answer");
_Static_assert(offsetof(atas_stop_answer, stamp) == 0, "atas_stop_answer.stamp");
_Static_assert(offsetof(atas_stop_answer, outcome) == 24, "atas_stop_answer.outcome");
_Static_assert(offsetof(atas_stop_answer, pid) == 28, "atas_stop_answer.pid");

// One event. Ordered by stamp.sequence; a gap means that events were dropped because the
// queue was full.
typedef struct atas_module_event {
    // captured_ns is the time of the tick.
    atas_stamp stamp;
    // Tick of the event.
    uint64_t tick;
    // Kind of the event.
    uint32_t kind; // enum atas_event_kind
    // Module, if applicable.
    uint32_t module; // enum atas_module_id
    // Hand, if applicable.
    uint32_t hand; // enum atas_hand
    // Fingertip of the hand, if applicable.
    uint32_t finger;
    // Mode after the event.
    uint32_t mode; // enum atas_mode
    // Written as zero.
    uint32_t pad;
    // Value that triggered the event, SI units.
    double value;
    // Threshold of that value, SI units.
    double threshold;
    // Reason of a mode change, goal change or warning.
    atas_reason reason;
    // Name, if applicable.
    char text[16];
} atas_module_event;
#define ATAS_MODULE_EVENT_TYPE "atas.ModuleEvent.v1"
_Static_assert(sizeof(atas_module_event) == 120, "atas_module_event");
_Static_assert(_Alignof(atas_module_event) == 8, "atas_module_event");
_Static_assert(offsetof(atas_module_event, stamp) == 0, "atas_module_event.stamp");
_Static_assert(offsetof(atas_module_event, tick) == 24, "atas_module_event.tick");
_Static_assert(offsetof(atas_module_event, kind) == 32, "atas_module_event.kind");
_Static_assert(offsetof(atas_module_event, module) == 36, "atas_module_event.module");
_Static_assert(offsetof(atas_module_event, hand) == 40, "atas_module_event.hand");
_Static_assert(offsetof(atas_module_event, finger) == 44, "atas_module_event.finger");
_Static_assert(offsetof(atas_module_event, mode) == 48, "atas_module_event.mode");
_Static_assert(offsetof(atas_module_event, pad) == 52, "atas_module_event.pad");
_Static_assert(offsetof(atas_module_event, value) == 56, "atas_module_event.value");
_Static_assert(offsetof(atas_module_event, threshold) == 64, "atas_module_event.threshold");
_Static_assert(offsetof(atas_module_event, reason) == 72, "atas_module_event.reason");
_Static_assert(offsetof(atas_module_event, text) == 104, "atas_module_event.text");

// Percentiles of a duration since the start, ns.
typedef struct atas_percentiles {
    // Median.
    uint64_t p50_ns;
    // 99th percentile.
    uint64_t p99_ns;
    // 99.9th percentile.
    uint64_t p999_ns;
    // Maximum.
    uint64_t max_ns;
    // Number of samples.
    uint64_t count;
} atas_percentiles;
#define ATAS_PERCENTILES_TYPE "atas.Percentiles.v1"
_Static_assert(sizeof(atas_percentiles) == 40, "atas_percentiles");
_Static_assert(_Alignof(atas_percentiles) == 8, "atas_percentiles");
_Static_assert(offsetof(atas_percentiles, p50_ns) == 0, "atas_percentiles.p50_ns");
_Static_assert(offsetof(atas_percentiles, p99_ns) == 8, "atas_percentiles.p99_ns");
_Static_assert(offsetof(atas_percentiles, p999_ns) == 16, "atas_percentiles.p999_ns");
_Static_assert(offsetof(atas_percentiles, max_ns) == 24, "atas_percentiles.max_ns");
_Static_assert(offsetof(atas_percentiles, count) == 32, "atas_percentiles.count");

// Status of one hand's sensor. Counts are since the start of the daemon.
typedef struct atas_hand_status {
    // Accepted frames.
    uint64_t frames;
    // Lost frames, from gaps in the sequence.
    uint64_t lost;
    // Duplicate frames.
    uint64_t duplicates;
    // Frames that arrived after a newer one.
    uint64_t reordered;
    // Frames with a wrong checksum.
    uint64_t corrupt;
    // Frames with a stamp too far in the past or future.
    uint64_t mistimed;
    // Frames of another writer, hand or layout.
    uint64_t foreign;
    // Readings masked because they are not finite or out of range.
    uint64_t masked_elements;
    // Restarts of the sensor process.
    uint64_t restarts;
    // Contacts per fingertip, with hysteresis.
    uint64_t touches[4];
    // Writer epoch of the pinned writer.
    uint64_t writer_epoch;
    // Age of the newest accepted frame, ns; u64::MAX before the first.
    uint64_t age_ns;
    // Hash of the configured layout.
    uint64_t layout_hash;
    // Normal force per fingertip, N.
    float normal_n[4];
    // Tangential force per fingertip, N.
    float tangential_n[4];
    // 1 if the configuration requires this hand.
    uint32_t required;
    // Bit n set: the module with ModuleId n is active.
    uint32_t modules_active;
} atas_hand_status;
#define ATAS_HAND_STATUS_TYPE "atas.HandStatus.v1"
_Static_assert(sizeof(atas_hand_status) == 168, "atas_hand_status");
_Static_assert(_Alignof(atas_hand_status) == 8, "atas_hand_status");
_Static_assert(offsetof(atas_hand_status, frames) == 0, "atas_hand_status.frames");
_Static_assert(offsetof(atas_hand_status, lost) == 8, "atas_hand_status.lost");
_Static_assert(offsetof(atas_hand_status, duplicates) == 16, "atas_hand_status.duplicates");
_Static_assert(offsetof(atas_hand_status, reordered) == 24, "atas_hand_status.reordered");
_Static_assert(offsetof(atas_hand_status, corrupt) == 32, "atas_hand_status.corrupt");
_Static_assert(offsetof(atas_hand_status, mistimed) == 40, "atas_hand_status.mistimed");
_Static_assert(offsetof(atas_hand_status, foreign) == 48, "atas_hand_status.foreign");
_Static_assert(offsetof(atas_hand_status, masked_elements) == 56, "atas_hand_status.masked_elements");
_Static_assert(offsetof(atas_hand_status, restarts) == 64, "atas_hand_status.restarts");
_Static_assert(offsetof(atas_hand_status, touches) == 72, "atas_hand_status.touches");
_Static_assert(offsetof(atas_hand_status, writer_epoch) == 104, "atas_hand_status.writer_epoch");
_Static_assert(offsetof(atas_hand_status, age_ns) == 112, "atas_hand_status.age_ns");
_Static_assert(offsetof(atas_hand_status, layout_hash) == 120, "atas_hand_status.layout_hash");
_Static_assert(offsetof(atas_hand_status, normal_n) == 128, "atas_hand_status.normal_n");
_Static_assert(offsetof(atas_hand_status, tangential_n) == 144, "atas_hand_status.tangential_n");
_Static_assert(offsetof(atas_hand_status, required) == 160, "atas_hand_status.required");
_Static_assert(offsetof(atas_hand_status, modules_active) == 164, "atas_hand_status.modules_active");

// Status of the joint feedback.
typedef struct atas_joint_status {
    // Accepted joint states.
    uint64_t states;
    // Unused joint states, from gaps in the sequence: lost, or superseded within one tick.
    uint64_t lost;
    // Rejected joint states.
    uint64_t rejected;
    // Age of the newest joint state, ns; u64::MAX before the first.
    uint64_t age_ns;
} atas_joint_status;
#define ATAS_JOINT_STATUS_TYPE "atas.JointStatus.v1"
_Static_assert(sizeof(atas_joint_status) == 32, "atas_joint_status");
_Static_assert(_Alignof(atas_joint_status) == 8, "atas_joint_status");
_Static_assert(offsetof(atas_joint_status, states) == 0, "atas_joint_status.states");
_Static_assert(offsetof(atas_joint_status, lost) == 8, "atas_joint_status.lost");
_Static_assert(offsetof(atas_joint_status, rejected) == 16, "atas_joint_status.rejected");
_Static_assert(offsetof(atas_joint_status, age_ns) == 24, "atas_joint_status.age_ns");

// Status of the daemon, 50 Hz.
typedef struct atas_status {
    // captured_ns is the time of the snapshot.
    atas_stamp stamp;
    // Version of the daemon.
    char version[32];
    // FNV-1a 64 of the active configuration text.
    uint64_t config_hash;
    // Start time of the daemon, ns of CLOCK_MONOTONIC. In lock-step: virtual time of the
    // first tick, 0 before it.
    uint64_t started_ns;
    // Process id.
    uint32_t pid;
    // StatusFlags.
    uint32_t flags;
    // Mode of the daemon.
    uint32_t mode; // enum atas_mode
    // Tick rate, Hz.
    uint32_t rate_hz;
    // Reason of the mode HOLD, SAFE_STOP or FAULT.
    atas_reason reason;
    // Executed ticks.
    uint64_t ticks;
    // Missed ticks: their time had passed before they could begin.
    uint64_t missed_ticks;
    // Ticks that began more than a tenth of a period late.
    uint64_t late_ticks;
    // Ticks started by the arrival of the expected frames.
    uint64_t ticks_on_arrival;
    // Ticks started by the timeout because an expected frame did not arrive.
    uint64_t ticks_without_frame;
    // Records dropped because the queue to the supervisor was full.
    uint64_t dropped_records;
    // Active or last goal, 0 if none.
    uint64_t goal_id;
    // Kind of that goal.
    uint32_t goal_kind; // enum atas_goal_kind
    // State of that goal.
    uint32_t goal_state; // enum atas_goal_state
    // Task step.
    char step[16];
    // Name of a user-defined task, else empty.
    char task[32];
    // Reason, if the goal ended without success.
    atas_reason goal_reason;
    // Wake-up delay of the ticks.
    atas_percentiles wake;
    // Age of the newest frame at the tick.
    atas_percentiles frame_age;
    // Duration of the tick computation.
    atas_percentiles tick;
    // Time from the sensor stamp to the command.
    atas_percentiles sensor_to_command;
    // Per hand.
    atas_hand_status hands[2];
    // Joint feedback.
    atas_joint_status joints;
} atas_status;
#define ATAS_STATUS_TYPE "atas.Status.v3"
_Static_assert(sizeof(atas_status) == 792, "atas_status");
_Static_assert(_Alignof(atas_status) == 8, "atas_status");
_Static_assert(offsetof(atas_status, stamp) == 0, "atas_status.stamp");
_Static_assert(offsetof(atas_status, version) == 24, "atas_status.version");
_Static_assert(offsetof(atas_status, config_hash) == 56, "atas_status.config_hash");
_Static_assert(offsetof(atas_status, started_ns) == 64, "atas_status.started_ns");
_Static_assert(offsetof(atas_status, pid) == 72, "atas_status.pid");
_Static_assert(offsetof(atas_status, flags) == 76, "atas_status.flags");
_Static_assert(offsetof(atas_status, mode) == 80, "atas_status.mode");
_Static_assert(offsetof(atas_status, rate_hz) == 84, "atas_status.rate_hz");
_Static_assert(offsetof(atas_status, reason) == 88, "atas_status.reason");
_Static_assert(offsetof(atas_status, ticks) == 120, "atas_status.ticks");
_Static_assert(offsetof(atas_status, missed_ticks) == 128, "atas_status.missed_ticks");
_Static_assert(offsetof(atas_status, late_ticks) == 136, "atas_status.late_ticks");
_Static_assert(offsetof(atas_status, ticks_on_arrival) == 144, "atas_status.ticks_on_arrival");
_Static_assert(offsetof(atas_status, ticks_without_frame) == 152, "atas_status.ticks_without_frame");
_Static_assert(offsetof(atas_status, dropped_records) == 160, "atas_status.dropped_records");
_Static_assert(offsetof(atas_status, goal_id) == 168, "atas_status.goal_id");
_Static_assert(offsetof(atas_status, goal_kind) == 176, "atas_status.goal_kind");
_Static_assert(offsetof(atas_status, goal_state) == 180, "atas_status.goal_state");
_Static_assert(offsetof(atas_status, step) == 184, "atas_status.step");
_Static_assert(offsetof(atas_status, task) == 200, "atas_status.task");
_Static_assert(offsetof(atas_status, goal_reason) == 232, "atas_status.goal_reason");
_Static_assert(offsetof(atas_status, wake) == 264, "atas_status.wake");
_Static_assert(offsetof(atas_status, frame_age) == 304, "atas_status.frame_age");
_Static_assert(offsetof(atas_status, tick) == 344, "atas_status.tick");
_Static_assert(offsetof(atas_status, sensor_to_command) == 384, "atas_status.sensor_to_command");
_Static_assert(offsetof(atas_status, hands) == 424, "atas_status.hands");
_Static_assert(offsetof(atas_status, joints) == 760, "atas_status.joints");

// Status of a sensor device from its sensor process, about 10 Hz and once at exit.
typedef struct atas_sensor_status {
    // captured_ns is the time of the snapshot.
    atas_stamp stamp;
    // Driver name, for example optoforce.
    char driver[32];
    // Device name, for example a tty.
    char device[64];
    // Hand of the sensor.
    uint32_t hand; // enum atas_hand
    // 1 while the device delivers data.
    uint32_t alive;
    // Valid frames read from the device.
    uint64_t frames;
    // Lost frames, from gaps in the device's counter.
    uint64_t lost;
    // Bytes outside valid frames.
    uint64_t junk_bytes;
    // Frame candidates with a wrong checksum.
    uint64_t checksum_failures;
    // Frames whose status word reports an error or overload.
    uint64_t device_errors;
    // Last status word of the device.
    uint32_t device_status;
    // Written as zero.
    uint32_t pad;
} atas_sensor_status;
#define ATAS_SENSOR_STATUS_TYPE "atas.SensorStatus.v1"
_Static_assert(sizeof(atas_sensor_status) == 176, "atas_sensor_status");
_Static_assert(_Alignof(atas_sensor_status) == 8, "atas_sensor_status");
_Static_assert(offsetof(atas_sensor_status, stamp) == 0, "atas_sensor_status.stamp");
_Static_assert(offsetof(atas_sensor_status, driver) == 24, "atas_sensor_status.driver");
_Static_assert(offsetof(atas_sensor_status, device) == 56, "atas_sensor_status.device");
_Static_assert(offsetof(atas_sensor_status, hand) == 120, "atas_sensor_status.hand");
_Static_assert(offsetof(atas_sensor_status, alive) == 124, "atas_sensor_status.alive");
_Static_assert(offsetof(atas_sensor_status, frames) == 128, "atas_sensor_status.frames");
_Static_assert(offsetof(atas_sensor_status, lost) == 136, "atas_sensor_status.lost");
_Static_assert(offsetof(atas_sensor_status, junk_bytes) == 144, "atas_sensor_status.junk_bytes");
_Static_assert(offsetof(atas_sensor_status, checksum_failures) == 152, "atas_sensor_status.checksum_failures");
_Static_assert(offsetof(atas_sensor_status, device_errors) == 160, "atas_sensor_status.device_errors");
_Static_assert(offsetof(atas_sensor_status, device_status) == 168, "atas_sensor_status.device_status");
_Static_assert(offsetof(atas_sensor_status, pad) == 172, "atas_sensor_status.pad");

// Contact state of one fingertip after perception.
typedef struct atas_finger_report {
    // F_n in the contact-patch frame, N.
    float normal_n;
    // F_t in the contact-patch frame, N.
    float tangential_n;
    // dF_t over its window, N.
    float tangential_increment_n;
    // Friction utilisation S; 1 means gross slip.
    float utilisation;
    // S from the present friction estimate, without its history.
    float utilisation_now;
    // Estimated friction coefficient.
    float friction;
    // Commanded closing speed, m/s, positive when closing.
    float closing_m_s;
    // 1 while the fingertip is in contact.
    uint32_t in_contact;
} atas_finger_report;
#define ATAS_FINGER_REPORT_TYPE "atas.FingerReport.v1"
_Static_assert(sizeof(atas_finger_report) == 32, "atas_finger_report");
_Static_assert(_Alignof(atas_finger_report) == 4, "atas_finger_report");
_Static_assert(offsetof(atas_finger_report, normal_n) == 0, "atas_finger_report.normal_n");
_Static_assert(offsetof(atas_finger_report, tangential_n) == 4, "atas_finger_report.tangential_n");
_Static_assert(offsetof(atas_finger_report, tangential_increment_n) == 8, "atas_finger_report.tangential_increment_n");
_Static_assert(offsetof(atas_finger_report, utilisation) == 12, "atas_finger_report.utilisation");
_Static_assert(offsetof(atas_finger_report, utilisation_now) == 16, "atas_finger_report.utilisation_now");
_Static_assert(offsetof(atas_finger_report, friction) == 20, "atas_finger_report.friction");
_Static_assert(offsetof(atas_finger_report, closing_m_s) == 24, "atas_finger_report.closing_m_s");
_Static_assert(offsetof(atas_finger_report, in_contact) == 28, "atas_finger_report.in_contact");

// Grasp state and active modules of one hand.
typedef struct atas_hand_report {
    // Sequence number of the newest frame used by the tick.
    uint64_t frame_sequence;
    // Age of that frame at the tick, ns.
    uint64_t frame_age_ns;
    // Frames received since the previous tick.
    uint32_t frames;
    // Bit n set: the module with ModuleId n is active.
    uint32_t modules_active;
    // Index of the task step.
    uint32_t step;
    // Minimum grip force F_1, N.
    float f1_n;
    // Force limit F_2, N.
    float f2_n;
    // Object stiffness, N/m.
    float stiffness_n_m;
    // Commanded position of the hand's centre, base frame, m.
    double centre_m[3];
    // Per fingertip.
    atas_finger_report fingers[4];
} atas_hand_report;
#define ATAS_HAND_REPORT_TYPE "atas.HandReport.v1"
_Static_assert(sizeof(atas_hand_report) == 192, "atas_hand_report");
_Static_assert(_Alignof(atas_hand_report) == 8, "atas_hand_report");
_Static_assert(offsetof(atas_hand_report, frame_sequence) == 0, "atas_hand_report.frame_sequence");
_Static_assert(offsetof(atas_hand_report, frame_age_ns) == 8, "atas_hand_report.frame_age_ns");
_Static_assert(offsetof(atas_hand_report, frames) == 16, "atas_hand_report.frames");
_Static_assert(offsetof(atas_hand_report, modules_active) == 20, "atas_hand_report.modules_active");
_Static_assert(offsetof(atas_hand_report, step) == 24, "atas_hand_report.step");
_Static_assert(offsetof(atas_hand_report, f1_n) == 28, "atas_hand_report.f1_n");
_Static_assert(offsetof(atas_hand_report, f2_n) == 32, "atas_hand_report.f2_n");
_Static_assert(offsetof(atas_hand_report, stiffness_n_m) == 36, "atas_hand_report.stiffness_n_m");
_Static_assert(offsetof(atas_hand_report, centre_m) == 40, "atas_hand_report.centre_m");
_Static_assert(offsetof(atas_hand_report, fingers) == 64, "atas_hand_report.fingers");

// Report of one tick.
typedef struct atas_tick_report {
    // captured_ns is the time of the tick.
    atas_stamp stamp;
    // Tick index; a gap means missed ticks.
    uint64_t tick;
    // Ticks missed since the start.
    uint64_t missed_ticks;
    // Active goal, 0 if none.
    uint64_t goal_id;
    // Sequence number of the joint state used by the tick.
    uint64_t joint_sequence;
    // Wake-up delay of the tick, ns.
    uint32_t wake_late_ns;
    // Mode after the tick.
    uint32_t mode; // enum atas_mode
    // Duration of each stage, ns: intake, perception, modules, kinematics, safety, publish,
    // report, recording.
    uint32_t stage_ns[8];
    // Time from the capture of the newest frame to the publication of the command, ns.
    uint32_t sensor_to_command_ns;
    // CRC-32 of the published command.
    uint32_t command_crc32;
    // Per hand.
    atas_hand_report hands[2];
} atas_tick_report;
#define ATAS_TICK_REPORT_TYPE "atas.TickReport.v1"
_Static_assert(sizeof(atas_tick_report) == 488, "atas_tick_report");
_Static_assert(_Alignof(atas_tick_report) == 8, "atas_tick_report");
_Static_assert(offsetof(atas_tick_report, stamp) == 0, "atas_tick_report.stamp");
_Static_assert(offsetof(atas_tick_report, tick) == 24, "atas_tick_report.tick");
_Static_assert(offsetof(atas_tick_report, missed_ticks) == 32, "atas_tick_report.missed_ticks");
_Static_assert(offsetof(atas_tick_report, goal_id) == 40, "atas_tick_report.goal_id");
_Static_assert(offsetof(atas_tick_report, joint_sequence) == 48, "atas_tick_report.joint_sequence");
_Static_assert(offsetof(atas_tick_report, wake_late_ns) == 56, "atas_tick_report.wake_late_ns");
_Static_assert(offsetof(atas_tick_report, mode) == 60, "atas_tick_report.mode");
_Static_assert(offsetof(atas_tick_report, stage_ns) == 64, "atas_tick_report.stage_ns");
_Static_assert(offsetof(atas_tick_report, sensor_to_command_ns) == 96, "atas_tick_report.sensor_to_command_ns");
_Static_assert(offsetof(atas_tick_report, command_crc32) == 100, "atas_tick_report.command_crc32");
_Static_assert(offsetof(atas_tick_report, hands) == 104, "atas_tick_report.hands");

// Newest frames and joint state, at about 60 Hz. The 1 kHz streams have a closed set of peers;
// observers read this one instead.
typedef struct atas_view {
    // captured_ns is the tick's time; sequence counts the views.
    atas_stamp stamp;
    // Tick that published the view.
    uint64_t tick;
    // Per hand: 1 after the first frame.
    uint32_t has_frame[2];
    // 1 after the first joint state.
    uint32_t has_joints;
    // Written as zero.
    uint32_t pad;
    // Newest frame of each hand, as received, not validated.
    atas_hand_frame frames[2];
    // Newest joint state, as received, not validated.
    atas_joint_state joints;
} atas_view;
#define ATAS_VIEW_TYPE "atas.View.v2"
_Static_assert(sizeof(atas_view) == 7456, "atas_view");
_Static_assert(_Alignof(atas_view) == 8, "atas_view");
_Static_assert(offsetof(atas_view, stamp) == 0, "atas_view.stamp");
_Static_assert(offsetof(atas_view, tick) == 24, "atas_view.tick");
_Static_assert(offsetof(atas_view, has_frame) == 32, "atas_view.has_frame");
_Static_assert(offsetof(atas_view, has_joints) == 40, "atas_view.has_joints");
_Static_assert(offsetof(atas_view, pad) == 44, "atas_view.pad");
_Static_assert(offsetof(atas_view, frames) == 48, "atas_view.frames");
_Static_assert(offsetof(atas_view, joints) == 6352, "atas_view.joints");

// All tunable parameters, in the order of the daemon's parameter table.
typedef struct atas_settings_record {
    // FNV-1a 64 of the parameter names; values of another table are incompatible.
    uint64_t names_hash;
    // Number of used entries in value, at most SETTINGS.
    uint32_t count;
    // Written as zero.
    uint32_t pad;
    // Parameter values.
    double value[96];
} atas_settings_record;
#define ATAS_SETTINGS_RECORD_TYPE "atas.SettingsRecord.v1"
_Static_assert(sizeof(atas_settings_record) == 784, "atas_settings_record");
_Static_assert(_Alignof(atas_settings_record) == 8, "atas_settings_record");
_Static_assert(offsetof(atas_settings_record, names_hash) == 0, "atas_settings_record.names_hash");
_Static_assert(offsetof(atas_settings_record, count) == 8, "atas_settings_record.count");
_Static_assert(offsetof(atas_settings_record, pad) == 12, "atas_settings_record.pad");
_Static_assert(offsetof(atas_settings_record, value) == 16, "atas_settings_record.value");

// One step of a task. The numeric codes are defined in tasks::words of the crate atas.
typedef struct atas_step_record {
    // Display name.
    char name[16];
    // Motion of the hand.
    uint32_t motion;
    // Waypoint of the motion, if it has one.
    uint32_t waypoint;
    // Active modules: bit n stands for module number n.
    uint32_t modules;
    // Condition that ends the step.
    uint32_t transition;
    // Meeting point, for a step that ends at one.
    uint32_t point;
    // Written as zero.
    uint32_t pad;
    // Time limit, s; infinite for none.
    double timeout_s;
} atas_step_record;
#define ATAS_STEP_RECORD_TYPE "atas.StepRecord.v1"
_Static_assert(sizeof(atas_step_record) == 48, "atas_step_record");
_Static_assert(_Alignof(atas_step_record) == 8, "atas_step_record");
_Static_assert(offsetof(atas_step_record, name) == 0, "atas_step_record.name");
_Static_assert(offsetof(atas_step_record, motion) == 16, "atas_step_record.motion");
_Static_assert(offsetof(atas_step_record, waypoint) == 20, "atas_step_record.waypoint");
_Static_assert(offsetof(atas_step_record, modules) == 24, "atas_step_record.modules");
_Static_assert(offsetof(atas_step_record, transition) == 28, "atas_step_record.transition");
_Static_assert(offsetof(atas_step_record, point) == 32, "atas_step_record.point");
_Static_assert(offsetof(atas_step_record, pad) == 36, "atas_step_record.pad");
_Static_assert(offsetof(atas_step_record, timeout_s) == 40, "atas_step_record.timeout_s");

// Step sequence of one hand.
typedef struct atas_track_record {
    // Number of used entries in steps, at most STEPS; 0 for an idle hand.
    uint32_t count;
    // Written as zero.
    uint32_t pad;
    // Steps.
    atas_step_record steps[32];
} atas_track_record;
#define ATAS_TRACK_RECORD_TYPE "atas.TrackRecord.v1"
_Static_assert(sizeof(atas_track_record) == 1544, "atas_track_record");
_Static_assert(_Alignof(atas_track_record) == 8, "atas_track_record");
_Static_assert(offsetof(atas_track_record, count) == 0, "atas_track_record.count");
_Static_assert(offsetof(atas_track_record, pad) == 4, "atas_track_record.pad");
_Static_assert(offsetof(atas_track_record, steps) == 8, "atas_track_record.steps");

// Behaviour table of a task (paper Table 1): one row per combination of sensor bits, one level
// per actuator and row.
typedef struct atas_table_record {
    // FNV-1a over all other fields; 0 if the task has no table.
    uint64_t hash;
    // Number of used sensor bits, at most SENSOR_BITS; the first is the lowest bit of the
    // row number.
    uint32_t count;
    // Sensor bits.
    uint32_t bits[6]; // enum atas_sensor_bit
    // Written as zero.
    uint32_t pad;
    // Closing speed of the fingers per level, m/s; negative opens.
    double fingers_m_s[4];
    // Factor on the path speed of the hand per level, −1 (backwards) to 1.
    double hand[4];
    // Four bits per row, row 0 lowest: finger level plus four times hand level.
    uint64_t rows[4];
} atas_table_record;
#define ATAS_TABLE_RECORD_TYPE "atas.TableRecord.v1"
_Static_assert(sizeof(atas_table_record) == 136, "atas_table_record");
_Static_assert(_Alignof(atas_table_record) == 8, "atas_table_record");
_Static_assert(offsetof(atas_table_record, hash) == 0, "atas_table_record.hash");
_Static_assert(offsetof(atas_table_record, count) == 8, "atas_table_record.count");
_Static_assert(offsetof(atas_table_record, bits) == 12, "atas_table_record.bits");
_Static_assert(offsetof(atas_table_record, pad) == 36, "atas_table_record.pad");
_Static_assert(offsetof(atas_table_record, fingers_m_s) == 40, "atas_table_record.fingers_m_s");
_Static_assert(offsetof(atas_table_record, hand) == 72, "atas_table_record.hand");
_Static_assert(offsetof(atas_table_record, rows) == 104, "atas_table_record.rows");

// Task of a goal: built-in or user-defined.
typedef struct atas_task_record {
    // Display name.
    char name[16];
    // Steps of the hand that the goal names.
    atas_track_record acting;
    // Steps of the other hand.
    atas_track_record helping;
    // Table of the module "behaviour table".
    atas_table_record table;
} atas_task_record;
#define ATAS_TASK_RECORD_TYPE "atas.TaskRecord.v2"
_Static_assert(sizeof(atas_task_record) == 3240, "atas_task_record");
_Static_assert(_Alignof(atas_task_record) == 8, "atas_task_record");
_Static_assert(offsetof(atas_task_record, name) == 0, "atas_task_record.name");
_Static_assert(offsetof(atas_task_record, acting) == 16, "atas_task_record.acting");
_Static_assert(offsetof(atas_task_record, helping) == 1560, "atas_task_record.helping");
_Static_assert(offsetof(atas_task_record, table) == 3104, "atas_task_record.table");

// One supervisor request. Only the fields that its kind uses are set; all others are zero.
typedef struct atas_order_record {
    // Kind of the request.
    uint32_t kind; // enum atas_order_kind
    // Index of a parameter or of a hand.
    uint32_t index;
    // Goal of the request.
    uint64_t goal_id;
    // Value of a parameter. For START: largest allowed offset of the grasp from the commanded
    // position, m.
    double value;
    // Reason of a stop or hold.
    atas_reason reason;
    // Goal to start.
    atas_goal_request goal;
    // Task of that goal, as configured at that time.
    atas_task_record task;
    // New settings.
    atas_settings_record settings;
} atas_order_record;
#define ATAS_ORDER_RECORD_TYPE "atas.OrderRecord.v5"
_Static_assert(sizeof(atas_order_record) == 4272, "atas_order_record");
_Static_assert(_Alignof(atas_order_record) == 8, "atas_order_record");
_Static_assert(offsetof(atas_order_record, kind) == 0, "atas_order_record.kind");
_Static_assert(offsetof(atas_order_record, index) == 4, "atas_order_record.index");
_Static_assert(offsetof(atas_order_record, goal_id) == 8, "atas_order_record.goal_id");
_Static_assert(offsetof(atas_order_record, value) == 16, "atas_order_record.value");
_Static_assert(offsetof(atas_order_record, reason) == 24, "atas_order_record.reason");
_Static_assert(offsetof(atas_order_record, goal) == 56, "atas_order_record.goal");
_Static_assert(offsetof(atas_order_record, task) == 248, "atas_order_record.task");
_Static_assert(offsetof(atas_order_record, settings) == 3488, "atas_order_record.settings");

// Inputs of one tick and the resulting command. A tick with several frames of a hand, or
// several targets, is split into consecutive parts.
typedef struct atas_tick_inputs {
    // sequence counts the parts of all ticks from 0; captured_ns is the time of the tick.
    atas_stamp stamp;
    // Index of the tick; a gap means missed ticks.
    uint64_t tick;
    // Index of this part, from 0. Fields that are not per frame are repeated in every part.
    uint32_t part;
    // Number of parts of this tick.
    uint32_t parts;
    // Per hand, 1 if this part has a frame.
    uint32_t has_frame[2];
    // 1 if a joint state arrived.
    uint32_t has_joints;
    // 1 if this part has a target.
    uint32_t has_target;
    // Frame number part of each hand, as received, not validated.
    atas_hand_frame frames[2];
    // Newest joint state, as received, not validated.
    atas_joint_state joints;
    // Target number part, as received, not validated.
    atas_grasp_target target;
    // Supervisor request processed in this tick.
    atas_order_record order;
    // Published command.
    atas_joint_command command;
} atas_tick_inputs;
#define ATAS_TICK_INPUTS_TYPE "atas.TickInputs.v7"
_Static_assert(sizeof(atas_tick_inputs) == 12416, "atas_tick_inputs");
_Static_assert(_Alignof(atas_tick_inputs) == 8, "atas_tick_inputs");
_Static_assert(offsetof(atas_tick_inputs, stamp) == 0, "atas_tick_inputs.stamp");
_Static_assert(offsetof(atas_tick_inputs, tick) == 24, "atas_tick_inputs.tick");
_Static_assert(offsetof(atas_tick_inputs, part) == 32, "atas_tick_inputs.part");
_Static_assert(offsetof(atas_tick_inputs, parts) == 36, "atas_tick_inputs.parts");
_Static_assert(offsetof(atas_tick_inputs, has_frame) == 40, "atas_tick_inputs.has_frame");
_Static_assert(offsetof(atas_tick_inputs, has_joints) == 48, "atas_tick_inputs.has_joints");
_Static_assert(offsetof(atas_tick_inputs, has_target) == 52, "atas_tick_inputs.has_target");
_Static_assert(offsetof(atas_tick_inputs, frames) == 56, "atas_tick_inputs.frames");
_Static_assert(offsetof(atas_tick_inputs, joints) == 6360, "atas_tick_inputs.joints");
_Static_assert(offsetof(atas_tick_inputs, target) == 7464, "atas_tick_inputs.target");
_Static_assert(offsetof(atas_tick_inputs, order) == 7552, "atas_tick_inputs.order");
_Static_assert(offsetof(atas_tick_inputs, command) == 11824, "atas_tick_inputs.command");

// Sensor set-up of one hand.
typedef struct atas_hand_wiring_record {
    // Number of fingertips with sensors.
    uint32_t fingers;
    // 1 if the robot must hold when frames of this hand stop arriving.
    uint32_t required;
    // Nominal frame rate, Hz.
    double rate_hz;
    // Number of elements of the layout, at most ELEMENTS.
    uint32_t element_count;
    // Written as zero.
    uint32_t pad;
    // Layout::normal.
    double normal[64][3];
    // Layout::tangent1.
    double tangent1[64][3];
    // Layout::tangent2.
    double tangent2[64][3];
    // Layout::position_m.
    double position_m[64][3];
    // Layout::element_area_m2.
    double element_area_m2;
} atas_hand_wiring_record;
#define ATAS_HAND_WIRING_RECORD_TYPE "atas.HandWiringRecord.v2"
_Static_assert(sizeof(atas_hand_wiring_record) == 6176, "atas_hand_wiring_record");
_Static_assert(_Alignof(atas_hand_wiring_record) == 8, "atas_hand_wiring_record");
_Static_assert(offsetof(atas_hand_wiring_record, fingers) == 0, "atas_hand_wiring_record.fingers");
_Static_assert(offsetof(atas_hand_wiring_record, required) == 4, "atas_hand_wiring_record.required");
_Static_assert(offsetof(atas_hand_wiring_record, rate_hz) == 8, "atas_hand_wiring_record.rate_hz");
_Static_assert(offsetof(atas_hand_wiring_record, element_count) == 16, "atas_hand_wiring_record.element_count");
_Static_assert(offsetof(atas_hand_wiring_record, pad) == 20, "atas_hand_wiring_record.pad");
_Static_assert(offsetof(atas_hand_wiring_record, normal) == 24, "atas_hand_wiring_record.normal");
_Static_assert(offsetof(atas_hand_wiring_record, tangent1) == 1560, "atas_hand_wiring_record.tangent1");
_Static_assert(offsetof(atas_hand_wiring_record, tangent2) == 3096, "atas_hand_wiring_record.tangent2");
_Static_assert(offsetof(atas_hand_wiring_record, position_m) == 4632, "atas_hand_wiring_record.position_m");
_Static_assert(offsetof(atas_hand_wiring_record, element_area_m2) == 6168, "atas_hand_wiring_record.element_area_m2");

// Header of a run: everything that determines the controller's initial state.
typedef struct atas_run_header {
    // captured_ns is the start time of the daemon; the epoch is that of its commands.
    atas_stamp stamp;
    // Version of the daemon. Other versions may compute other commands.
    char version[32];
    // FNV-1a 64 of config.
    uint64_t config_hash;
    // Robot: name of a shipped robot, or absolute path of its model file.
    char robot[256];
    // FNV-1a 64 of the URDF and robot file texts; 0 if the files are missing.
    uint64_t robot_hash;
    // Tick rate, Hz.
    uint32_t rate_hz;
    // StatusFlags.
    uint32_t flags;
    // Nominal tick period, s.
    double tick_s;
    // 1 if joint feedback exists.
    uint32_t joints_required;
    // Written as zero.
    uint32_t pad;
    // Servo stiffness of each joint of one hand, N·m/rad; zero in unused entries.
    double stiffness[32];
    // Per hand.
    atas_hand_wiring_record hands[2];
    // Settings of the first tick. Later changes are supervisor requests.
    atas_settings_record settings;
    // Complete configuration as TOML, for readers only; a replay uses the other fields.
    char config[16384];
} atas_run_header;
#define ATAS_RUN_HEADER_TYPE "atas.RunHeader.v2"
_Static_assert(sizeof(atas_run_header) == 30128, "atas_run_header");
_Static_assert(_Alignof(atas_run_header) == 8, "atas_run_header");
_Static_assert(offsetof(atas_run_header, stamp) == 0, "atas_run_header.stamp");
_Static_assert(offsetof(atas_run_header, version) == 24, "atas_run_header.version");
_Static_assert(offsetof(atas_run_header, config_hash) == 56, "atas_run_header.config_hash");
_Static_assert(offsetof(atas_run_header, robot) == 64, "atas_run_header.robot");
_Static_assert(offsetof(atas_run_header, robot_hash) == 320, "atas_run_header.robot_hash");
_Static_assert(offsetof(atas_run_header, rate_hz) == 328, "atas_run_header.rate_hz");
_Static_assert(offsetof(atas_run_header, flags) == 332, "atas_run_header.flags");
_Static_assert(offsetof(atas_run_header, tick_s) == 336, "atas_run_header.tick_s");
_Static_assert(offsetof(atas_run_header, joints_required) == 344, "atas_run_header.joints_required");
_Static_assert(offsetof(atas_run_header, pad) == 348, "atas_run_header.pad");
_Static_assert(offsetof(atas_run_header, stiffness) == 352, "atas_run_header.stiffness");
_Static_assert(offsetof(atas_run_header, hands) == 608, "atas_run_header.hands");
_Static_assert(offsetof(atas_run_header, settings) == 12960, "atas_run_header.settings");
_Static_assert(offsetof(atas_run_header, config) == 13744, "atas_run_header.config");

// Sensor rows of all agents at the start of one field frame.
typedef struct atas_agent_sensors {
    // captured_ns is the time of the frame.
    atas_stamp stamp;
    // Index of the field frame within the trial.
    uint64_t frame;
    // Index of the trial (goal position).
    uint32_t trial;
    // Number of used entries in row, at most AGENTS.
    uint32_t agent_count;
    // Hash of the field parameters. Agents reject a field for which their tables were not
    // evolved.
    uint64_t field_hash;
    // Per agent: table row selected by the sensors; bit 0 is S1, bit 4 is S5.
    uint32_t row[1024];
} atas_agent_sensors;
#define ATAS_AGENT_SENSORS_TYPE "atas.AgentSensors.v2"
_Static_assert(sizeof(atas_agent_sensors) == 4144, "atas_agent_sensors");
_Static_assert(_Alignof(atas_agent_sensors) == 8, "atas_agent_sensors");
_Static_assert(offsetof(atas_agent_sensors, stamp) == 0, "atas_agent_sensors.stamp");
_Static_assert(offsetof(atas_agent_sensors, frame) == 24, "atas_agent_sensors.frame");
_Static_assert(offsetof(atas_agent_sensors, trial) == 32, "atas_agent_sensors.trial");
_Static_assert(offsetof(atas_agent_sensors, agent_count) == 36, "atas_agent_sensors.agent_count");
_Static_assert(offsetof(atas_agent_sensors, field_hash) == 40, "atas_agent_sensors.field_hash");
_Static_assert(offsetof(atas_agent_sensors, row) == 48, "atas_agent_sensors.row");

// Wheel commands of all agents for one field frame.
typedef struct atas_wheel_commands {
    // captured_ns is copied from the sensors that this command answers.
    atas_stamp stamp;
    // Field frame that this command answers.
    uint64_t frame;
    // Trial that this command answers.
    uint32_t trial;
    // Number of used entries in output.
    uint32_t agent_count;
    // First 8 bytes of the hash of the behaviour table in use; a change shows a table swap.
    uint64_t table_hash;
    // Per agent: output bits of the table; L1 bit 0, L2 bit 1, R1 bit 2, R2 bit 3.
    uint32_t output[1024];
} atas_wheel_commands;
#define ATAS_WHEEL_COMMANDS_TYPE "atas.WheelCommands.v1"
_Static_assert(sizeof(atas_wheel_commands) == 4144, "atas_wheel_commands");
_Static_assert(_Alignof(atas_wheel_commands) == 8, "atas_wheel_commands");
_Static_assert(offsetof(atas_wheel_commands, stamp) == 0, "atas_wheel_commands.stamp");
_Static_assert(offsetof(atas_wheel_commands, frame) == 24, "atas_wheel_commands.frame");
_Static_assert(offsetof(atas_wheel_commands, trial) == 32, "atas_wheel_commands.trial");
_Static_assert(offsetof(atas_wheel_commands, agent_count) == 36, "atas_wheel_commands.agent_count");
_Static_assert(offsetof(atas_wheel_commands, table_hash) == 40, "atas_wheel_commands.table_hash");
_Static_assert(offsetof(atas_wheel_commands, output) == 48, "atas_wheel_commands.output");

// State of a base at the start of a frame. Positions are relative to the base centre, m:
// ahead, left.
typedef struct atas_base_state {
    // captured_ns is the time of the frame.
    atas_stamp stamp;
    // Index of the frame.
    uint64_t frame;
    // Position of the object light, m; undefined while the hand holds the object.
    double object_m[2];
    // Position of the goal light, m.
    double goal_m[2];
    // Distance to the robot with the right of way, m; infinite if this robot has it or no
    // robot needs it.
    double right_of_way_m;
    // 1 while the object stands on the ground and its light is visible.
    uint32_t object_stands;
    // 1 while the wheels are stopped.
    uint32_t wheels_stopped;
    // Incident that ended the course.
    uint32_t mishap; // enum atas_mishap
    // Written as zero.
    uint32_t pad;
} atas_base_state;
#define ATAS_BASE_STATE_TYPE "atas.BaseState.v1"
_Static_assert(sizeof(atas_base_state) == 88, "atas_base_state");
_Static_assert(_Alignof(atas_base_state) == 8, "atas_base_state");
_Static_assert(offsetof(atas_base_state, stamp) == 0, "atas_base_state.stamp");
_Static_assert(offsetof(atas_base_state, frame) == 24, "atas_base_state.frame");
_Static_assert(offsetof(atas_base_state, object_m) == 32, "atas_base_state.object_m");
_Static_assert(offsetof(atas_base_state, goal_m) == 48, "atas_base_state.goal_m");
_Static_assert(offsetof(atas_base_state, right_of_way_m) == 64, "atas_base_state.right_of_way_m");
_Static_assert(offsetof(atas_base_state, object_stands) == 72, "atas_base_state.object_stands");
_Static_assert(offsetof(atas_base_state, wheels_stopped) == 76, "atas_base_state.wheels_stopped");
_Static_assert(offsetof(atas_base_state, mishap) == 80, "atas_base_state.mishap");
_Static_assert(offsetof(atas_base_state, pad) == 84, "atas_base_state.pad");

// Command to a base for one frame.
typedef struct atas_base_command {
    // captured_ns is copied from the state that this command answers.
    atas_stamp stamp;
    // Frame that this command answers.
    uint64_t frame;
    // Control owner.
    uint32_t owner; // enum atas_control_owner
    // Light that the base detects. With the goal light the base drives gently, because the
    // robot carries the object.
    uint32_t light; // enum atas_light
} atas_base_command;
#define ATAS_BASE_COMMAND_TYPE "atas.BaseCommand.v1"
_Static_assert(sizeof(atas_base_command) == 40, "atas_base_command");
_Static_assert(_Alignof(atas_base_command) == 8, "atas_base_command");
_Static_assert(offsetof(atas_base_command, stamp) == 0, "atas_base_command.stamp");
_Static_assert(offsetof(atas_base_command, frame) == 24, "atas_base_command.frame");
_Static_assert(offsetof(atas_base_command, owner) == 32, "atas_base_command.owner");
_Static_assert(offsetof(atas_base_command, light) == 36, "atas_base_command.light");

// Ground truth of one simulated object.
typedef struct atas_object_truth {
    // Object name, as in its data file.
    char name[32];
    // Centre of its shape, base frame, m.
    double position_m[3];
    // Orientation, base frame, quaternion w, x, y, z.
    double orientation[4];
    // Height of the centre above its initial rest height, m.
    double lifted_m;
    // Tilt of the upright axis, rad.
    double tilt_rad;
    // Minimum force per grasp side to carry the object, m·g / (2·μ), N.
    double needed_n;
    // Force at which the object is crushed, N; infinite if never.
    double crush_n;
    // Largest force applied so far, N.
    double max_force_n;
    // Sum of the support forces of the table or another base, N.
    double table_n;
    // Simulated time of the first landing after the last lift, ns; 0 if never.
    uint64_t landed_ns;
    // Simulated time at which the support first carries the object after that landing, ns; 0
    // if never. The threshold is the larger of 0.2 N and a tenth of its weight, so a grazing
    // corner does not count.
    uint64_t carried_ns;
    // Simulated time at which the last fingertip released the object after the last lift, ns;
    // 0 if never. It is the first release after landing, else the most recent one.
    uint64_t released_ns;
    // Clearance under the object at that moment, m.
    double released_above_m;
    // Largest excess of the support force over the weight from that landing until the release,
    // N, low-passed with 10 ms against impacts: the hand presses the object onto its support.
    double pressed_down_n;
    // Largest slip along the fingertips in any hold so far, m. Measured while the support does
    // not carry the whole weight.
    double slip_in_hand_m;
    // Largest rotation in any of these holds, rad.
    double turn_in_hand_rad;
    // Horizontal distance from the initial position, m.
    double displaced_m;
    // Rotation of a cap since thread engagement, rad, positive closing. This and the following
    // cap fields are 0 for other objects.
    double cap_angle_rad;
    // Angle at which the cap is closed, rad.
    double cap_closing_rad;
    // Thread friction torque before the cap closes, N·m.
    double cap_friction_n_m;
    // Present torque on the thread, N·m.
    double cap_torque_n_m;
    // Torque needed to turn the cap further (tightness), N·m.
    double cap_holding_n_m;
    // 1 while the cap is on the neck and its thread is engaged.
    uint32_t cap_engaged;
    // 1 while the thread is engaged and turned to the closing angle or beyond.
    uint32_t cap_closed;
    // 1 while the object stands unsupported by a hand, within 5° of upright and 10 mm of its
    // initial position.
    uint32_t stands;
    // 1 while a fingertip presses the object.
    uint32_t pressed;
    // 1 once crushed.
    uint32_t crushed;
    // 1 once dropped: fallen out of the hand after a lift.
    uint32_t dropped;
    // 1 once tipped over.
    uint32_t tipped;
    // 1 once spilt: a bottle tilted while it was not closed.
    uint32_t spilt;
} atas_object_truth;
#define ATAS_OBJECT_TRUTH_TYPE "atas.ObjectTruth.v5"
_Static_assert(sizeof(atas_object_truth) == 272, "atas_object_truth");
_Static_assert(_Alignof(atas_object_truth) == 8, "atas_object_truth");
_Static_assert(offsetof(atas_object_truth, name) == 0, "atas_object_truth.name");
_Static_assert(offsetof(atas_object_truth, position_m) == 32, "atas_object_truth.position_m");
_Static_assert(offsetof(atas_object_truth, orientation) == 56, "atas_object_truth.orientation");
_Static_assert(offsetof(atas_object_truth, lifted_m) == 88, "atas_object_truth.lifted_m");
_Static_assert(offsetof(atas_object_truth, tilt_rad) == 96, "atas_object_truth.tilt_rad");
_Static_assert(offsetof(atas_object_truth, needed_n) == 104, "atas_object_truth.needed_n");
_Static_assert(offsetof(atas_object_truth, crush_n) == 112, "atas_object_truth.crush_n");
_Static_assert(offsetof(atas_object_truth, max_force_n) == 120, "atas_object_truth.max_force_n");
_Static_assert(offsetof(atas_object_truth, table_n) == 128, "atas_object_truth.table_n");
_Static_assert(offsetof(atas_object_truth, landed_ns) == 136, "atas_object_truth.landed_ns");
_Static_assert(offsetof(atas_object_truth, carried_ns) == 144, "atas_object_truth.carried_ns");
_Static_assert(offsetof(atas_object_truth, released_ns) == 152, "atas_object_truth.released_ns");
_Static_assert(offsetof(atas_object_truth, released_above_m) == 160, "atas_object_truth.released_above_m");
_Static_assert(offsetof(atas_object_truth, pressed_down_n) == 168, "atas_object_truth.pressed_down_n");
_Static_assert(offsetof(atas_object_truth, slip_in_hand_m) == 176, "atas_object_truth.slip_in_hand_m");
_Static_assert(offsetof(atas_object_truth, turn_in_hand_rad) == 184, "atas_object_truth.turn_in_hand_rad");
_Static_assert(offsetof(atas_object_truth, displaced_m) == 192, "atas_object_truth.displaced_m");
_Static_assert(offsetof(atas_object_truth, cap_angle_rad) == 200, "atas_object_truth.cap_angle_rad");
_Static_assert(offsetof(atas_object_truth, cap_closing_rad) == 208, "atas_object_truth.cap_closing_rad");
_Static_assert(offsetof(atas_object_truth, cap_friction_n_m) == 216, "atas_object_truth.cap_friction_n_m");
_Static_assert(offsetof(atas_object_truth, cap_torque_n_m) == 224, "atas_object_truth.cap_torque_n_m");
_Static_assert(offsetof(atas_object_truth, cap_holding_n_m) == 232, "atas_object_truth.cap_holding_n_m");
_Static_assert(offsetof(atas_object_truth, cap_engaged) == 240, "atas_object_truth.cap_engaged");
_Static_assert(offsetof(atas_object_truth, cap_closed) == 244, "atas_object_truth.cap_closed");
_Static_assert(offsetof(atas_object_truth, stands) == 248, "atas_object_truth.stands");
_Static_assert(offsetof(atas_object_truth, pressed) == 252, "atas_object_truth.pressed");
_Static_assert(offsetof(atas_object_truth, crushed) == 256, "atas_object_truth.crushed");
_Static_assert(offsetof(atas_object_truth, dropped) == 260, "atas_object_truth.dropped");
_Static_assert(offsetof(atas_object_truth, tipped) == 264, "atas_object_truth.tipped");
_Static_assert(offsetof(atas_object_truth, spilt) == 268, "atas_object_truth.spilt");

// Ground truth of the simulated world.
typedef struct atas_world_truth {
    // captured_ns is the simulated time.
    atas_stamp stamp;
    // Milliseconds of real time skipped so far because the simulator was late; 0 in lock-step.
    uint64_t missed_ticks;
    // Number of used entries in objects.
    uint32_t object_count;
    // Commands rejected or expired so far.
    uint32_t expired_commands;
    // Objects.
    atas_object_truth objects[4];
    // Sliding distance of each fingertip on the touched surface since its first contact, m.
    double slip_m[2][4];
    // Normal force of each fingertip, N.
    double normal_n[2][4];
} atas_world_truth;
#define ATAS_WORLD_TRUTH_TYPE "atas.WorldTruth.v5"
_Static_assert(sizeof(atas_world_truth) == 1256, "atas_world_truth");
_Static_assert(_Alignof(atas_world_truth) == 8, "atas_world_truth");
_Static_assert(offsetof(atas_world_truth, stamp) == 0, "atas_world_truth.stamp");
_Static_assert(offsetof(atas_world_truth, missed_ticks) == 24, "atas_world_truth.missed_ticks");
_Static_assert(offsetof(atas_world_truth, object_count) == 32, "atas_world_truth.object_count");
_Static_assert(offsetof(atas_world_truth, expired_commands) == 36, "atas_world_truth.expired_commands");
_Static_assert(offsetof(atas_world_truth, objects) == 40, "atas_world_truth.objects");
_Static_assert(offsetof(atas_world_truth, slip_m) == 1128, "atas_world_truth.slip_m");
_Static_assert(offsetof(atas_world_truth, normal_n) == 1192, "atas_world_truth.normal_n");

// Pose, sensor row and output of one agent in one frame.
typedef struct atas_agent_truth {
    // Centre relative to the field centre, x right and y up, px.
    float position_px[2];
    // Heading, counter-clockwise from +x, 1/64 turns.
    uint32_t heading_steps;
    // Table row selected by the sensors: bit 0 is S1, bit 4 is S5.
    uint32_t row;
    // Output bits of the table in this frame: L1 bit 0, L2 bit 1, R1 bit 2, R2 bit 3. 0
    // (standing) without a command and after a trial.
    uint32_t output;
    // 1 if the agent pushed the object in the previous frame.
    uint32_t touches;
} atas_agent_truth;
#define ATAS_AGENT_TRUTH_TYPE "atas.AgentTruth.v1"
_Static_assert(sizeof(atas_agent_truth) == 24, "atas_agent_truth");
_Static_assert(_Alignof(atas_agent_truth) == 4, "atas_agent_truth");
_Static_assert(offsetof(atas_agent_truth, position_px) == 0, "atas_agent_truth.position_px");
_Static_assert(offsetof(atas_agent_truth, heading_steps) == 8, "atas_agent_truth.heading_steps");
_Static_assert(offsetof(atas_agent_truth, row) == 12, "atas_agent_truth.row");
_Static_assert(offsetof(atas_agent_truth, output) == 16, "atas_agent_truth.output");
_Static_assert(offsetof(atas_agent_truth, touches) == 20, "atas_agent_truth.touches");

// State of one field: object, goal and score.
typedef struct atas_field_truth {
    // Centre of the object, px.
    float object_px[2];
    // Centre of the goal, px.
    float goal_px[2];
    // Distance from the object to the goal, px.
    float distance_px;
    // E1 (Eq. 2) of that distance, points.
    float e1_points;
    // E2 (Eq. 3), points; 0 until the object is within the goal radius.
    float e2_points;
    // Score of the trial by the rule of the field, of 100 points; 0 until the trial is over.
    float points;
    // First frame, from 1, after which the object is within the goal radius; 0 until then.
    uint32_t reached_frame;
    // 1 once the trial is over and the object has reached its goal.
    uint32_t solved;
} atas_field_truth;
#define ATAS_FIELD_TRUTH_TYPE "atas.FieldTruth.v1"
_Static_assert(sizeof(atas_field_truth) == 40, "atas_field_truth");
_Static_assert(_Alignof(atas_field_truth) == 4, "atas_field_truth");
_Static_assert(offsetof(atas_field_truth, object_px) == 0, "atas_field_truth.object_px");
_Static_assert(offsetof(atas_field_truth, goal_px) == 8, "atas_field_truth.goal_px");
_Static_assert(offsetof(atas_field_truth, distance_px) == 16, "atas_field_truth.distance_px");
_Static_assert(offsetof(atas_field_truth, e1_points) == 20, "atas_field_truth.e1_points");
_Static_assert(offsetof(atas_field_truth, e2_points) == 24, "atas_field_truth.e2_points");
_Static_assert(offsetof(atas_field_truth, points) == 28, "atas_field_truth.points");
_Static_assert(offsetof(atas_field_truth, reached_frame) == 32, "atas_field_truth.reached_frame");
_Static_assert(offsetof(atas_field_truth, solved) == 36, "atas_field_truth.solved");

// Result of a completed trial on field 0.
typedef struct atas_trial_truth {
    // Index of the trial.
    uint32_t trial;
    // Goal of the trial, 1 to 8; 0 in an unused entry.
    uint32_t goal;
    // Final distance from the object to the goal, px.
    float distance_px;
    // First frame, from 1, after which the object was within the goal radius; 0 if never.
    uint32_t reached_frame;
    // Score by the rule of the field, of 100 points.
    float points;
    // Number of parallel fields in which the object reached its goal.
    uint32_t solved_fields;
    // Frames in which the agents stood still because the command was late.
    uint32_t missed_frames;
    // Frames in which the agents stood still because the command was malformed.
    uint32_t refused_frames;
} atas_trial_truth;
#define ATAS_TRIAL_TRUTH_TYPE "atas.TrialTruth.v1"
_Static_assert(sizeof(atas_trial_truth) == 32, "atas_trial_truth");
_Static_assert(_Alignof(atas_trial_truth) == 4, "atas_trial_truth");
_Static_assert(offsetof(atas_trial_truth, trial) == 0, "atas_trial_truth.trial");
_Static_assert(offsetof(atas_trial_truth, goal) == 4, "atas_trial_truth.goal");
_Static_assert(offsetof(atas_trial_truth, distance_px) == 8, "atas_trial_truth.distance_px");
_Static_assert(offsetof(atas_trial_truth, reached_frame) == 12, "atas_trial_truth.reached_frame");
_Static_assert(offsetof(atas_trial_truth, points) == 16, "atas_trial_truth.points");
_Static_assert(offsetof(atas_trial_truth, solved_fields) == 20, "atas_trial_truth.solved_fields");
_Static_assert(offsetof(atas_trial_truth, missed_frames) == 24, "atas_trial_truth.missed_frames");
_Static_assert(offsetof(atas_trial_truth, refused_frames) == 28, "atas_trial_truth.refused_frames");

// A straight wall inside a field.
typedef struct atas_wall_truth {
    // Start point, px.
    float from_px[2];
    // End point, px.
    float to_px[2];
} atas_wall_truth;
#define ATAS_WALL_TRUTH_TYPE "atas.WallTruth.v1"
_Static_assert(sizeof(atas_wall_truth) == 16, "atas_wall_truth");
_Static_assert(_Alignof(atas_wall_truth) == 4, "atas_wall_truth");
_Static_assert(offsetof(atas_wall_truth, from_px) == 0, "atas_wall_truth.from_px");
_Static_assert(offsetof(atas_wall_truth, to_px) == 8, "atas_wall_truth.to_px");

// A cylindrical post inside a field.
typedef struct atas_post_truth {
    // Centre, px.
    float at_px[2];
    // Radius, px.
    float radius_px;
} atas_post_truth;
#define ATAS_POST_TRUTH_TYPE "atas.PostTruth.v1"
_Static_assert(sizeof(atas_post_truth) == 12, "atas_post_truth");
_Static_assert(_Alignof(atas_post_truth) == 4, "atas_post_truth");
_Static_assert(offsetof(atas_post_truth, at_px) == 0, "atas_post_truth.at_px");
_Static_assert(offsetof(atas_post_truth, radius_px) == 8, "atas_post_truth.radius_px");

// Ground truth of all fields in one frame.
typedef struct atas_arena_truth {
    // captured_ns is the time of the frame, as in AgentSensors.
    atas_stamp stamp;
    // Index of the frame within the trial; equals trial_frames when the trial is over.
    uint64_t frame;
    // Hash of the field parameters, as in AgentSensors.
    uint64_t field_hash;
    // First 8 bytes of the hash of the behaviour table in use; 0 without a command.
    uint64_t table_hash;
    // Index of the trial (goal position).
    uint32_t trial;
    // Number of trials in the session.
    uint32_t trial_count;
    // Goal of the trial on field 0, 1 to 8, counter-clockwise from +x.
    uint32_t goal;
    // Frames of the task execution time (paper III.b.3).
    uint32_t execution_frames;
    // Frames of a trial: execution time plus evaluation time.
    uint32_t trial_frames;
    // 1 if the agents received a command for this frame.
    uint32_t is_driven;
    // Number of used entries in agents, at most AGENTS; the agents of field 0 come
    // first.
    uint32_t agent_count;
    // Number of used entries in fields, at most AGENTS.
    uint32_t field_count;
    // Agents per field.
    uint32_t team;
    // Angle between the side IR sensors and straight ahead, 1/64 turns.
    uint32_t ir_angle_steps;
    // Angle between the photo sensor axes and straight ahead, 1/64 turns.
    uint32_t photo_angle_steps;
    // Cosine of half the opening angle of a photo sensor: 0 for a half-plane, 1 for a ray.
    float photo_half_angle_cosine;
    // Half the side length of a field, px.
    float half_side_px;
    // Radius of an agent, px.
    float agent_radius_px;
    // Radius of an object, px.
    float object_radius_px;
    // Largest distance between object and goal centres at which the object counts as
    // delivered, px.
    float goal_radius_px;
    // Range of an IR sensor from the agent centre, px.
    float ir_range_px;
    // Distance within which the object light is visible, px.
    float object_light_px;
    // Distance within which the goal light is visible, px.
    float goal_light_px;
    // Object friction divided by the stall force of one agent; 0 in a field with a fitted
    // yielding.
    float friction_stall_forces;
    // Share of an overlap by which one, two, three and four agents move the object.
    float yielding[4];
    // Number of used entries in walls, at most OBSTACLES.
    uint32_t wall_count;
    // Number of used entries in posts, at most OBSTACLES.
    uint32_t post_count;
    // Walls inside every field.
    atas_wall_truth walls[16];
    // Posts inside every field.
    atas_post_truth posts[16];
    // Name of the field preset.
    char preset[32];
    // Most recent completed trials; trial t is at index t modulo 8.
    atas_trial_truth trials[8];
    // The fields.
    atas_field_truth fields[1024];
    // The agents.
    atas_agent_truth agents[1024];
} atas_arena_truth;
#define ATAS_ARENA_TRUTH_TYPE "atas.ArenaTruth.v2"
_Static_assert(sizeof(atas_arena_truth) == 66424, "atas_arena_truth");
_Static_assert(_Alignof(atas_arena_truth) == 8, "atas_arena_truth");
_Static_assert(offsetof(atas_arena_truth, stamp) == 0, "atas_arena_truth.stamp");
_Static_assert(offsetof(atas_arena_truth, frame) == 24, "atas_arena_truth.frame");
_Static_assert(offsetof(atas_arena_truth, field_hash) == 32, "atas_arena_truth.field_hash");
_Static_assert(offsetof(atas_arena_truth, table_hash) == 40, "atas_arena_truth.table_hash");
_Static_assert(offsetof(atas_arena_truth, trial) == 48, "atas_arena_truth.trial");
_Static_assert(offsetof(atas_arena_truth, trial_count) == 52, "atas_arena_truth.trial_count");
_Static_assert(offsetof(atas_arena_truth, goal) == 56, "atas_arena_truth.goal");
_Static_assert(offsetof(atas_arena_truth, execution_frames) == 60, "atas_arena_truth.execution_frames");
_Static_assert(offsetof(atas_arena_truth, trial_frames) == 64, "atas_arena_truth.trial_frames");
_Static_assert(offsetof(atas_arena_truth, is_driven) == 68, "atas_arena_truth.is_driven");
_Static_assert(offsetof(atas_arena_truth, agent_count) == 72, "atas_arena_truth.agent_count");
_Static_assert(offsetof(atas_arena_truth, field_count) == 76, "atas_arena_truth.field_count");
_Static_assert(offsetof(atas_arena_truth, team) == 80, "atas_arena_truth.team");
_Static_assert(offsetof(atas_arena_truth, ir_angle_steps) == 84, "atas_arena_truth.ir_angle_steps");
_Static_assert(offsetof(atas_arena_truth, photo_angle_steps) == 88, "atas_arena_truth.photo_angle_steps");
_Static_assert(offsetof(atas_arena_truth, photo_half_angle_cosine) == 92, "atas_arena_truth.photo_half_angle_cosine");
_Static_assert(offsetof(atas_arena_truth, half_side_px) == 96, "atas_arena_truth.half_side_px");
_Static_assert(offsetof(atas_arena_truth, agent_radius_px) == 100, "atas_arena_truth.agent_radius_px");
_Static_assert(offsetof(atas_arena_truth, object_radius_px) == 104, "atas_arena_truth.object_radius_px");
_Static_assert(offsetof(atas_arena_truth, goal_radius_px) == 108, "atas_arena_truth.goal_radius_px");
_Static_assert(offsetof(atas_arena_truth, ir_range_px) == 112, "atas_arena_truth.ir_range_px");
_Static_assert(offsetof(atas_arena_truth, object_light_px) == 116, "atas_arena_truth.object_light_px");
_Static_assert(offsetof(atas_arena_truth, goal_light_px) == 120, "atas_arena_truth.goal_light_px");
_Static_assert(offsetof(atas_arena_truth, friction_stall_forces) == 124, "atas_arena_truth.friction_stall_forces");
_Static_assert(offsetof(atas_arena_truth, yielding) == 128, "atas_arena_truth.yielding");
_Static_assert(offsetof(atas_arena_truth, wall_count) == 144, "atas_arena_truth.wall_count");
_Static_assert(offsetof(atas_arena_truth, post_count) == 148, "atas_arena_truth.post_count");
_Static_assert(offsetof(atas_arena_truth, walls) == 152, "atas_arena_truth.walls");
_Static_assert(offsetof(atas_arena_truth, posts) == 408, "atas_arena_truth.posts");
_Static_assert(offsetof(atas_arena_truth, preset) == 600, "atas_arena_truth.preset");
_Static_assert(offsetof(atas_arena_truth, trials) == 632, "atas_arena_truth.trials");
_Static_assert(offsetof(atas_arena_truth, fields) == 888, "atas_arena_truth.fields");
_Static_assert(offsetof(atas_arena_truth, agents) == 41848, "atas_arena_truth.agents");

#endif
