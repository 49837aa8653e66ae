"""parisph: MPI-parallel incompressible SPH for violent water waves."""

__version__ = "0.1.0"
