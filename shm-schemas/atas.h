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

// How much fits into one payload.
#define ATAS_HANDS 2
#define ATAS_FINGERS 4
#define ATAS_ELEMENTS 64
#define ATAS_JOINTS 32
#define ATAS_AGENTS 1024
#define ATAS_STAGES 8
#define ATAS_SETTINGS 96
#define ATAS_STEPS 32

// Services.
#define ATAS_SERVICE_HAND_FRAME_LEFT "atas/v1/hand-frame/left"
#define ATAS_SERVICE_HAND_FRAME_RIGHT "atas/v1/hand-frame/right"
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

// Which hand.
enum atas_hand {
    // The left hand: joints 0 to 10 of the built-in robot.
    ATAS_HAND_LEFT = 0,
    // The right hand: joints 11 to 21 of the built-in robot.
    ATAS_HAND_RIGHT = 1,
};

// Mode of the daemon, ordered by severity.
enum atas_mode {
    // Waiting for the first valid frames and joint states.
    ATAS_MODE_INIT = 0,
    // Everything fresh, no goal.
    ATAS_MODE_READY = 1,
    // A goal is being pursued.
    ATAS_MODE_RUN = 2,
    // Something is in doubt: positions and grip are kept, the cause is watched.
    ATAS_MODE_HOLD = 3,
    // Stopped and latched until an explicit recover.
    ATAS_MODE_SAFE_STOP = 4,
    // The daemon itself failed; latched until restart.
    ATAS_MODE_FAULT = 5,
};

// Which task.
enum atas_goal_kind {
    // Grasp, lift and hold the object at from_m (paper II.b (1)).
    ATAS_GOAL_KIND_GRASP = 1,
    // Grasp at from_m, set down at to_m (paper II.b (3)).
    ATAS_GOAL_KIND_PICK_PLACE = 2,
    // Screw the cap at from_m (paper II.b (2)).
    ATAS_GOAL_KIND_SCREW = 3,
    // Cap from from_m onto the bottle at to_m, with both hands (paper II.c).
    ATAS_GOAL_KIND_ASSEMBLE = 4,
    // Open the hand where it is and move it home.
    ATAS_GOAL_KIND_RELEASE = 5,
    // A user's own task, by GoalRequest::task.
    ATAS_GOAL_KIND_CUSTOM = 6,
    // The acting hand follows the targets that this goal's client streams (GraspTarget).
    ATAS_GOAL_KIND_FOLLOW = 7,
    // Both hands do.
    ATAS_GOAL_KIND_FOLLOW_BOTH = 8,
};

// What happens to a goal when its client goes away.
enum atas_goal_policy {
    // The goal goes on to its end.
    ATAS_GOAL_POLICY_DETACHED = 0,
    // The goal is held: HOLD within 100 ticks.
    ATAS_GOAL_POLICY_ATTACHED = 1,
};

// Where a goal stands.
enum atas_goal_state {
    // Checked and queued for the next tick.
    ATAS_GOAL_STATE_ACCEPTED = 1,
    // Refused before anything moved; reason says why.
    ATAS_GOAL_STATE_REJECTED = 2,
    // In progress.
    ATAS_GOAL_STATE_RUNNING = 3,
    // Done as asked.
    ATAS_GOAL_STATE_SUCCEEDED = 4,
    // The robot refused the object while trying, and backed out safely (for example: too heavy for the hand).
    ATAS_GOAL_STATE_REFUSED = 5,
    // Ended without success; reason says why.
    ATAS_GOAL_STATE_FAILED = 6,
    // Ended by the client.
    ATAS_GOAL_STATE_CANCELLED = 7,
};

// Which way a cap is turned, seen from above.
enum atas_turn {
    // Closes a standard right-hand thread.
    ATAS_TURN_CLOCKWISE = 0,
    // Closes a left-hand thread, opens a right-hand one.
    ATAS_TURN_ANTICLOCKWISE = 1,
};

// What the fingers shall do.
enum atas_grip_order {
    // Go to opening_m. Fingertips that meet something on their way take hold of it, and hold it as gently as touch
    // allows, until a wider opening is wanted.
    ATAS_GRIP_ORDER_WIDTH = 0,
    // Close until the fingertips touch, and hold what is there.
    ATAS_GRIP_ORDER_HOLD = 1,
};

// What is asked.
enum atas_control_op {
    // Stop now and latch (SAFE_STOP).
    ATAS_CONTROL_OP_ESTOP = 1,
    // Leave SAFE_STOP. The robot then waits in HOLD until nothing is in doubt; HOLD ends by itself.
    ATAS_CONTROL_OP_RECOVER = 2,
    // Read the parameter name.
    ATAS_CONTROL_OP_PARAM_GET = 3,
    // Set the parameter name to value.
    ATAS_CONTROL_OP_PARAM_SET = 4,
    // Name the parameter with the index value.
    ATAS_CONTROL_OP_PARAM_LIST = 5,
    // Take the present reading of the hand with index value as zero force.
    ATAS_CONTROL_OP_BIAS = 6,
    // Read the configuration files again.
    ATAS_CONTROL_OP_RELOAD = 7,
    // Cancel the goal whose id is written in name, in decimal; nothing if it has ended.
    ATAS_CONTROL_OP_CANCEL = 8,
    // In lock-step: let virtual time go on to the tick with the index value, also without a goal. It stands still there.
    ATAS_CONTROL_OP_ADVANCE = 9,
};

// How it went.
enum atas_control_outcome {
    // Done.
    ATAS_CONTROL_OUTCOME_DONE = 1,
    // Refused; text says why.
    ATAS_CONTROL_OUTCOME_REFUSED = 2,
    // The daemon does not know the operation or the name.
    ATAS_CONTROL_OUTCOME_UNKNOWN = 3,
};

// What became of a stop.
enum atas_stop_outcome {
    // A tick took it: the commands stand still from that tick on.
    ATAS_STOP_OUTCOME_STOPPED = 1,
    // It waits for the next tick, which has not come yet: the tick is frozen, or time stands still in lock-step.
    ATAS_STOP_OUTCOME_WAITING = 2,
};

// What an event is about.
enum atas_event_kind {
    // A module became active.
    ATAS_EVENT_KIND_MODULE_ON = 1,
    // A module became inactive.
    ATAS_EVENT_KIND_MODULE_OFF = 2,
    // A fingertip touched something.
    ATAS_EVENT_KIND_TOUCH_ON = 3,
    // A fingertip let go.
    ATAS_EVENT_KIND_TOUCH_OFF = 4,
    // A goal changed its state; value is the state.
    ATAS_EVENT_KIND_GOAL = 5,
    // A task entered a step; text names it.
    ATAS_EVENT_KIND_STEP = 6,
    // The mode changed; reason says why.
    ATAS_EVENT_KIND_MODE = 7,
    // The stiffness probe ended; value is N/m, text is F_2.
    ATAS_EVENT_KIND_STIFFNESS = 8,
    // Something is wrong but was tolerated; reason says what.
    ATAS_EVENT_KIND_WARNING = 9,
};

