"""Settings for all tests: one thread a rank, parallel h5py. Before anything imports numpy."""

from parisph.base import environment

environment.prepare()
