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
    result = Contacts(np.zeros(model.tips), np.full(model.tips, -1), np.zeros(objects), np.zeros(pins))
    if data.ncon == 0 or objects == 0:
        return result
    contact = data.contact
    geoms, address = contact.geom, contact.efc_address
    efc_n = data.efc_force
    pin, thing = model.pin_of_geom[geoms].max(axis=1), model.object_of_geom[geoms].max(axis=1)
    # A contact beyond its gap has no rows.
    along_n = np.where(address >= 0, efc_n[address], 0.0)
    on_pin = pin >= 0
    if on_pin.any():
        pressed = pin[on_pin]
        result.pressed_n[:] = np.bincount(pressed, along_n[on_pin], pins)
        tip_and_object = model.tip_of_pin[pressed] * objects + thing[on_pin]
        share = np.bincount(tip_and_object, along_n[on_pin], model.tips * objects).reshape(-1, objects)
        result.normal_n = share.sum(axis=1)
        result.touched = np.where(result.normal_n > 0, share.argmax(axis=1), -1)
    for index in np.flatnonzero(~on_pin & (thing >= 0) & (address >= 0)):
        upward = contact.frame[index].reshape(3, 3)[:, 2]
        # MuJoCo's force acts on the second geometry.
        sign = 1.0 if model.object_of_geom[geoms[index, 1]] >= 0 else -1.0
        result.support_n[thing[index]] += sign * float(upward @ efc_n[address[index] : address[index] + 3])
    return result


def element_forces_n(model: Model) -> Floats:
    """Returns the forces of objects on the elements, tip frame, N, flat: those that deflect the pins."""
    force_n = np.zeros((model.elements, 3))
    if len(model.pin_geoms) > 0:
        along = model.pin_stiffness * model.qpos_now[model.pin_qpos] + model.pin_damping * model.qvel_now[model.pin_dof]
        of_pins = (along.reshape(-1, 3, 1) * model.pin_axes).sum(axis=1)
        force_n[model.sensing] = np.add.reduceat(of_pins, model.first_pins)
    return force_n.ravel()


class Slip:
    """Distance that the surface has slid under each fingertip since its touch."""

    def __init__(self, tips: int) -> None:
        self.slip_m = np.zeros(tips)
        self._touched = np.full(tips, -1)
        self._on_object_m: Floats | None = None

    def reset(self) -> None:
        """Forgets the positions of the pins: another model continues."""
        self._on_object_m = None

    def update(self, model: Model, contacts: Contacts) -> None:
        """Adds the motion of pressed pins on the surface, weighted by their force."""
        touched = contacts.touched
        on_object_m = None if (touched < 0).all() else _pins_on_objects_m(model, touched)
        if on_object_m is not None and self._on_object_m is not None:
            way_m = on_object_m - self._on_object_m
            moved_m = np.sqrt((way_m * way_m).sum(axis=1))
            weighted = np.bincount(model.tip_of_pin, contacts.pressed_n * moved_m, model.tips)
            goes_on = touched == self._touched
            self.slip_m[goes_on] += (weighted / np.maximum(contacts.normal_n, 1e-9))[goes_on]
        self._touched, self._on_object_m = touched, on_object_m
        self.slip_m[touched < 0] = 0.0


def _pins_on_objects_m(model: Model, touched: Indices) -> Floats:
    """Positions of the pins in the frames of the objects that their fingertips touch, m."""
    data, result_m = model.data, np.zeros((len(model.pin_geoms), 3))
    of_pins = touched[model.tip_of_pin]
    for index in set(touched[touched >= 0].tolist()):
        body, pins = model.bodies[index], of_pins == index
        result_m[pins] = (data.geom_xpos[model.pin_geoms[pins]] - data.xpos[body]) @ data.xmat[body].reshape(3, 3)
    return result_m
