"""Tests of pictures: of the simulation, of environments, and of their window."""

from pathlib import Path
from typing import Any

import atas
import gymnasium
import numpy as np
import pytest
from atas import window
from atas.environments import GraspEnv, GraspVectorEnv
from gymnasium.utils.passive_env_checker import env_render_passive_checker

SIZE = (160, 120)


def blue(picture: window.Picture) -> np.ndarray[Any, Any]:
    """Rows of the pixels that show an object."""
    red, green, blue = (picture[:, :, channel].astype(int) for channel in range(3))
    return np.nonzero((blue > red + 60) & (green > red + 30) & (blue > green + 20))[0]


def test_simulation_draws_the_lift() -> None:
    simulation = atas.Simulation("slippery-50", seed=1, robot="test-bench")
    before = simulation.render(*SIZE)
    assert before.shape == (120, 160, 3) and before.dtype == np.uint8
    assert simulation.run()["state"] == atas.GoalState.SUCCEEDED
    after = simulation.render(*SIZE)
    assert len(blue(before)) > 100 and len(blue(after)) > 100
    assert blue(after).mean() < blue(before).mean() - 5, "rows count from the top"
    svg = simulation._repr_svg_()
    assert svg.startswith("<svg") and "goal succeeded" in svg


def test_size_out_of_range_is_rejected() -> None:
    simulation = atas.Simulation()
    with pytest.raises(ValueError, match="1 to 4096"):
        simulation.render(0, 10)
    with pytest.raises(ValueError, match="1 to 4096"):
        simulation.render(10, 4097)


@pytest.mark.parametrize("name", ["atas/Grasp-v0", "atas/PickPlace-v0"])
def test_environment_renders_arrays(name: str) -> None:
    environment = gymnasium.make(name, render_mode="rgb_array", render_size=SIZE)
    environment.reset(seed=1)
    first: Any = environment.render()
    assert first.shape == (120, 160, 3) and first.dtype == np.uint8
    for _ in range(20):
        environment.step(np.array([0, 0, 0, 1, 1], np.float32))
    later: Any = environment.render()
    assert (first != later).any(), "the fingers close"
    env_render_passive_checker(environment.unwrapped)
    environment.close()


def test_vector_renders_each_environment() -> None:
    many = GraspVectorEnv(3, objects=["wood", "bottle"], render_mode="rgb_array", render_size=SIZE)
    many.reset(seed=1)
    pictures = many.render()
    assert pictures is not None and [picture.shape for picture in pictures] == [(120, 160, 3)] * 3
    alone = GraspEnv(objects=["wood", "bottle"], render_mode="rgb_array", render_size=SIZE)
    alone.reset(seed=2)
    single = alone.render()
    assert single is not None and (single == pictures[1]).all()
    assert GraspVectorEnv(1).render() is None and GraspEnv().render() is None


def test_invalid_render_modes_are_rejected() -> None:
    with pytest.raises(ValueError, match="'human' or 'rgb_array'"):
        GraspEnv(render_mode="ansi")
    with pytest.raises(ValueError, match="needs 'rgb_array'"):
        GraspVectorEnv(2, render_mode="human")
    environment = GraspEnv(render_mode="rgb_array")
    with pytest.raises(ValueError, match="call reset first"):
        environment.render()


def test_window_without_display_names_the_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    with pytest.raises(RuntimeError, match='could not open a window: .*render_mode="rgb_array"'):
        GraspEnv(render_mode="human")


class Screen:
    """Window that stores the pictures instead of a display."""

    def __init__(self, title: str) -> None:
        self.title, self.shown, self.is_open = title, list[tuple[window.Picture, float]](), True

    def show(self, picture: window.Picture, hz: float) -> None:
        self.shown.append((picture, hz))

    def close(self) -> None:
        self.is_open = False


def test_human_mode_shows_each_step(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("atas.environments.Window", Screen)
    environment = GraspEnv(render_mode="human", render_size=SIZE)
    screen: Any = environment._window
    environment.reset(seed=1)
    for _ in range(3):
        environment.step(np.zeros(5, np.float32))
    assert environment.render() is None
    assert [(picture.shape, hz) for picture, hz in screen.shown] == [((120, 160, 3), 50)] * 4
    environment.close()
    environment.step(np.zeros(5, np.float32))
    assert len(screen.shown) == 4, "a closed window shows nothing"


def own_robot(folder: Path) -> str:
    """Robot file of a user: the built-in test bench with flat pads."""
    robots = Path(__file__).resolve().parents[3] / "daemon" / "robot" / "robots"
    text = (robots / "test-bench" / "robot.toml").read_text()
    skin = 'skin = { layout = "flat-4x4-4.5", compression_m = 1.8e-5, exponent = 1.0 }'
    (folder / "robot.urdf").write_text((robots / "test-bench" / "robot.urdf").read_text())
    (folder / "mine.toml").write_text('urdf = "robot.urdf"\n' + text.replace("palm =", f"{skin}\npalm ="))
    return str(folder / "mine.toml")


def test_own_robot_grasps_in_simulation_and_environment(tmp_path: Path) -> None:
    robot = own_robot(tmp_path)
    simulation = atas.Simulation("slippery-50", seed=1, robot=robot)
    assert simulation.robot == robot
    assert simulation.run()["state"] == atas.GoalState.SUCCEEDED
    environment = GraspEnv(robot=robot, objects=["slippery-50"], render_mode="rgb_array")
    seen, _ = environment.reset(seed=1)
    assert {name: part.shape for name, part in seen.items()} == {
        "taxels": (2, 16, 3), "joints": (2, 3), "percept": (2, 6), "modules": (4,), "hand": (8,),
    }  # fmt: skip
    assert environment.observation_space.contains(seen)
    for _ in range(60):
        seen, *_ = environment.step(np.array([0, 0, 0, 0.4, 0.4], np.float32))
    assert (seen["percept"][:, 0] > 0.3).all(), "both fingertips press"
    many = GraspVectorEnv(2, robot=robot, objects=["slippery-50"])
    assert many.reset(seed=1)[0]["taxels"].shape == (2, 2, 16, 3)


def test_unsuitable_robots_are_rejected() -> None:
    cases: list[tuple[dict[str, Any], str]] = [
        ({"robot": "no-such"}, "two-hand-arm"),
        ({"robot": "/no/such/robot.toml"}, "robot.toml"),
        ({"robot": "test-bench", "hand": "left"}, 'use "right"'),
        ({"robot": "test-bench", "scene": "assembly"}, "two hands"),
    ]
    for arguments, says in cases:
        with pytest.raises(ValueError, match=says):
            atas.Simulation(**arguments)
    with pytest.raises(ValueError, match="two-hand-arm"):
        GraspEnv(robot="no-such")


def test_object_wider_than_the_hand_is_rejected(tmp_path: Path) -> None:
    wide = tmp_path / "wide.toml"
    objects = Path(__file__).resolve().parents[3] / "sim-backend" / "objects"
    text = (objects / "wood.toml").read_text()
    wide.write_text(text.replace("size_m = [0.05,", "size_m = [0.19,"))
    with pytest.raises(ValueError, match="190 mm wide, the hand grasps at most"):
        GraspEnv(objects=[str(wide)])
