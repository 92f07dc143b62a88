"""ATAS, an artificial tactile affordance system, from Python.

* `Bus`: frames, reports, status and events as NumPy arrays; publish as a sensor or a robot; send goals, stop.
* `Simulation`: the simulator with the production controller in this process, in virtual time.
* `Recording`: what `atas record` wrote, as arrays; replayed bit for bit.
* `gymnasium` environments `atas/Grasp-v0` and `atas/PickPlace-v0`, if gymnasium is installed.

Every array is structured as the payload on the bus that it holds: `frames["force_n"]`, `report["hands"]["fingers"]`; `dtype` tells
the fields, `clients/protocol.md` what they mean. Units stand last in names; times are nanoseconds of CLOCK_MONOTONIC.
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
    Leader,
    Reader,
    Recording,
    Robot,
    Sensor,
    Simulation,
    __version__,
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
    "Leader",
    "Mode",
    "ModuleId",
    "Rate",
    "Reader",
    "Recording",
    "Robot",
    "Sensor",
    "Simulation",
    "__version__",
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
    # Only gymnasium itself may be missing: who does not learn does not need it.
    if missing.name != "gymnasium":
        raise
else:
    _environments.register()
