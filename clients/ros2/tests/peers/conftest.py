"""Fixtures of the tests with Cyclone DDS as the peer; other peers have fixtures of their own."""

import pytest
from bench import Bench


@pytest.fixture(scope="module")
def bench():
    with Bench(bridge=("--services", "cyclonedds")) as running:
        yield running


@pytest.fixture(scope="module")
def peer(bench):
    # Tests of other middlewares do not need Cyclone DDS.
    from cyclone import Peer

    return Peer()
