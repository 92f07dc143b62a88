"""Emulates the board of a magnetic fingertip (ReSkin, AnySkin, eFlesh).

    python3 eflesh_board.py board PIPE            unloaded fingertip, 100 frames per second
    python3 eflesh_board.py presses FILE          one second of frames for each load of LOADS_N
    python3 eflesh_board.py steps TABLE           times and forces of these loads, for a calibration

A frame has temperature (°C) and flux (µT) of five magnetometers as little-endian float32, then
CR LF. The response of the magnetometers to a force is synthetic; noise and step are those of a
magnetometer at rest.
"""

import csv
import itertools
import random
import struct
import sys
import time

RATE_HZ = 100
STEP_UT = 2.4
"""Resolution at rest, from the recording behind the sensor model `eflesh`."""
LOADS_N = [
    *((normal_n, 0, 0) for normal_n in (0, 0.5, 1, 2, 3, 4, 6)),
    *((normal_n, side_n, 0) for normal_n in (2, 4, 6) for side_n in (-1.5, -0.5, 0.5, 1.5)),
    *((normal_n, 0, side_n) for normal_n in (2, 4, 6) for side_n in (-1.5, -0.5, 0.5, 1.5)),
]
"""Normal and tangential forces of the presses."""
GAINS_UT_N = [(9, 2, 140), (80, 12, 60), (-80, 9, 62), (11, 85, 58), (7, -82, 61)]
"""Change of the flux in z per normal force, and in x and y per tangential force."""


def frame(load_n, noise):
    normal_n, first_n, second_n = load_n
    values = []
    for along_x, along_y, along_z in GAINS_UT_N:
        flux = (
            120 + along_x * normal_n * 0.3 + 70 * first_n,
            -80 + along_y * normal_n * 0.3 + 70 * second_n,
            310 + along_z * normal_n + 15 * first_n - 9 * second_n,
        )
        values += [24.0, *(axis + STEP_UT * noise.choice((-1, 0, 0, 1)) for axis in flux)]
    return struct.pack("<20f", *values) + b"\r\n"


def main(mode, path):
    noise = random.Random(path)
    if mode == "steps":
        with open(path) as table:
            times_ns = [int(row["captured_ns"]) for row in csv.DictReader(table)]
        print("from_ns,to_ns,normal_n,tangential1_n,tangential2_n")
        for step, load_n in enumerate(LOADS_N):
            first, last = times_ns[step * RATE_HZ], times_ns[(step + 1) * RATE_HZ - 1]
            print(first, last, *load_n, sep=",")
        return
    loads = itertools.repeat((0, 0, 0)) if mode == "board" else (load for load in LOADS_N for _ in range(RATE_HZ))
    with open(path, "wb", buffering=0) as board:
        for load_n in loads:
            board.write(frame(load_n, noise))
            time.sleep(1 / RATE_HZ if mode == "board" else 0)


main(*sys.argv[1:])
