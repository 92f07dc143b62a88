"""Type hashes against a second implementation (`rosbags`), from definition files."""

import subprocess

from bench import BRIDGE
from interfaces import STORE
from rosbags.typesys.base import TypesysError


def test_type_hashes_equal_a_second_implementation():
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


def test_service_hashes_equal_a_third_implementation():
    from ros2_pyterfaces.cyclone.rcl_interfaces import srv as parameters
    from ros2_pyterfaces.cyclone.std_srvs.srv import Trigger

    printed = subprocess.run(
        [BRIDGE, "--print-types"], capture_output=True, text=True, check=True
    ).stdout.split()
    ours = dict(zip(printed[::2], printed[1::2], strict=True))
    names = ("GetParameters", "SetParameters", "ListParameters", "DescribeParameters")
    for of in (Trigger, *(getattr(parameters, name) for name in names)):
        assert ours[of.get_type_name()] == of.hash_rihs01(), of.get_type_name()
