"""The files of a run: probes, snapshots, checkpoints, reader, pictures."""

from parisph.base import libraries

libraries.require("h5py")    # says how to get it, where the import of a module in here would not