// The modules of the paper, and the motions that carry them.
enum atas_module_id {
    // No module.
    ATAS_MODULE_ID_NONE = 0,
    // Module 0: square trajectory, adapted by contact (paper II.b (2)).
    ATAS_MODULE_ID_TRAJECTORY = 1,
    // Module 0': conveys and sets down (paper II.b (3)).
    ATAS_MODULE_ID_TRANSFER = 2,
    // Module 1: first touch, F_n > F_1 (paper II.b (1)).
    ATAS_MODULE_ID_FIRST_TOUCH = 3,
    // Module 2: slip, dF_t > dr (paper II.b (1)).
    ATAS_MODULE_ID_SLIP = 4,
    // Module 3: force limit, F_n > F_2 (paper II.b (1)).
    ATAS_MODULE_ID_FORCE_LIMIT = 5,
    // Module 4: terminates screwing, dF_t > 1.4 dF_max (paper II.b (2)).
    ATAS_MODULE_ID_TERMINATE_SCREW = 6,
    // Module 4: releases on upward tangential force (paper II.b (3)).
    ATAS_MODULE_ID_RELEASE_PLACED = 7,
    // Stiffness probe, 100 ms after the first touch (paper II.b (1)).
    ATAS_MODULE_ID_PROBE = 8,
    // Carries the hand along a planned path.
    ATAS_MODULE_ID_CARRY = 9,
    // Gives back force that friction does not need.
    ATAS_MODULE_ID_RELAX = 10,
    // Turns the hand back when it touches something while it moves freely.
    ATAS_MODULE_ID_CONTACT_GUARD = 11,
    // Tugs back once in a lift, to tell what hangs from what still stands.
    ATAS_MODULE_ID_LOAD_TEST = 12,
    // Grips harder by a fixed share whenever the object slips: a baseline, in no built-in task.
    ATAS_MODULE_ID_SLIP_REACTION = 13,
    // Leads the hand after streamed targets, within limits of speed, acceleration and jerk.
    ATAS_MODULE_ID_FOLLOW = 14,
    // Reads fingers and hand off the task's behaviour table (paper section III).
    ATAS_MODULE_ID_BEHAVIOUR_TABLE = 15,
};

// What went wrong.
enum atas_cause {
    // Nothing.
    ATAS_CAUSE_NONE = 0,
    // A value of the goal is not finite.
    ATAS_CAUSE_NOT_FINITE = 1,
    // A value of the goal is out of its range.
    ATAS_CAUSE_OUT_OF_RANGE = 2,
    // The position cannot be reached.
    ATAS_CAUSE_UNREACHABLE = 3,
    // The goal's kind, hand or policy is unknown.
    ATAS_CAUSE_UNKNOWN_GOAL = 4,
    // Another goal is active.
    ATAS_CAUSE_BUSY = 5,
    // The daemon is not ready: see its mode.
    ATAS_CAUSE_NOT_READY = 6,
    // The hand still holds an object.
    ATAS_CAUSE_HAND_FULL = 7,
    // The hand has no tactile sensor.
    ATAS_CAUSE_NO_SENSOR = 8,
    // The two arms would come too near to each other.
    ATAS_CAUSE_ARMS_COLLIDE = 9,
    // No object was touched on the way in.
    ATAS_CAUSE_NOTHING_TOUCHED = 10,
    // The object needs more force than the fingers may press with (grasp.f2_max_n).
    ATAS_CAUSE_TOO_HEAVY = 11,
    // The object slipped out of the hand.
    ATAS_CAUSE_LOST_OBJECT = 12,
    // Force is at its ceiling and the object still slips while held.
    ATAS_CAUSE_OUT_OF_FORCE = 13,
    // A step took longer than allowed.
    ATAS_CAUSE_TIMED_OUT = 14,
    // The client cancelled.
    ATAS_CAUSE_CANCELLED = 15,
    // The client of an attached goal went away.
    ATAS_CAUSE_CLIENT_GONE = 16,
    // Nothing carried the object where it should have been set down; the hand has lifted it again.
    ATAS_CAUSE_NO_SUPPORT = 17,
    // A fingertip touched something while the hand moved freely; the hand has gone back.
    ATAS_CAUSE_OBSTRUCTED = 18,
    // The goal names a task that the configuration does not have.
    ATAS_CAUSE_UNKNOWN_TASK = 19,
    // No tactile frame for too long.
    ATAS_CAUSE_FRAMES_STOPPED = 20,
    // A frame's stamp is too old.
    ATAS_CAUSE_FRAME_STALE = 21,
    // A frame's stamp lies in the future.
    ATAS_CAUSE_FRAME_FUTURE = 22,
    // Too many frames were lost in a row.
    ATAS_CAUSE_FRAMES_LOST = 23,
    // A frame failed its checksum.
    ATAS_CAUSE_FRAME_CORRUPT = 24,
    // A frame came from a writer that is not the pinned one, or follows another layout.
    ATAS_CAUSE_FRAME_FOREIGN = 25,
    // Too many elements are invalid.
    ATAS_CAUSE_ELEMENTS_INVALID = 26,
    // The readings do not change any more although the counter advances.
    ATAS_CAUSE_FRAMES_FROZEN = 27,
    // The sensor process restarted in mid-task.
    ATAS_CAUSE_SENSOR_RESTARTED = 28,
    // An object that is held slides through the fingers.
    ATAS_CAUSE_SLIDING = 29,
    // No joint state for too long.
    ATAS_CAUSE_JOINTS_STOPPED = 30,
    // A joint state is not finite, out of range or jumps.
    ATAS_CAUSE_JOINTS_INVALID = 31,
    // A joint does not follow its command.
    ATAS_CAUSE_FOLLOWING_ERROR = 32,
    // A command was not finite.
    ATAS_CAUSE_COMMAND_NOT_FINITE = 33,
    // A command jumped.
    ATAS_CAUSE_COMMAND_STEP = 34,
    // A grip force rose above its ceiling.
    ATAS_CAUSE_GRIP_CEILING = 35,
    // The robot process restarted.
    ATAS_CAUSE_ROBOT_RESTARTED = 36,
    // A fingertip's force cannot be: it is more than a hand can press.
    ATAS_CAUSE_FORCE_IMPLAUSIBLE = 37,
    // An order that is not allowed now: the robot moves, or the hand is not empty.
    ATAS_CAUSE_NOT_NOW = 38,
    // There is no robot to move: the daemon was told to sense only.
    ATAS_CAUSE_SENSE_ONLY = 39,
    // A module panicked.
    ATAS_CAUSE_MODULE_PANICKED = 40,
    // The loop stood still for a while.
    ATAS_CAUSE_LOOP_STALLED = 41,
    // Stopped by a person: atas estop.
    ATAS_CAUSE_ESTOP = 42,
    // The daemon is shutting down.
    ATAS_CAUSE_SHUTDOWN = 43,
    // The daemon's supervisor, which takes orders and tells users, has been silent.
    ATAS_CAUSE_SUPERVISOR_SILENT = 44,
    // Some elements of a fingertip keep their reading although frames keep coming: they are not believed.
    ATAS_CAUSE_ELEMENT_STUCK = 45,
    // What a skin says that a hand presses, and what its joints bear, do not agree.
    ATAS_CAUSE_FORCE_AGAINST_JOINTS = 46,
    // The object needs more force than its stiffness bears (grasp.compression_m).
    ATAS_CAUSE_TOO_SOFT = 50,
    // The hand was found gripping something; it keeps it and watches it.
    ATAS_CAUSE_GRIP_FOUND = 51,
    // The object turned about the closing axis while it was held.
    ATAS_CAUSE_TURNED_IN_HAND = 52,
    // The object slipped through the fingers on the way, and was held again.
    ATAS_CAUSE_SLIPPED_IN_HAND = 53,
    // The object needs more force than the goal allows (GoalRequest).
    ATAS_CAUSE_ABOVE_MAX_FORCE = 54,
    // The ways of the task are too long, or those of both hands together too many, to be checked.
    ATAS_CAUSE_TASK_TOO_LONG = 60,
    // The robot has no such hand.
    ATAS_CAUSE_NO_HAND = 61,
    // The fingertips cannot pass each other, as turning a cap needs.
    ATAS_CAUSE_CANNOT_TURN = 62,
    // A client can lead only a hand whose robot file states a workspace.
    ATAS_CAUSE_NO_WORKSPACE = 63,
    // The hand holds nothing that the task could go on with.
    ATAS_CAUSE_HAND_EMPTY = 64,
    // Closed to this width, the jaws' domes would not face each other well enough to feel.
    ATAS_CAUSE_DOMES_ASKEW = 65,
    // The client's stream of targets has ended or pauses: the hand stands and keeps what it holds.
    ATAS_CAUSE_TARGETS_STOPPED = 70,
    // A target failed its checksum.
    ATAS_CAUSE_TARGET_CORRUPT = 71,
    // A target comes from another writer than the one whose goal opened the stream.
    ATAS_CAUSE_TARGET_FOREIGN = 72,
    // A target is older than the one before, was made before its goal began or ahead of time, or has expired.
    ATAS_CAUSE_TARGET_STALE = 73,
    // A target names a hand that its goal does not have, or an order that this version does not know.
    ATAS_CAUSE_TARGET_UNKNOWN = 74,
    // A value of a target is not finite.
    ATAS_CAUSE_TARGET_NOT_FINITE = 75,
    // A value of a target is out of its range.
    ATAS_CAUSE_TARGET_OUT_OF_RANGE = 76,
    // An arm stands across the middle, which both keep clear of while a client leads them.
    ATAS_CAUSE_ACROSS_THE_MIDDLE = 77,
};

