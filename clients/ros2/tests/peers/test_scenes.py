"""Pick and place, screwing and assembly over DDS, each in its own scene and in real time."""

import math

import pytest
from bench import Bench
from cyclone import SUCCEEDED, Peer
from test_tasks import POINT, wood

CAP = {"width_m": 0.03, "top_m": 0.01}

TASKS = {
    "pick_place": (
        "PickPlace",
        "pick-place",
        {
            "hand": "right",
            "object": wood(position=POINT(x=0.32, y=-0.15, z=0.0445)),
            "destination": POINT(x=0.32, y=-0.27, z=0.0445),
            "lift_m": 0.03,
        },
    ),
    "screw": (
        "Screw",
        "screw",
        {
            "hand": "right",
            "cap": wood(position=POINT(x=0.34, y=-0.12, z=0.12), **CAP),
            "anticlockwise": False,
        },
    ),
    "assemble": (
        "Assemble",
        "assembly",
        {
            "hand": "right",
            "cap": wood(
                position=POINT(x=0.32, y=-0.18, z=0.05), yaw_rad=math.radians(60), **CAP
            ),
            "on_bottle": POINT(x=0.38, y=0.0, z=0.12),
            "on_bottle_yaw_rad": math.radians(60),
            "bottle_width_m": 0.06,
        },
    ),
}


@pytest.mark.parametrize("name", TASKS)
def test_task_succeeds_in_its_scene(name):
    of, scene, fields = TASKS[name]
    with Bench(scene=("--scene", scene), bridge=("--services", "cyclonedds")):
        action = Peer().action(f"/atas/{name}", f"atas_msgs/action/{of}")
        action.wait_for_server()
        status, result = action.execute(timeout=240, **fields)
        assert status == SUCCEEDED, result.outcome.cause
        print(f"{name}: {result.outcome.took_s:.1f} s")
