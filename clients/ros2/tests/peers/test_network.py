"""Loss, delay, cuts and killed participants between two network namespaces."""

import json
import os
import random
import subprocess
import sys
import time
from pathlib import Path

import pytest
from bench import Bench, wait
from network import Link

CLIENT = Path(__file__).with_name("far_client.py")


class FarBench(Bench):
    """Bench whose bridge is in the first namespace of a link."""

    def __init__(self, link):
        self.link = link
        super().__init__(bridge=("--services", "cyclonedds"), start_bridge=False)
        self.start_bridge()

    def start(self, name, command):
        prefix = self.link.within(0) if name == "bridge" else ()
        return super().start(name, [*prefix, *command])


@pytest.fixture(scope="module")
def link():
    of = Link()
    of.start()
    yield of
    of.close()


@pytest.fixture(scope="module")
def bench(link):
    with FarBench(link) as running:
        yield running


def client(link, goals, seconds):
    words = [*link.within(1), sys.executable, str(CLIENT), str(goals), str(seconds)]
    return subprocess.Popen(words, stdout=subprocess.PIPE, text=True)


def counts(process, seconds):
    output, _ = process.communicate(timeout=seconds)
    return json.loads(output)


def test_lossy_slow_link_loses_no_goal_and_no_result(bench, link):
    link.loss, link.delay_s = 0.1, 0.02
    of = counts(client(link, 60, 60), 90)
    link.loss, link.delay_s = 0.0, 0.0
    print(f"10 % loss, 20 ms delay: {of}; {link.dropped} packets dropped")
    assert of["lost"] == of["other"] == 0 and of["goals"] == 60 and link.dropped > 100


def test_random_cuts_lose_no_goal_and_no_result(bench, link):
    goals = int(os.environ.get("ATAS_GOALS", "200"))
    draw = random.Random(3)
    process = client(link, goals, 60 + 2 * goals)
    cuts = 0
    time.sleep(2)
    while process.poll() is None:
        time.sleep(draw.uniform(0.5, 3.0))
        link.is_cut = True
        time.sleep(draw.uniform(0.1, 1.5))
        link.is_cut = False
        cuts += 1
    of = counts(process, 10)
    print(f"{cuts} cuts: {of}")
    assert of["lost"] == of["other"] == 0 and of["goals"] == goals and cuts > 5
    bench.wait_for_mode("ready")


def test_partition_longer_than_a_lease_heals(bench, link):
    assert counts(client(link, 2, 60), 90)["lost"] == 0
    process = client(link, 60, 90)
    time.sleep(4)
    link.is_cut = True
    time.sleep(15)
    link.is_cut = False
    healed = time.monotonic()
    of = counts(process, 110)
    print(f"after a partition of 15 s: {of}, last goal {time.monotonic() - healed:.0f} s later")
    assert of["lost"] == of["other"] == 0 and of["repeated"] > 0


def test_killed_client_leaves_the_goal_to_its_end(bench, link):
    process = client(link, 1000, 600)
    wait(lambda: "goal teleop running" in bench.atas("status"), 30, "goal")
    # The client is a child of nsenter's process, which it replaced.
    process.kill()
    process.wait()
    wait(lambda: "goal teleop running" not in bench.atas("status"), 40, "end of the goal")
    bench.wait_for_mode("ready")
    assert counts(client(link, 11, 60), 90)["lost"] == 0
