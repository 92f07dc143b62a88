"""MessagePack with NumPy arrays, as openpi's servers use it.

An array is a map with the keys `__ndarray__`, `data`, `dtype` and `shape`; a NumPy scalar one with
`__npgeneric__`, `data` and `dtype`. Keys are bytes. Answers come from another machine: sizes, types
and shapes are checked before an array is made.
"""

from __future__ import annotations

import math
from typing import Any

import msgpack
import numpy as np

from .errors import PolicyChunkError

MESSAGE_MAX_BYTES = 64 << 20
"""Largest message, bytes. Design choice: a hundred pictures of 224 by 224 and more."""

_KINDS = "biuf"
"""Kinds of array elements: bool, integers, floats. Others have no place in a chunk."""


def _encode(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic) and value.dtype.kind not in _KINDS:
        raise ValueError(f"observation rejected: element type {value.dtype}; needs numbers or bool")
    if isinstance(value, np.ndarray):
        shape = list(value.shape)
        return {b"__ndarray__": True, b"data": value.tobytes(), b"dtype": value.dtype.str, b"shape": shape}
    if isinstance(value, np.generic):
        return {b"__npgeneric__": True, b"data": value.item(), b"dtype": value.dtype.str}
    raise ValueError(f"observation rejected: a value of type {type(value).__name__} cannot be sent")


def _decode(value: dict[Any, Any]) -> Any:
    if b"__ndarray__" in value:
        return _array(value)
    if b"__npgeneric__" in value:
        return _element_type(value).type(value[b"data"])
    return value


def _element_type(value: dict[Any, Any]) -> np.dtype[Any]:
    try:
        found: np.dtype[Any] = np.dtype(value[b"dtype"])
    except (KeyError, TypeError) as cause:
        raise PolicyChunkError("answer rejected: an array without a valid element type") from cause
    if found.kind not in _KINDS:
        raise PolicyChunkError(f"answer rejected: element type {found}; needs numbers or bool")
    return found


def _array(value: dict[Any, Any]) -> np.ndarray[Any, Any]:
    found = _element_type(value)
    data, shape = value.get(b"data"), value.get(b"shape")
    is_shape = isinstance(shape, list | tuple) and all(
        isinstance(size, int) and not isinstance(size, bool) and size >= 0 for size in shape
    )
    if not isinstance(data, bytes) or not is_shape:
        raise PolicyChunkError("answer rejected: an array without data or shape")
    assert isinstance(shape, list | tuple)
    needed = math.prod(shape) * found.itemsize
    if needed != len(data):
        raise PolicyChunkError(
            f"answer rejected: an array of shape {tuple(shape)} and type {found} has {len(data)} bytes; needs {needed}"
        )
    return np.frombuffer(data, found).reshape(shape)


def pack(value: Any) -> bytes:
    """Packs maps, lists, texts, numbers and arrays. Raises ValueError for other values."""
    packed = msgpack.packb(value, default=_encode)
    assert isinstance(packed, bytes)
    return packed


def unpack(message: bytes) -> Any:
    """Unpacks a message. Raises PolicyChunkError if it is malformed."""
    try:
        return msgpack.unpackb(message, object_hook=_decode)
    except PolicyChunkError:
        raise
    except Exception as cause:  # msgpack raises several kinds for malformed bytes.
        raise PolicyChunkError(f"answer rejected: {len(message)} bytes are not valid MessagePack ({cause})") from cause
