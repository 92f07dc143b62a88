"""Sensitivity of the grasp to the parameters of contact, sensor, object and robot.

    parameters ─▶ design of points ─▶ `atas eval grasp` per point ─▶ measures ─▶ tables, figures, domain

Each design point is one run of the evaluation with the same seeds. `one-at-a-time` varies one
parameter over its range and keeps all others nominal; the domain of validity follows from it.
`morris` varies all parameters together and ranks them by elementary effects, with SALib.
Install: `pip install 'atas[sensitivity]'`. Run: `python -m atas.sensitivity --help`.
"""
