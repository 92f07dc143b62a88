"""Tests of the sensitivity analysis: table, designs, cache, domain, figures, and one run of the real programs."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from atas.sensitivity import evaluation, figures, report
from atas.sensitivity.design import levels, realise
from atas.sensitivity.evaluation import Evaluator, Failed, Outcomes, Settings, name_of
from atas.sensitivity.measures import MEASURES, Measures, wilson
from atas.sensitivity.morris import Design
from atas.sensitivity.objects import OBJECTS, file_text
from atas.sensitivity.one_at_a_time import Beyond, Criterion, Row, points, rows
from atas.sensitivity.parameters import PARAMETERS, select
from conftest import PROGRAMS, ROOT

# Success falls with every error and with the noise; a delay of 100 ms crushes an object.
FAKE = """#!{python}
import json, sys
words = sys.argv[1:]
if words == ["--version"]:
    print("atas 9.9"); sys.exit()
value = lambda name, default: words[words.index(name) + 1] if name in words else default
errors = dict(part.split("=") for part in value("--errors", "").split(",") if part)
trials = int(value("--trials", 0))
open({log!r}, "a").write(" ".join(words) + "\\n")
if "yaw" in errors:
    sys.exit("the yaw is broken")
lost = sum(float(amount) for amount in errors.values()) + float(value("--noise", 1)) - 1
held = max(trials - int(lost), 0)
group = dict(trials=trials, held=held, refused=0, crushed=int(errors.get("latency") == "100"), dropped=trials - held)
group |= dict(success=held / trials, over_grip_median=1.5 if held else None)
print(json.dumps(dict(trials=trials, success=held / trials, failures=dict(dropped=trials - held), feasible=group,
    infeasible=dict(crushed=0, dropped=0), by_physics=dict(success=held / trials))))