// What a tick was told by the daemon's supervisor.
enum atas_order_kind {
    // Nothing.
    ATAS_ORDER_KIND_NONE = 0,
    // Start goal.
    ATAS_ORDER_KIND_START = 1,
    // End the goal goal_id.
    ATAS_ORDER_KIND_CANCEL = 2,
    // The client of the goal goal_id went away.
    ATAS_ORDER_KIND_CLIENT_GONE = 3,
    // Stop and latch for reason.
    ATAS_ORDER_KIND_STOP = 4,
    // Leave SAFE_STOP.
    ATAS_ORDER_KIND_RECOVER = 5,
    // Set the parameter with this index to value.
    ATAS_ORDER_KIND_SET_PARAMETER = 6,
    // Replace all settings by settings.
    ATAS_ORDER_KIND_CONFIGURE = 7,
    // Take the reading of the hand with this index as zero force.
    ATAS_ORDER_KIND_BIAS = 8,
    // Hold in this tick for reason.
    ATAS_ORDER_KIND_HOLD = 9,
};

// One sensor bit of a behaviour table that feels: true or false in every tick (paper Table 1, S1 to S5).
enum atas_sensor_bit {
    // No bit.
    ATAS_SENSOR_BIT_NONE = 0,
    // Every finger touches.
    ATAS_SENSOR_BIT_TOUCHING = 1,
    // The weakest finger presses more than F_1: what Module 1 asks.
    ATAS_SENSOR_BIT_ABOVE_F1 = 2,
    // A finger has nearly used up its friction, or slips: what Module 2 asks.
    ATAS_SENSOR_BIT_SLIPPING = 3,
    // The strongest finger presses more than F_2: what Module 3 asks.
    ATAS_SENSOR_BIT_ABOVE_F2 = 4,
    // The hand has carried its object for more than 3 mm.
    ATAS_SENSOR_BIT_LIFTED = 5,
    // Every finger has had friction to spare for 100 ms.
    ATAS_SENSOR_BIT_SPARE = 6,
};

// Which light a base's photo sensors look for.
enum atas_light {
    // The object's.
    ATAS_LIGHT_OBJECT = 0,
    // The goal's.
    ATAS_LIGHT_GOAL = 1,
};

// Who has the say over a robot.
enum atas_say {
    // Nobody: the base brakes and stands.
    ATAS_SAY_NOBODY = 0,
    // The behaviour table: the base drives.
    ATAS_SAY_TABLE = 1,
    // The hand: it works, the base stands.
    ATAS_SAY_HAND = 2,
    // Nobody any more: the course is over, the base brakes and stays.
    ATAS_SAY_OVER = 3,
};

// What ended a base's course at once.
enum atas_mishap {
    // Nothing did.
    ATAS_MISHAP_NONE = 0,
    // It came too near to a wall.
    ATAS_MISHAP_LEFT_FIELD = 1,
    // It met another robot.
    ATAS_MISHAP_MET_ROBOT = 2,
    // It drove over an object.
    ATAS_MISHAP_MET_OBJECT = 3,
};

// Who wrote a payload, when, and as which in its series.
typedef struct atas_stamp {
    // Counts the payloads of this writer, from 0, without gaps: a gap means that payloads were lost.
    uint64_t sequence;
    // When the content was true (sensor time, not sending time), nanoseconds of CLOCK_MONOTONIC.
    uint64_t captured_ns;
    // Drawn anew at each start of the writer. A reader pins it; a change means that the writer restarted.
    uint64_t writer_epoch;
} atas_stamp;
#define ATAS_STAMP_TYPE "atas.Stamp.v1"
_Static_assert(sizeof(atas_stamp) == 24, "atas_stamp");
_Static_assert(_Alignof(atas_stamp) == 8, "atas_stamp");
_Static_assert(offsetof(atas_stamp, sequence) == 0, "atas_stamp.sequence");
_Static_assert(offsetof(atas_stamp, captured_ns) == 8, "atas_stamp.captured_ns");
_Static_assert(offsetof(atas_stamp, writer_epoch) == 16, "atas_stamp.writer_epoch");

