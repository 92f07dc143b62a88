"""Runs a policy of a server on a hand, or serves recorded chunks: `python -m atas.policy --help`."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np

from .. import AtasError
from ..hands import BusHand, SimulatedHand
from .client import PolicyClient
from .errors import PolicyError
from .executor import ChunkExecutor, run
from .server import FAULTS, ReplayServer


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m atas.policy", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    run_ = commands.add_parser("run", help="run the policy of a server on a hand")
    run_.add_argument("url", help="address of the server, for example ws://localhost:8000")
    run_.add_argument("--bus", help="bus of the daemon (default: ATAS_BUS, else atas)")
    run_.add_argument("--simulate", metavar="OBJECT", help="simulate this object in this process instead")
    run_.add_argument("--seed", type=int, default=0, help="seed of the simulation")
    run_.add_argument("--hand", choices=("left", "right"), default="right", help="hand (default %(default)s)")
    run_.add_argument("--tactile", choices=("none", "summary", "taxels"), default="summary", help="tactile observation")
    run_.add_argument("--object", type=float, nargs=5, metavar=("X", "Y", "Z", "YAW", "WIDTH"), help="expected object")
    run_.add_argument("--prompt", default="", help="task text")
    run_.add_argument("--rate-hz", type=float, default=20.0, help="steps per second (default %(default)s)")
    run_.add_argument("--replan", type=int, default=10, help="steps before the next request (default %(default)s)")
    run_.add_argument("--silence", type=float, default=2.0, help="longest time without an answer, s (default %(default)s)")
    run_.add_argument("--seconds", type=float, default=16.0, help="duration, s (default %(default)s)")
    run_.add_argument("--api-key", help="key for the server")
    serve = commands.add_parser("serve", help="serve recorded chunks on the loopback interface, for tests")
    serve.add_argument("chunks", type=Path, help="file .npy: an array (chunks, steps, values)")
    serve.add_argument("--port", type=int, default=8000, help="port (default %(default)s)")
    serve.add_argument("--fault", choices=FAULTS, help="fault of request --at")
    serve.add_argument("--at", type=int, default=3, help="number of the request with the fault, from 0")
    return parser


def _serve(given: argparse.Namespace) -> None:
    faults = {given.at: given.fault} if given.fault else None
    with ReplayServer(np.load(given.chunks), port=given.port, faults=faults) as server:
        print("serving", len(server.chunks), "chunks at", server.url, flush=True)
        while True:
            time.sleep(1.0)


def _run(given: argparse.Namespace) -> None:
    hand: BusHand | SimulatedHand
    if given.simulate:
        hand = SimulatedHand(given.simulate, seed=given.seed, hand=given.hand, tactile=given.tactile)
    else:
        hand = BusHand(given.bus, hand=given.hand, tactile=given.tactile, item=given.object)
    with PolicyClient(given.url, api_key=given.api_key) as client:
        executor = ChunkExecutor(
            hand, client, rate_hz=given.rate_hz, replan=given.replan, silence_s=given.silence, prompt=given.prompt
        )
        try:
            run(executor, given.seconds)
        finally:
            print(f"{executor.chunks} chunks, {executor.steps} steps, {executor.late_steps} late steps; the hand holds")
    if isinstance(hand, SimulatedHand):
        held = hand.simulation.truth["objects"][0]
        crushed, lifted_mm = bool(held["crushed"]), held["lifted_m"] * 1e3
        print(f"lifted {lifted_mm:.1f} mm, crushed {crushed}, peak force {hand.peak_n:.2f} N")


def main() -> None:
    """Parses the command line."""
    given = _parser().parse_args()
    try:
        _serve(given) if given.command == "serve" else _run(given)
    except (PolicyError, AtasError, ValueError, OSError) as error:
        sys.exit(f"error: {error}")
    except KeyboardInterrupt:
        sys.exit(130)


if __name__ == "__main__":
    main()
