"""PETSc options of the pressure solve: our defaults, and how the user's options win."""

from contextlib import contextmanager

from petsc4py import PETSc

from parisph.base.errors import CaseError

PREFIX = "pressure_"

# Krylov methods that take the preconditioner from the right, where the residual that the
# iteration watches is the true one.
_RIGHT = {"gmres", "fgmres", "lgmres", "dgmres", "pgmres", "gcr", "bcgs", "fbcgs", "bcgsl", "tfqmr"}

_KRYLOV = {"ksp_type": "gmres", "ksp_gmres_restart": "50", "ksp_max_it": "100"}

# Aggressive coarsening with extended+i interpolation: the cheapest BoomerAMG for these
# nonsymmetric M-like rows, iterations flat from 1e4 to 1e6 unknowns.
_AMG = {
    "pc_type": "hypre",
    "pc_hypre_type": "boomeramg",
    "pc_hypre_boomeramg_coarsen_type": "HMIS",
    "pc_hypre_boomeramg_interp_type": "ext+i",
    "pc_hypre_boomeramg_P_max": "4",
    "pc_hypre_boomeramg_agg_nl": "1",
    "pc_hypre_boomeramg_no_CF": None,
    "pc_hypre_boomeramg_strong_threshold": "0.25",
}

# Gaussian elimination on a singular coarsest level divides by rounding errors.
_AMG_CLOSED = {"pc_hypre_boomeramg_relax_type_coarse": "symmetric-SOR/Jacobi"}


def primary(rtol, closed):
    """Return our options of the first attempt, name without prefix -> value or None."""
    options = dict(_KRYLOV, ksp_rtol=repr(float(rtol)), **_AMG)
    if closed:
        options.update(_AMG_CLOSED)
    return options


@contextmanager
def defaults(prefix, options):
    """Put options into PETSc's database where the user has not, and take them out again.

    The database is global and limited (512 entries), so ours stay in it only while an
    object is being configured; what the user gave is never touched.
    """
    database = PETSc.Options(prefix)
    ours = [name for name in options if not database.hasName(name)]
    for name in ours:
        database.setValue(name, options[name])
    try:
        yield
    finally:
        for name in ours:
            database.delValue(name)


def right_side(ksp):
    """Precondition from the right where the method can and the user did not choose."""
    if ksp.getType() in _RIGHT and not PETSc.Options(ksp.getOptionsPrefix()).hasName("ksp_pc_side"):
        ksp.setPCSide(PETSc.PC.Side.RIGHT)


class UserOptions:
    """The options that the user gave after `--`, in PETSc's database until `withdraw`.

    Parameters
    ----------
    options : list of str or None
        As on a command line: ["-pressure_ksp_rtol", "1e-8", "-pressure_ksp_view"].

    Raises
    ------
    CaseError : a word that is neither an option nor its value, or a solver option without prefix.
    """

    def __init__(self, options=None):
        self.given = _parse(options or [])
        database = PETSc.Options()
        before = database.getAll()
        self._before = {name: before.get(name) for name in self.given}
        for name, value in self.given.items():
            database.setValue(name, value)

    def withdraw(self):
        """Give PETSc's database back as it was."""
        database = PETSc.Options()
        for name, value in self._before.items():
            if value is None:
                database.delValue(name)
            else:
                database.setValue(name, value)
        self._before = {}


def _parse(words):
    given = {}
    name = None
    for word in words:
        if _is_name(word):
            name = word[1:]
            if name.startswith(("ksp_", "pc_")):
                raise CaseError(f"option {word} has no effect: options of the pressure solve "
                                f"bear a prefix, write -{PREFIX}{name}")
            given[name] = None
        elif name is None or given[name] is not None:
            raise CaseError(f"'{word}' among the PETSc options is neither an option (-name) nor the value of one")
        else:
            given[name] = word
    return given


def _is_name(word):
    return len(word) > 1 and word[0] == "-" and not word[1].isdigit() and word[1] != "."
