"""The files of a run: probes, snapshots, checkpoints, reader, pictures."""

from parisph.base import libraries

libraries.require("h5py")    # its error says how to install it
