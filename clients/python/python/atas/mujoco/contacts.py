"""Contact forces and slip of one tick, read from MuJoCo's constraints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .model import Model

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass
class Contacts:
    """Forces between pins, objects and supports."""

    normal_n: Floats
    """Normal force on each fingertip, N."""
    touched: Indices
    """Object that each fingertip touches, or -1."""
    support_n: Floats
    """Vertical force of supports on each object, N."""
    pressed_n: Floats
    """Normal force on each pin, N."""


def read_contacts(model: Model) -> Contacts:
    """Returns the contact forces at the end of a step."""
    data: Any = model.data
    objects, pins = len(model.bodies), len(model.pin_geoms)
    none = Contacts(np.zeros(model.tips), np.full(model.tips, -1), np.zeros(objects), np.zeros(pins))
    if data.ncon == 0 or objects == 0:
        return none
    address = data.contact.efc_address
    active = address >= 0
    geoms, frames, address = data.contact.geom[active], data.contact.frame[active], address[active]
    force_n = data.efc_force[address[:, None] + np.arange(3)]
    pin, things = model.pin_of_geom[geoms].max(axis=1), model.object_of_geom[geoms]
    thing, on_pin = things.max(axis=1), model.pin_of_geom[geoms].max(axis=1) >= 0
    pin, along_n = pin[on_pin], force_n[on_pin, 0]
    none.pressed_n[:] = np.bincount(pin, along_n, pins)
    share = np.bincount(model.tip_of_pin[pin] * objects + thing[on_pin], along_n, model.tips * objects).reshape(-1, objects)
    none.normal_n[:] = share.sum(axis=1)
    none.touched[:] = np.where(none.normal_n > 0, share.argmax(axis=1), -1)
    others = ~on_pin & (thing >= 0)
    upward_n = np.einsum("ca,ca->c", frames[others].reshape(-1, 3, 3)[:, :, 2], force_n[others])
    # MuJoCo's force acts on the second geometry.
    sign = np.where(things[others, 1] >= 0, 1.0, -1.0)
    none.support_n[:] = np.bincount(thing[others], sign * upward_n, objects)
    return none


def element_forces_n(model: Model) -> Floats:
    """Returns the forces of objects on the elements, tip frame, N, flat: those that deflect the pins."""
    data: Any = model.data
    along = model.pin_stiffness * data.qpos[model.pin_qpos] + model.pin_damping * data.qvel[model.pin_dof]
    return np.asarray(model.elements_of_pins @ along)


class Slip:
    """Distance that the surface has slid under each fingertip since its touch."""

    def __init__(self, tips: int) -> None:
        self.slip_m = np.zeros(tips)
        self._on_object_m: Floats | None = None

    def reset(self) -> None:
        """Forgets the positions of the pins: another model continues."""
        self._on_object_m = None

    def update(self, model: Model, contacts: Contacts) -> None:
        """Adds the motion of pressed pins on the surface, weighted by their force."""
        if len(model.pin_geoms) == 0:
            self.slip_m[:] = 0.0
            return
        data: Any = model.data
        body = model.bodies[np.maximum(contacts.touched, 0)][model.tip_of_pin]
        from_object_m = data.geom_xpos[model.pin_geoms] - data.xpos[body]
        now_m = np.einsum("pji,pj->pi", data.xmat[body].reshape(-1, 3, 3), from_object_m)
        moved_m = np.zeros(len(body)) if self._on_object_m is None else np.linalg.norm(now_m - self._on_object_m, axis=1)
        self._on_object_m = now_m
        weighted = np.bincount(model.tip_of_pin, contacts.pressed_n * moved_m, model.tips)
        self.slip_m += weighted / np.maximum(contacts.normal_n, 1e-9)
        self.slip_m[contacts.touched < 0] = 0.0
