#!/usr/bin/env bash
# Builds the ROS 2 bridge and tests it against foreign peers, in network namespaces of their own:
# Cyclone DDS and Fast DDS for DDS, eclipse-zenoh with pyzeros for Zenoh, rosbags for messages and
# type hashes. Prints the measured figures. Needs root for the namespaces, and the programs in
# target/debug (`cargo build --workspace --bins`). Installs its Python packages into target/ros2.
#
#   tests/ros2.sh             everything
#   tests/ros2.sh --no-zenoh  without Zenoh, which adds most of the build
#
# Not part of CI: a first build takes several minutes. ATAS_GOALS sets the number of goals on the
# link with random cuts.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD
out=$root/target/ros2
peers=$root/clients/ros2/tests/peers
features=(--features zenoh)
[ "${1:-}" = --no-zenoh ] && features=()
[ "$(id -u)" = 0 ] || { echo "tests/ros2.sh needs root for its network namespaces" >&2; exit 1; }
for program in atas atasd atas-sim; do
    [ -x "target/debug/$program" ] ||
        { echo "target/debug/$program is missing; run: cargo build --workspace --bins" >&2; exit 1; }
done
mkdir -p "$out/logs"

echo "== peers"
python=$out/venv/bin/python
[ -x "$python" ] || "${PYTHON:-python3}" -m venv "$out/venv"
"$python" -c 'import cyclonedds, pytest, pyzeros, rosbags, zenoh' 2>/dev/null ||
    "$out/venv/bin/pip" install --quiet 'cyclonedds==11.*' 'rosbags==0.11.*' 'pyzeros==0.1.*' \
        'ros2_pyterfaces==0.3.*' pytest
if [ ! -e /usr/include/fastdds ]; then
    apt-get update -qq
    apt-get install -y -qq --no-install-recommends libfastrtps-dev g++ >"$out/logs/apt.log"
fi
g++ -std=c++17 -O1 "$peers/fast_peer.cpp" -o "$out/fast-peer" -lfastrtps -lfastcdr

echo "== bridge"
begin=$SECONDS
cd clients/ros2
cargo fmt --check
cargo clippy --quiet --locked --target-dir "$out" --all-targets "${features[@]}" -- -D warnings
cargo build --quiet --locked --target-dir "$out" "${features[@]}"
cargo test --quiet --locked --target-dir "$out" "${features[@]}"
cd "$root"
echo "built and tested in $((SECONDS - begin)) s"

export ATAS_PROGRAMS=$root/target/debug ATAS_ROS2=$out/debug/atas-ros2 ATAS_LOGS=$out/logs
export FAST_PEER=$out/fast-peer
[ ${#features[@]} = 0 ] || export ATAS_ZENOH=1
rm -f "$out"/logs/ros2-*
echo "== tests against peers"
# Only the loopback of a namespace of its own: no packet leaves this machine.
unshare --net bash -euc '
    ip link set lo up multicast on
    ip route add 239.0.0.0/8 dev lo
    exec "$@"' -- "$python" -m pytest -q -s -p no:cacheprovider "$peers"
