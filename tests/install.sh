#!/usr/bin/env bash
# Installs, runs and removes an artefact in a fresh root: tests/install.sh wheel|archive|deb ARTEFACT
#
# The root has new namespaces (mount, process, network, IPC, host name), an empty HOME, no network
# and no device but null, zero, random and urandom. The demo runs as another user without
# capabilities.
# Time limit of installation and demo: 60 s. After the removal, no file of the artefact remains.
# Exit code 77: this user may not make the namespaces.
set -euo pipefail

user=12345
limit_s=60

usage() {
    sed -n '2s/^# //p' "$0" >&2
    exit 2
}

# --- outside: namespaces ---

outside() {
    [ $# -eq 2 ] && [ -f "$2" ] || usage
    case $1 in wheel | archive | deb) ;; *) usage ;; esac
    namespaces=(--mount --pid --net --ipc --uts --fork --kill-child)
    [ "$(id -u)" = 0 ] && unshare "${namespaces[@]}" true 2>/dev/null || {
        echo "NOT RUN: namespaces with another user are not permitted; run this test as root, in a container with CAP_SYS_ADMIN" >&2
        exit 77
    }
    export ARTEFACT=$(realpath "$2") SCRIPT=$(realpath "$0") PYTHON=python3 PREFIX
    PREFIX=$(python3 -c 'import sys; print(sys.base_prefix)')
    PYTHON=$PREFIX/bin/python3
    # numpy is the only dependency of the wheel; the fresh root has no network to fetch it.
    [ "$1" != wheel ] || wheels
    FRESH_ROOT=$(mktemp -d)
    export FRESH_ROOT
    trap 'rm -rf "$FRESH_ROOT" "${WHEELS:-}"' EXIT
    unshare "${namespaces[@]}" bash "$SCRIPT" --inside "$1"
    echo "$1: installed, ran and removed; nothing remains"
}

wheels() {
    WHEELS=$(mktemp -d)
    export WHEELS
    "$PYTHON" -m pip download --quiet --disable-pip-version-check --only-binary :all: --dest "$WHEELS" "numpy>=1.26"
    chmod -R a+rX "$WHEELS"
}

# --- inside: a fresh root, as its root user ---

