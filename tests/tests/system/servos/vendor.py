#!/usr/bin/env python3
"""Verifies the servo emulator with the vendors' clients: `vendor.py dynamixel|feetech TERMINAL`.

Needs `pip install "dynamixel-sdk==4.*" "feetech-servo-sdk==1.*"`. The terminal has servos 1, 2 and 3 of the models in vendor.rs
and no servo 9. Exit codes: 77 if the clients are not installed, 1 with a message if the emulator differs.
"""

import sys
import time

try:
    import dynamixel_sdk
    import scservo_sdk
except ImportError as missing:
    print(f"{missing.name} is not installed")
    sys.exit(77)

IDS = [1, 2, 3]
PATIENCE_S = 20.0
SLOW_MS = 1000.0


def expect(what, found, wanted):
    if found != wanted:
        sys.exit(f"{what}: found {found!r}, wanted {wanted!r}")


def rests(what, ask):
    """Waits until a condition is true ten times in a row: a shaft may overshoot its goal."""
    deadline, in_a_row = time.monotonic() + PATIENCE_S, 0
    while in_a_row < 10:
        in_a_row = in_a_row + 1 if ask() else 0
        if time.monotonic() > deadline:
            sys.exit(f"timed out waiting for {what}")
        time.sleep(0.02)


def bytes_of(value, length):
    return list(value.to_bytes(length, "little"))


def opened(sdk, terminal):
    port = sdk.PortHandler(terminal)
    if not (port.openPort() and port.setBaudRate(1_000_000)):
        sys.exit(f"could not open {terminal}")
    # Long timeout: a busy machine may delay a reply.
    port.setPacketTimeout = lambda _length: port.setPacketTimeoutMillis(SLOW_MS)
    return port


def sync_read(group, ids, address, length):
    for servo in ids:
        group.addParam(servo)
    expect("a sync read", group.txRxPacket(), 0)
    return [group.getData(servo, address, length) for servo in ids]


def sync_write(group, values):
    for servo, value in values.items():
        group.addParam(servo, value)
    expect("a sync write", group.txPacket(), 0)


def dynamixel(terminal):
    """Protocol 2.0, XM430-W350, XL330-M288, XL430-W250."""
    sdk, port = dynamixel_sdk, opened(dynamixel_sdk, terminal)
    packets = sdk.PacketHandler(2.0)
    models = [packets.ping(port, servo) for servo in IDS]
    expect("pings", models, [(1020, 0, 0), (1200, 0, 0), (1060, 0, 0)])
    found, result = packets.broadcastPing(port)
    expect("a broadcast ping", (sorted(found), result), (IDS, 0))
    expect("an absent servo", packets.ping(port, 9)[1], sdk.COMM_RX_TIMEOUT)

    # A header pattern inside a packet is byte-stuffed and must arrive unchanged.
    packets.write4ByteTxRx(port, 1, 108, 0x00FDFFFF)
    expect("stuffed bytes", packets.read4ByteTxRx(port, 1, 108), (0x00FDFFFF, 0, 0))
    packets.write4ByteTxRx(port, 1, 108, 0)

    # Persistent registers are locked while torque is on.
    expect("a mode", packets.write1ByteTxRx(port, 2, 11, 5), (0, 0))
    for servo in IDS:
        expect("torque", packets.write1ByteTxRx(port, servo, 64, 1), (0, 0))
    expect("a locked register", packets.write1ByteTxRx(port, 2, 11, 3), (0, 7))

    goals = {1: 2100, 2: 1900, 3: 2048}
    sync_write(sdk.GroupSyncWrite(port, packets, 116, 4), {s: bytes_of(g, 4) for s, g in goals.items()})
    there = lambda: sync_read(sdk.GroupSyncRead(port, packets, 132, 4), IDS, 132, 4) == list(goals.values())
    rests("the goals", there)

    fast = sdk.GroupSyncRead(port, packets, 132, 4)
    for servo in IDS:
        fast.addParam(servo)
    expect("a fast sync read", fast.fastSyncRead(), 0)
    expect("its values", [fast.getData(servo, 132, 4) for servo in IDS], list(goals.values()))
    expect("a read of all measurements", len(packets.readTxRx(port, 1, 126, 21)[0]), 21)

    expect("a reboot", packets.reboot(port, 1), (0, 0))
    expect("no torque after it", packets.read1ByteTxRx(port, 1, 64), (0, 0, 0))


def feetech(terminal):
    """Protocol 1.0, Feetech variant, STS3215."""
    sdk, port = scservo_sdk, opened(scservo_sdk, terminal)
    packets = sdk.PacketHandler(0)
    expect("pings", [packets.ping(port, servo) for servo in IDS], [(777, 0, 0)] * 3)
    expect("an absent servo", packets.ping(port, 9)[1], sdk.COMM_RX_TIMEOUT)

    # Persistent registers are not written while the lock is closed.
    packets.write1ByteTxRx(port, 1, 33, 1)
    expect("a locked register", packets.read1ByteTxRx(port, 1, 33), (0, 0, 0))
    packets.write1ByteTxRx(port, 1, 55, 0)
    packets.write1ByteTxRx(port, 1, 7, 0)
    expect("an open one", packets.read1ByteTxRx(port, 1, 7), (0, 0, 0))

    for servo in IDS:
        expect("torque", packets.write1ByteTxRx(port, servo, 40, 1), (0, 0))
    goals = {1: 2100, 2: 1900, 3: 2048}
    sync_write(sdk.GroupSyncWrite(port, packets, 42, 2), {s: bytes_of(g, 2) for s, g in goals.items()})
    there = lambda: sync_read(sdk.GroupSyncRead(port, packets, 56, 2), IDS, 56, 2) == list(goals.values())
    rests("the goals", there)


{"dynamixel": dynamixel, "feetech": feetech}[sys.argv[1]](sys.argv[2])
print(f"{sys.argv[1]}: emulator works with the vendor's client")
