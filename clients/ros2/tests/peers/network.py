"""Two network namespaces, connected by a link with loss, delay and cuts.

The kernel of a test machine may lack netem, so this process forwards the packets of two TUN
devices.
"""

import fcntl
import heapq
import os
import random
import select
import struct
import subprocess
import threading
import time

_TUNSETIFF = 0x400454CA
_IFF_TUN_NO_PI = 0x0001 | 0x1000
_MTU = 1500
ADDRESSES = ("10.213.0.1", "10.213.0.2")


class Link(threading.Thread):
    """Link between two namespaces: `sides[0]` and `sides[1]` are processes within them."""

    def __init__(self, seed=1):
        super().__init__(daemon=True)
        self.random = random.Random(seed)
        self.loss, self.delay_s, self.is_cut = 0.0, 0.0, False
        self.forwarded, self.dropped, self.ends = 0, 0, False
        self.sides, self.devices = [], []
        for index, address in enumerate(ADDRESSES):
            side = subprocess.Popen(["unshare", "-n", "sleep", "infinity"])
            self.sides.append(side)
            wait_for_namespace(side.pid)
            name = f"atas{index}"
            device = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
            fcntl.ioctl(device, _TUNSETIFF, struct.pack("16sH", name.encode(), _IFF_TUN_NO_PI))
            self.devices.append(device)
            run("ip", "link", "set", name, "netns", str(side.pid))
            for words in (
                ("link", "set", "lo", "up"),
                ("address", "add", address, "peer", ADDRESSES[1 - index], "dev", name),
                ("link", "set", name, "up", "multicast", "on", "mtu", str(_MTU)),
                ("route", "add", "239.0.0.0/8", "dev", name),
            ):
                run(*self.within(index), "ip", *words)

    def within(self, index):
        """Returns the prefix that runs a command in a namespace."""
        return ("nsenter", "-t", str(self.sides[index].pid), "-n")

    def run(self):
        queue, count = [], 0
        while not self.ends:
            wait_s = max(0.0, queue[0][0] - time.monotonic()) if queue else 0.02
            for device in select.select(self.devices, [], [], min(wait_s, 0.02))[0]:
                to = self.devices[1 - self.devices.index(device)]
                try:
                    packet = os.read(device, 65536)
                except BlockingIOError:
                    continue
                if self.is_cut or self.random.random() < self.loss:
                    self.dropped += 1
                    continue
                count += 1
                heapq.heappush(queue, (time.monotonic() + self.delay_s, count, to, packet))
            while queue and queue[0][0] <= time.monotonic():
                _, _, to, packet = heapq.heappop(queue)
                try:
                    os.write(to, packet)
                    self.forwarded += 1
                except (BlockingIOError, OSError):
                    self.dropped += 1

    def close(self):
        """Ends the link and its namespaces."""
        self.ends = True
        self.join()
        for device in self.devices:
            os.close(device)
        for side in self.sides:
            side.kill()
            side.wait()


def run(*words):
    """Runs a command that must succeed."""
    subprocess.run(words, check=True)


def wait_for_namespace(pid):
    """Waits until a process has left the network namespace of this process."""
    own = os.readlink("/proc/self/ns/net")
    end = time.monotonic() + 5
    while os.readlink(f"/proc/{pid}/ns/net") == own:
        assert time.monotonic() < end, "no network namespace"
        time.sleep(0.01)