inside() {
    root=$FRESH_ROOT
    mount --make-rprivate /
    mount -t tmpfs -o mode=755 tmpfs "$root"
    mkdir -p "$root"/{usr,etc,var/lib/dpkg/info,var/lib/dpkg/updates,dev/shm,proc,tmp,run,opt,home/user,root,artefact,.changes/upper,.changes/work}
    # All writes to /usr end in .changes/upper.
    mount -t overlay -o "lowerdir=/usr,upperdir=$root/.changes/upper,workdir=$root/.changes/work" overlay "$root/usr"
    for link in bin sbin lib lib32 lib64; do
        [ ! -L "/$link" ] || cp --no-dereference "/$link" "$root/$link"
    done
    [ ! -e /etc/ld.so.cache ] || cp /etc/ld.so.cache "$root/etc/"
    [ ! -e /etc/alternatives ] || cp --recursive --no-dereference /etc/alternatives "$root/etc/"
    printf 'root:x:0:0::/root:/bin/sh\nuser:x:%s:%s::/home/user:/bin/sh\n' $user $user > "$root/etc/passwd"
    printf 'root:x:0:\nuser:x:%s:\n' $user > "$root/etc/group"
    touch "$root"/var/lib/dpkg/{status,available}
    for device in null zero random urandom; do
        touch "$root/dev/$device"
        mount --bind "/dev/$device" "$root/dev/$device"
    done
    mount -t tmpfs -o mode=1777 tmpfs "$root/dev/shm"
    mount -t proc proc "$root/proc"
    chmod 1777 "$root/tmp"
    chown "$user:$user" "$root/home/user"
    case $PREFIX in
    /usr | /usr/*) ;;
    *)
        mkdir -p "$root$PREFIX"
        mount --bind -o ro "$PREFIX" "$root$PREFIX"
        ;;
    esac
    mount --bind -o ro "$(dirname "$ARTEFACT")" "$root/artefact"
    if [ -n "${WHEELS:-}" ]; then
        mkdir -p "$root/wheels"
        mount --bind -o ro "$WHEELS" "$root/wheels"
    fi
    cp "$SCRIPT" "$root/install.sh"
    exec env --ignore-environment PATH=/usr/bin:/bin:/usr/sbin:/sbin HOME=/root LC_ALL=C.UTF-8 PYTHON="$PYTHON" ARTEFACT="/artefact/$(basename "$ARTEFACT")" \
        chroot "$root" bash /install.sh --test "$1"
}

# Lists all files that the test may change. dpkg's database, the accounts of the system and the
# cache of the loader are not files of the artefact.
files() {
    find /usr /etc /var /home /tmp /run /opt /dev/shm -mindepth 1 \
        ! -path '/var/lib/dpkg*' ! -path '/etc/ld.so.cache*' ! -path '/etc/.pwd.lock' ! -path '/tmp/output*' -printf '%p %y\n' |
        grep -vE '^/etc/(passwd|group|shadow|gshadow)-? ' | LC_ALL=C sort --buffer-size=256M
}

# Replaces this shell by a command of another user without capabilities, in its home folder.
as_user() {
    exec setpriv --reuid=$user --regid=$user --clear-groups --inh-caps=-all --bounding-set=-all --no-new-privs \
        env --chdir=/home/user HOME=/home/user \
        PATH=/home/user/environment/bin:/home/user/atas/bin:/usr/bin:/bin "$@"
}

check() { "$@" || { echo "install: check failed: $*" >&2; exit 1; }; }

test_all() {
    kind=$1
    files > /.before
    check test "$(grep -c : /proc/net/dev)" = 1
    check test ! -e /dev/cpu_dma_latency
    begun=$(date +%s%N)
    install_"$kind"
    demo
    took_ms=$((($(date +%s%N) - begun) / 1000000))
    echo "$kind: installation and demo took $took_ms ms"
    check test $took_ms -le $((limit_s * 1000))
    [ "$kind" != wheel ] || module
    status
    remove_"$kind"
    files > /.after
    if ! diff /.before /.after > /.left; then
        echo "install: these files remain after the removal:" >&2
        cat /.left >&2
        exit 1
    fi
}

install_wheel() {
    (as_user "$PYTHON" -m venv environment)
    (as_user pip install --quiet --disable-pip-version-check --no-cache-dir --no-index --find-links /wheels "$ARTEFACT")
}

module() {
    (as_user python -m atas --version)
    (as_user python -c 'import atas; print(atas.Simulation("wood", seed=1).run()["reason"])')
    (as_user python -m atas demo grasp) > /tmp/output 2> /tmp/output-progress
    check grep -q held /tmp/output
}

remove_wheel() {
    (as_user pip uninstall --quiet --yes atas)
    check test -z "$(find /home/user/environment -name 'atas*' -o -name ebts)"
    # numpy and the interpreter's copy belong to the environment.
    (as_user rm -r environment)
}

install_archive() {
    (as_user mkdir atas)
    (as_user tar --extract --gzip --file "$ARTEFACT" --directory atas --strip-components 1)
}

remove_archive() { (as_user rm -r atas); }

install_deb() {
    dpkg --force-depends -i "$ARTEFACT" > /tmp/output 2>&1 || { cat /tmp/output >&2; exit 1; }
}

remove_deb() {
    # The package leaves its system user, because files may belong to it.
    dpkg --purge atas > /tmp/output 2>&1 || { cat /tmp/output >&2; exit 1; }
    check test -z "$(dpkg-query -W -f '${db:Status-Abbrev}' atas 2>/dev/null)"
}

demo() {
    (as_user atas demo grasp) > /tmp/output 2> /tmp/output-progress || { cat /tmp/output /tmp/output-progress; exit 1; }
    cat /tmp/output
    check grep -q held /tmp/output
    # The cost of missing real-time rights: once, in one line.
    check test "$(grep -c DEGRADED /tmp/output)" = 1
}

# Simulator, daemon and client as separate commands.
status() {
    (as_user atas-sim run --object wood) 2> /tmp/output-sim & robot=$!
    (as_user atasd --config /dev/null) 2> /tmp/output-daemon & daemon=$!
    for _ in $(seq 100); do
        (as_user atas status) > /tmp/output 2>&1 && grep -q "^mode ready" /tmp/output && break
        sleep 0.1
    done
    cat /tmp/output
    check grep -q "^mode ready" /tmp/output
    for process in $daemon $robot; do
        kill -TERM "$process"
        wait "$process" || { cat /tmp/output-*; exit 1; }
    done
    # As in the guide: the bus of a daemon remains until the next start.
    rm -rf /dev/shm/atas-$user /dev/shm/atas_*
}

case ${1:-} in
--inside) inside "$2" ;;
--test) test_all "$2" ;;
*) outside "$@" ;;
esac
