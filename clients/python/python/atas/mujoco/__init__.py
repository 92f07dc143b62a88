"""MuJoCo as the physics engine of `atas-sim run --engine mujoco` and `atas eval TASK --engine mujoco`.

    scene (JSON) ─▶ robot, scene ─▶ MjSpec ─▶ World ── tick: set-points ─▶ joints, element forces, objects

The simulator's process owns sensors, noise, errors, drives, faults and ground truth; this package
computes only motion and forces. Module `protocol` exchanges the messages, which the Rust module
`sim_backend::engine` describes. Install: `pip install 'atas[mujoco]'`.
"""
