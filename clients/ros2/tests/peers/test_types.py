"""Type hashes against a second implementation (`rosbags`), from definition files."""

import subprocess

from bench import BRIDGE
from interfaces import STORE
from rosbags.typesys.base import TypesysError


def test_type_hashes_equal_a_second_implementation():
    # rosbags takes `char` for a type of its own; rosidl maps it to `uint8`.
    name = "service_msgs/msg/ServiceEventInfo"
    constants, fields = STORE.fielddefs[name]
    array = dict(fields)["client_gid"]
    bytes_of = (array[0], ((array[1][0][0], ("uint8", 0)), array[1][1]))
    STORE.fielddefs[name] = (
        constants,
        [(field, bytes_of if field == "client_gid" else of) for field, of in fields],
    )
    printed = subprocess.run(
        [BRIDGE, "--print-types"], capture_output=True, text=True, check=True
    ).stdout.split()
    ours = dict(zip(printed[::2], printed[1::2], strict=True))
    assert len(ours) > 60
    wrong = []
    for of, hashed in ours.items():
        try:
            theirs = STORE.hash_rihs01(of)
        except (KeyError, TypesysError) as error:
            theirs = repr(error)
        if theirs != hashed:
            wrong.append((of, hashed, theirs))
    assert not wrong
    print(f"{len(ours)} type hashes are equal")
