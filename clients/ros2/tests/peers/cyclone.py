"""Peer over Cyclone DDS: topics, and services and actions as rmw_cyclonedds maps them."""

import os
import time
import uuid

from bench import wait
from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from interfaces import cyclone

RELIABLE = Policy.Reliability.Reliable(duration(milliseconds=100))
SERVICE = Qos(RELIABLE, Policy.Durability.Volatile, Policy.History.KeepLast(100))
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6


class Peer:
    """Participant of the ROS graph."""

    def __init__(self, domain=0):
        self.participant = DomainParticipant(domain)

    def reader(self, topic, of, best_effort=False, latched=False, depth=1000):
        """Opens a reader of a ROS topic."""
        reliability = Policy.Reliability.BestEffort if best_effort else RELIABLE
        durability = Policy.Durability.TransientLocal if latched else Policy.Durability.Volatile
        qos = Qos(reliability, durability, Policy.History.KeepLast(depth))
        named = Topic(self.participant, f"rt{topic}", cyclone(of))
        return DataReader(self.participant, named, qos=qos)

    def writer(self, topic, of, depth=10):
        """Opens a writer of a ROS topic."""
        qos = Qos(RELIABLE, Policy.History.KeepLast(depth))
        named = Topic(self.participant, f"rt{topic}", cyclone(of))
        return DataWriter(self.participant, named, qos=qos)

    def topics(self, seconds=3.0):
        """Returns the type of every published topic that is discovered."""
        reader = BuiltinDataReader(self.participant, BuiltinTopicDcpsPublication)
        end, found = time.monotonic() + seconds, {}
        while time.monotonic() < end:
            for sample in reader.take(200):
                if getattr(sample, "topic_name", None):
                    found[sample.topic_name] = sample.type_name
            time.sleep(0.05)
        return found

    def client(self, name, of):
        """Opens a client of a service."""
        return Client(self, name, of)

    def action(self, name, of):
        """Opens a client of an action."""
        return ActionClient(self, name, of)


class Client:
    """Client of a service: the request carries identifier and number of rmw_cyclonedds."""

    def __init__(self, peer, name, of):
        self.request_type = cyclone(f"{of}_Request", header=True)
        response_type = cyclone(f"{of}_Response", header=True)
        asked = Topic(peer.participant, f"rq{name}Request", self.request_type)
        answered = Topic(peer.participant, f"rr{name}Reply", response_type)
        self.writer = DataWriter(peer.participant, asked, qos=SERVICE)
        self.reader = DataReader(peer.participant, answered, qos=SERVICE)
        self.guid = int.from_bytes(os.urandom(8), "little")
        self.sequence = 0
        self.answers = {}

    def wait_for_server(self, timeout=10):
        """Waits until reader and writer of the server are discovered."""
        wait(
            lambda: self.writer.get_matched_subscriptions()
            and self.reader.get_matched_publications(),
            timeout,
            "server",
        )
        # The server may discover this client a moment later.
        time.sleep(0.2)

    def send(self, **fields):
        """Sends a request; returns its number."""
        self.sequence += 1
        self.writer.write(self.request_type(guid=self.guid, seq=self.sequence, **fields))
        return self.sequence

    def answer(self, sequence):
        """Returns the answer to a request, or None."""
        for sample in self.reader.take(100):
            if getattr(sample, "guid", None) == self.guid:
                self.answers[sample.seq] = sample
        return self.answers.pop(sequence, None)

    def call(self, timeout=5, **fields):
        """Sends a request and waits for the answer."""
        sequence = self.send(**fields)
        return wait(lambda: self.answer(sequence), timeout, "answer")


class ActionClient:
    """Client of an action."""

    def __init__(self, peer, name, of):
        base = f"{name}/_action"
        self.goal_type = cyclone(f"{of}_Goal")
        self.goals = peer.client(f"{base}/send_goal", f"{of}_SendGoal")
        self.cancels = peer.client(f"{base}/cancel_goal", "action_msgs/srv/CancelGoal")
        self.results = peer.client(f"{base}/get_result", f"{of}_GetResult")
        self.feedback = peer.reader(f"{base}/feedback", f"{of}_FeedbackMessage")
        self.statuses = peer.reader(
            f"{base}/status", "action_msgs/msg/GoalStatusArray", latched=True, depth=1
        )
        self.uuid = cyclone("unique_identifier_msgs/msg/UUID")
        self.info = cyclone("action_msgs/msg/GoalInfo")

    def wait_for_server(self, timeout=10):
        """Waits until all services are discovered."""
        for client in (self.goals, self.cancels, self.results):
            client.wait_for_server(timeout)

    def send(self, timeout=5, **fields):
        """Sends a goal and waits for its acceptance; returns its identifier."""
        goal_id = self.uuid(uuid=list(uuid.uuid4().bytes))
        answer = self.goals.call(timeout, goal_id=goal_id, goal=self.goal_type(**fields))
        assert answer.accepted
        return goal_id

    def result(self, goal_id, timeout=60):
        """Waits for the result; returns state and result."""
        answer = self.results.call(timeout, goal_id=goal_id)
        return answer.status, answer.result

    def execute(self, timeout=60, **fields):
        """Sends a goal and waits for its result."""
        return self.result(self.send(**fields), timeout)

    def cancel(self, goal_id, timeout=5):
        """Cancels a goal; returns the code of the answer."""
        info = self.info(goal_id=goal_id)
        return self.cancels.call(timeout, goal_info=info).return_code
