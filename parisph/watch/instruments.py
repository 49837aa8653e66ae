"""The probes of a run, on particles that are distributed over ranks.

Call `samplers = build(case, comm)` once, then `sample_all(samplers, particles, domain, time)` for each sample. One
Allreduce adds the sums of all probes, and one Allgatherv collects their rows.
"""

from collections.abc import Sequence

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Floats
from parisph.base.communicator import Communicator
from parisph.base.errors import CaseError, agree
from parisph.base.probe_rows import WIDTH
from parisph.case.schema import Case
from parisph.parallel.domain import Domain
from parisph.parallel.particles import Particles
from parisph.watch.passages import Passages
from parisph.watch.sampling import ProbeScene, Sampler, View


def build(case: Case, comm: Communicator) -> list[Sampler]:
    """Return the samplers of the case's probes, in their order. Collective.

    Raises CaseError on every rank: a probe for 2D in a case in 3D.
    """
    error, samplers = None, []
    try:
        scene = ProbeScene.of(case)
        samplers = [Sampler(probe, scene) for probe in case.probes]
    except CaseError as problem:
        error = problem
    agree(comm, error)
    return samplers


def sample_all(samplers: Sequence[Sampler], particles: Particles, domain: Domain,
               time: float, passages: Passages | None = None) -> dict[str, tuple[float, ...]]:
    """Return {name of the probe: tuple of floats, in the order of its `columns`}, the same on all ranks. Collective.

    Fields of ghosts that a sampler needs are updated; nothing else changes. `domain` must have been refreshed since
    particles were assigned. A probe without anything to measure gives nan.

    time : of the particles [s]; passages : volumes that have passed lines, in a run
    """
    if not samplers:
        return {}
    stale = sorted({name for sampler in samplers for name in sampler.ghosts})
    if stale:
        domain.update(*stale)
    view = View(particles, domain, samplers[0].scene, time, passages)
    members = [member for sampler in samplers for member in sampler.members]
    sums = [np.asarray(member.measure.sums(view), float) for member in members]
    rows = [member.measure.rows(view) for member in members]
    if particles.comm.size > 1:
        sums, rows = _together(particles.comm, sums, rows)
    found = iter([member.values(own, others, view) for member, own, others in zip(members, sums, rows)])
    return {sampler.name: sum((next(found) for _ in sampler.members), ()) for sampler in samplers}


def _together(comm: MPI.Comm, sums: Sequence[Floats], rows: Sequence[Floats]) -> tuple[list[Floats], list[Floats]]:
    """Return the sums over all ranks (k,) and the rows of all ranks (n, WIDTH), of each sampler. Collective."""
    table = np.concatenate([np.column_stack([np.full(len(own), number, float), own])
                            for number, own in enumerate(rows)])
    ends = np.cumsum([len(own) for own in sums])
    # the sums are followed by the number of rows of each rank
    packed = np.concatenate([*sums, np.zeros(comm.size)])
    packed[ends[-1] + comm.rank] = len(table)
    comm.Allreduce(MPI.IN_PLACE, packed, op=MPI.SUM)
    counts = packed[ends[-1]:].astype(int)
    everyone = np.empty((counts.sum(), 1 + WIDTH))
    if len(everyone):
        comm.Allgatherv(table, [everyone, (1 + WIDTH) * counts])
    return (np.split(packed[:ends[-1]], ends[:-1]),
            [everyone[everyone[:, 0] == number, 1:] for number in range(len(rows))])
