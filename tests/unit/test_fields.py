"""A scene has the fields that its parts declare, and no others."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph.base import fields
from parisph.base.fields import CORE, FIELDS, Field, FieldSet
from parisph.methods.catalogue import parts_of
from parisph.methods.guesses import Guesses
from parisph.parallel.particles import Particles
from tests.scenes import scene

# Beside those that every scene has. Still water, and waves that do not break; a dam break; a driven cavity.
OWN = {
    "hydrostatic": {"closing", "alpha", "pairs", "acceleration", "acceleration_before", "expansion", "left",
                    "laplacian", "p_earliest", "grad_u", "strain_rate", "lack", "hollow", "phi", "share", "spare",
                    "beside"},
    "dam_break": {"closing", "alpha", "grad_u", "strain_rate", "pairs", "phi", "grad_alpha", "turn",
                  "share", "spare", "beside", "lack", "hollow"},
    "lid_driven_cavity": {"grad_u", "strain_rate", "pairs", "grad_alpha", "no_slip", "wall_u", "nu", "viscous"},
}


def parts(name, **numerics):
    case = scene(name)
    case = case.changed(numerics=case.numerics.model_copy(update=numerics))
    return parts_of(case.complete_numerics(), case.physics), case.closed


@pytest.mark.parametrize("name", OWN)
def test_a_scene_has_the_fields_that_it_needs(name):
    assert set(parts(name)[0].fields) == {*CORE, *Guesses.fields, *OWN[name]}


def test_a_scene_has_the_stages_that_it_needs():
    stages = {name: found.stages(closed) for name, (found, closed) in ((name, parts(name)) for name in OWN)}
    said = {name: " | ".join(words) for name, words in stages.items()}
    assert "viscous" not in said["hydrostatic"] + said["dam_break"] and "viscous force" in said["lid_driven_cavity"]
    assert "surface (gap)" in said["dam_break"] and "surface (gap)" in said["hydrostatic"]
    assert "surface (" not in said["lid_driven_cavity"]
    for word in ("Fick shift", "projection", "films"):
        assert word in said["dam_break"] and word not in said["hydrostatic"]
    for word in ("filling of voids", "even distances", "volume given back"):
        assert word in said["hydrostatic"] and word not in said["dam_break"]
    assert all(("irrotational filter" in words) == (name != "lid_driven_cavity") for name, words in said.items())


def test_a_surface_that_keeps_its_particles_is_not_looked_for():
    found, closed = parts("hydrostatic", surface_rule="frozen", kappa=0.0)
    assert "start_role" in found.fields and "alpha" not in found.fields
    assert not any(word.startswith("surface (") for word in found.stages(closed))


def test_only_fields_of_the_scene_have_arrays():
    p = Particles(MPI.COMM_SELF, 2, FieldSet(["alpha"]))
    p.assign({"x": np.zeros((3, 2))})
    np.testing.assert_array_equal(p.alpha, 1.0)    # the default, as for a field that an older checkpoint lacks
    assert not hasattr(p, "phi") and set(p.fields) == {*CORE, "alpha"}
    with pytest.raises(AttributeError, match="no part of the scene's method declares"):
        p.grad_u


def test_a_part_from_outside_can_declare_a_field(monkeypatch):
    monkeypatch.setattr(fields, "FIELDS", dict(FIELDS))
    dye = Field("dye", "scalar", np.float64, "", "concentration of a dye", default=0.5)
    fields.register(dye)
    fields.register(dye)
    assert FieldSet(["dye"])["dye"].empty(2, 2).tolist() == [0.5, 0.5]
    with pytest.raises(ValueError, match="another particle field 'dye'"):
        fields.register(Field("dye", "vector", np.float64, "", "something else"))
    with pytest.raises(KeyError, match="no such particle field: salt"):
        FieldSet(["salt"])
