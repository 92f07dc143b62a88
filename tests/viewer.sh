#!/usr/bin/env bash
# Records and exports a grasp, and checks with Rerun's command line that it contains transforms, points, scalars and log messages.
# Rerun is independent of this project, so other viewers can read the export as well.
set -euo pipefail
cd "$(dirname "$0")/.."
bin=$PWD/target/debug
work=$(mktemp -d)
export ATAS_BUS=viewer-$$
cleanup() {
    kill "${daemon:-}" "${robot:-}" "${recorder:-}" 2>/dev/null || true
    wait 2>/dev/null || true
    rm -rf "$work"
}
trap cleanup EXIT

"$bin/atas" record --out "$work/run.mcap" & recorder=$!
until [ -e "$work/run.mcap" ]; do sleep 0.05; done
"$bin/atas-sim" run --lockstep --object wood & robot=$!
"$bin/atasd" --lockstep --record-stream --config /dev/null & daemon=$!
until "$bin/atas" status >/dev/null 2>&1; do sleep 0.05; done
"$bin/atas" grasp --at 0.32,-0.15,0.0345 --width 50 --lift 10 --hold 0.05
kill "$daemon" && wait "$daemon"
kill -INT "$recorder" && wait "$recorder"

for kind in mcap csv parquet; do
    "$bin/atas" export "$work/run.mcap" --to $kind --format json | tee "$work/$kind.json"
done

[ -x target/rerun/bin/rerun ] || {
    python3 -m venv target/rerun
    target/rerun/bin/pip install --quiet --disable-pip-version-check rerun-sdk==0.41.0
}
target/rerun/bin/rerun mcap convert "$work/run-ros2.mcap" --output "$work/run.rrd"
target/rerun/bin/rerun rrd print -vv "$work/run.rrd" > "$work/printed"
for part in Transform3D:translation Points3D:positions Scalars:scalars TextLog:text /tf /joint_states /right/finger1/elements \
    /right/f2 /right/module/slip /events; do
    grep -q -- "$part" "$work/printed" || { echo "viewer: $part is missing in the export"; exit 1; }
done
echo "viewer: transforms, points, scalars and log messages found"

target/rerun/bin/python - "$work" <<'CHECK'
import csv, json, sys
import numpy as np
import pyarrow.parquet as parquet
work = sys.argv[1]
told = {kind: json.load(open(f"{work}/{kind}.json")) for kind in ("mcap", "csv", "parquet")}
rows = list(csv.DictReader(open(f"{work}/run.csv")))
table = parquet.read_table(f"{work}/run.parquet")
assert len(rows) == table.num_rows == told["csv"]["ticks"], "one row per tick"
assert table.column_names == list(rows[0]), "the same columns"
pressed = table.column("right_finger1_normal_n").to_pylist()
# Both formats contain the same 32-bit values; parsing the digits must not round.
assert np.array_equal(np.float32(pressed), np.float32([row["right_finger1_normal_n"] for row in rows]))
assert max(pressed) > 1.0, "a grip"
for kind, t in told.items():
    print(f"{kind}: {t['seconds'] / t['took_s']:.0f} times real time")
    assert t["seconds"] >= 5 * t["took_s"], t
CHECK
