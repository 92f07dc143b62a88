"""Interface of LeRobot that the plugin uses: recorded from the real classes, replayed without them.

`python tests/contract.py` in an environment with LeRobot writes `contract.json`. Without LeRobot,
`replay` puts modules with this interface in its place, so that the plugin's own logic is tested
where PyTorch is not installed. With LeRobot, `test_contract.py` compares the file with the real
classes, and all tests run on them.
"""

from __future__ import annotations

import abc
import dataclasses
import importlib
import importlib.metadata
import importlib.util
import inspect
import json
import sys
import types
from pathlib import Path
from typing import Any

INSTALLED = importlib.util.find_spec("lerobot") is not None
"""Whether the real LeRobot can be imported."""
FILE = Path(__file__).with_name("contract.json")
DEVICES = {"lerobot.robots": ("Robot", "RobotConfig"), "lerobot.teleoperators": ("Teleoperator", "TeleoperatorConfig")}
ERRORS = ("DeviceNotConnectedError", "DeviceAlreadyConnectedError")
FUNCTIONS = {
    "lerobot.cameras": ("make_cameras_from_configs",),
    "lerobot.teleoperators": ("make_teleoperator_from_config",),
}
ATTRIBUTES = ("id", "robot_type", "calibration", "calibration_dir", "calibration_fpath")


def _members(cls: type) -> dict[str, dict[str, Any]]:
    found = {}
    for name in sorted(cls.__abstractmethods__):  # type: ignore[attr-defined]
        member = inspect.getattr_static(cls, name)
        is_property = isinstance(member, property)
        arguments = [] if is_property else list(inspect.signature(member).parameters)
        found[name] = {"property": is_property, "arguments": arguments}
    return found


def _attributes(cls: type, config: Any) -> list[str]:
    filled = {name: (lambda self, *given: None) for name in cls.__abstractmethods__}  # type: ignore[attr-defined]
    filled["is_connected"] = property(lambda self: False)  # type: ignore[assignment]
    made = type("Filled", (cls,), filled | {"name": "filled"})(config)
    return [name for name in ATTRIBUTES if hasattr(made, name)]


def record(calibration_dir: Path) -> dict[str, Any]:
    """The interface of the installed LeRobot."""
    known: dict[str, Any] = {"version": importlib.metadata.version("lerobot").rpartition(".")[0], "devices": {}}
    for module_name, (device, config) in DEVICES.items():
        module = importlib.import_module(module_name)
        cls, config_cls = getattr(module, device), getattr(module, config)
        # A subclass: the base has no registered name.
        made = dataclasses.dataclass(kw_only=True)(type("OwnConfig", (config_cls,), {}))(calibration_dir=calibration_dir)
        known["devices"][module_name] = {
            "device": device,
            "members": _members(cls),
            "attributes": _attributes(cls, made),
            "config": config,
            "fields": {one.name: one.default for one in dataclasses.fields(config_cls)},
            "config_has_post_init": hasattr(config_cls, "__post_init__"),
        }
    errors = importlib.import_module("lerobot.utils.errors")
    known["errors"] = {name: [base.__name__ for base in getattr(errors, name).__mro__[1:]] for name in ERRORS}
    known["functions"] = {
        f"{module}.{name}": list(inspect.signature(getattr(importlib.import_module(module), name)).parameters)
        for module, names in FUNCTIONS.items()
        for name in names
    }
    return known


class _Registry:
    """A registry of subclasses by name, as LeRobot's configurations have."""

    registered: dict[str, type]

    @classmethod
    def register_subclass(cls, name: str) -> Any:
        def keep(sub: type) -> type:
            if name in cls.registered:
                raise ValueError(f"{name} is registered twice")
            cls.registered[name] = sub
            return sub

        return keep

    @classmethod
    def get_choice_name(cls, sub: type) -> str:
        return next(name for name, known in cls.registered.items() if known is sub)

    @property
    def type(self) -> str:
        return self.get_choice_name(self.__class__)


def _device(about: dict[str, Any]) -> type:
    def init(self: Any, config: Any) -> None:
        values = {
            "id": config.id,
            "robot_type": self.name,
            "calibration": {},
            "calibration_dir": config.calibration_dir,
            "calibration_fpath": None,
        }
        for name in about["attributes"]:
            setattr(self, name, values[name])

    body: dict[str, Any] = {"__init__": init, "__str__": lambda self: f"{self.id} {self.__class__.__name__}"}
    for name, member in about["members"].items():
        missing = abc.abstractmethod(lambda self, *given: None)
        body[name] = property(missing) if member["property"] else missing
    return abc.ABCMeta(about["device"], (abc.ABC,), body)


def _config(about: dict[str, Any]) -> type:
    fields = [(name, Any, dataclasses.field(default=value)) for name, value in about["fields"].items()]
    body: dict[str, Any] = {"registered": {}}
    if about["config_has_post_init"]:
        body["__post_init__"] = lambda self: None
    return dataclasses.make_dataclass(about["config"], fields, bases=(_Registry,), namespace=body, kw_only=True)


def replay(known: dict[str, Any]) -> None:
    """Puts modules with the recorded interface in place of LeRobot."""

    def module(name: str) -> types.ModuleType:
        if name not in sys.modules:
            sys.modules[name] = types.ModuleType(name)
        return sys.modules[name]

    for name in ("lerobot", "lerobot.utils"):
        module(name)
    for name, about in known["devices"].items():
        setattr(module(name), about["device"], _device(about))
        setattr(module(name), about["config"], _config(about))
    builtin = {"ConnectionError": ConnectionError}
    for name, bases in known["errors"].items():
        setattr(module("lerobot.utils.errors"), name, type(name, (builtin[bases[0]],), {}))
    for path in known["functions"]:
        name, _, function = path.rpartition(".")

        def absent(configs: Any, path: str = path) -> Any:
            if configs:
                raise RuntimeError(f"{path} needs LeRobot")
            return {}

        setattr(module(name), function, absent)
    module("lerobot.cameras").CameraConfig = type("CameraConfig", (), {})  # type: ignore[attr-defined]


if __name__ == "__main__":
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        FILE.write_text(json.dumps(record(Path(folder)), indent=2) + "\n")
    print("wrote", FILE)
