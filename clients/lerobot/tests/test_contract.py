"""Tests of the recorded interface of LeRobot."""

import json
from pathlib import Path

import contract
import lerobot_robot_atas as plugin
import pytest
from lerobot.robots import Robot, RobotConfig
from lerobot.teleoperators import Teleoperator, TeleoperatorConfig

DEVICES = {
    "atas": (plugin.AtasConfig, plugin.Atas, Robot, RobotConfig),
    "atas_simulation": (plugin.AtasSimulationConfig, plugin.AtasSimulation, Robot, RobotConfig),
    "atas_keyboard": (plugin.AtasKeyboardConfig, plugin.AtasKeyboard, Teleoperator, TeleoperatorConfig),
    "atas_leader": (plugin.AtasLeaderConfig, plugin.AtasLeader, Teleoperator, TeleoperatorConfig),
}


@pytest.mark.parametrize("name", list(DEVICES))
def test_device_implements_the_recorded_interface(name: str) -> None:
    config, device, base, config_base = DEVICES[name]
    assert issubclass(device, base) and issubclass(config, config_base)
    assert device.name == name and device.config_class is config
    assert config_base.get_choice_name(config) == name
    assert not device.__abstractmethods__
    # LeRobot finds a device by the name of its configuration, in the package of that module.
    assert config.__name__ == device.__name__ + "Config" and config.__module__ == "lerobot_robot_atas.config"
    assert getattr(plugin, device.__name__) is device


def test_recorded_interface_is_that_of_the_installed_lerobot(tmp_path: Path) -> None:
    known = json.loads(contract.FILE.read_text())
    if contract.INSTALLED:
        assert contract.record(tmp_path) == known, "run tests/contract.py again and read the difference"
    else:
        # Without LeRobot the modules come from this file: every part of it must be in use.
        for about in known["devices"].values():
            assert {"is_connected", "connect", "calibrate", "configure"} <= set(about["members"])
        assert all("ConnectionError" in bases for bases in known["errors"].values())
