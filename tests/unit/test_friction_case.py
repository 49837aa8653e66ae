"""Friction on walls in a case: what is refused, and where it is found again."""

from types import SimpleNamespace

import numpy as np
import pytest

from parisph import Box, Case, CaseError, Fluid, Friction, Numerics, Obstacle, Tank
from parisph.base import vocabulary
from parisph.methods import parts
from parisph.methods.catalogue import parts_of

TANK = Tank(2.0, 2.0)


def scene(friction, walls=TANK, **numerics):
    return Case(title="test", fluid=Fluid(Box(1.0, 1.0), density=1000.0), walls=walls,
                gravity=(0.0, -9.81), friction=friction, numerics=Numerics(spacing=0.1, **numerics), end_time=1.0)


@pytest.mark.parametrize("friction, walls, numerics, message", [
    (Friction(roughness=0.2), TANK, {}, r"friction.roughness = 0.2: must be at most the spacing, here 0.1"),
    (Friction(), TANK, {"forces": ("body",)}, "friction: needs the force 'friction'; add it to numerics.forces"),
    (Friction(), TANK, {"method": "SPH"}, "friction: weakly compressible SPH has none"),
    (Friction(), Tank(2.0, 2.0, no_slip=True), {}, "friction: acts on walls along which fluid slips"),
    (Friction(), Tank(2.0, 2.0, no_slip=("left", "right", "bottom")), {}, "this scene has none"),
    (Friction(), None, {}, "along which fluid slips, and this scene has none"),
    ("yes", TANK, {}, r"friction.*write friction=Friction\(\)"),
    (True, TANK, {}, r"friction.*write friction=Friction\(\)"),
    ({"viscosity": -1.0}, TANK, {}, "friction.viscosity = -1"),
    ({"viscosity": 0.0}, TANK, {}, "then there is no friction; give one of them"),
])
def test_what_makes_no_sense_is_refused(friction, walls, numerics, message):
    with pytest.raises(CaseError, match=message):
        scene(friction, walls, **numerics)


def test_one_wall_to_slip_along_is_enough():
    sticky = Tank(2.0, 2.0, no_slip=True)
    free = Obstacle(Box(width=0.3, height=0.3, at=(1.5, 0.0)))
    assert scene(Friction(), (sticky, free)).physics == {"friction"}
    assert scene(Friction(), Tank(2.0, 2.0, lid=True, no_slip=("left", "right", "bottom"))).friction == Friction()
    # in 3D, water slips along the front and the back
    assert scene(Friction(), Tank(2.0, 2.0, breadth=1.0, no_slip=("left", "right", "bottom"))).friction == Friction()
    with pytest.raises(CaseError, match="this scene has none"):
        scene(Friction(), Tank(2.0, 2.0, breadth=1.0, no_slip=True))


def test_only_a_scene_with_friction_pays_for_it():
    without, has = (parts_of(case.complete_numerics(), case.physics) for case in (scene(None), scene(Friction())))
    assert "friction" not in [part.name for part in without.forces] and "friction" not in without.fields
    assert {"friction", "wall_u", "no_slip"} <= set(has.fields) and "friction" in has.causes


def test_a_force_of_unknown_physics_is_refused():
    with pytest.raises(ValueError, match="only = 'magnetic' is not a kind of physics; choose viscous, turning"):
        type("Pull", (parts.ForceTerm,), {"name": "pull", "only": "magnetic"})
    with pytest.raises(ValueError, match='viscous = True has no effect; write only = "viscous"'):
        type("Old", (parts.ForceTerm,), {"name": "old", "viscous": True})
    assert {part.only for part in parts.FORCES.values()} == {"", *vocabulary.PHYSICS}


def test_the_work_of_friction_alone_is_what_kinetic_energy_changes_by():
    (u, pull), volume, dt = np.random.default_rng(0).normal(size=(2, 5, 2)), np.linspace(0.5, 1.0, 5), 0.1
    particles = SimpleNamespace(friction=pull, u=u + dt * pull, volume=volume)
    flow = SimpleNamespace(particles=particles, step=SimpleNamespace(dt=dt), density=1000.0)
    gain = 500.0 * volume @ ((particles.u**2).sum(axis=1) - (u**2).sum(axis=1))
    assert parts.FORCES["friction"].work(flow, u) == pytest.approx(gain)