"""


def fake(folder: Path) -> Path:
    """A program that answers like `atas eval grasp`, and a log of its calls."""
    program = folder / "atas"
    program.write_text(FAKE.format(python=sys.executable, log=str(folder / "log")))
    program.chmod(0o755)
    return program


def evaluator(folder: Path, trials: int = 40) -> Evaluator:
    program = folder / "atas" if (folder / "atas").exists() else fake(folder)
    return Evaluator(program, folder / "out", Settings(trials, 1, tuple(OBJECTS)), 2)


def run(of: Evaluator, *parameters: str) -> Outcomes:
    return of.run(points(select(parameters), 5), lambda *_: None)


def measures(succeeded: int, trials: int = 48, crushed: int = 0) -> Measures:
    return Measures(trials, succeeded, succeeded, crushed, trials - succeeded, 0, 1.5, {})


def row(name: str, *results: Measures | None) -> Row:
    (parameter,) = select([name])
    return Row(parameter, tuple(levels(parameter, len(results))), results)


def sensitivity(*words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "atas.sensitivity", *words]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)


def test_parameters_are_complete_and_within_the_limits_of_the_simulator() -> None:
    names = [parameter.name for parameter in PARAMETERS]
    assert len(names) == len(set(names)) and len(names) >= 25
    for parameter in PARAMETERS:
        assert parameter.source and parameter.unit and parameter.first != parameter.last
        assert any(level.is_nominal for level in levels(parameter, 5)), parameter.name
    with pytest.raises(ValueError, match="unknown parameter moon; needs some of rate"):
        select(["moon", "drift"])


def test_built_in_objects_match_the_files_of_the_simulator() -> None:
    def plain(text: str) -> dict[str, str]:
        pairs = [line.partition("#")[0].split(" = ", 1) for line in text.splitlines() if " = " in line.partition("#")[0]]
        numeric = ("mass_kg", "friction", "stiffness_n_m", "crush_n")
        return {key: str(float(value)) if key in numeric else value.strip() for key, value in pairs}

    for name in OBJECTS:
        file = (ROOT / "sim-backend" / "objects" / f"{name}.toml").read_text()
        assert plain(file_text(name, {})) == plain(file), name


def test_scaled_objects_stay_within_their_limits() -> None:
    assert "mass_kg = 0.0125\n" in file_text("sponge", {"mass_kg": 0.5})
    assert "stiffness_n_m = 100.0\n" in file_text("sponge", {"stiffness_n_m": 0.25})
    assert "stiffness" not in file_text("wood", {"stiffness_n_m": 4.0})


def test_nominal_point_uses_the_default_evaluation() -> None:
    nominal = realise({}, tuple(OBJECTS), Path("out"), "tag")
    assert nominal.options == ["--noise", "1", "--rate-hz", "1000"] and not nominal.files


def test_values_become_options_and_files() -> None:
    values = {"drift": 0.05, "yaw": 10.0, "rate": 100.0, "resolution": 10.0, "mass": 2.0}
    found = realise(values, ("wood", "sponge"), Path("out"), "tag")
    assert found.options[:6] == ["--noise", "1", "--rate-hz", "100", "--errors", "drift=0.05,yaw=10"]
    objects = "out/objects/tag/wood.toml,out/objects/tag/sponge.toml"
    assert found.options[6:] == ["--sensor-model", "out/models/tag.toml", "--objects", objects]
    assert found.files["models/tag.toml"] == "step_n = [0.01, 0.01]\n"
    assert "mass_kg = 0.6\n" in found.files["objects/tag/wood.toml"]


def test_engine_and_robot_are_passed_on() -> None:
    options = Settings(8, 1, ("wood",), robot="arm7-gripper", engine="mujoco --pins 3").options()
    assert options[4:8] == ["--robot", "arm7-gripper", "--engine", "mujoco --pins 3"]


def test_wilson_interval_matches_known_values() -> None:
    assert wilson(200, 200) == pytest.approx((0.981, 1.0), abs=5e-4)
    assert wilson(0, 0) == (0.0, 1.0) and wilson(0, 10)[0] == 0.0


def test_points_are_cached_and_failures_are_kept_apart(tmp_path: Path) -> None:
    first = run(evaluator(tmp_path), "drift", "latency", "yaw")
    assert len(first.measures) == 9 and len(first.failed) == 4
    assert "the yaw is broken" in next(iter(first.failed.values()))
    assert first.of({"latency": 6.25}) == Measures(40, 34, 34, 0, 6, 0, 1.5, {"dropped": 6})
    calls = (tmp_path / "log").read_text().splitlines()
    assert run(evaluator(tmp_path), "drift", "latency").measures == first.measures
    assert (tmp_path / "log").read_text().splitlines() == calls, "finished points are not evaluated again"
    damaged = next((tmp_path / "out" / "points").iterdir())
    damaged.write_text("{")
    run(evaluator(tmp_path), "drift", "latency")
    run(evaluator(tmp_path, trials=41), "drift")
    assert len((tmp_path / "log").read_text().splitlines()) == len(calls) + 1 + 5
    with (tmp_path / "atas").open("a") as program:
        program.write("# another build\n")
    run(evaluator(tmp_path), "drift")
    assert len((tmp_path / "log").read_text().splitlines()) == len(calls) + 6 + 5


def test_failure_of_the_first_point_ends_the_run(tmp_path: Path) -> None:
    with pytest.raises(Failed, match="ended with 1: the yaw is broken"):
        evaluator(tmp_path).run([{"yaw": 1.0}, {}], lambda *_: None)


def test_missing_programs_are_named_with_a_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evaluation, "installed_program", lambda: None)
    monkeypatch.setenv("PATH", "")
    with pytest.raises(evaluation.MissingProgram, match="--program target/debug/atas"):
        evaluation.find_program(None)
    with pytest.raises(evaluation.MissingProgram, match="could not run /absent"):
        evaluation.find_program("/absent")


def test_domain_ends_before_the_first_failing_level() -> None:
    good, bad = measures(48), measures(30)
    criterion = Criterion(0.85)
    domain = row("drift", good, good, bad, good, good).domain(criterion)
    assert domain is not None and domain.low is None and domain.high is not None
    assert domain.high.value == 0.00625 and domain.high.beyond is not None and domain.high.beyond.value == 0.025
    crushes = row("drift", good, good, measures(48, crushed=1), good, good).domain(criterion)
    assert crushes is not None and crushes.text() == domain.text() == "to 0.00625"
    # A missing result is not valid either; a rate is worse when it is lower.
    rate = row("rate", good, good, None, good, good).domain(criterion)
    assert rate is not None and rate.high is None and rate.low is not None
    assert rate.low.value == 316.0 and rate.low.beyond == Beyond(100.0, None) and rate.low.beyond.cause == "unknown"
    mass = row("mass", bad, good, good, good, good).domain(criterion)
    assert mass is not None and mass.low is not None and mass.high is not None
    assert (mass.low.value, mass.low.beyond, mass.low.edge) == (0.5774, Beyond(0.3333, bad), 1)
    assert (mass.high.value, mass.high.beyond, mass.high.edge) == (3.0, None, 5)
    assert row("drift", bad, good, good).domain(criterion) is None


def test_criterion_needs_enough_trials() -> None:
    Criterion(0.85).check(24)
    with pytest.raises(ValueError, match="raise --trials"):
        Criterion(0.85).check(20)


def test_domain_file_is_valid_toml(tmp_path: Path) -> None:
    toml = pytest.importorskip("tomllib", reason="Python 3.10 has no TOML reader")
    found = run(evaluator(tmp_path), "latency", "mass")
    origin = report.Origin('say "hi"', {"version": "atas 9.9", "programs_sha256": "0"}, Settings(40, 20_001, tuple(OBJECTS)))
    text = report.domain_toml(rows(select(["latency", "mass"]), 5, found), Criterion(0.8), origin)
    domain = toml.loads(text)
    assert domain["evaluation"]["command"] == 'say "hi"' and domain["evaluation"]["last_seed"] == 20_005
    latency, mass = domain["parameter"]
    assert latency == {
        "name": "latency", "group": "sensor", "unit": "ms", "nominal": 0.0, "high": 0.0, "high_fails_at": 6.25,
        "high_failure": "dropped",
        "high_success": [40, 40], "model_key": "frames.latency_s", "model_factor": 1000.0,
    }  # fmt: skip
    assert mass["low"] == 0.3333 and "low_fails_at" not in mass and "model_key" not in mass
    assert all(len(line) <= 100 for line in text.splitlines() if line.startswith("#"))


def test_committed_domain_matches_the_table_of_parameters() -> None:
    toml = pytest.importorskip("tomllib", reason="Python 3.10 has no TOML reader")
    text = (ROOT / "clients" / "lab" / "src" / "calibrate" / "domain.toml").read_text()
    assert text.startswith(report.DOMAIN_HEADER)
    domain = toml.loads(text)
    assert domain["version"] == 1 and domain["evaluation"]["first_seed"] > 20_000
    committed = {of["name"]: (of["unit"], of["nominal"], of.get("model_key")) for of in domain["parameter"]}
    assert committed == {of.name: (of.unit, of.nominal, of.model_key) for of in PARAMETERS}
    page = (ROOT / "clients" / "guide" / "src" / "results.md").read_text()
    for of in domain["parameter"]:
        assert f"| {of['name']}, {of['unit']} | " in page, of["name"]


def test_morris_finds_the_strongest_parameter(tmp_path: Path) -> None:
    pytest.importorskip("SALib")
    parameters = select(["drift", "latency", "hysteresis", "mass"])
    design = Design.sample(parameters, 4, 0.5, 1)
    assert (design.shares == Design.sample(parameters, 4, 0.5, 1).shares).all()
    assert len(design.points()) == 4 * 5
    for values in design.points():
        assert values.get("latency", 0.0) <= 25.0 and 0.57 < values.get("mass", 1.0) < 1.74
    outcomes = evaluator(tmp_path).run(design.points(), lambda *_: None)
    success = design.screen(outcomes)[0]
    assert (success.measure, success.trajectories) == ("success", 4)
    assert success.ranking()[:2] == ["latency", "hysteresis"]
    assert success.effects["mass"].mu_star == 0.0 and success.effects["latency"].mu < -0.2
    # A trajectory with a missing point is left out.
    del outcomes.measures[name_of(design.points()[0])]
    assert design.screen(outcomes)[0].trajectories == 3


def test_figures_and_tables_are_reproducible(tmp_path: Path) -> None:
    found = run(evaluator(tmp_path), "latency", "mass", "yaw")
    results = rows(select(["latency", "mass", "yaw"]), 5, found)
    svg = figures.one_at_a_time(results, Criterion(0.8), "title")
    assert svg == figures.one_at_a_time(results, Criterion(0.8), "title")
    for text in ("latency, ms", *MEASURES.values()):
        assert text in svg, text
    table = report.one_at_a_time_table(results, Criterion(0.8), 40)
    assert "| latency, ms | **0**, 6.25, 25, 56.25, 100 | 40, 34, 15, 0, 0 |" in table
    assert "from 0.3333 (end of the range) to 3 (end of the range)" in table
    domain = report.domain_table(results, Criterion(0.8))
    assert "| latency, ms | to 0 | 6.25 | 85 [71, 93] | dropped |" in domain and "| 2.5 | – | unknown |" in domain


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        ("one-at-a-time --levels 4", 2, "is even"),
        ("one-at-a-time --trials 0", 2, "at least 1"),
        ("one-at-a-time --trials 8", 2, "raise --trials"),
        ("one-at-a-time --parameters moon", 2, "unknown parameter moon"),
        ("one-at-a-time --out a,b", 2, "contains a comma"),
        ("morris --trajectories 1", 2, "at least 2"),
        ("morris --span 0", 2, "not in the range"),
        ("morris --program /absent/atas", 127, "could not run /absent/atas"),
        ("", 2, "required"),
    ],
)
def test_invalid_command_lines_are_rejected(words: str, code: int, says: str) -> None:
    ran = sensitivity(*words.split())
    assert ran.returncode == code and says in ran.stderr and "Traceback" not in ran.stderr, ran.stderr


def test_interrupt_keeps_finished_points(tmp_path: Path) -> None:
    program = fake(tmp_path)
    slow = program.read_text().replace("import json, sys\n", "import json, sys, time\nif 'jitter' in str(sys.argv): time.sleep(60)\n")
    program.write_text(slow)
    words = ["--parameters", "drift", "jitter", "--out", str(tmp_path / "out"), "--program", str(program), "--jobs", "1"]
    child = subprocess.Popen([sys.executable, "-m", "atas.sensitivity", "one-at-a-time", *words], stderr=subprocess.PIPE, text=True)
    for _ in range(600):
        if len(list((tmp_path / "out" / "points").glob("*.json"))) == 5:
            break
        time.sleep(0.1)
    os.kill(child.pid, signal.SIGINT)
    _, err = child.communicate(timeout=60)
    assert child.returncode == 5 and "interrupted after 5 of 9 points; the same command continues" in err


def test_failed_points_give_partial_results_and_exit_code(tmp_path: Path) -> None:
    words = ["--parameters", "drift", "yaw", "--out", str(tmp_path / "out"), "--program", str(fake(tmp_path))]
    ran = sensitivity("one-at-a-time", *words)
    assert ran.returncode == 1 and "4 points failed" in ran.stderr and "the yaw is broken" in ran.stderr
    result = json.loads((tmp_path / "out" / "one-at-a-time.json").read_text())
    assert len(result["failed_points"]) == 4 and result["versions"]["atas"] == "atas 9.9"
    assert result["nominal"]["succeeded_ci95"][1] == 1.0


def test_real_programs_run_a_point_of_every_option(tmp_path: Path) -> None:
    program = PROGRAMS / "atas"
    given = Settings(trials=1, first_seed=20_001, objects=("slippery-50",))
    values = {"noise": 1.5, "rate": 416.0, "resolution": 2.0, "gain-spread": 4.0, "friction": 1.2, "mass": 0.8, "crush": 1.1}
    values |= {parameter.name: parameter.value(0.02) for parameter in PARAMETERS if parameter.name not in values}
    outcomes = Evaluator(program, tmp_path, given, 1).run([{}, values], lambda *_: None)
    nominal, varied = outcomes.of({}), outcomes.of(values)
    assert nominal is not None and nominal.succeeded == 1 and nominal.over_grip is not None
    assert varied is not None and varied.trials == 1, outcomes.failed
