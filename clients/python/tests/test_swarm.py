"""Tests of ask and tell: fitness of behaviour tables, and the genetic algorithm."""

import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import atas
import numpy as np
import pytest
from conftest import PROGRAMS
from numpy.typing import NDArray

BUILT_IN = Path(__file__).resolve().parents[2] / "swarm" / "tables" / "r3-two-agents.toml"


def test_built_in_table_has_its_known_fitness() -> None:
    field, genome = atas.SwarmField.load(BUILT_IN)
    assert field.bits == len(genome) == 128 and field.goals == 8
    points = field.points(genome[None])
    assert points.shape == (1, 8) and points.dtype == np.float32
    assert points.sum() == pytest.approx(606.4, abs=0.05) and (points[0] == 100).sum() == 6
    assert field.fitness(genome[None].astype(bool))[0] == points.sum(dtype=np.float32)


def test_fitness_does_not_depend_on_batch_or_threads() -> None:
    genomes = np.random.default_rng(3).integers(0, 2, (40, 128), dtype=np.uint8)
    one, many = atas.SwarmField(threads=1), atas.SwarmField(threads=2)
    whole = one.fitness(genomes)
    assert whole.tobytes() == many.fitness(genomes).tobytes()
    single = np.concatenate([many.fitness(genomes[k : k + 1]) for k in range(40)])
    assert whole.tobytes() == single.tobytes()
    assert one.evaluations == 40 and many.evaluations == 80
    assert len(set(whole.tolist())) > 10, "the genomes differ"


def test_batches_are_read_in_place() -> None:
    field = atas.SwarmField()
    genomes = np.random.default_rng(4).integers(0, 2, (8, 256), dtype=np.uint8)
    # A strided view and a Fortran-ordered array are read without a copy by the caller.
    expected = field.fitness(np.ascontiguousarray(genomes[:, ::2]))
    assert (field.fitness(genomes[:, ::2]) == expected).all()
    assert (field.fitness(np.asfortranarray(genomes[:, ::2])) == expected).all()
    asked = atas.SwarmSearch(128, seed=1).ask()
    assert asked.flags.owndata or asked.base is not None
    assert asked.shape == (10, 128) and set(np.unique(asked)) == {0, 1}


def evolved(seed: int, generations: int) -> tuple[NDArray[np.uint8], float]:
    field, search = atas.SwarmField("R3", agents=2), atas.SwarmSearch(128, seed=seed)
    for _ in range(generations + 1):
        search.tell(field.fitness(search.ask()))
    assert search.generation == generations + 1
    return search.best


def test_ask_and_tell_equal_the_command_bit_for_bit(tmp_path: Path) -> None:
    best, fitness = evolved(seed=71, generations=60)
    out = tmp_path / "table.toml"
    line = ["evolve", "--agents", "2", "--seed", "71", "--generations", "60", "--out", str(out)]
    subprocess.run([PROGRAMS / "ebts", *line], check=True, capture_output=True)
    field, genome = atas.SwarmField.load(out)
    assert (genome == best).all() and field.fitness(best[None])[0] == np.float32(fitness)
    assert fitness > evolved(seed=71, generations=0)[1]


def test_saved_table_is_read_by_the_command_and_back(tmp_path: Path) -> None:
    field, file = atas.SwarmField("R3", agents=3), tmp_path / "mine.toml"
    genome = np.random.default_rng(7).integers(0, 2, 128, dtype=np.uint8)
    field.save(genome, file)
    again, loaded = atas.SwarmField.load(file)
    assert (loaded == genome).all() and again.bits == 128
    shown = subprocess.run([PROGRAMS / "ebts", "show", file, "--format", "json"], check=True, capture_output=True)
    report = json.loads(shown.stdout)
    assert report["agents"] == 3 and report["fitness"] == pytest.approx(float(field.fitness(genome[None])[0]), rel=1e-6)
    with pytest.raises(ValueError, match="absent.toml"):
        atas.SwarmField.load(tmp_path / "absent.toml")


def test_turns_of_ask_and_tell_are_checked() -> None:
    search = atas.SwarmSearch(16, seed=1, population=4)
    with pytest.raises(RuntimeError, match="call `ask` first"):
        search.tell(np.zeros(4))
    with pytest.raises(RuntimeError, match="no genome has a fitness"):
        _ = search.best
    genomes = search.ask()
    with pytest.raises(RuntimeError, match="call `tell` first"):
        search.ask()
    for fitness, says in (
        (np.zeros(3), "3 numbers for 4 genomes"),
        (np.array([1.0, np.nan, 0.0, 0.0]), "number 1 is NaN"),
        (np.array([1.0, 0.0, -2.0, 0.0]), "number 2 is -2"),
    ):
        with pytest.raises(ValueError, match=says):
            search.tell(fitness)
    with pytest.raises(TypeError, match="one-dimensional"):
        search.tell([1.0, 2.0, 3.0, 4.0])  # type: ignore[arg-type]
    search.tell(np.array([1.0, 4.0, 2.0, 3.0], np.float32))
    best, largest = search.best
    assert largest == 4.0 and (best == genomes[1]).all()


@pytest.mark.parametrize(
    ("make", "kind", "says"),
    [
        (lambda: atas.SwarmField("R99"), ValueError, "neither a preset nor a file"),
        (lambda: atas.SwarmField(agents=5), ValueError, "5"),
        (lambda: atas.SwarmSearch(0), ValueError, "needs 1 to"),
        (lambda: atas.SwarmSearch(128, population=7), ValueError, "population"),
        (lambda: atas.SwarmSearch(128, mutation_rate=2.0), ValueError, "mutation_rate"),
        (lambda: atas.SwarmField().fitness(np.zeros((2, 64), np.uint8)), ValueError, r"shape \(2, 64\), needs \(2, 128\)"),
        (lambda: atas.SwarmField().fitness(np.full((1, 128), 2, np.uint8)), ValueError, "bit 0 of genome 0 is 2"),
        (lambda: atas.SwarmField().fitness(np.zeros((1, 128))), TypeError, "bool or uint8"),  # type: ignore[arg-type]
    ],
)
def test_invalid_argument_raises(make: Callable[[], Any], kind: type[Exception], says: str) -> None:
    with pytest.raises(kind, match=says):
        make()
