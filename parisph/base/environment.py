"""Environment variables that a process of parisph needs, and how a launcher is recognised.

Nothing here imports MPI or numpy: it runs before both.
"""

import os
from pathlib import Path

# One thread a rank: ranks fill the cores, and threads on top of them only compete.
THREADS = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")

# Settings of Open MPI for ranks that share one machine, where there may be more ranks than
# cores and other jobs beside them. Other MPI libraries ignore them. They are the same as in
# run_scripts/env.
ONE_MACHINE = {
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_mpi_yield_when_idle": "1",
    "OMPI_MCA_hwloc_base_binding_policy": "none",
}
AS_ROOT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
LOOPBACK = {"OMPI_MCA_oob_tcp_if_include": "127.0.0.0/8", "OMPI_MCA_btl_tcp_if_include": "127.0.0.0/8"}

# (rank, size) as the launchers of Open MPI, MPICH and its kin, PMIx and Slurm's srun name them.
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


def prepare(environ=os.environ):
    """Set, where the user has not, what must stand before numpy, numba, BLAS and h5py load.

    Changes `environ` in place: one thread a rank, and Debian's h5py in its parallel build,
    which it otherwise takes only under mpirun.
    """
    for name in THREADS:
        environ.setdefault(name, "1")
    environ.setdefault("H5PY_ALWAYS_USE_MPI", "1")


def cache_folder(environ=os.environ) -> Path:
    """Return the folder where parisph may keep what can be made again: XDG_CACHE_HOME/parisph, or ~/.cache/parisph."""
    return Path(environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser()) / "parisph"


def launched(environ=os.environ):
    """Return (rank, size) as the launcher of this process set them; (0, 1) without a launcher."""
    for rank, size in _LAUNCHERS:
        if rank in environ and size in environ:
            return int(environ[rank]), int(environ[size])
    return 0, 1


def for_launching(environ=os.environ):
    """Return a copy of `environ` in which `mpirun` can start ranks on this one machine.

    Variables that an outer mpirun left are taken out, because a nested one fails on them, and
    those of a batch job, because this machine is meant alone. Settings of the user win, except
    that ranks talk over loopback only.
    """
    clean = {name: value for name, value in environ.items()
             if not name.startswith(_OF_A_LAUNCHER + _OF_A_BATCH_JOB)}
    settings = dict(ONE_MACHINE)
    if hasattr(os, "geteuid") and os.geteuid() == 0:
        settings.update(AS_ROOT)
    for name, value in settings.items():
        clean.setdefault(name, value)
    clean.update(LOOPBACK)
    prepare(clean)
    return clean
