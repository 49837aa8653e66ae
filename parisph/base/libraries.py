"""Optional libraries, and how to install them. Checking a case and looking at a run need neither MPI nor PETSc."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import Any

from parisph.base import surroundings
from parisph.base.errors import MissingLibrary

ENGINE = ("mpi4py.MPI", "petsc4py", "h5py")    # what a run needs

SURFACES = ("trimesh", "manifold3d", "pymeshlab")    # what files of triangles need

SETUP = ("run_scripts/setup in a clone of parisph (on Debian, or on a cluster with its modules loaded), "
         "or conda install -c conda-forge mpi4py petsc4py h5py")
_REMEDIES = {
    ENGINE: f"to run cases, use {SETUP}",
    ("h5py",): f"to look at runs, pip install 'parisph[look]'; to run cases too, use {SETUP}",
    ("matplotlib",): "to make pictures, pip install 'parisph[plot]'",
    ("pyvista",): "to render views of 3D flows, pip install 'parisph[render]'",
    SURFACES: "to read surfaces from files such as STL, pip install 'parisph[surfaces]'",
    ("shtab",): "to complete commands in a shell, pip install shtab",
}

# Files that a library reads from the current folder, and that can make it execute programs.
_CONFIGURATION = {"matplotlib": "matplotlibrc", "numba": ".numba_config.yaml"}

# What must be loaded before a library: pymeshlab brings an old libnghttp2, with which the libcurl of HDF5 lacks a
# function, and h5py cannot be loaded.
_AFTER = {"pymeshlab": "h5py"}


@contextmanager
def unconfigured(library: str) -> Iterator[None]:
    """Context that keeps an imported library from its configuration file in the current folder. Not collective.

    If there is such a file, the current folder is that of Python's library meanwhile.
    """
    if not os.path.lexists(_CONFIGURATION[library]):
        yield
        return
    here = os.getcwd()
    os.chdir(os.path.dirname(os.__file__))
    try:
        yield
    finally:
        os.chdir(here)


def require(*names: str) -> None:
    """Import libraries, given by the names of modules. Not collective.

    names : ENGINE, or a library in `_REMEDIES`

    Raises MissingLibrary : some cannot be imported; one line names them and says how to install them
    BadEnvironment : the machine or the environment does not let installed ones be loaded
    """
    absent, broken = [], []
    for name in names:
        library = name.partition(".")[0]
        try:
            _import(name)
        except Exception as error:    # RuntimeError: mpi4py finds no MPI library; ValueError: another numpy
            fault = surroundings.explained(error)
            if fault is not None:
                raise fault from error
            if isinstance(error, ModuleNotFoundError) and (error.name or library).partition(".")[0] == library:
                absent.append(library)
            else:
                broken.append(f"{library} cannot be loaded ({(str(error) or type(error).__name__).splitlines()[0]})")
    if absent:
        broken.insert(0, f"{' and '.join(absent)} {'are' if len(absent) > 1 else 'is'} not installed")
    if broken:
        raise MissingLibrary(f"{', '.join(broken)}: {_REMEDIES[names]}")


def loaded(name: str) -> Any:
    """Return the module of a library, loaded after the one that must come first. Not collective. Raises ImportError."""
    if name in _AFTER:
        with suppress(Exception):    # what is wrong with it is told where it is needed
            import_module(_AFTER[name])
    return import_module(name)


def _import(name: str) -> None:
    if name not in _CONFIGURATION:
        loaded(name)
        return
    if "MATPLOTLIBRC" in os.environ:    # the user's own file, relative to the current folder
        os.environ["MATPLOTLIBRC"] = os.path.abspath(os.environ["MATPLOTLIBRC"])
    with unconfigured(name):
        import_module(name)
