"""ROS 2 interfaces of the peers, from definition files by `rosbags`.

No type comes from the bridge: standard messages are those of `rosbags` (Jazzy), the others are read
from the files of `atas_msgs` and from the texts below (control_msgs, std_srvs, rcl_interfaces).
"""

import dataclasses
import types as python_types
from pathlib import Path

from cyclonedds import idl
from cyclonedds.idl import types as idl_types
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

ATAS_MSGS = Path(__file__).parents[2] / "atas_msgs"
EMPTY = "structure_needs_at_least_one_member"

MESSAGES = {
    "control_msgs/msg/GripperCommand": "float64 position\nfloat64 max_effort",
}
SERVICES = {
    "std_srvs/srv/Trigger": "---\nbool success\nstring message",
    "action_msgs/srv/CancelGoal": (
        "action_msgs/GoalInfo goal_info\n---\n"
        "int8 return_code\naction_msgs/GoalInfo[] goals_canceling"
    ),
    "rcl_interfaces/srv/GetParameters": (
        "string[] names\n---\nrcl_interfaces/ParameterValue[] values"
    ),
    "rcl_interfaces/srv/GetParameterTypes": "string[] names\n---\nuint8[] types",
    "rcl_interfaces/srv/SetParameters": (
        "rcl_interfaces/Parameter[] parameters\n---\n"
        "rcl_interfaces/SetParametersResult[] results"
    ),
    "rcl_interfaces/srv/SetParametersAtomically": (
        "rcl_interfaces/Parameter[] parameters\n---\nrcl_interfaces/SetParametersResult result"
    ),
    "rcl_interfaces/srv/ListParameters": (
        "string[] prefixes\nuint64 depth\n---\nrcl_interfaces/ListParametersResult result"
    ),
    "rcl_interfaces/srv/DescribeParameters": (
        "string[] names\n---\nrcl_interfaces/ParameterDescriptor[] descriptors"
    ),
}
ACTIONS = {
    "control_msgs/action/GripperCommand": (
        "control_msgs/GripperCommand command\n---\n"
        "float64 position\nfloat64 effort\nbool stalled\nbool reached_goal\n---\n"
        "float64 position\nfloat64 effort\nbool stalled\nbool reached_goal"
    ),
    "control_msgs/action/ParallelGripperCommand": (
        "sensor_msgs/JointState command\n---\n"
        "sensor_msgs/JointState state\nbool stalled\nbool reached_goal\n---\n"
        "sensor_msgs/JointState state"
    ),
}


def atas_definitions():
    """Reads the files of atas_msgs: messages and actions by name."""
    messages = {
        f"atas_msgs/msg/{path.stem}": path.read_text() for path in ATAS_MSGS.glob("msg/*.msg")
    }
    actions = {
        f"atas_msgs/action/{path.stem}": path.read_text()
        for path in ATAS_MSGS.glob("action/*.action")
    }
    return messages, actions


def parts_of(text):
    """Splits a service or action definition."""
    parts, lines = [], []
    for line in text.splitlines():
        if line.strip() == "---":
            parts.append("\n".join(lines))
            lines = []
        else:
            lines.append(line)
    return [*parts, "\n".join(lines)]


