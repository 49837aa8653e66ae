"""A run in 3D that is written without being computed: still water beside a box."""

from types import SimpleNamespace

import numpy as np

from parisph import Box, Case, Fluid, Numerics, Obstacle, PressureTap, Tank
from parisph.base.fields import FIELDS, FLUID, WALL, WET
from parisph.geometry.build import build
from tests.stored import stored

S = 0.1    # spacing [m]
DEPTH = 0.5    # [m]


def tank(**changes):
    """Water of 1.2 m x .8 m x .5 m in a tank with a box of .2 m x .4 m x .2 m on its bed."""
    about = dict(title="Box in 3D", fluid=Fluid(Box(width=1.2, height=DEPTH), density=1000.0),
                 walls=(Tank(width=1.2, height=0.8, breadth=0.8),
                        Obstacle(Box(width=0.2, height=0.2, breadth=0.4, at=(0.5, 0.2, 0.0)), name="box")),
                 gravity=(0.0, 0.0, -9.81), numerics=Numerics(spacing=S), end_time=1.0,
                 probes=[PressureTap("P1", at=(0.5, 0.4, 0.1))])
    return Case(**{**about, **changes})


def water(case):
    """The particles at the start, with the pressure of water at rest and the velocity (x, y, z)."""
    made = build(case)
    arrays = {name: made.get(name, field.empty(len(made["id"]), 3)) for name, field in FIELDS.items()}
    arrays["p"] = 9810.0 * np.maximum(DEPTH - made["x"][:, 2], 0.0)
    arrays["u"] = np.where((made["kind"] == FLUID)[:, None], made["x"], 0.0)
    wet = (made["kind"] == WALL) & (made["x"][:, 2] < DEPTH)
    arrays["role"] = np.where(wet, WET, made["role"]).astype(np.int8)
    n = len(made["id"])
    return SimpleNamespace(dim=3, offset=0, n_owned=n, n_global=n, **arrays)


def written(folder, case=None):
    """Write the folder of a run with three snapshots, and return its Run."""
    case = case or tank()
    particles = water(case)
    series = {"steps": {"dt": "s", "iterations": ""}, "probes/P1": {"pressure": "Pa"}}
    samples = [(0.01 * step, step, {"steps": (0.01, 8), "probes/P1": (3924.0 + step,)}) for step in range(20)]
    return stored(folder, case, series, samples, [(particles, 0.1 * step, step) for step in range(3)])
