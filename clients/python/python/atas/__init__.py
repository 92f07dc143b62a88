"""Python interface of ATAS, an artificial tactile affordance system.

* `Bus`: reads frames, reports, status and events as NumPy arrays; publishes as a sensor or robot; sends goals and stops.
* `Simulation`: the simulator with the production controller in this process, in virtual time.
* `Kinematics`: pinch poses of joint positions, for leader arms and data sets.
* `atas.hands` and `atas.policy`: hands for policies, and policies over the network.
* `SwarmField`, `SwarmSearch`: fitness of behaviour tables, and the genetic algorithm as ask and tell.
* `Recording`: recordings of `atas record` as arrays, and their bit-exact replay.
* `gymnasium` environments `atas/Grasp-v0` and `atas/PickPlace-v0`, if gymnasium is installed.

Arrays are structured like the payloads on the bus: `frames["force_n"]`, `report["hands"]["fingers"]`. `dtype` returns the
fields; `clients/protocol.md` describes them. Names end with the unit; times are nanoseconds of CLOCK_MONOTONIC.
"""

from . import codes
from ._native import (
    ELEMENTS,
    FINGERS,
    JOINT_NAMES,
    JOINTS,
    AtasError,
    Bus,
    BusError,
    Goal,
    Kinematics,
    Teleop,
    Reader,
    Recording,
    Robot,
    Sensor,
    Simulation,
    SwarmField,
    SwarmSearch,
    __version__,
    abi,
    dtype,
    layout,
    now_ns,
    objects,
    reason,
    wipe,
)
from .codes import Cause, EventKind, GoalKind, GoalState, Hand, Mode, ModuleId
from .rate import Rate

__all__ = [
    "ELEMENTS",
    "FINGERS",
    "JOINTS",
    "JOINT_NAMES",
    "AtasError",
    "Bus",
    "BusError",
    "Cause",
    "EventKind",
    "Goal",
    "GoalKind",
    "GoalState",
    "Hand",
    "Kinematics",
    "Teleop",
    "Mode",
    "ModuleId",
    "Rate",
    "Reader",
    "Recording",
    "Robot",
    "Sensor",
    "Simulation",
    "SwarmField",
    "SwarmSearch",
    "__version__",
    "abi",
    "codes",
    "dtype",
    "layout",
    "now_ns",
    "objects",
    "reason",
    "wipe",
]

try:
    from . import environments as _environments
except ModuleNotFoundError as missing:
    # gymnasium is optional; any other missing module is an error.
    if missing.name != "gymnasium":
        raise
else:
    _environments.register()
