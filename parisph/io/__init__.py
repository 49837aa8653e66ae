"""The files of a run: time series, snapshots, checkpoints, and their reader."""

from parisph.base import libraries

libraries.require("h5py")    # its error says how to install it
