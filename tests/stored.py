"""Runs that are written without being computed, for tests of what reads them."""

from mpi4py import MPI

from parisph.case.stored import to_json
from parisph.io.reader import open_run
from parisph.io.store import Store


def stored(folder, case, series, samples, snapshots=(), summary=None):
    """Write the folder of a run, and return its Run.

    series : {name: columns with units}; samples : list of (time [s], step, {name: values})
    snapshots : list of (particles, time [s], step), with velocities and pressures; summary : dict, None without one
    """
    store = Store.create(MPI.COMM_SELF, folder, to_json(case), fields=("u", "p"))
    for name, columns in series.items():
        store.add_series(name, columns)
    for sample in samples:
        store.append(*sample)
    for snapshot in snapshots:
        store.snapshot(*snapshot)
    if summary is not None:
        store.summary(summary)
    store.close()
    return open_run(folder)
