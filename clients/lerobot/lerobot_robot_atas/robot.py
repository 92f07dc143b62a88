"""Robot `atas`: a hand of a running daemon, over the shared-memory bus."""

from __future__ import annotations

import logging
from typing import Any

import atas
from atas.features import ENVIRONMENT, HandFeatures
from atas.hands import BusHand
from lerobot.cameras import make_cameras_from_configs
from lerobot.robots import Robot
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError

from .config import AtasConfig

logger = logging.getLogger(__name__)


class HandRobot(Robot):
    """Base of both robots: features, cameras, and the states of a connection."""

    def __init__(self, config: Any, model: str | None) -> None:
        super().__init__(config)
        self.config = config
        self.features = HandFeatures(model, config.hand, config.tactile, config.actions)
        self.cameras = make_cameras_from_configs(config.cameras)
        self._hand: Any = None

    @property
    def is_connected(self) -> bool:
        """True from `connect` to `disconnect`."""
        return self._hand is not None

    @property
    def observation_features(self) -> dict[str, Any]:
        """State, environment, taxels if configured: float. Cameras: height, width, channels."""
        names = [*self.features.state_names(), *ENVIRONMENT]
        if self.config.tactile == "taxels":
            names += self.features.taxel_names(self.config.elements)
        sizes = {name: (one.height, one.width, 3) for name, one in self.config.cameras.items()}
        return dict.fromkeys(names, float) | sizes

    @property
    def action_features(self) -> dict[str, Any]:
        """Pose and opening of the hand, or its joints: float."""
        return dict.fromkeys(self.features.action_names(), float)

    @property
    def is_calibrated(self) -> bool:
        """Always true: the daemon applies the calibration of its sensors and joints."""
        return True

    def configure(self) -> None:
        """Does nothing: the daemon has its configuration."""

    def _require(self, connected: bool) -> None:
        if connected and not self.is_connected:
            raise DeviceNotConnectedError(f"{self} is not connected; call `connect` first")
        if not connected and self.is_connected:
            raise DeviceAlreadyConnectedError(f"{self} is connected already; call `disconnect` first")

    def _see(self) -> dict[str, Any]:
        return {name: camera.read_latest() for name, camera in self.cameras.items()}

    def _connect_cameras(self) -> None:
        for camera in self.cameras.values():
            camera.connect()

    def _disconnect_cameras(self) -> None:
        for camera in self.cameras.values():
            if camera.is_connected:
                camera.disconnect()


class Atas(HandRobot):
    """A hand of a running daemon. The first action starts the daemon's teleoperation."""

    config_class = AtasConfig
    name = "atas"

    def __init__(self, config: AtasConfig) -> None:
        super().__init__(config, config.model)
        self._hand: BusHand | None = None

    def connect(self, calibrate: bool = True) -> None:
        """Joins the bus and waits for the first data of the daemon. Moves nothing."""
        self._require(connected=False)
        config = self.config
        try:
            self._hand = BusHand(
                config.bus,
                hand=config.hand,
                model=config.model,
                tactile=config.tactile,
                actions=config.actions,
                elements=config.elements,
                valid_s=config.valid_s,
                item=config.object,
                place=config.place,
                role="lerobot",
            )
        except atas.BusError as cause:
            raise DeviceNotConnectedError(
                f"could not connect {self}: {cause}; start the robot and `atasd` first"
            ) from cause
        try:
            self._connect_cameras()
        except BaseException:
            self.disconnect()
            raise

    def calibrate(self) -> None:
        """Zeroes the fingertip sensors. The hand must be empty and the daemon ready."""
        self._require(connected=True)
        assert self._hand is not None
        try:
            self._hand.zero()
        except (atas.AtasError, TimeoutError) as cause:
            raise RuntimeError(f"could not zero the fingertip sensors of {self}: {cause}") from cause

    def get_observation(self) -> dict[str, Any]:
        """The newest state, environment and pictures. Does not wait for the next tick."""
        self._require(connected=True)
        assert self._hand is not None
        try:
            seen: dict[str, Any] = dict(self._hand.observe())
        except atas.BusError as cause:
            raise DeviceNotConnectedError(f"{self} lost the daemon: {cause}") from cause
        return seen | self._see()

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        """Requests a pose, limited to the bounds of teleoperation, and returns what was sent.

        The pose is valid for `valid_s`; then the hand brakes and keeps its grip. An invalid
        action raises ValueError and sends nothing.
        """
        self._require(connected=True)
        assert self._hand is not None
        target = self.features.target(action)
        try:
            self._hand.send(target)
        except atas.BusError as cause:
            raise DeviceNotConnectedError(f"{self} lost the daemon: {cause}; see `atas doctor`") from cause
        except (atas.AtasError, TimeoutError) as cause:
            # A daemon that is gone raises an error with the next observation.
            if not self.config.restart:
                raise RuntimeError(f"{self}: the teleoperation ended: {cause}") from cause
            logger.warning("%s: the teleoperation ended: %s; the next action starts it again", self, cause)
        return self.features.sent(action, target)

    def disconnect(self) -> None:
        """Ends the teleoperation (the hand brakes and keeps its grip) and leaves the bus."""
        self._require(connected=True)
        hand, self._hand = self._hand, None
        assert hand is not None
        try:
            hand.hold()
        except (atas.AtasError, TimeoutError) as cause:
            # The daemon is gone or has ended the teleoperation; both keep the grip.
            logger.warning("%s: the teleoperation ended: %s", self, cause)
        finally:
            self._disconnect_cameras()
