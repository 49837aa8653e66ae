"""The names of what stands in the folder of a run.

    DIR/case.json                      the resolved case
    DIR/steps.csv                      one line a step
    DIR/probes/NAME.csv                one file a probe
    DIR/snapshots/NNNNNN.vtkhdf        the particles at one time
    DIR/flow.hdf.series                the list of snapshots, to open in ParaView
    DIR/checkpoints/NNNNNNNN.h5        the last two; the number is that of the step
    DIR/summary.json                   at the end of the run, also of one that failed
    DIR/run.log                        the driver's log
    DIR/run.lock                       who writes into the folder; gone at the end
    DIR/replaced/N/...                 what a restart has replaced, by its old name
"""

from pathlib import Path

INDEX = "flow.hdf.series"
FILES = ("case.json", "summary.json", "steps.csv", INDEX, "run.log")
FOLDERS = ("probes", "snapshots", "checkpoints")
REPLACED = "replaced"


def run_of(path):
    """Return the folder (pathlib.Path) of the run that a checkpoint file is in; of any other path, the path itself.

    It is relative where it lies in the current folder, so that messages name it as users do. Not collective.
    """
    path = Path(path)
    if not path.is_file():
        return path
    folder, here = path.resolve().parent.parent, Path.cwd()
    return folder.relative_to(here) if folder.is_relative_to(here) else folder
