"""Tests of observations and actions, in the simulator."""

import math
import types
from typing import Any

import atas
import numpy as np
import pytest
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError
from lerobot_robot_atas import AtasSimulation, AtasSimulationConfig


def robot(options: dict[str, Any], **more: Any) -> AtasSimulation:
    made = AtasSimulation(AtasSimulationConfig(**options, **more))
    made.connect()
    return made


def pose_of(one: AtasSimulation, up: float = 0.06, wider: float = 0.018) -> dict[str, float]:
    hint = one.simulation.hint
    x, y, z = hint["at"]
    return {
        "hand.x": x,
        "hand.y": y,
        "hand.z": z + up,
        "hand.yaw": hint["yaw"],
        "hand.opening": hint["width"] + wider,
    }


@pytest.mark.parametrize("tactile", ["none", "summary", "taxels"])
@pytest.mark.parametrize("actions", ["pose", "joints"])
def test_observation_and_action_match_their_features(options: dict[str, Any], tactile: str, actions: str) -> None:
    one = AtasSimulation(AtasSimulationConfig(**options, tactile=tactile, actions=actions))
    observed, acted = one.observation_features, one.action_features
    one.connect()
    seen = one.get_observation()
    assert list(seen) == list(observed) and set(observed.values()) == {float}
    assert all(isinstance(value, float) and math.isfinite(value) for value in seen.values())
    assert len([name for name in seen if ".element" in name]) == (2 * 41 * 3 if tactile == "taxels" else 0)
    assert ("module.slip" in seen) == (tactile != "none")
    action = pose_of(one) if actions == "pose" else {name: seen[name] for name in acted}
    sent = one.send_action(action)
    assert list(sent) == list(acted) and sent == pytest.approx(action)


def test_measured_pose_follows_the_action(options: dict[str, Any]) -> None:
    one = robot(options)
    wanted = pose_of(one) | {"hand.yaw": math.pi / 2 + 0.1}
    for _ in range(150):
        one.send_action(wanted)
    seen = one.get_observation()
    assert {name: seen[name] for name in wanted} == pytest.approx(wanted, abs=1e-3)


def test_joint_actions_move_like_the_pose(options: dict[str, Any]) -> None:
    by_pose, by_joints = robot(options), robot(options, actions="joints")
    for _ in range(100):
        by_pose.send_action(pose_of(by_pose))
    joints = {name: by_pose.get_observation()[name] for name in by_joints.action_features}
    for _ in range(100):
        by_joints.send_action(joints)
    reached, wanted = by_joints.get_observation(), by_pose.get_observation()
    for name in ("hand.x", "hand.y", "hand.z", "hand.opening"):
        assert reached[name] == pytest.approx(wanted[name], abs=1e-3), name


def test_observed_forces_are_those_of_the_report(options: dict[str, Any]) -> None:
    one = robot(options, tactile="taxels")
    for up, wider, steps in ((0.06, 0.018, 100), (0.0, 0.018, 100), (0.0, -0.004, 200)):
        for _ in range(steps):
            one.send_action(pose_of(one, up, wider))
    seen = one.get_observation()
    pressed = sum(value for name, value in seen.items() if name.startswith("finger1.element") and name.endswith(".fn_n"))
    assert seen["finger1.in_contact"] == 1.0 and seen["finger1.normal_n"] > 0.3
    assert pressed > 0.5 * seen["finger1.normal_n"]
    assert seen["grip.f2_n"] >= seen["grip.f1_n"] > 0.0
    assert seen["object.width"] == pytest.approx(one.simulation.hint["width"])


