"""Bodies of walls and of fluid near the spacing: of .1 to 3 spacings, that touch, overlap or nearly do.

What is accepted has the right volume and no two particles in one place. What is refused is accepted when the advice of
the message is followed.
"""

import re
import warnings

import numpy as np

from parisph import Box, Case, Disc, Fluid, Numerics, Obstacle, Plate, Polygon, Profile, StillWater, Tank
from parisph.base.errors import CaseError
from parisph.base.fields import FLUID
from parisph.geometry import build, scene_checks
from parisph.geometry.solid import in_fluid
from parisph.geometry.standing import standing

S = 0.1
WIDTH, HEIGHT, LEVEL = 2.0, 1.4, 1.0
CLOSEST = 0.45          # spacings between particles
FINE = 1 / 24           # of a spacing: of the places at which the fluid is looked for
VOLUME = 0.004          # part of the volume that these places may miss
LATTICE = 0.2           # part of the volume by which the lattice may be wrong before particles are given their volumes
LEAST = 0.004           # [m]: finer spacings that are named are taken to do
STILL = Fluid(StillWater(LEVEL), 1000.0)


def make(count, random, folder):
    """See table.Part."""
    kinds = (_wall, _wall, _two_walls, _fluids)
    for attempt in range(count):
        yield judge(*kinds[attempt % len(kinds)](random))


def judge(walls, fluids):
    """Return None if a scene of these walls and fluids is treated well, else what is wrong with that."""
    what = f"walls {walls[1:]!r}, fluid {[fluid.shape for fluid in fluids]!r}"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            said, case = _said(walls, fluids, S)
            wrong = _not_followed(said, walls, fluids) if said else _wrong_particles(case)
    except Exception as error:
        wrong = f"{type(error).__name__}: {error}"
    return wrong and f"{what}: {wrong}"


def _said(walls, fluids, spacing):
    """Return with which messages a scene is refused, and the case of one that is not."""
    try:
        case = Case(title="near the spacing", fluid=tuple(fluids), walls=tuple(walls), gravity=(0.0, -9.81),
                    end_time=1.0, numerics=Numerics(spacing=spacing))
    except CaseError as error:
        return str(error).split("\n"), None
    return scene_checks.faults(case), case


def _not_followed(said, walls, fluids):
    """Follow the advice of a refusal; return what is still refused then, or None."""
    for line in said:
        if "give its points the other way round" in line:
            return f"is advised what nobody can do: {line}"
    advised = [float(found) for line in said for found in re.findall(r"a spacing of at most ([^\s,;]+)", line)]
    fewer = [body for body in walls[1:] if not any(
        f"{body.name}:" in line and "leave it out" in line for line in said)]
    mixed = [fluid for number, fluid in enumerate(fluids) if not any(
        line.startswith(f"fluid[{number}]") and "leave it out" in line for line in said)]
    if advised:
        again = _said(walls, fluids, min(advised))[0] if min(advised) > LEAST else []
    elif len(fewer) < len(walls) - 1 or len(mixed) < len(fluids):
        again = _said([walls[0], *fewer], mixed, S)[0]
    elif any("its ends lead back to it" in line for line in said):
        again = []
    else:
        return f"gets no advice: {said}"
    left = [line for line in again if line.partition(",")[0] in {old.partition(",")[0] for old in said}]
    return f"follows {said} and is refused again: {left}" if left else None


def _wrong_particles(case):
    parts = build.build(case)
    fluid = parts["kind"] == FLUID
    x = parts["x"][fluid]
    apart = np.linalg.norm(x[:, None] - x, axis=2) + np.eye(len(x))
    if apart.min() < CLOSEST * S:
        return f"two particles are {apart.min() / S:.2g} spacings apart"
    exact, seen = build.volume(case), _seen(case)
    if abs(exact - seen) > VOLUME * seen:
        return f"its fluid has {seen:.5g} m2, and {exact:.5g} by what parisph says"
    lattice = parts["volume"][fluid].sum()
    if abs(lattice / exact - 1.0) > LATTICE:
        return f"its particles have {lattice:.5g} m2 of {exact:.5g}"
    scene_checks.warnings(case)
    return None


def _seen(case):
    """Return the area [m2] of the fluid by looking for it at many places."""
    h = FINE * S
    axes = [np.arange(0.5 * h, end, h) for end in (WIDTH, HEIGHT)]
    x = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    wet = np.zeros(len(x), dtype=bool)
    for fluid in case.fluids:
        wet |= x[:, 1] <= fluid.shape.level if isinstance(fluid.shape, StillWater) else fluid.shape.inside(x, 0.0)
    wet[wet] = in_fluid(standing(case), x[wet])
    return float(wet.sum() * h * h)