def make_store():
    """Creates the store of all types, including those that ROS 2 derives from actions."""
    store = get_typestore(Stores.ROS2_JAZZY)
    own_messages, own_actions = atas_definitions()
    found = {}
    for name, text in {**MESSAGES, **own_messages}.items():
        found.update(get_types_from_msg(text, name))
    services = dict(SERVICES)
    for name, text in {**ACTIONS, **own_actions}.items():
        goal, result, feedback = parts_of(text)
        for suffix, part in (("Goal", goal), ("Result", result), ("Feedback", feedback)):
            found.update(get_types_from_msg(part, f"{name}_{suffix}"))
        id_of = "unique_identifier_msgs/UUID goal_id"
        services[f"{name}_SendGoal"] = (
            f"{id_of}\n{name}_Goal goal\n---\nbool accepted\nbuiltin_interfaces/Time stamp"
        )
        services[f"{name}_GetResult"] = f"{id_of}\n---\nint8 status\n{name}_Result result"
        found.update(
            get_types_from_msg(f"{id_of}\n{name}_Feedback feedback", f"{name}_FeedbackMessage")
        )
    for name, text in services.items():
        request, response = parts_of(text)
        found.update(get_types_from_msg(request, f"{name}_Request"))
        found.update(get_types_from_msg(response, f"{name}_Response"))
        found.update(
            get_types_from_msg(
                f"service_msgs/ServiceEventInfo info\n{name}_Request[<=1] request\n"
                f"{name}_Response[<=1] response",
                f"{name}_Event",
            )
        )
        found.update(
            get_types_from_msg(
                f"{name}_Request request_message\n{name}_Response response_message\n"
                f"{name}_Event event_message",
                name,
            )
        )
    found = _with_services_named(found)
    store.register({name: of for name, of in found.items() if name not in store.fielddefs})
    # rosbags takes `char` for a type of its own; rosidl maps it to `uint8`.
    name = "service_msgs/msg/ServiceEventInfo"
    constants, fields = store.fielddefs[name]
    array = dict(fields)["client_gid"]
    bytes_of = (array[0], ((array[1][0][0], ("uint8", 0)), array[1][1]))
    store.fielddefs[name] = (
        constants,
        [(field, bytes_of if field == "client_gid" else of) for field, of in fields],
    )
    return store


def _with_services_named(of):
    """Undoes the insertion of `msg` into the names of services by `rosbags`."""
    if isinstance(of, str):
        return of.replace("/srv/msg/", "/srv/")
    if isinstance(of, dict):
        return {_with_services_named(k): _with_services_named(v) for k, v in of.items()}
    if isinstance(of, list | tuple):
        return type(of)(_with_services_named(v) for v in of)
    return of


STORE = make_store()
_CLASSES = {}
_BASES = {
    "byte": idl_types.uint8,
    "octet": idl_types.uint8,
    "char": idl_types.uint8,
    "bool": bool,
    "string": str,
    **{
        name: getattr(idl_types, name)
        for name in ("int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64")
    },
    "float32": idl_types.float32,
    "float64": idl_types.float64,
}


def dds_name(name):
    """Returns the type name on DDS."""
    *package, last = name.split("/")
    return "::".join([*package, "dds_", f"{last}_"])


def fields_of(name):
    """Returns the fields of a type; ROS 2 fills an empty one."""
    return STORE.fielddefs[name][1] or [(EMPTY, (1, ("uint8", 0)))]


def _annotation(of):
    kind, rest = int(of[0]), of[1]
    if kind == 1:
        return _BASES[rest[0]]
    if kind == 2:
        return cyclone(rest)
    element, count = rest
    if kind == 3:
        return idl_types.array[_annotation(element), count]
    if count:
        return idl_types.sequence[_annotation(element), count]
    return idl_types.sequence[_annotation(element)]


def _default(of):
    kind, rest = int(of[0]), of[1]
    if kind == 1:
        return {"bool": bool, "string": str, "float32": float, "float64": float}.get(rest[0], int)()
    if kind == 2:
        return cyclone(rest)()
    if kind == 3:
        return [_default(rest[0]) for _ in range(rest[1])]
    return []


def cyclone(name, header=False):
    """Returns the class of a type for Cyclone DDS; `header` adds that of rmw_cyclonedds."""
    key = (name, header)
    if key not in _CLASSES:
        fields = fields_of(name)
        hints = {field: _annotation(of) for field, of in fields}
        body = {
            field: dataclasses.field(default_factory=lambda of=of: _default(of))
            for field, of in fields
        }
        if header:
            hints = {"guid": idl_types.uint64, "seq": idl_types.int64, **hints}
            body = {"guid": 0, "seq": 0, **body}
        made = python_types.new_class(
            name.rsplit("/", 1)[1],
            (idl.IdlStruct,),
            {"typename": dds_name(name)},
            lambda space: space.update({"__annotations__": hints, **body}),
        )
        _CLASSES[key] = dataclasses.dataclass(made)
    return _CLASSES[key]
