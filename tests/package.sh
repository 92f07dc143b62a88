#!/usr/bin/env bash
# Builds, installs, runs, upgrades, removes and purges the Debian package in a private root (dpkg --root; its scripts use
# DPKG_ROOT), so that this machine is not changed and no chroot is needed.
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
root=$work/root
trap 'rm -rf "$work"' EXIT
check() { "$@" || { echo "package: check failed: $*"; exit 1; }; }
in_root() { dpkg --root="$root" --force-script-chrootless --force-depends --force-not-root --force-confold "$@"; }
state() { dpkg-query --root="$root" -W -f '${db:Status-Abbrev} ${Version}' atas 2>/dev/null || true; }

first=$PWD/$(.ci/package dev 0.1.0-1)
# Next version with the same files.
dpkg-deb -R "$first" "$work/next"
sed -i 's/^Version: .*/Version: 0.1.0-2/' "$work/next/DEBIAN/control"
dpkg-deb --root-owner-group -Zgzip -z1 -b "$work/next" "$work/next.deb" >/dev/null

mkdir -p "$root"/var/lib/dpkg/{info,updates} "$root"/etc
touch "$root"/var/lib/dpkg/{status,available}
in_root -i "$first"
check test "$(state)" = "ii  0.1.0-1"
check grep -q '^atas:' "$root/etc/passwd"
for file in usr/bin/{atasd,atas,atas-demo,atas-gate,atas-lab,atas-live,atas-remote,atas-robot,atas-sensor,atas-sim,ebts} etc/atas/{atas.toml,sensors,robots,conf.d} \
    usr/lib/systemd/system/{atasd,atas-gate,atas-remote,atas-sim,atas-record,atas-sensor@,atas-robot@}.service usr/lib/systemd/system/atas-gate.socket usr/lib/sysusers.d/atas.conf \
    usr/lib/udev/rules.d/60-atas.rules usr/share/man/man1/atas{,-grasp,-sim-run}.1.gz usr/share/man/man8/{atasd,atas-gate}.8.gz \
    usr/include/atas.h; do
    check test -e "$root/$file"
done
for program in atas atas-robot atas-sensor atas-sim atasd ebts; do
    check bash -n "$root/usr/share/bash-completion/completions/$program.bash"
    check test -e "$root/usr/share/zsh/vendor-completions/_$program"
    check test -e "$root/usr/share/fish/vendor_completions.d/$program.fish"
done

# Runs daemon, simulator and client of the package with a private notify socket.
python3 - "$root" "$work" <<'RUN'
import json, os, signal, socket, subprocess, sys
root, work = sys.argv[1:]
notify = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
notify.bind(f"{work}/notify")
notify.settimeout(60)
environment = {"PATH": f"{root}/usr/bin:/usr/bin:/bin", "ATAS_BUS": f"package-{os.getpid()}"}

def start(*words, **more):
    return subprocess.Popen([f"{root}/usr/bin/{words[0]}", *words[1:]], env=environment | more)

def ask(*words):
    told = subprocess.run([f"{root}/usr/bin/atas", *words, "--format", "json"], env=environment, capture_output=True, text=True)
    assert told.returncode == 0, (words, told)
    return json.loads(told.stdout.splitlines()[-1])

def until(word):
    while word not in notify.recv(4096).decode():
        pass

def visit():
    """With the installed configuration, a member of the gate's group may observe and stop, but not command."""
    group, path = 60601, f"{work}/gate.sock"
    door = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    door.bind(path)
    os.chmod(work, 0o711)
    os.chown(path, 0, group)
    os.chmod(path, 0o660)
    door.listen()
    words = [f"{root}/usr/bin/atas-gate", "--config", f"{root}/etc/atas/atas.toml"]
    gate = subprocess.Popen(words, env=environment, stdin=door)
    member = ["setpriv", "--reuid=60602", "--regid=60602", f"--groups={group}", "--", f"{root}/usr/bin/atas"]
    try:
        for command, code in (("status", 0), ("recover", 4), ("estop", 0)):
            told = subprocess.run([*member, command], env=environment | {"ATAS_GATE": path}, capture_output=True, text=True)
            assert told.returncode == code, (command, told)
    finally:
        gate.kill()
        gate.wait()

robot = start("atas-sim", "run", "--lockstep", "--object", "wood")
daemon = start("atasd", "--lockstep", "--config", f"{root}/etc/atas/atas.toml", NOTIFY_SOCKET=f"{work}/notify")
try:
    until("READY=1")
    goal = ask("grasp", "--at", "0.32,-0.15,0.0345", "--width", "50", "--lift", "10", "--hold", "0.05")
    assert goal["state"] == "succeeded", goal
    assert ask("status")["mode"], "a mode"
    # atas finds the laboratory program in its folder.
    assert ask("explain", "last")["state"] == "succeeded"
    if os.geteuid() == 0:
        visit()
    daemon.send_signal(signal.SIGTERM)
    until("STOPPING=1")
    assert daemon.wait(60) == 0
finally:
    for process in (robot, daemon):
        process.kill()
        process.wait()
print("package: daemon, simulator and client ran")
RUN

echo '# mine' >> "$root/etc/atas/atas.toml"
mkdir -p "$root/var/lib/atas/recordings" && touch "$root/var/lib/atas/recordings/run.mcap"
in_root -i "$work/next.deb"
check test "$(state)" = "ii  0.1.0-2"
check grep -q '^# mine' "$root/etc/atas/atas.toml"
in_root -r atas
check test ! -e "$root/usr/bin/atasd"
check grep -q '^# mine' "$root/etc/atas/atas.toml"
in_root -P atas
check test -z "$(state)"
check test ! -e "$root/etc/atas"
check test -e "$root/var/lib/atas/recordings/run.mcap"
echo "package: installed, upgraded, removed and purged"
