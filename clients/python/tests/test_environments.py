"""Tests of the gymnasium environments."""

from typing import Any

import atas
import gymnasium
import numpy as np
import pytest
from atas.environments import GraspEnv, GraspVectorEnv
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

NAMES = ["atas/Grasp-v0", "atas/PickPlace-v0"]


def actions(count: int, steps: int) -> np.ndarray[Any, np.dtype[np.float32]]:
    drawn = np.random.default_rng(7).uniform(-0.5, 0.5, (steps, count, 5))
    drawn[:, :, 3:] += 0.3
    return drawn.astype(np.float32)


def flat(seen: dict[str, Any]) -> np.ndarray[Any, Any]:
    return np.concatenate([np.asarray(part).reshape(len(part), -1) for part in seen.values()], axis=1)


@pytest.mark.parametrize("name", NAMES)
def test_gymnasium_checker_passes(name: str) -> None:
    check_env(gymnasium.make(name).unwrapped, skip_render_check=True)


@pytest.mark.parametrize("name", NAMES)
def test_environment_is_deterministic(name: str) -> None:
    def run(seed: int) -> list[bytes]:
        environment = gymnasium.make(name)
        seen, _ = environment.reset(seed=seed)
        told = [b"".join(part.tobytes() for part in seen.values())]
        for action in actions(1, 120)[:, 0]:
            seen, reward, terminated, truncated, _ = environment.step(action)
            told.append(b"".join(part.tobytes() for part in seen.values()) + np.float64(reward).tobytes())
            if terminated or truncated:
                seen, _ = environment.reset()
        return told

    assert run(3) == run(3) != run(4)


def test_vector_equals_single_environments() -> None:
    count, steps = 4, 320
    drawn = actions(count, steps)
    many = GraspVectorEnv(count, threads=2)
    seen, _ = many.reset(seed=11)
    together = [flat(seen)]
    ended = 0
    for action in drawn:
        seen, _, terminated, truncated, _ = many.step(action)
        together.append(flat(seen))
        ended += int((terminated | truncated).sum())
    assert ended > 0, "episodes end and restart"
    for index in range(count):
        alone = GraspEnv()
        one, _ = alone.reset(seed=11 + index)
        over = False
        for step in range(steps + 1):
            row = np.concatenate([part.ravel() for part in one.values()])
            assert (row == together[step][index]).all(), f"environment {index}, step {step}"
            if step == steps:
                break
            if over:
                one, _ = alone.reset()
                over = False
            else:
                one, _, has_ended, is_late, _ = alone.step(drawn[step, index])
                over = has_ended or is_late


def test_gymnasium_makes_vectors() -> None:
    for mode in ("vector_entry_point", "sync"):
        many = gymnasium.make_vec("atas/Grasp-v0", num_envs=3, vectorization_mode=mode)
        seen, infos = many.reset(seed=1)
        assert many.observation_space.contains(seen)
        assert seen["taxels"].shape == (3, 2, 41, 3) and infos["_success"].all()
        seen, reward, _, _, infos = many.step(many.action_space.sample())
        assert reward.shape == (3,) and "lifted_m" in infos
        many.close()


def test_ended_environment_waits_without_autoreset() -> None:
    many = GraspVectorEnv(2, objects=["wood"], autoreset=False)
    assert many.metadata["autoreset_mode"] == AutoresetMode.DISABLED
    many.reset(seed=1)
    for _ in range(301):
        seen, reward, _, truncated, _ = many.step(np.zeros((2, 5), np.float32))
    assert truncated.all() and (reward == 0).all()


def test_only_named_objects_are_used() -> None:
    environment = GraspEnv(objects=["sponge"])
    assert {environment.reset(seed=seed)[1]["object"] for seed in range(5)} == {"sponge"}
    every = GraspEnv()
    assert {every.reset(seed=seed)[1]["object"] for seed in range(40)} == {
        "wood", "slippery-200", "slippery-50", "paper-box", "sponge", "bottle",
    }  # fmt: skip
    with pytest.raises(ValueError, match="woad"):
        GraspEnv(objects=["woad"])


def test_invalid_actions_are_rejected() -> None:
    environment = GraspEnv()
    with pytest.raises(ValueError, match="reset"):
        environment.step(np.zeros(5, np.float32))
    environment.reset(seed=1)
    with pytest.raises(ValueError, match="5"):
        environment.step(np.zeros(4, np.float32))
    with pytest.raises(ValueError, match="finite"):
        environment.step(np.full(5, np.nan, np.float32))
    many = GraspVectorEnv(2)
    many.reset(seed=1)
    with pytest.raises(ValueError, match="shape"):
        many.step(np.zeros((3, 5), np.float32))


@pytest.mark.parametrize(
    ("arguments", "says"), [({"noise": -1.0}, "noise"), ({"noise": np.nan}, "noise"), ({"num_envs": 0}, "num_envs"), ({"threads": -1}, "threads")]
)
def test_invalid_arguments_are_rejected(arguments: dict[str, Any], says: str) -> None:
    with pytest.raises(ValueError, match=f"rejected: {says} is"):
        GraspVectorEnv(**arguments)


def test_import_registers_environments() -> None:
    assert atas.__version__
    assert atas.abi.startswith("v")
    assert all(name in gymnasium.registry for name in NAMES)
