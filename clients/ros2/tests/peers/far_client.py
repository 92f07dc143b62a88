"""Client in another namespace: executes goals, and repeats requests that a cut swallowed.

Arguments: number of goals, largest duration of all, s. Prints one JSON object.
"""

import json
import random
import sys
import time
import uuid

from cyclone import Peer
from interfaces import cyclone

ANSWER_S = 1.5
# Pause between goals, so that cuts meet all states of a goal.
PAUSE_S = 0.1


def repeat(client, until, **fields):
    """Sends a request until an answer to it or to an earlier copy arrives."""
    numbers = []
    while time.monotonic() < until:
        numbers.append(client.send(**fields))
        end = time.monotonic() + ANSWER_S
        while time.monotonic() < end:
            for number in numbers:
                answer = client.answer(number)
                if answer is not None:
                    return answer
            time.sleep(0.002)
    return None


def main():
    goals, limit_s = int(sys.argv[1]), float(sys.argv[2])
    until = time.monotonic() + limit_s
    peer = Peer()
    action = peer.action("/atas/right/gripper_cmd", "control_msgs/action/GripperCommand")
    action.wait_for_server(timeout=30)
    draw = random.Random(5)
    counts = {"goals": 0, "succeeded": 0, "aborted": 0, "other": 0, "lost": 0, "repeated": 0}
    for number in range(goals):
        time.sleep(PAUSE_S)
        goal_id = action.uuid(uuid=list(uuid.uuid4().bytes))
        # Every tenth command moves the fingers; the others are out of range and refused.
        moves = number % 10 == 0
        position = draw.choice([0.03, 0.05, 0.06]) if moves else 0.5
        goal = action.goal_type(
            command=cyclone("control_msgs/msg/GripperCommand")(position=position, max_effort=0.0)
        )
        counts["goals"] += 1
        before = action.goals.sequence + action.results.sequence
        answer = repeat(action.goals, until, goal_id=goal_id, goal=goal)
        # A copy of a goal that arrived is not accepted again; its result exists.
        result = answer and repeat(action.results, until, goal_id=goal_id)
        counts["repeated"] += action.goals.sequence + action.results.sequence - before - 2
        expected = 4 if moves else 6
        if result is None or result.status == 0:
            counts["lost"] += 1
        elif result.status != expected:
            counts["other"] += 1
        else:
            counts["succeeded" if moves else "aborted"] += 1
    print(json.dumps(counts))


main()
