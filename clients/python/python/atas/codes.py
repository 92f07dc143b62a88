"""Codes of the bus, generated from the schema (checked by a test). Unknown values remain plain numbers."""

from enum import IntEnum


class Hand(IntEnum):
    """Left or right hand."""

    LEFT = 0
    RIGHT = 1


class Mode(IntEnum):
    """Mode of the daemon, ordered by severity."""

    INIT = 0
    READY = 1
    RUN = 2
    HOLD = 3
    SAFE_STOP = 4
    FAULT = 5


class GoalKind(IntEnum):
    """Task of a goal."""

    GRASP = 1
    PICK_PLACE = 2
    SCREW = 3
    ASSEMBLE = 4
    RELEASE = 5
    CUSTOM = 6
    TELEOP = 7
    TELEOP_BOTH = 8


class GoalPolicy(IntEnum):
    """Reaction to the disconnection of the client."""

    DETACHED = 0
    ATTACHED = 1


class GoalState(IntEnum):
    """State of a goal."""

    ACCEPTED = 1
    REJECTED = 2
    RUNNING = 3
    SUCCEEDED = 4
    REFUSED = 5
    FAILED = 6
    CANCELLED = 7


class Turn(IntEnum):
    """Direction in which a cap is turned, seen from above."""

    CLOCKWISE = 0
    ANTICLOCKWISE = 1


class GripOrder(IntEnum):
    """Grip command of a target."""

    WIDTH = 0
    HOLD = 1


class ControlOp(IntEnum):
    """Operation of a control request."""

    ESTOP = 1
    RECOVER = 2
    PARAM_GET = 3
    PARAM_SET = 4
    PARAM_LIST = 5
    BIAS = 6
    RELOAD = 7
    CANCEL = 8
    ADVANCE = 9


class ControlOutcome(IntEnum):
    """Result of a control request."""

    DONE = 1
    REFUSED = 2
    UNKNOWN = 3


class StopOutcome(IntEnum):
    """Result of a stop request."""

    STOPPED = 1
    WAITING = 2


class EventKind(IntEnum):
    """Kind of an event."""

    MODULE_ON = 1
    MODULE_OFF = 2
    TOUCH_ON = 3
    TOUCH_OFF = 4
    GOAL = 5
    STEP = 6
    MODE = 7
    STIFFNESS = 8
    WARNING = 9


class ModuleId(IntEnum):
    """Modules of the paper and additional modules."""

    NONE = 0
    TRAJECTORY = 1
    TRANSFER = 2
    FIRST_TOUCH = 3
    SLIP = 4
    FORCE_LIMIT = 5
    TERMINATE_SCREW = 6
    RELEASE_PLACED = 7
    PROBE = 8
    CARRY = 9
    RELAX = 10
    CONTACT_GUARD = 11
    LIFT_VERIFICATION = 12
    SLIP_REACTION = 13
    TELEOP = 14
    BEHAVIOUR_TABLE = 15


class Cause(IntEnum):
    """Cause of a rejection, a hold or a stop."""

    NONE = 0
    NOT_FINITE = 1
    OUT_OF_RANGE = 2
    UNREACHABLE = 3
    UNKNOWN_GOAL = 4
    BUSY = 5
    NOT_READY = 6
    HAND_FULL = 7
    NO_SENSOR = 8
    ARMS_COLLIDE = 9
    NOTHING_TOUCHED = 10
    TOO_HEAVY = 11
    LOST_OBJECT = 12
    OUT_OF_FORCE = 13
    TIMED_OUT = 14
    CANCELLED = 15
    CLIENT_GONE = 16
    NO_SUPPORT = 17
    OBSTRUCTED = 18
    UNKNOWN_TASK = 19
    FRAMES_STOPPED = 20
    FRAME_STALE = 21
    FRAME_FUTURE = 22
    FRAMES_LOST = 23
    FRAME_CORRUPT = 24
    FRAME_FOREIGN = 25
    ELEMENTS_INVALID = 26
    FRAMES_FROZEN = 27
    SENSOR_RESTARTED = 28
    SLIDING = 29
    JOINTS_STOPPED = 30
    JOINTS_INVALID = 31
    FOLLOWING_ERROR = 32
    COMMAND_NOT_FINITE = 33
    COMMAND_STEP = 34
    GRIP_CEILING = 35
    ROBOT_RESTARTED = 36
    FORCE_IMPLAUSIBLE = 37
    NOT_NOW = 38
    SENSE_ONLY = 39
    MODULE_PANICKED = 40
    LOOP_STALLED = 41
    ESTOP = 42
    SHUTDOWN = 43
    SUPERVISOR_SILENT = 44
    ELEMENT_STUCK = 45
    FORCE_AGAINST_JOINTS = 46
    FORCE_AGAINST_OPENING = 47
    TOO_SOFT = 50
    GRIP_FOUND = 51
    TURNED_IN_HAND = 52
    SLIPPED_IN_HAND = 53
    ABOVE_MAX_FORCE = 54
    TASK_TOO_LONG = 60
    NO_HAND = 61
    CANNOT_TURN = 62
    NO_WORKSPACE = 63
    HAND_EMPTY = 64
    FINGERTIPS_MISALIGNED = 65
    TARGETS_STOPPED = 70
    TARGET_CORRUPT = 71
    TARGET_FOREIGN = 72
    TARGET_STALE = 73
    TARGET_UNKNOWN = 74
    TARGET_NOT_FINITE = 75
    TARGET_OUT_OF_RANGE = 76
    ACROSS_THE_MIDDLE = 77


class OrderKind(IntEnum):
    """Request from the supervisor to a tick."""

    NONE = 0
    START = 1
    CANCEL = 2
    CLIENT_GONE = 3
    STOP = 4
    RECOVER = 5
    SET_PARAMETER = 6
    CONFIGURE = 7
    BIAS = 8
    HOLD = 9


class SensorBit(IntEnum):
    """Sensor bit of a behaviour table, evaluated in every tick (paper Table 1, S1 to S5)."""

    NONE = 0
    TOUCHING = 1
    ABOVE_F1 = 2
    SLIPPING = 3
    ABOVE_F2 = 4
    LIFTED = 5
    FRICTION_MARGIN = 6


class Light(IntEnum):
    """Light that the photo sensors of a base detect."""

    OBJECT = 0
    GOAL = 1


class ControlOwner(IntEnum):
    """Subsystem that controls the robot."""

    NONE = 0
    TABLE = 1
    HAND = 2
    OVER = 3


class Mishap(IntEnum):
    """Incident that ended the course of a base."""

    NONE = 0
    LEFT_FIELD = 1
    MET_ROBOT = 2
    MET_OBJECT = 3
