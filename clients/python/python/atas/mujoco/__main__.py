"""Engine process of the simulator, and converter of robots: `atas-mujoco robot FILE`."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from .options import Options, parse, parse_robot
from .protocol import BEGIN, TICK, Channel, parse_scene

COMMAND = "robot"


def serve(channel: Channel, options: Options) -> None:
    """Answers messages until the input ends."""
    import numpy as np

    import mujoco

    from .show import Show
    from .world import Failed, World

    world: World | None = None
    show = Show(options)
    while (message := channel.receive()) is not None:
        kind, payload = message
        try:
            if kind == BEGIN:
                world = World(parse_scene(payload), options)
                show.begin(world)
                channel.ready(f"MuJoCo {mujoco.__version__}")
            elif kind == TICK and world is not None:
                channel.state(world.advance(np.frombuffer(payload, dtype="<f8")))
                show.update(world)
            else:
                channel.failed(f"message {kind} is unexpected: a scene must begin first")
        except KeyError as error:
            world = None
            channel.failed(f"the scene has no {error}; install the same version of simulator and package")
        except (Failed, ValueError) as error:
            world = None
            channel.failed(str(error))


def convert(arguments: list[str]) -> int:
    """Writes a robot with its skins as MJCF: the simulator reads the robot file, this engine saves the model."""
    options = parse_robot(arguments)
    program = Path(sys.executable).with_name("atas-sim")
    words = [str(program) if program.exists() else "atas-sim", "run", "--robot", options.robot]
    words += ["--lockstep", "--duration", "0", "--bus", f"atas-mujoco-{os.getpid()}"]
    engine = f"mujoco --pins {options.pins} --save {options.out.absolute()}"
    environment = {"RUST_LOG": "error", "ATAS_PYTHON": sys.executable} | os.environ
    return subprocess.run([*words, "--engine", engine], env=environment, check=False).returncode


def main() -> None:
    """Runs the command line."""
    arguments = sys.argv[1:]
    if arguments[:1] == [COMMAND]:
        sys.exit(convert(arguments[1:]))
    options = parse(arguments)
    if options.pictures is not None and not os.environ.get("DISPLAY"):
        os.environ.setdefault("MUJOCO_GL", "egl")
    channel = Channel.standard()
    try:
        import mujoco  # noqa: F401
    except ImportError as error:
        channel.receive()
        channel.failed(f"{error}; install it with `pip install 'atas[mujoco]'`")
        return
    serve(channel, options)


if __name__ == "__main__":
    main()