// One reading of all fingertips of one hand.
//
// Forces are those of the object **on** the tip, resolved along each element's own axes: f_n = −F·d (positive
// when pressed), f_t1 = F·t1, f_t2 = F·t2. The axes d, t1, t2 come from the Layout that both
// sides are configured with; HandFrame::layout_hash proves that they agree.
typedef struct atas_hand_frame {
    // captured_ns is when the sensor sampled.
    atas_stamp stamp;
    // Layout::hash of the layout that the elements follow.
    uint64_t layout_hash;
    // Which hand.
    uint32_t hand; // enum atas_hand
    // Fingers that carry data, at most FINGERS. Finger 0 is finger1 of the URDF.
    uint32_t finger_count;
    // Per finger, bit e set: element e carries a valid reading.
    uint64_t valid_mask[4];
    // Newtons: force_n[finger][element] = [f_n, f_t1, f_t2].
    float force_n[4][64][3];
    // Written as zero.
    uint32_t pad;
    // CRC-32 (IEEE) of every byte before this field: HandFrame::seal, HandFrame::is_intact.
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

// Measured joints, left 11 then right 11 for the built-in robot, and what they are told to do.
//
// The robot outlives the daemon. What it tells of the command in force lets the next daemon go on from there: a grip is
// what the servos are commanded beyond where the fingers are, so who began again from measured positions would let go.
typedef struct atas_joint_state {
    // captured_ns is when the encoders were read.
    atas_stamp stamp;
    // Joints that carry data, at most JOINTS.
    uint32_t joint_count;
    // Joints whose commanded_rad means something: joint_count, or 0 for a robot that cannot tell.
    uint32_t commanded_count;
    // Measured positions, rad.
    double position_rad[32];
    // Measured velocities, rad/s.
    double velocity_rad_s[32];
    // Measured efforts, N·m; zero where the drive does not measure.
    double effort_n_m[32];
    // Positions that the servos hold now, rad: of the last command obeyed, also when it has expired.
    double commanded_rad[32];
    // JointCommand::grip_limit_n of that command, 0 before the first.
    double grip_limit_n[2];
    // Epoch of the writer of that command, 0 before the first.
    uint64_t command_epoch;
    // Sequence of that command.
    uint64_t command_sequence;
    // Until when that command is valid, ns; it has expired if this has passed.
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
_Static_assert(offsetof(atas_joint_state, position_rad) == 32, "atas_joint_state.position_rad");
_Static_assert(offsetof(atas_joint_state, velocity_rad_s) == 288, "atas_joint_state.velocity_rad_s");
_Static_assert(offsetof(atas_joint_state, effort_n_m) == 544, "atas_joint_state.effort_n_m");
_Static_assert(offsetof(atas_joint_state, commanded_rad) == 800, "atas_joint_state.commanded_rad");
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

// What the joints shall do now. Published every tick, also in HOLD: the command is the heartbeat.
//
// The consumer enforces JointCommand::valid_until_ns: on expiry it holds the last commanded positions with
// zero velocity, which keeps the last safe grip force. Opening the hand is never the default stop.
typedef struct atas_joint_command {
    // captured_ns is the tick's time.
    atas_stamp stamp;
    // The command must not be obeyed after this time, CLOCK_MONOTONIC nanoseconds.
    uint64_t valid_until_ns;
    // The tick that produced the command.
    uint64_t tick;
    // Sequence of the newest JointState that the command has seen; lock-step waits for it.
    uint64_t answers_sequence;
    // Mode of the daemon.
    uint32_t mode; // enum atas_mode
    // Joints that carry data, at most JOINTS.
    uint32_t joint_count;
    // Commanded positions, rad.
    double position_rad[32];
    // Velocity feed-forward, rad/s; zero in HOLD.
    double velocity_rad_s[32];
    // F_2, the most that what each hand holds may be pressed with, N; 0 for an empty hand. The robot does nothing with it but
    // tell it in JointState: so a limit outlives the daemon that knows it.
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
_Static_assert(offsetof(atas_joint_command, position_rad) == 56, "atas_joint_command.position_rad");
_Static_assert(offsetof(atas_joint_command, velocity_rad_s) == 312, "atas_joint_command.velocity_rad_s");
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

// One goal. Frame: base of the robot (x forward, y left, z up, origin on the table top under the torso).
typedef struct atas_goal_request {
    // captured_ns is when the client sent it.
    atas_stamp stamp;
    // Chosen by the client; repeated in every update.
    uint64_t goal_id;
    // Which task.
    uint32_t kind; // enum atas_goal_kind
    // Which hand acts; for assembly, which hand screws.
    uint32_t hand; // enum atas_hand
    // What happens when the client goes away.
    uint32_t policy; // enum atas_goal_policy
    // Which way to turn a cap; not used by GRASP and PICK_PLACE.
    uint32_t turn; // enum atas_turn
    // Where the fingertips shall close, m. The true object may be off by some millimetres.
    double from_m[3];
    // Direction of the closing axis at from_m, from finger 2's side to finger 1's, rad from +x towards +y.
    double from_yaw_rad;
    // Where the object shall stand afterwards, m; not used by GRASP.
    double to_m[3];
    // Direction of the closing axis at to_m, rad; not used by GRASP.
    double to_yaw_rad;
    // Expected width of the object along the closing axis, m. The hand opens a little wider.
    double width_m;
    // How far to lift, m.
    double lift_m;
    // How long to hold the lifted object before the goal counts as reached, s.
    double hold_s;
    // Expected width of what the other hand holds, m; only used by ASSEMBLE: the bottle's.
    double helper_width_m;
    // How far the object reaches above where the fingertips close, m: the hand comes from above that. Zero if unknown.
    double top_m;
    // What one side of the hand may press the object with at most, N: F_2, instead of what its stiffness allows. Zero if
    // unknown.
    double max_force_n;
    // Name of the task for CUSTOM.
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

// What the hand learnt about the object, SI units, zero where not (yet) known.
typedef struct atas_grasp_figures {
    // Normal force per finger, N.
    float normal_n[4];
    // Tangential force per finger, N.
    float tangential_n[4];
    // F_1, the minimum grasping force, N.
    float f1_n;
    // F_2, the maximum grasping force, N.
    float f2_n;
    // Object stiffness from the stiffness probe, N/m.
    float stiffness_n_m;
    // How far the stiffness may be trusted, 0 to 1.
    float stiffness_confidence;
    // Estimated friction coefficient, the lowest of the fingers.
    float friction;
    // How far the hand has lifted the object, m.
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

// A cause with the module that saw it and the value against its limit.
typedef struct atas_reason {
    // What went wrong.
    uint32_t cause; // enum atas_cause
    // Which module saw it; ModuleId::NONE outside the modules.
    uint32_t module; // enum atas_module_id
    // The value that broke the limit, in the unit that the sentence of Reason's Display names.
    double value;
    // The limit it broke.
    double limit;
    // Which field, joint, finger or hand, by index; its meaning depends on the cause.
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

// One step of a goal's story.
typedef struct atas_goal_update {
    // captured_ns is the tick's time.
    atas_stamp stamp;
    // Echo of GoalRequest::goal_id.
    uint64_t goal_id;
    // Tick of this update.
    uint64_t tick;
    // Where the goal stands.
    uint32_t state; // enum atas_goal_state
    // Fraction done, 0 to 1.
    float progress;
    // Why, when rejected, refused, failed or held.
    atas_reason reason;
    // Name of the task's step, for example lift; of a goal that names an unknown task, that name.
    char step[16];
    // What the hand learnt so far.
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

// Where a hand shall be: one target of the stream that a goal follow has opened. Frame: base of the robot (x forward,
// y left, z up, origin on the table top under the torso); the hand points straight down.
//
// The newest target counts. The hand follows it within limits of its own; how hard it holds is not the client's to say.
typedef struct atas_grasp_target {
    // writer_epoch is that of the goal's request, sequence rises, captured_ns is when the target was made.
    atas_stamp stamp;
    // The hand stops and keeps what it holds if nothing newer has come by then, nanoseconds of the clock of the daemon's
    // stamps. At most two seconds ahead count.
    uint64_t valid_until_ns;
    // Which hand.
    uint32_t hand; // enum atas_hand
    // What its fingers shall do.
    uint32_t grip; // enum atas_grip_order
    // Point between the fingertips, m.
    double centre_m[3];
    // Direction of the closing axis, rad from +x towards +y. A half turn more or less is the same grasp: the hand takes
    // the one that is nearer.
    double closing_yaw_rad;
    // Distance between the fingertips' surfaces, m; not used by HOLD.
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

// One request.
typedef struct atas_control_request {
    // captured_ns is when the client sent it.
    atas_stamp stamp;
    // What is asked.
    uint32_t op; // enum atas_control_op
    // Written as zero.
    uint32_t pad;
    // Its number, where it has one.
    double value;
    // Its name, where it has one.
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

// The answer: exactly one per request, given after the request took effect.
typedef struct atas_control_reply {
    // captured_ns is when the daemon answered.
    atas_stamp stamp;
    // How it went.
    uint32_t outcome; // enum atas_control_outcome
    // Written as zero.
    uint32_t pad;
    // The value asked for.
    double value;
    // The lowest value allowed, for parameters.
    double lower;
    // The highest value allowed, for parameters.
    double upper;
    // Of a parameter its name, and on a second line what it means; else a sentence that says why not.
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

// A stop. Whatever else arrives at the stop socket counts as one too, without a reason.
typedef struct atas_stop_request {
    // captured_ns is when the client sent it.
    atas_stamp stamp;
    // Why, for the log.
    char reason[96];
} atas_stop_request;
#define ATAS_STOP_REQUEST_TYPE "atas.StopRequest.v1"
_Static_assert(sizeof(atas_stop_request) == 120, "atas_stop_request");
_Static_assert(_Alignof(atas_stop_request) == 8, "atas_stop_request");
_Static_assert(offsetof(atas_stop_request, stamp) == 0, "atas_stop_request.stamp");
_Static_assert(offsetof(atas_stop_request, reason) == 24, "atas_stop_request.reason");

// The answer to a stop.
typedef struct atas_stop_answer {
    // captured_ns is when the daemon received the stop, sequence counts the stops that it received.
    atas_stamp stamp;
    // What became of it.
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

// One event. Ordered by stamp.sequence; a gap means that the queue was full and events were dropped.
typedef struct atas_module_event {
    // captured_ns is the tick's time.
    atas_stamp stamp;
    // The tick.
    uint64_t tick;
    // What the event is about.
    uint32_t kind; // enum atas_event_kind
    // Which module, where one is concerned.
    uint32_t module; // enum atas_module_id
    // Which hand, where one is concerned.
    uint32_t hand; // enum atas_hand
    // Which finger of the hand, where one is concerned.
    uint32_t finger;
    // Mode after the event.
    uint32_t mode; // enum atas_mode
    // Written as zero.
    uint32_t pad;
    // The value that decided, SI units.
    double value;
    // The threshold it was held against, SI units.
    double threshold;
    // Why, for modes, goals and warnings.
    atas_reason reason;
    // A name, where one helps.
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

// A distribution of durations since the start, ns.
typedef struct atas_percentiles {
    // Median.
    uint64_t p50_ns;
    // 99th percentile.
    uint64_t p99_ns;
    // 99.9th percentile.
    uint64_t p999_ns;
    // Longest.
    uint64_t max_ns;
    // How many were measured.
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

// What the daemon thinks of one hand's sensor. All counts since the daemon's start.
typedef struct atas_hand_status {
    // Frames accepted.
    uint64_t frames;
    // Frames lost, by gaps in the sequence.
    uint64_t lost;
    // Frames seen twice.
    uint64_t duplicates;
    // Frames that came after a newer one.
    uint64_t reordered;
    // Frames that failed their checksum.
    uint64_t corrupt;
    // Frames stamped too far in the past or in the future.
    uint64_t mistimed;
    // Frames of another writer, hand or layout.
    uint64_t foreign;
    // Readings masked because they were not finite or out of range.
    uint64_t masked_elements;
    // Restarts of the sensor process.
    uint64_t restarts;
    // Touches per finger, with hysteresis.
    uint64_t touches[4];
    // Epoch of the pinned writer.
    uint64_t writer_epoch;
    // Age of the newest accepted frame, ns; u64::MAX before the first.
    uint64_t age_ns;
    // Configured layout.
    uint64_t layout_hash;
    // Normal force per finger, N.
    float normal_n[4];
    // Tangential force per finger, N.
    float tangential_n[4];
    // 1 if the configuration wants this hand.
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

// What the daemon thinks of the joint feedback.
typedef struct atas_joint_status {
    // States accepted.
    uint64_t states;
    // States not taken in, by gaps in the sequence: lost, or superseded by a newer one within one tick.
    uint64_t lost;
    // States refused.
    uint64_t rejected;
    // Age of the newest, ns; u64::MAX before the first.
    uint64_t age_ns;
} atas_joint_status;
#define ATAS_JOINT_STATUS_TYPE "atas.JointStatus.v1"
_Static_assert(sizeof(atas_joint_status) == 32, "atas_joint_status");
_Static_assert(_Alignof(atas_joint_status) == 8, "atas_joint_status");
_Static_assert(offsetof(atas_joint_status, states) == 0, "atas_joint_status.states");
_Static_assert(offsetof(atas_joint_status, lost) == 8, "atas_joint_status.lost");
_Static_assert(offsetof(atas_joint_status, rejected) == 16, "atas_joint_status.rejected");
_Static_assert(offsetof(atas_joint_status, age_ns) == 24, "atas_joint_status.age_ns");

// The daemon's state, 50 Hz.
typedef struct atas_status {
    // captured_ns is when the snapshot was taken.
    atas_stamp stamp;
    // Version of the daemon.
    char version[32];
    // FNV-1a 64 of the configuration text in force.
    uint64_t config_hash;
    // When the daemon started, ns of the clock of its stamps: CLOCK_MONOTONIC; in lock-step the virtual time of its first
    // tick, 0 before that.
    uint64_t started_ns;
    // Process id.
    uint32_t pid;
    // StatusFlags.
    uint32_t flags;
    // Mode.
    uint32_t mode; // enum atas_mode
    // Tick rate, Hz.
    uint32_t rate_hz;
    // Why the mode is HOLD, SAFE_STOP or FAULT.
    atas_reason reason;
    // Ticks executed.
    uint64_t ticks;
    // Ticks missed: their time had passed when the loop came round.
    uint64_t missed_ticks;
    // Ticks that began more than a tenth of a period late.
    uint64_t late_ticks;
    // Ticks that began because the frames that they awaited came.
    uint64_t ticks_on_arrival;
    // Ticks that awaited a frame until the latest moment, in vain.
    uint64_t ticks_in_vain;
    // Records dropped because the queue to the non-real-time side was full.
    uint64_t dropped_records;
    // Active or last goal, 0 if none.
    uint64_t goal_id;
    // Its kind.
    uint32_t goal_kind; // enum atas_goal_kind
    // Its state.
    uint32_t goal_state; // enum atas_goal_state
    // Its step.
    char step[16];
    // Name of its task if it is one of the user's own, else empty.
    char task[32];
    // Why it ended, if it ended without success.
    atas_reason goal_reason;
    // How late ticks begin.
    atas_percentiles wake;
    // Age of the newest frame at the tick.
    atas_percentiles frame_age;
    // Duration of the tick's body.
    atas_percentiles tick;
    // From the sensor's stamp to the command.
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
_Static_assert(offsetof(atas_status, ticks_in_vain) == 152, "atas_status.ticks_in_vain");
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

// What a sensor process says of its device, about 10 Hz and once more at its end.
typedef struct atas_sensor_status {
    // captured_ns is when the snapshot was taken.
    atas_stamp stamp;
    // The driver, for example optoforce.
    char driver[32];
    // The device, for example a tty.
    char device[64];
    // Which hand it feels for.
    uint32_t hand; // enum atas_hand
    // 1 while the device delivers.
    uint32_t alive;
    // Valid frames read from the device.
    uint64_t frames;
    // Frames lost, by gaps in the device's own counter.
    uint64_t lost;
    // Bytes that belong to no valid frame.
    uint64_t junk_bytes;
    // Candidates that failed their checksum.
    uint64_t checksum_failures;
    // Frames whose status word reports an error or an overload.
    uint64_t device_errors;
    // The device's last status word.
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

// What one fingertip felt, after perception.
typedef struct atas_finger_report {
    // F_n in the contact-patch frame, N.
    float normal_n;
    // F_t in the contact-patch frame, N.
    float tangential_n;
    // dF_t over its window, N.
    float tangential_increment_n;
    // S, friction utilisation: 1 means gross slip.
    float utilisation;
    // S from the present friction reading, without memory.
    float utilisation_now;
    // Estimated friction coefficient.
    float friction;
    // Commanded closing speed, m/s, positive when closing.
    float closing_m_s;
    // 1 while the fingertip touches something.
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

// What one hand felt and wanted.
typedef struct atas_hand_report {
    // Sequence of the newest frame that the tick used.
    uint64_t frame_sequence;
    // Age of that frame at the tick, ns.
    uint64_t frame_age_ns;
    // Frames that arrived since the tick before.
    uint32_t frames;
    // Bit n set: the module with ModuleId n is active.
    uint32_t modules_active;
    // Index of the task's step.
    uint32_t step;
    // F_1, N.
    float f1_n;
    // F_2, N.
    float f2_n;
    // Object stiffness, N/m.
    float stiffness_n_m;
    // Commanded position of the hand's centre, base frame, m.
    double centre_m[3];
    // Per finger.
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

// What one tick did.
typedef struct atas_tick_report {
    // captured_ns is the tick's time.
    atas_stamp stamp;
    // Index of the tick; a gap means missed ticks.
    uint64_t tick;
    // Ticks missed so far.
    uint64_t missed_ticks;
    // Active goal, 0 if none.
    uint64_t goal_id;
    // Sequence of the joint state that the tick used.
    uint64_t joint_sequence;
    // How late the tick began, ns.
    uint32_t wake_late_ns;
    // Mode after the tick.
    uint32_t mode; // enum atas_mode
    // Duration of each stage, ns: intake, perception, modules, kinematics, safety, publish, report, recording.
    uint32_t stage_ns[8];
    // From the newest frame's capture to the command's publication, ns.
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

// The newest frames and joint state, some 60 times a second: the streams of the 1 kHz loop have a closed set of peers,
// this one is for screens.
typedef struct atas_view {
    // captured_ns is the tick's time; sequence counts the views.
    atas_stamp stamp;
    // The tick that left it.
    uint64_t tick;
    // Per hand, 1 once a frame has come.
    uint32_t has_frame[2];
    // 1 once a joint state has come.
    uint32_t has_joints;
    // Written as zero.
    uint32_t pad;
    // The newest frame of each hand, as it came, unchecked.
    atas_hand_frame frames[2];
    // The newest joint state, as it came, unchecked.
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

// Every tunable number, in the order of the daemon's table of parameters.
typedef struct atas_settings_record {
    // FNV-1a 64 of the names: values of another table mean something else.
    uint64_t names_hash;
    // Numbers that are used, at most SETTINGS.
    uint32_t count;
    // Written as zero.
    uint32_t pad;
    // The numbers.
    double value[96];
} atas_settings_record;
#define ATAS_SETTINGS_RECORD_TYPE "atas.SettingsRecord.v1"
_Static_assert(sizeof(atas_settings_record) == 784, "atas_settings_record");
_Static_assert(_Alignof(atas_settings_record) == 8, "atas_settings_record");
_Static_assert(offsetof(atas_settings_record, names_hash) == 0, "atas_settings_record.names_hash");
_Static_assert(offsetof(atas_settings_record, count) == 8, "atas_settings_record.count");
_Static_assert(offsetof(atas_settings_record, pad) == 12, "atas_settings_record.pad");
_Static_assert(offsetof(atas_settings_record, value) == 16, "atas_settings_record.value");

// One step of a task. The numbers are those of the daemon's words for tasks (crate atas, tasks::words).
typedef struct atas_step_record {
    // Name, as users see it.
    char name[16];
    // How the hand moves.
    uint32_t motion;
    // Where to, for a motion that has a waypoint.
    uint32_t waypoint;
    // Which modules work: bit n stands for the module with the number n.
    uint32_t modules;
    // When the step is done.
    uint32_t transition;
    // Meeting point, for a step that ends at one.
    uint32_t point;
    // Written as zero.
    uint32_t pad;
    // When it has taken too long, s; infinite for never.
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

// The steps of one hand.
typedef struct atas_track_record {
    // Steps that are used, at most STEPS; 0 for a hand that does nothing.
    uint32_t count;
    // Written as zero.
    uint32_t pad;
    // The steps.
    atas_step_record steps[32];
} atas_track_record;
#define ATAS_TRACK_RECORD_TYPE "atas.TrackRecord.v1"
_Static_assert(sizeof(atas_track_record) == 1544, "atas_track_record");
_Static_assert(_Alignof(atas_track_record) == 8, "atas_track_record");
_Static_assert(offsetof(atas_track_record, count) == 0, "atas_track_record.count");
_Static_assert(offsetof(atas_track_record, pad) == 4, "atas_track_record.pad");
_Static_assert(offsetof(atas_track_record, steps) == 8, "atas_track_record.steps");

// The behaviour table of a task (paper Table 1): one row per combination of sensor bits, one level per actuator and row.
typedef struct atas_table_record {
    // FNV-1a over all other fields; 0 with no bits: the task has no table.
    uint64_t hash;
    // Sensor bits that are used, at most SENSOR_BITS; the first is the lowest of the row's number.
    uint32_t count;
    // Which bits.
    uint32_t bits[6]; // enum atas_sensor_bit
    // Written as zero.
    uint32_t pad;
    // Closing speed of the fingers per level, m/s, negative opens.
    double fingers_m_s[4];
    // Factor on the hand's speed along its path per level, −1 (back) to 1.
    double hand[4];
    // Four bits per row, row 0 lowest: level of the fingers, then level of the hand times four.
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

// What a goal made the hands do: a built-in task or a user's own.
typedef struct atas_task_record {
    // Name, as users see it.
    char name[16];
    // The hand that the goal names.
    atas_track_record acting;
    // The other hand.
    atas_track_record helping;
    // What the module "behaviour table" reads.
    atas_table_record table;
} atas_task_record;
#define ATAS_TASK_RECORD_TYPE "atas.TaskRecord.v2"
_Static_assert(sizeof(atas_task_record) == 3240, "atas_task_record");
_Static_assert(_Alignof(atas_task_record) == 8, "atas_task_record");
_Static_assert(offsetof(atas_task_record, name) == 0, "atas_task_record.name");
_Static_assert(offsetof(atas_task_record, acting) == 16, "atas_task_record.acting");
_Static_assert(offsetof(atas_task_record, helping) == 1560, "atas_task_record.helping");
_Static_assert(offsetof(atas_task_record, table) == 3104, "atas_task_record.table");

// One order; only what its kind names is used, the rest is zero.
typedef struct atas_order_record {
    // What is ordered.
    uint32_t kind; // enum atas_order_kind
    // Index of a parameter or of a hand.
    uint32_t index;
    // Which goal.
    uint64_t goal_id;
    // Value of a parameter; of a goal to start, how far its hands may grasp beside where they were told, m.
    double value;
    // Why.
    atas_reason reason;
    // A goal to start.
    atas_goal_request goal;
    // Its task, as the configuration had it then.
    atas_task_record task;
    // All settings.
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

// What one tick took in, and the command that came out. A tick that took more than one frame of a hand, or more
// than one target, is told in several parts, one after the other.
typedef struct atas_tick_inputs {
    // sequence counts the parts of all ticks since the start, from 0; captured_ns is the tick's time.
    atas_stamp stamp;
    // Index of the tick; a gap means missed ticks.
    uint64_t tick;
    // Which part this is, from 0. What is not per frame stands in every part.
    uint32_t part;
    // Parts of this tick.
    uint32_t parts;
    // Per hand, 1 if this part has a frame.
    uint32_t has_frame[2];
    // 1 if a joint state arrived.
    uint32_t has_joints;
    // 1 if this part has a target.
    uint32_t has_target;
    // Frame number part of each hand, as it came, unchecked.
    atas_hand_frame frames[2];
    // The newest joint state, as it came, unchecked.
    atas_joint_state joints;
    // Target number part, as it came, unchecked.
    atas_grasp_target target;
    // The order that was taken.
    atas_order_record order;
    // The command that was published.
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

// One hand's sensor, as the controller is wired to it.
typedef struct atas_hand_wiring_record {
    // Fingers that carry sensors.
    uint32_t fingers;
    // 1 if the robot must hold when this hand is silent.
    uint32_t required;
    // Nominal frame rate, Hz.
    double rate_hz;
    // Elements of the layout, at most ELEMENTS.
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

// How a run began: what the controller was made from.
typedef struct atas_run_header {
    // captured_ns is when the daemon started; the epoch is that of its commands.
    atas_stamp stamp;
    // Version of the daemon. Another version may compute another command.
    char version[32];
    // FNV-1a 64 of config.
    uint64_t config_hash;
    // The robot: built-in, or the path of its URDF.
    char robot[256];
    // FNV-1a 64 of the URDF's text, 0 for the built-in robot.
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
    // Servo stiffness of each joint of one hand, N·m/rad; zero where there is no joint.
    double stiffness_n_m_rad[32];
    // Per hand.
    atas_hand_wiring_record hands[2];
    // The settings of the first tick. Later changes are orders.
    atas_settings_record settings;
    // The whole configuration as TOML, for people: what a replay needs of it stands in the other fields.
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
_Static_assert(offsetof(atas_run_header, stiffness_n_m_rad) == 352, "atas_run_header.stiffness_n_m_rad");
_Static_assert(offsetof(atas_run_header, hands) == 608, "atas_run_header.hands");
_Static_assert(offsetof(atas_run_header, settings) == 12960, "atas_run_header.settings");
_Static_assert(offsetof(atas_run_header, config) == 13744, "atas_run_header.config");

// What every agent senses at the start of one field frame.
typedef struct atas_agent_sensors {
    // captured_ns is the frame's time.
    atas_stamp stamp;
    // Index of the field frame within the trial.
    uint64_t frame;
    // Index of the trial (goal position).
    uint32_t trial;
    // Agents that carry data, at most AGENTS.
    uint32_t agent_count;
    // Names the field's numbers, so that agents can refuse a field that their tables were not evolved for.
    uint64_t field_hash;
    // Per agent the table row that its sensors select: bit 0 is S1, bit 4 is S5.
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

// What every agent does in that field frame.
typedef struct atas_wheel_commands {
    // captured_ns is copied from the sensors that it answers.
    atas_stamp stamp;
    // The field frame that it answers.
    uint64_t frame;
    // The trial that it answers.
    uint32_t trial;
    // Agents that carry data.
    uint32_t agent_count;
    // First 8 bytes of the hash of the table that was looked up, so that a swap is visible.
    uint64_t table_hash;
    // Per agent the table's output bits: L1 bit 0, L2 bit 1, R1 bit 2, R2 bit 3.
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

// What a base sees at the start of a frame. Places are metres ahead of its middle and to the left.
typedef struct atas_base_state {
    // captured_ns is the frame's time.
    atas_stamp stamp;
    // Index of the frame.
    uint64_t frame;
    // Where the object's light is, m; means nothing while the hand has the object.
    double object_m[2];
    // Where the goal's light is, m.
    double goal_m[2];
    // Distance to the robot that has the right of way, m; infinite if this one has it, or nobody needs it.
    double first_m;
    // 1 while the object stands, so that its light is seen.
    uint32_t object_stands;
    // 1 while the wheels stand.
    uint32_t stands;
    // What ended the course at once.
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
_Static_assert(offsetof(atas_base_state, first_m) == 64, "atas_base_state.first_m");
_Static_assert(offsetof(atas_base_state, object_stands) == 72, "atas_base_state.object_stands");
_Static_assert(offsetof(atas_base_state, stands) == 76, "atas_base_state.stands");
_Static_assert(offsetof(atas_base_state, mishap) == 80, "atas_base_state.mishap");
_Static_assert(offsetof(atas_base_state, pad) == 84, "atas_base_state.pad");

// What a base is told for that frame.
typedef struct atas_base_command {
    // captured_ns is copied from the state that it answers.
    atas_stamp stamp;
    // The frame that it answers.
    uint64_t frame;
    // Who has the say.
    uint32_t say; // enum atas_say
    // Which light counts. The base drives gently once it is the goal's: its robot carries the object then.
    uint32_t light; // enum atas_light
} atas_base_command;
#define ATAS_BASE_COMMAND_TYPE "atas.BaseCommand.v1"
_Static_assert(sizeof(atas_base_command) == 40, "atas_base_command");
_Static_assert(_Alignof(atas_base_command) == 8, "atas_base_command");
_Static_assert(offsetof(atas_base_command, stamp) == 0, "atas_base_command.stamp");
_Static_assert(offsetof(atas_base_command, frame) == 24, "atas_base_command.frame");
_Static_assert(offsetof(atas_base_command, say) == 32, "atas_base_command.say");
_Static_assert(offsetof(atas_base_command, light) == 36, "atas_base_command.light");

// The true state of one simulated object.
typedef struct atas_object_truth {
    // Name of the object, as in its data file.
    char name[32];
    // Middle of its shape, base frame, m.
    double position_m[3];
    // Orientation, base frame, quaternion w, x, y, z.
    double orientation[4];
    // How far its middle is above where it rested at the start, m.
    double lifted_m;
    // Tilt of its upright axis, rad.
    double tilt_rad;
    // Force each finger must press with to carry it, m·g / (2·μ), N.
    double needed_n;
    // Force at which it crushes, N; infinite if it does not.
    double crush_n;
    // Largest force it has felt, N.
    double max_force_n;
    // Sum of the forces of the table, or of what else it stands on, N.
    double table_n;
    // When it first stood again after it had been lifted last, simulated time, ns; 0 if never.
    uint64_t landed_ns;
    // When what it stands on first truly carried it after that: with 0.2 N or a tenth of its weight, whichever is more, where a
    // first corner that grazes carries less; simulated time, ns; 0 if never.
    uint64_t carried_ns;
    // When the last fingertip let go of it after it had been lifted last: for the first time after it landed, else most
    // recently; simulated time, ns; 0 if never.
    uint64_t released_ns;
    // Its height above what was under it at that moment, m.
    double released_above_m;
    // Greatest slip along the fingertips in any hold of a hand so far, while its support did not carry all of it, m.
    double slip_in_hand_m;
    // Greatest turn in any of these holds, rad.
    double turn_in_hand_rad;
    // How far it is from where it stood at the start, over the table, m.
    double displaced_m;
    // How far a cap has been turned since the threads met, rad, positive closing. This and the following are 0 for
    // other objects.
    double cap_angle_rad;
    // Angle at which a cap is closed, rad.
    double cap_closing_rad;
    // Friction torque of a cap's thread before it closes, N·m.
    double cap_friction_n_m;
    // Torque on a cap's thread now, N·m.
    double cap_torque_n_m;
    // Torque that it takes to turn a cap any further, N·m: how tight it is.
    double cap_holding_n_m;
    // 1 while a cap is on the neck and its thread engaged.
    uint32_t cap_engaged;
    // 1 while it is engaged and turned to its closing angle or beyond.
    uint32_t cap_closed;
    // 1 while it stands by itself, upright within 5° and within 10 mm of where it stood at the start.
    uint32_t stands;
    // 1 while a fingertip presses it.
    uint32_t pressed;
    // 1 once crushed.
    uint32_t crushed;
    // 1 once dropped: it fell out of the hand after it had been lifted.
    uint32_t dropped;
    // 1 once it tipped over.
    uint32_t tipped;
    // 1 once spilt: a bottle that tilted while it was not closed.
    uint32_t spilt;
} atas_object_truth;
#define ATAS_OBJECT_TRUTH_TYPE "atas.ObjectTruth.v4"
_Static_assert(sizeof(atas_object_truth) == 264, "atas_object_truth");
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
_Static_assert(offsetof(atas_object_truth, slip_in_hand_m) == 168, "atas_object_truth.slip_in_hand_m");
_Static_assert(offsetof(atas_object_truth, turn_in_hand_rad) == 176, "atas_object_truth.turn_in_hand_rad");
_Static_assert(offsetof(atas_object_truth, displaced_m) == 184, "atas_object_truth.displaced_m");
_Static_assert(offsetof(atas_object_truth, cap_angle_rad) == 192, "atas_object_truth.cap_angle_rad");
_Static_assert(offsetof(atas_object_truth, cap_closing_rad) == 200, "atas_object_truth.cap_closing_rad");
_Static_assert(offsetof(atas_object_truth, cap_friction_n_m) == 208, "atas_object_truth.cap_friction_n_m");
_Static_assert(offsetof(atas_object_truth, cap_torque_n_m) == 216, "atas_object_truth.cap_torque_n_m");
_Static_assert(offsetof(atas_object_truth, cap_holding_n_m) == 224, "atas_object_truth.cap_holding_n_m");
_Static_assert(offsetof(atas_object_truth, cap_engaged) == 232, "atas_object_truth.cap_engaged");
_Static_assert(offsetof(atas_object_truth, cap_closed) == 236, "atas_object_truth.cap_closed");
_Static_assert(offsetof(atas_object_truth, stands) == 240, "atas_object_truth.stands");
_Static_assert(offsetof(atas_object_truth, pressed) == 244, "atas_object_truth.pressed");
_Static_assert(offsetof(atas_object_truth, crushed) == 248, "atas_object_truth.crushed");
_Static_assert(offsetof(atas_object_truth, dropped) == 252, "atas_object_truth.dropped");
_Static_assert(offsetof(atas_object_truth, tipped) == 256, "atas_object_truth.tipped");
_Static_assert(offsetof(atas_object_truth, spilt) == 260, "atas_object_truth.spilt");

// The true state of the simulated world.
typedef struct atas_world_truth {
    // captured_ns is the simulated time.
    atas_stamp stamp;
    // Milliseconds of the machine's clock that were skipped so far because the simulator came late; 0 in lock-step.
    uint64_t missed_ticks;
    // Objects that carry data.
    uint32_t object_count;
    // Commands refused or expired so far.
    uint32_t expired_commands;
    // The objects.
    atas_object_truth objects[4];
    // True sliding distance of each fingertip on what it touches since its first touch, m.
    double slip_m[2][4];
    // True normal force of each fingertip, N.
    double normal_n[2][4];
} atas_world_truth;
#define ATAS_WORLD_TRUTH_TYPE "atas.WorldTruth.v4"
_Static_assert(sizeof(atas_world_truth) == 1224, "atas_world_truth");
_Static_assert(_Alignof(atas_world_truth) == 8, "atas_world_truth");
_Static_assert(offsetof(atas_world_truth, stamp) == 0, "atas_world_truth.stamp");
_Static_assert(offsetof(atas_world_truth, missed_ticks) == 24, "atas_world_truth.missed_ticks");
_Static_assert(offsetof(atas_world_truth, object_count) == 32, "atas_world_truth.object_count");
_Static_assert(offsetof(atas_world_truth, expired_commands) == 36, "atas_world_truth.expired_commands");
_Static_assert(offsetof(atas_world_truth, objects) == 40, "atas_world_truth.objects");
_Static_assert(offsetof(atas_world_truth, slip_m) == 1096, "atas_world_truth.slip_m");
_Static_assert(offsetof(atas_world_truth, normal_n) == 1160, "atas_world_truth.normal_n");

// One agent in one frame: where it is, what it senses there, and what it does about it.
typedef struct atas_agent_truth {
    // Its centre, to the right of the field's and above it, px.
    float position_px[2];
    // Where it looks, counter-clockwise from +x, 1/64 turns.
    uint32_t heading_steps;
    // The table row that its sensors select here: bit 0 is S1, bit 4 is S5.
    uint32_t row;
    // What it does in this frame, its table's output bits: L1 bit 0, L2 bit 1, R1 bit 2, R2 bit 3. It stands still (0) where
    // nothing was answered and when a trial is over.
    uint32_t output;
    // 1 if it pressed against the object in the frame before.
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

// One field: an object, a goal, and how well the object is on its way.
typedef struct atas_field_truth {
    // Centre of the object, px.
    float object_px[2];
    // Centre of the goal, px.
    float goal_px[2];
    // From the object to the goal, px.
    float distance_px;
    // E1 (Eq. 2) of that distance, points.
    float e1_points;
    // E2 (Eq. 3), points; 0 before the object was within the goal's radius.
    float e2_points;
    // What the trial is worth by the field's rule, points of 100; 0 before it is over.
    float points;
    // The first frame, from 1, after which the object was within the goal's radius; 0 before.
    uint32_t reached_frame;
    // 1 once the trial is over and the object was carried to its goal.
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

// What a trial that is over came to, on field 0.
typedef struct atas_trial_truth {
    // Index of the trial.
    uint32_t trial;
    // Its goal, 1 to 8; 0 in a place that holds no trial yet.
    uint32_t goal;
    // From the object to the goal in the end, px.
    float distance_px;
    // The first frame, from 1, after which the object was within the goal's radius; 0 if it never was.
    uint32_t reached_frame;
    // What it is worth by the field's rule, points of 100.
    float points;
    // Fields, of all side by side, whose object was carried to its goal.
    uint32_t solved_fields;
    // Frames in which the agents stood still because no answer came in time.
    uint32_t missed_frames;
    // Frames in which they stood still because the answer was malformed.
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
    // Where it begins, px.
    float from_px[2];
    // Where it ends, px.
    float to_px[2];
} atas_wall_truth;
#define ATAS_WALL_TRUTH_TYPE "atas.WallTruth.v1"
_Static_assert(sizeof(atas_wall_truth) == 16, "atas_wall_truth");
_Static_assert(_Alignof(atas_wall_truth) == 4, "atas_wall_truth");
_Static_assert(offsetof(atas_wall_truth, from_px) == 0, "atas_wall_truth.from_px");
_Static_assert(offsetof(atas_wall_truth, to_px) == 8, "atas_wall_truth.to_px");

// A round post inside a field.
typedef struct atas_post_truth {
    // Its centre, px.
    float at_px[2];
    // Its radius, px.
    float radius_px;
} atas_post_truth;
#define ATAS_POST_TRUTH_TYPE "atas.PostTruth.v1"
_Static_assert(sizeof(atas_post_truth) == 12, "atas_post_truth");
_Static_assert(_Alignof(atas_post_truth) == 4, "atas_post_truth");
_Static_assert(offsetof(atas_post_truth, at_px) == 0, "atas_post_truth.at_px");
_Static_assert(offsetof(atas_post_truth, radius_px) == 8, "atas_post_truth.radius_px");

// The true state of the swarm's fields in one frame.
typedef struct atas_arena_truth {
    // captured_ns is the frame's time, as in the agents' sensors.
    atas_stamp stamp;
    // Index of the frame within the trial; as many as a trial has when it is over.
    uint64_t frame;
    // Names the field's numbers, as in the agents' sensors.
    uint64_t field_hash;
    // First 8 bytes of the hash of the table that is looked up in this frame; 0 if nothing was answered.
    uint64_t table_hash;
    // Index of the trial (goal position).
    uint32_t trial;
    // Trials of the session.
    uint32_t trial_count;
    // Goal of the trial on field 0, 1 to 8, counter-clockwise from +x.
    uint32_t goal;
    // Frames of the task execution time (paper III.b.3).
    uint32_t execution_frames;
    // Frames of a trial: the execution time and the evaluation time after it.
    uint32_t trial_frames;
    // 1 if the agents were told what to do in this frame.
    uint32_t is_driven;
    // Agents that carry data, at most AGENTS: those of field 0 first.
    uint32_t agent_count;
    // Fields that carry data, at most AGENTS.
    uint32_t field_count;
    // Agents on each field.
    uint32_t team;
    // Angle of the side IR sensors to straight ahead, 1/64 turns.
    uint32_t ir_angle_steps;
    // Angle of the photo sensors' axes to straight ahead, 1/64 turns.
    uint32_t photo_angle_steps;
    // Cosine of half a photo sensor's opening angle: 0 sees a half-plane, towards 1 sees a ray.
    float photo_half_angle_cosine;
    // Half the side of a field: its border, px.
    float half_side_px;
    // Radius of an agent, px.
    float agent_radius_px;
    // Radius of an object, px.
    float object_radius_px;
    // An object has arrived when its centre is this close to the goal's, px.
    float goal_radius_px;
    // Reach of an IR sensor from the agent's centre, px.
    float ir_range_px;
    // Distance within which the object's light is seen, px.
    float object_light_px;
    // Distance within which the goal's light is seen, px.
    float goal_light_px;
    // Friction of the object over the force at which one agent stalls; 0 in a field whose yielding was fitted.
    float friction_stall_forces;
    // The part of an overlap by which one, two, three and four agents move the object.
    float yielding[4];
    // Walls that carry data, at most OBSTACLES.
    uint32_t wall_count;
    // Posts that carry data, at most OBSTACLES.
    uint32_t post_count;
    // The walls inside every field.
    atas_wall_truth walls[16];
    // The posts inside every field.
    atas_post_truth posts[16];
    // How the field's preset is called.
    char preset[32];
    // The newest trials that are over, that of index t in place t modulo 8.
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
