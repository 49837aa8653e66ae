"""Environment variables that parisph needs, and how a launcher is recognised. Runs before MPI and numpy are loaded."""

import os
import tempfile
from collections.abc import Mapping, MutableMapping
from contextlib import suppress
from pathlib import Path

from parisph.base.errors import BadEnvironment
from parisph.base.text import shown

# One thread per rank: the ranks use all cores, and more threads would compete with them.
THREADS = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")

# Settings of Open MPI for ranks on one machine, which may have fewer cores than ranks, and other jobs. Other MPI
# libraries ignore them. run_scripts/env has the same ones.
ONE_MACHINE = {
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_mpi_yield_when_idle": "1",
    "OMPI_MCA_hwloc_base_binding_policy": "none",
}
AS_ROOT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
# Keeps Open MPI without a launcher from starting a daemon, which takes 0.1 s and only MPI_Comm_spawn needs.
ALONE = {"OMPI_MCA_ess_singleton_isolated": "1"}
LOOPBACK = {"OMPI_MCA_oob_tcp_if_include": "127.0.0.0/8", "OMPI_MCA_btl_tcp_if_include": "127.0.0.0/8"}

# Names of (rank, size) in the environment: Open MPI, MPICH and libraries built on it, Slurm's srun.
_LAUNCHERS = (
    ("OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"),
    ("PMI_RANK", "PMI_SIZE"),
    ("SLURM_PROCID", "SLURM_STEP_NUM_TASKS"),
)
_OF_A_LAUNCHER = ("OMPI_COMM_", "OMPI_FILE_", "OMPI_MCA_ess", "OMPI_MCA_orte", "OMPI_MCA_pmix",
                  "OMPI_MCA_shmem", "OMPI_MCA_initial_wdir", "OMPI_MCA_mpi_oversubscribe",
                  "OMPI_APP", "OMPI_NUM_APP", "OMPI_FIRST_RANKS", "OMPI_COMMAND", "OMPI_ARGV",
                  "OMPI_UNIVERSE", "PMI_", "PMIX_", "PRTE_", "MPI_LOCALRANKID", "MPI_LOCALNRANKS",
                  "HYDI_", "HYDRA_")
# Inside a batch job mpirun would start its daemons on the nodes of the job.
_OF_A_BATCH_JOB = ("SLURM_", "PBS_", "LSB_", "LSF_", "JOB_ID", "PE_HOSTFILE")


def prepare(environ: MutableMapping[str, str] = os.environ) -> None:
    """Set the variables that numpy, numba, BLAS, h5py and MPI read when they load.

    Changes `environ` in place: one thread per rank, and Debian's parallel build of h5py, which is otherwise used only
    under mpirun. Without a launcher, MPI starts no daemon and gets folders that it can use. The user's values stay.
    """
    _prepare_any(environ)
    with suppress(BadEnvironment):    # see `surroundings.check`
        if launched(environ)[1] == 1:
            for name, value in ALONE.items():
                environ.setdefault(name, value)
            _find_folders(environ)


def _prepare_any(environ: MutableMapping[str, str]) -> None:
    for name in THREADS:
        if not environ.get(name):
            environ[name] = "1"
    environ.setdefault("H5PY_ALWAYS_USE_MPI", "1")


def _find_folders(environ: MutableMapping[str, str]) -> None:
    """Set TMPDIR, which MPI uses, if its folder cannot be written, and HOME if there is no home folder.

    A user that the machine does not know, as in a container, has none.
    """
    with suppress(OSError):    # no folder can be written
        folder = tempfile.gettempdir()
        if folder != os.path.abspath(environ.get("TMPDIR") or "/tmp"):
            environ["TMPDIR"] = folder
        if not environ.get("HOME") and _home(environ) is None:
            environ["HOME"] = folder


def _home(environ: Mapping[str, str]) -> Path | None:
    if "HOME" in environ:
        return Path(environ["HOME"]) if environ["HOME"] else None
    try:
        return Path.home()
    except RuntimeError:    # the machine does not know this user
        return None


def cache_folder(environ: Mapping[str, str] = os.environ) -> Path:
    """Return the folder for files that can be made again: XDG_CACHE_HOME/parisph, or ~/.cache/parisph.

    Raises OSError where there is no home folder.
    """
    given = environ.get("XDG_CACHE_HOME", "")
    if os.path.isabs(given):    # the definition of this variable says to ignore any other path
        return Path(given) / "parisph"
    home = _home(environ)
    if home is None:
        raise FileNotFoundError("there is no home folder")
    return home / ".cache" / "parisph"


def launched(environ: Mapping[str, str] = os.environ) -> tuple[int, int]:
    """Return (rank, size) as set by the launcher of this process; (0, 1) without a launcher.

    Raises BadEnvironment: rank or size is not a valid number.
    """
    for names in _LAUNCHERS:
        rank, size = (environ.get(name, "") for name in names)
        if not rank or not size:
            continue
        if rank.isdecimal() and size.isdecimal() and int(rank) < int(size):
            return int(rank), int(size)
        raise BadEnvironment(
            f"the environment has {names[0]} = {shown(rank)} and {names[1]} = {shown(size)}, which must be the number "
            "of this process, from 0, and how many there are. mpirun or srun sets both: start parisph with it, or "
            f"unset {' '.join(names)}")
    return 0, 1


def is_first(environ: Mapping[str, str] = os.environ) -> bool:
    """Return whether this process is the first rank, or the only one, as far as its launcher says."""
    try:
        return launched(environ)[0] == 0
    except BadEnvironment:
        return True


def for_launching(environ: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Return a copy of `environ` in which `mpirun` can start ranks on this one machine.

    Removes the variables of an outer mpirun, with which a nested one would fail, and those of a batch job, which would
    start ranks on other nodes. Other settings of the user stay. Ranks communicate over the loopback interface.
    """
    clean = {name: value for name, value in environ.items()
             if not name.startswith(_OF_A_LAUNCHER + _OF_A_BATCH_JOB)}
    settings = dict(ONE_MACHINE)
    if hasattr(os, "geteuid") and os.geteuid() == 0:
        settings.update(AS_ROOT)
    for name, value in settings.items():
        clean.setdefault(name, value)
    clean.update(LOOPBACK)
    _prepare_any(clean)
    return clean


def for_own(environ: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Return `for_launching` with a PYTHONPATH that finds this parisph first, installed or not."""
    found, here = for_launching(environ), str(Path(__file__).resolve().parents[2])
    found["PYTHONPATH"] = os.pathsep.join(filter(None, [here, found.get("PYTHONPATH")]))
    return found
