"""LeRobot plugin for ATAS, an artificial tactile affordance system.

* Robot `atas`: a hand of a running daemon, over the shared-memory bus.
* Robot `atas_simulation`: the simulator with the same controller in this process, in virtual time.
* Teleoperators `atas_keyboard` and `atas_leader`: keys, and any leader arm with a robot file.

An action is the pose and opening of the hand (or its joints). The tactile modules of the daemon
control the grip force beneath it: the external reference only proposes.
"""

from .config import AtasConfig, AtasKeyboardConfig, AtasLeaderConfig, AtasSimulationConfig
from .robot import Atas
from .simulation import AtasSimulation
from .teleoperators import AtasKeyboard, AtasLeader

__all__ = [
    "Atas",
    "AtasConfig",
    "AtasKeyboard",
    "AtasKeyboardConfig",
    "AtasLeader",
    "AtasLeaderConfig",
    "AtasSimulation",
    "AtasSimulationConfig",
]
