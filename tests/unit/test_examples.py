"""The examples in the docstrings of what `from parisph import ...` offers for cases: each class has one, and it holds.

An example may use all these names, pi, and the files roll.csv and bed.stl in the current folder.
"""

import doctest
import inspect
import pydoc
from math import pi
from pathlib import Path

import pytest

import parisph
from parisph.case import bodies, motion, schema
from parisph.case.model import Model

OFFERED = {name: getattr(schema, name, None) or getattr(parisph, name)
           for name in sorted({*schema.__all__, *parisph.__all__})}
CLASSES = {name: value for name, value in OFFERED.items() if isinstance(value, type) and issubclass(value, Model)}
CLASSES |= {value.__name__: value for value in (bodies.Profile, bodies.Obstacle, bodies.Plate, bodies.StillWater,
                                               motion.PistonStroke, motion.FlapStroke)}


def examples(thing):
    """Return the examples in the docstring of a class, as one doctest."""
    return doctest.DocTestParser().get_doctest(thing.__doc__, {"pi": pi, **CLASSES}, thing.__name__, None, None)


def failures(test):
    """Return what a doctest prints about the examples that do not hold; empty if all do."""
    said = []
    doctest.DocTestRunner(verbose=False).run(test, out=said.append)
    return "".join(said)


def test_all_classes_of_cases_are_looked_at():
    offered = {name for name in parisph.__all__ if parisph._PUBLIC.get(name) == "parisph.case.schema"}
    assert offered <= set(CLASSES)


@pytest.mark.parametrize("name", sorted(CLASSES))
def test_example_holds(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("roll.csv").write_text("t_s,angle_deg\n0,0\n1,4\n2,4\n3,0\n", encoding="utf-8")
    Path("bed.stl").write_text("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
                               "endloop\nendfacet\nendsolid\n", encoding="utf-8")
    test = examples(CLASSES[name])
    assert any(f"{name}(" in example.source for example in test.examples)
    assert not any(example.options for example in test.examples), "an example that is not run proves nothing"
    assert failures(test) == ""


class Wrong:
    """An example that does not hold.

    >>> 1 + 1
    3
    """


def test_a_wrong_example_is_found():
    assert "Expected" in failures(examples(Wrong))


@pytest.mark.parametrize("name", sorted(name for name, kind in CLASSES.items() if issubclass(kind, Model)))
def test_a_record_has_the_signature_of_its_fields_and_help_of_its_own(name):
    kind = CLASSES[name]
    fields = {key: field for key, field in kind.model_fields.items() if key != "kind"}
    found = inspect.signature(kind).parameters
    assert list(found) == list(fields) and "Annotated" not in str(inspect.signature(kind))
    for key, field in fields.items():
        assert (found[key].default is inspect.Parameter.empty) == field.is_required()
    page = pydoc.plain(pydoc.render_doc(kind))
    assert f"{name}({next(iter(fields), '')}" in page
    assert "model_dump" not in page and "pydantic_" not in page and "inherited from pydantic" not in page


def test_the_signature_is_that_of_a_call():
    assert str(inspect.signature(schema.Box)) == (
        "(width: float, height: float, at: tuple[float, ...] = (0.0, 0.0), breadth: Optional[float] = None)")
    bound = inspect.signature(schema.Sway).bind(0.1, 2.0, ramp=1.0)
    assert schema.Sway(*bound.args, **bound.kwargs) == schema.Sway(amplitude=0.1, frequency=2.0, ramp=1.0)
