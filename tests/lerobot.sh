#!/usr/bin/env bash
# Runs the LeRobot plugin on the real LeRobot (6 GB, Python 3.12 or later): its tests on the real
# classes, the discovery by LeRobot's commands, and a data set of `atas export`, loaded and replayed.
# Not part of CI because of its size. PYTHON names the interpreter, default python3.12.
# Needs the programs in target/debug and the wheel in target/wheels.
set -euo pipefail
cd "$(dirname "$0")/.."
venv=$PWD/target/lerobot
[ -x "$venv/bin/python" ] || "${PYTHON:-python3.12}" -m venv "$venv"
"$venv/bin/python" -c "import lerobot, pytest" 2>/dev/null ||
    "$venv/bin/pip" install --quiet 'lerobot[core-scripts,training]==0.6.*' pytest
"$venv/bin/pip" install --quiet --force-reinstall --no-deps target/wheels/atas-*.whl
"$venv/bin/pip" show --quiet lerobot_robot_atas 2>/dev/null ||
    "$venv/bin/pip" install --quiet --no-deps --editable clients/lerobot
folder=$(mktemp -d)
export HF_HUB_OFFLINE=1 HF_HOME=$folder/hf ATAS_BUS=lerobot-$$ PATH=$PWD/target/debug:$PATH
trap 'kill $(jobs -p) 2>/dev/null || true; wait; rm -rf "$folder"' EXIT

echo "== tests on the real classes"
"$venv/bin/python" -m pytest -q clients/lerobot

echo "== discovery by LeRobot"
help=$("$venv/bin/lerobot-teleoperate" --help 2>&1)
for name in atas atas_simulation atas_keyboard atas_leader; do
    grep -qE "[{,]$name[,}]" <<< "$help" || { echo "lerobot-teleoperate does not know $name" >&2; exit 1; }
    echo "found $name"
done

echo "== data set"
atas record --out "$folder/run.mcap" &
recorder=$!
until [ -e "$folder/run.mcap" ]; do sleep 0.1; done
atas-sim run --object wood --seed 3 --lockstep &
robot=$!
atasd --lockstep --record-stream --config /dev/null 2>/dev/null &
daemon=$!
until atas status >/dev/null 2>&1; do sleep 0.1; done
atas grasp --at 0.32,-0.15,0.0345 --width 50 --lift 20
kill $daemon $robot; wait $daemon $robot || true
kill -INT $recorder; wait $recorder || true
atas export "$folder/run.mcap" --to lerobot --elements --out "$folder/dataset"
"$venv/bin/python" - "$folder/dataset" 2>/dev/null <<'CHECK'
import sys
import numpy as np
from atas.features import ENVIRONMENT, POSE, HandFeatures
from lerobot.datasets import LeRobotDataset
data = LeRobotDataset("atas/check", root=sys.argv[1], delta_timestamps={"action": [0.0, 0.02]})
features = HandFeatures(None, "right", "summary", "pose")
names = {key: data.features[key]["names"] for key in data.features}
assert names["observation.state"] == features.state_names()
assert names["observation.environment_state"] == list(ENVIRONMENT) and names["action"] == list(POSE)
assert names["observation.taxels"] == features.taxel_names(41)
assert data.num_episodes == 1 and data.fps == 50 and data[0]["action"].shape == (2, 5)
assert bool(data.hf_dataset[len(data) - 1]["next.success"]) and data[0]["task"] == "Grasp the object and lift it."
states = np.stack([data.hf_dataset[index]["observation.state"].numpy() for index in range(len(data))]).astype(float)
stats = data.meta.stats["observation.state"]
for name, of in (("mean", states.mean(0)), ("std", states.std(0)), ("q90", np.quantile(states, 0.9, axis=0))):
    assert np.allclose(stats[name], of, atol=1e-5), name
print(f"loaded {len(data)} frames; names and statistics are equal")
CHECK

echo "== replay by lerobot-replay"
"$venv/bin/lerobot-replay" --robot.type=atas_simulation --robot.item=wood --robot.seed=3 \
    --robot.id=check --dataset.repo_id=atas/check --dataset.root="$folder/dataset" \
    --dataset.episode=0 --play_sounds=false 2>/dev/null
echo "== passed"
