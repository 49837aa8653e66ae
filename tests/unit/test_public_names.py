"""What `from parisph import ...` offers."""

import importlib

import pytest

import parisph


@pytest.mark.parametrize("name", [name for name in parisph.__all__ if name != "__version__"])
def test_public_name_is_that_of_its_module(name):
    assert getattr(parisph, name) is getattr(importlib.import_module(parisph._PUBLIC[name]), name)
    assert name in dir(parisph)


def test_unknown_name():
    with pytest.raises(ImportError, match="simulation"):
        from parisph import simulation  # noqa: F401
