#!/usr/bin/env bash
# Runs daemon and simulator of an image as two containers that share the bus: tests/image.sh IMAGE.tar
#
# It needs no container engine. Each container has its own namespaces (mount, process, network, IPC,
# host name), the files of the image as root, and the user of the image without capabilities. Both
# share /dev/shm. The health check of the image must succeed in the container of the daemon.
# Exit code 77: this user may not make the namespaces.
set -euo pipefail
[ $# -eq 1 ] && [ -f "$1" ] || { sed -n '2s/^# //p' "$0" >&2; exit 2; }
image=$1
unshare --mount --pid --net --ipc --uts --fork true 2>/dev/null && [ "$(id -u)" = 0 ] || {
    echo "NOT RUN: namespaces with another user need root; run this test as root" >&2
    exit 77
}
work=$(mktemp -d)
cleanup() {
    for container in ${daemon:-} ${robot:-}; do
        kill -TERM "$(inner "$container")" 2>/dev/null || true
    done
    wait 2>/dev/null || true
    umount "$work/shm" 2>/dev/null || true
    rm -rf "$work"
}
trap cleanup EXIT

# Prints the process id, in this namespace, of the first process of a container.
inner() { pgrep --parent "$1" | head -1; }

mkdir "$work/image" "$work/root" "$work/shm"
tar --extract --file "$image" --directory "$work/image"
# Prints a value of the configuration, and fails if a digest does not match its file.
python3 - "$work/image" > "$work/settings" <<'READ'
import hashlib, json, pathlib, shlex, sys
image = pathlib.Path(sys.argv[1])

def blob(descriptor):
    data = (image / "blobs" / descriptor["digest"].replace(":", "/")).read_bytes()
    assert "sha256:" + hashlib.sha256(data).hexdigest() == descriptor["digest"], descriptor
    assert len(data) == descriptor["size"], descriptor
    return data

manifest = json.loads(blob(json.loads((image / "index.json").read_text())["manifests"][0]))
config = json.loads(blob(manifest["config"]))["config"]
blob(manifest["layers"][0])
user = config["User"].partition(":")[0]
assert user != "0", "the user of the image is root"
print("user=" + user)
print("layer=" + str(image / "blobs" / manifest["layers"][0]["digest"].replace(":", "/")))
print("variables=(" + shlex.join(config["Env"]) + ")")
print("health=(" + shlex.join(config["Healthcheck"]["Test"][1:]) + ")")
print("command=(" + shlex.join(config["Cmd"]) + ")")
READ
. "$work/settings"
tar --extract --gzip --file "$layer" --directory "$work/root"
mount -t tmpfs -o mode=1777 tmpfs "$work/shm"

# Replaces this shell by a program in a new container.
container() {
    exec unshare --mount --pid --net --ipc --uts --fork --kill-child bash -c '
        set -e
        root=$1 shm=$2 user=$3
        mount --make-rprivate /
        mount --bind "$root" "$root"
        cd "$root"
        mount -t proc proc proc
        mount -t tmpfs -o mode=1777 tmpfs tmp
        mount -t tmpfs -o mode=755 tmpfs dev
        for device in null urandom; do
            touch "dev/$device"
            mount --bind "/dev/$device" "dev/$device"
        done
        mkdir dev/shm
        mount --bind "$shm" dev/shm
        mount -o remount,bind,ro "$root"
        exec env --ignore-environment "${@:4}"
    ' container "$work/root" "$work/shm" "$user" "${variables[@]}" \
        /usr/bin/setpriv --no-new-privs /usr/sbin/chroot --userspec="$user:$user" "$work/root" "$@"
}
# Runs a program in the container of the daemon, as `podman exec` does.
in_daemon() {
    nsenter --target "$(inner "$daemon")" --mount --pid --net --ipc --uts --root --wd --setuid "$user" --setgid "$user" \
        -- "$1" "${@:2}"
}
fail() {
    echo "image: $1" >&2
    cat "$work"/*.log >&2
    exit 1
}

# Programs started in a container get the variables of the image.
export "${variables[@]:1}"
(container /usr/bin/atas-sim run --object wood) 2> "$work/robot.log" & robot=$!
(container "/usr/bin/${command[0]}" "${command[@]:1}") 2> "$work/daemon.log" & daemon=$!
for _ in $(seq 100); do
    in_daemon "${health[@]}" > "$work/status" 2>&1 && grep -q "^mode ready" "$work/status" && break
    sleep 0.1
done
cat "$work/status"
grep -q "^mode ready" "$work/status" || fail "the health check does not report a ready daemon"
in_daemon /usr/bin/atas grasp --at 0.32,-0.15,0.0345 --width 50 > "$work/goal" 2>&1 || { cat "$work/goal"; fail "the goal failed"; }
cat "$work/goal"
[ "$(stat --format %u "$work"/shm/*)" ] && ! stat --format %u "$work"/shm/* | grep -qvx "$user" || fail "a file of the bus belongs to another user"
echo "image: daemon and simulator ran as two containers of user $user and shared the bus"
