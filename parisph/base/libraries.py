"""Libraries that parisph can be installed without, and how to install them.

Checking a case and looking at a run need neither MPI nor PETSc, so a laptop can do without them.
"""

from importlib import import_module

from parisph.base.errors import MissingLibrary

ENGINE = ("mpi4py.MPI", "petsc4py", "h5py")    # what a run needs

_SETUP = ("run_scripts/setup in a clone of parisph (on Debian, or on a cluster with its modules loaded), "
          "or conda install -c conda-forge mpi4py petsc4py h5py")
_REMEDIES = {
    ENGINE: f"to run cases, use {_SETUP}",
    ("h5py",): f"to look at runs, pip install 'parisph[look]'; to run cases too, use {_SETUP}",
    ("matplotlib",): "to make pictures, pip install 'parisph[plot]'",
    ("shtab",): "to complete commands in a shell, pip install 'parisph[completion]'",
}


def require(*names: str) -> None:
    """Import libraries, given by the names of modules. Not collective.

    names : ENGINE, or a library in `_REMEDIES`

    Raises
    ------
    MissingLibrary : says in one line which ones cannot be imported, and how to install them
    """
    absent, broken = [], []
    for name in names:
        library = name.partition(".")[0]
        try:
            import_module(name)
        except (ImportError, RuntimeError) as error:    # RuntimeError: mpi4py finds no MPI library
            if isinstance(error, ModuleNotFoundError) and (error.name or library).partition(".")[0] == library:
                absent.append(library)
            else:
                broken.append(f"{library} cannot be loaded ({str(error).splitlines()[0]})")
    if absent:
        broken.insert(0, f"{' and '.join(absent)} {'are' if len(absent) > 1 else 'is'} not installed")
    if broken:
        raise MissingLibrary(f"{', '.join(broken)}: {_REMEDIES[names]}")