def _wall(random):
    size, tank = _size(random), Tank(WIDTH, HEIGHT, name="tank")
    if random.random() < 0.1:
        over = float(random.uniform(0.0, 1.2))
        turn = np.linspace(np.pi - over, 2.0 * np.pi + over, 25)
        return [Profile(_around(0.8, turn, (1.0, 0.85)), name="body")], [Fluid(StillWater(0.8), 1000.0)]
    if random.random() < 0.1:
        low = (float(random.uniform(0.3, 1.7)), _gap(random))
        return [tank, Plate([low, (low[0] + float(random.normal(0.0, size)), low[1] + size)], name="body")], [STILL]
    return [tank, Obstacle(_placed(random, _shape(random, size)), name="body")], [STILL]


def _two_walls(random):
    walls, fluids = _wall(random)
    if not isinstance(walls[-1], Obstacle):
        return walls, fluids
    (low, bottom), (high, top) = walls[-1].bounds
    radius = _size(random)
    at = (high + radius + _gap(random), 0.5 * (bottom + top))
    return [*walls, Obstacle(Disc(radius, at=tuple(map(float, at))), name="beside")], fluids


def _fluids(random):
    tank, first = Tank(WIDTH, HEIGHT, name="tank"), Box(0.8, float(random.choice([0.5, 0.53])))
    gap, size = _gap(random), float(random.uniform(0.2, 0.5))
    other = [Box(size, 0.5, at=(0.8 + gap, 0.0)), Box(0.8, size, at=(0.0, first.height + gap)),
             Box(size, size, at=(0.8 + gap, first.height + gap)), Disc(size, at=(0.8 + size + gap, 0.55)),
             Box(0.6, 0.4, at=(0.4, float(random.uniform(0.0, 0.5)))), Disc(0.3, at=(0.4, 0.6)),
             Polygon([(0.8 + gap, 0.0), (0.8 + gap + size, 0.0), (0.8 + gap, 0.4)])][int(random.integers(7))]
    more = [Fluid(StillWater(float(random.uniform(0.2, 0.6))), 1000.0)] if random.random() < 0.3 else []
    return [tank], [Fluid(first, 1000.0), Fluid(other, 1000.0), *more]


def _size(random):
    return S * float(np.exp(random.uniform(np.log(0.1), np.log(3.0))))


def _gap(random):
    """A distance: nothing, rounding, less than a spacing, up to two, or an overlap [m]."""
    return float(random.choice([0.0, 1e-12, S * 10.0 ** random.uniform(-7.0, 0.0), S * random.uniform(0.0, 2.0),
                                -S * 10.0 ** random.uniform(-7.0, 0.0)]))


def _around(radius, turn, at=(0.0, 0.0)):
    return [(float(at[0] + r * np.cos(a)), float(at[1] + r * np.sin(a)))
            for r, a in zip(np.broadcast_to(radius, len(turn)), turn)]


def _shape(random, size):
    """A shape of about a size [m], near the origin."""
    kind, corners = int(random.integers(7)), int(random.integers(3, 30))
    turn = 2.0 * np.pi * (np.arange(corners) / corners + random.random())
    thin = size * float(random.uniform(0.05, 0.6))
    half = np.linspace(-random.uniform(0.0, 0.7), np.pi + random.uniform(0.0, 0.7), 20)
    return [
        lambda: Disc(size), lambda: Box(size, size), lambda: Box(10.0 * size / 3.0, thin),
        lambda: Polygon(_around(size, turn)),
        lambda: Polygon([(-size, 0.0), (size, 0.0), (0.0, thin)]),
        lambda: Polygon(_around(np.where(np.arange(10) % 2, thin, size), np.pi / 5.0 * np.arange(10))),
        lambda: Polygon(_around(2.0 * size, half) + _around(2.0 * size - thin, half[::-1])),
    ][kind]()


def _placed(random, shape):
    """Move a shape into the water, to the bed, to a side or into a corner, with a gap."""
    (low, bottom), (high, top) = shape.bounds
    x, y = (float(random.uniform(0.5, 1.0)), float(random.uniform(0.4, 0.7)))
    place = int(random.integers(4))
    if place in (1, 3):
        y = _gap(random) - bottom
    if place in (2, 3):
        x = _gap(random) - low
    if isinstance(shape, Polygon):
        return Polygon([(a + x, b + y) for a, b in shape.points])
    return shape.model_copy(update={"at": (shape.at[0] + x, shape.at[1] + y)})
