"""Hands that a policy controls by poses: of a running daemon, or simulated in this process.

Both have the same methods. The tactile modules of the controller choose the grip force beneath the
poses. If no pose follows, the hand brakes and keeps its grip.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

from . import _native
from .features import HandFeatures

FRESH_S = 1.0
"""Time without a message of the daemon after which an observation fails, s. Design choice: a
thousand ticks. Smaller values fail while a loaded machine delays this process."""

SAMPLE_TICKS = 5
"""Ticks between two samples of the true force. Design choice: a grip rises over tens of
milliseconds; sampling every tick takes three times as long."""

UNREACHABLE_N = 1e4
"""Touch threshold that no force reaches, N: removes the reflex."""


class BusHand:
    """A hand of a running daemon. The first pose starts the daemon's teleoperation.

    `model` is the daemon's robot: a built-in name, or the path of a robot file. `tactile` is "none",
    "summary" or "taxels", `actions` is "pose" or "joints". A pose is valid for `valid_s` (at most
    2 s). `item` (x, y, z, yaw, width) and `place` (x, y, z) are part of the observation.
    """

    def __init__(
        self,
        bus: str | None = None,
        *,
        hand: str = "right",
        model: str | None = None,
        tactile: str = "summary",
        actions: str = "pose",
        elements: int = 41,
        valid_s: float = 0.4,
        item: Sequence[float] | None = None,
        place: Sequence[float] | None = None,
        role: str = "policy",
    ) -> None:
        self.features = HandFeatures(model, hand, tactile, actions)
        self._elements, self._valid_s, self._item, self._place = elements, valid_s, item, place
        self._bus = _native.Bus(bus, role=role)
        self._teleop: _native.Teleop | None = None
        self._readers = {"joint state": self._bus.joint_states(), "report": self._bus.reports()}
        if tactile == "taxels":
            self._readers["frame"] = self._bus.frames(hand)
        self._newest: dict[str, Any] = {}
        self._received_s = dict.fromkeys(self._readers, time.monotonic())
        self._receive()

    def __repr__(self) -> str:
        state = "runs" if self._teleop is not None else "holds"
        return f"<BusHand {self.features.hand!r} on {self._bus!r}: {state}>"

    def now_s(self) -> float:
        """Time, s."""
        return time.monotonic()

    def wait(self, until_s: float) -> None:
        """Waits until a time."""
        time.sleep(max(until_s - self.now_s(), 0.0))

    def observe(self) -> dict[str, float]:
        """The newest state, environment and taxels. Raises BusError if the daemon is silent."""
        self._receive()
        newest = self._newest
        seen = self.features.state(newest["joint state"]["position"], newest["report"])
        seen |= self.features.environment(self._item, self._place)
        if "frame" in newest:
            seen |= self.features.taxels(newest["frame"], self._elements)
        return seen

    def send(self, target: Mapping[str, float]) -> None:
        """Requests a pose (`HandFeatures.target`).

        Raises AtasError if the daemon has ended the teleoperation; the next call starts it again.
        """
        if self._teleop is None:
            self._teleop = self._bus.teleop(self.features.hand)
        at = [target["hand.x"], target["hand.y"], target["hand.z"]]
        try:
            self._teleop.send(at, target["hand.opening"], yaw=target["hand.yaw"], valid=self._valid_s)
        except _native.BusError:
            raise
        except _native.AtasError:
            self._teleop = None
            raise

    def hold(self) -> None:
        """Ends the teleoperation: the hand brakes and keeps its grip."""
        teleop, self._teleop = self._teleop, None
        if teleop is not None:
            teleop.end()

    def zero(self) -> None:
        """Zeroes the fingertip sensors. The hand must be empty and the daemon ready."""
        self.hold()
        self._bus.bias(self.features.hand)

    def _receive(self) -> None:
        """Takes new data; waits for the first."""
        while True:
            now_s = time.monotonic()
            for name, reader in self._readers.items():
                newest = reader.newest()
                if newest is not None:
                    self._newest[name], self._received_s[name] = newest, now_s
                elif now_s - self._received_s[name] > FRESH_S:
                    raise _native.BusError(
                        f"received no {name} for {FRESH_S} s; see `atas status` and `atas doctor`"
                    )
            if len(self._newest) == len(self._readers):
                return
            time.sleep(0.002)


class SimulatedHand:
    """A simulated hand and object with the controller of the daemon, in virtual time.

    Equal seeds and poses give equal bits. `model` is the robot. `reflex=False` removes the reflex for comparison: touch
    is never detected, so that the hand executes the requested openings.
    """

    def __init__(
        self,
        object: str = "wood",
        *,
        seed: int = 0,
        hand: str = "right",
        model: str | None = None,
        tactile: str = "summary",
        actions: str = "pose",
        elements: int = 41,
        reflex: bool = True,
        noise: float = 1.0,
        item: Sequence[float] | None = None,
        place: Sequence[float] | None = None,
    ) -> None:
        self.features = HandFeatures(model, hand, tactile, actions)
        self._elements, self._place = elements, place
        touch_n = {"perception.touch_on_n": UNREACHABLE_N, "perception.touch_off_n": UNREACHABLE_N}
        settings = {} if reflex else touch_n
        self.simulation = _native.Simulation(object, seed=seed, hand=hand, noise=noise, settings=settings, robot=model)
        hint = self.simulation.hint
        self._item = item or [*hint["at"], hint["yaw"], hint["width"]]
        self._report: Any = None
        self._frame: Any = None
        self.is_teleoperated = False
        self.peak_n = 0.0
        """Largest true normal force of a fingertip, N; sampled every 5 ms."""
        self.run(1)

    def __repr__(self) -> str:
        return f"<SimulatedHand {self.features.hand!r}: {self.simulation!r}, peak {self.peak_n:.2f} N>"

    def now_s(self) -> float:
        """Virtual time, s."""
        return self.simulation.now_ns * 1e-9

    def wait(self, until_s: float) -> None:
        """Runs the simulation until a virtual time."""
        self.run(max(round((until_s - self.now_s()) * 1e3), 0))

    def run(self, ticks: int) -> None:
        """Runs ticks of 1 ms."""
        for begin in range(0, ticks, SAMPLE_TICKS):
            self._report = self.simulation.step(min(SAMPLE_TICKS, ticks - begin))[-1]
            frame = self.simulation.frame(self.features.hand)
            self._frame = self._frame if frame is None else frame
            pressed_n = self.simulation.truth["normal_n"][self.features.index]
            self.peak_n = max(self.peak_n, float(pressed_n.max()))

    def observe(self) -> dict[str, float]:
        """State, environment and taxels of the last tick. The scene supplies the object."""
        seen = self.features.state(self.simulation.joint_state["position"], self._report)
        seen |= self.features.environment(self._item, self._place)
        if self.features.tactile == "taxels":
            seen |= self.features.taxels(self._frame, self._elements)
        return seen

    def send(self, target: Mapping[str, float]) -> None:
        """Requests a pose; see `BusHand.send`. `wait` or `run` executes it."""
        if not self.is_teleoperated:
            self.simulation.teleoperate()
            self.is_teleoperated = True
        at = [target["hand.x"], target["hand.y"], target["hand.z"]]
        try:
            self.simulation.send(at, target["hand.opening"], yaw=target["hand.yaw"])
        except _native.AtasError:
            self.is_teleoperated = False
            raise

    def hold(self) -> None:
        """Sends no further pose: the last one expires, and the hand keeps its grip."""
