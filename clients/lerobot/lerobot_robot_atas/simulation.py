"""Robot `atas_simulation`: the simulator with the controller of the daemon, in virtual time."""

from __future__ import annotations

import logging
from typing import Any

import atas
from atas.hands import SimulatedHand

from .config import AtasSimulationConfig
from .robot import HandRobot

logger = logging.getLogger(__name__)


class AtasSimulation(HandRobot):
    """Simulated hand and object. An action runs the simulation for one period of `fps`."""

    config_class = AtasSimulationConfig
    name = "atas_simulation"

    def __init__(self, config: AtasSimulationConfig) -> None:
        super().__init__(config, None)
        self._hand: SimulatedHand | None = None

    @property
    def hand(self) -> SimulatedHand:
        """The simulated hand: its `simulation` has the truth, `peak_n` is the largest force."""
        self._require(connected=True)
        assert self._hand is not None
        return self._hand

    @property
    def simulation(self) -> atas.Simulation:
        """The simulator, for example for its `hint` and `truth`."""
        return self.hand.simulation

    def connect(self, calibrate: bool = True) -> None:
        """Creates the world with the configured seed."""
        self._require(connected=False)
        self._begin(self.config.seed, self.config.item)
        self._connect_cameras()

    def begin_episode(self, seed: int, item: str | None = None) -> None:
        """Replaces the world by a new one with this seed, and another object if named."""
        self._require(connected=True)
        self._begin(seed, item or self.config.item)

    def calibrate(self) -> None:
        """Does nothing: the sensors of a new world have no offset."""
        self._require(connected=True)

    def get_observation(self) -> dict[str, Any]:
        """State, environment and pictures of the last tick. The scene supplies the object."""
        return dict(self.hand.observe()) | self._see()

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        """Requests a pose and runs the simulation for one period; see `Atas.send_action`."""
        hand = self.hand
        target = self.features.target(action)
        try:
            hand.send(target)
        except atas.AtasError as cause:
            logger.warning("%s: the teleoperation ended: %s; the next action starts it again", self, cause)
        hand.run(1000 // self.config.fps)
        return self.features.sent(action, target)

    def disconnect(self) -> None:
        """Removes the world."""
        self._require(connected=True)
        self._hand = None
        self._disconnect_cameras()

    def _begin(self, seed: int, item: str) -> None:
        config = self.config
        self._hand = SimulatedHand(
            item,
            seed=seed,
            hand=config.hand,
            tactile=config.tactile,
            actions=config.actions,
            elements=config.elements,
            reflex=config.reflex,
            noise=config.noise,
            item=config.object,
            place=config.place,
        )
