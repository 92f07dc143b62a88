"""Window that shows pictures, with the toolkit of Python's standard library (tkinter)."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
"""Rows of pixels: (height, width, 3) for red, green, blue."""

REMEDY = 'use render_mode="rgb_array", or a machine with a display'


class Window:
    """Window on the display of this machine. Raises RuntimeError if there is none."""

    def __init__(self, title: str) -> None:
        try:
            import tkinter
        except ImportError as cause:
            raise RuntimeError(
                f"could not open a window: this Python has no tkinter ({cause}); install it (Debian: python3-tk), or {REMEDY}"
            ) from cause
        try:
            self._root: Any = tkinter.Tk()
        except tkinter.TclError as cause:
            raise RuntimeError(f"could not open a window: {cause}; {REMEDY}") from cause
        self._root.title(title)
        self._root.protocol("WM_DELETE_WINDOW", self.close)
        self._label: Any = tkinter.Label(self._root)
        self._label.pack()
        self._new_image = tkinter.PhotoImage
        self._shown_s = 0.0

    @property
    def is_open(self) -> bool:
        """True until the user or the program closes it."""
        return self._root is not None

    def show(self, picture: Picture, hz: float) -> None:
        """Shows a picture, at most `hz` per second: waits if called more often. A closed window shows nothing."""
        if self._root is None:
            return
        time.sleep(max(self._shown_s + 1.0 / hz - time.monotonic(), 0.0))
        self._shown_s = time.monotonic()
        height, width, _ = picture.shape
        # The label does not keep its image alive.
        self._image: Any = self._new_image(data=b"P6 %d %d 255\n" % (width, height) + picture.tobytes(), format="PPM")
        self._label.configure(image=self._image)
        self._root.update()

    def close(self) -> None:
        """Closes it; has no effect on a closed window."""
        root, self._root = self._root, None
        if root is not None:
            root.destroy()

    def __repr__(self) -> str:
        return f"<atas.window.Window: {'open' if self.is_open else 'closed'}>"