def test_action_is_limited_to_the_bounds(options: dict[str, Any]) -> None:
    one = robot(options)
    sent = one.send_action(pose_of(one) | {"hand.x": 9.0, "hand.opening": -1.0})
    assert sent["hand.x"] == pytest.approx(0.40) and sent["hand.opening"] == 0.0
    one.send_action(sent)
    assert not [event for event in one.simulation.events if event["kind"] == atas.EventKind.WARNING]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"hand.x": float("nan")}, "hand.x is nan"),
        ({"hand.yaw": float("inf")}, "hand.yaw is inf"),
        ({"hand.w": 1.0}, "unknown"),
    ],
)
def test_invalid_action_moves_nothing(options: dict[str, Any], change: dict[str, float], says: str) -> None:
    one = robot(options)
    before = one.simulation.now_ns
    with pytest.raises(ValueError, match=says):
        one.send_action(pose_of(one) | change)
    with pytest.raises(ValueError, match="missing"):
        one.send_action({"hand.x": 0.3})
    assert one.simulation.now_ns == before


def test_states_of_the_connection_raise_lerobots_errors(options: dict[str, Any]) -> None:
    one = AtasSimulation(AtasSimulationConfig(**options))
    for call in (one.get_observation, one.disconnect, one.calibrate, lambda: one.send_action({})):
        with pytest.raises(DeviceNotConnectedError, match="connect"):
            call()
    one.connect()
    with pytest.raises(DeviceAlreadyConnectedError, match="already"):
        one.connect()
    one.disconnect()
    assert not one.is_connected
    one.connect()
    assert one.is_connected


def test_equal_seeds_give_equal_observations(options: dict[str, Any]) -> None:
    def told(seed: int) -> list[float]:
        one = robot(options, seed=seed, item="sponge")
        for _ in range(20):
            one.send_action(pose_of(one))
        return list(one.get_observation().values())

    assert told(4) == told(4) and told(4) != told(5)


def test_reflex_holds_what_a_position_controlled_hand_crushes(options: dict[str, Any]) -> None:
    outcomes = {}
    for reflex in (True, False):
        one = robot(options, item="paper-box", seed=1, reflex=reflex)
        for up, wider, steps in ((0.06, 0.018, 100), (0.0, 0.018, 100), (0.0, -0.004, 200), (0.04, -0.004, 150)):
            for _ in range(steps):
                one.send_action(pose_of(one, up, wider))
        held = one.simulation.truth["objects"][0]
        outcomes[reflex] = (bool(held["crushed"]), float(held["lifted_m"]) > 0.03, one.hand.peak_n)
    assert outcomes[True][:2] == (False, True) and outcomes[False][:2] == (True, False), outcomes
    assert outcomes[True][2] < outcomes[False][2]


class Camera:
    """Substitute for a camera of LeRobot."""

    def __init__(self) -> None:
        self.is_connected = False

    def connect(self) -> None:
        self.is_connected = True

    def read_latest(self) -> np.ndarray[Any, Any]:
        assert self.is_connected
        return np.full((3, 4, 3), 7, np.uint8)

    def disconnect(self) -> None:
        self.is_connected = False


def test_pictures_are_part_of_the_observation(options: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    camera = Camera()
    monkeypatch.setattr("lerobot_robot_atas.robot.make_cameras_from_configs", lambda configs: {"wrist": camera})
    sizes = {"wrist": types.SimpleNamespace(width=4, height=3, fps=30)}
    one = robot(options, cameras=sizes)
    assert one.observation_features["wrist"] == (3, 4, 3)
    assert (one.get_observation()["wrist"] == 7).all()
    one.disconnect()
    assert not camera.is_connected


@pytest.mark.parametrize(
    ("option", "says"),
    [
        ({"hand": "both"}, "left, right"),
        ({"tactile": "some"}, "taxels"),
        ({"actions": "torque"}, "joints"),
        ({"object": [0.3, 0.1]}, "5 finite numbers"),
        ({"place": [0.3, 0.1, np.nan]}, "3 finite numbers"),
        ({"fps": 30}, "divisor of 1000"),
    ],
)
def test_invalid_option_is_refused(options: dict[str, Any], option: dict[str, Any], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        AtasSimulationConfig(**options, **option)
