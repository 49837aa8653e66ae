"""The names of the files in the folder of a run.

    DIR/case.json                      the resolved case
    DIR/walls.h5                       the walls of a scene with Surfaces, as they were meshed
    DIR/steps.csv                      one line per step
    DIR/probes/NAME.csv                one file per probe
    DIR/snapshots/NNNNNN.vtkhdf        the particles at one time
    DIR/peaks/NAME.vtkhdf              the particles at the greatest value of a probe with peak=True
    DIR/peaks/before/NAME.vtkhdf       the same until the last checkpoint, if that value has been exceeded since
    DIR/flow.hdf.series                the list of snapshots, to open in ParaView
    DIR/checkpoints/NNNNNNNN.h5        the last two; the number is that of the step
    DIR/summary.json                   written at the end of the run, also if it failed
    DIR/run.log                        the log
    DIR/run.lock                       names the process that writes; removed at the end
    DIR/replaced/N/...                 files that a restart has replaced
"""

from pathlib import Path

from parisph.base.errors import StoreError
from parisph.base.paths import AnyPath
from parisph.base.text import named

INDEX = "flow.hdf.series"
WALLS = "walls.h5"
FILES = ("case.json", "summary.json", "steps.csv", INDEX, "run.log", WALLS)
FOLDERS = ("probes", "snapshots", "checkpoints")
PEAKS, BEFORE = "peaks", "peaks/before"     # made for their first file
REPLACED = "replaced"


def run_of(path: AnyPath) -> Path:
    """Return the folder (pathlib.Path) of the run of a checkpoint file; any other path is returned unchanged.

    The folder is relative if it is inside the current one. Raises StoreError for a missing checkpoint. Not collective.
    """
    path = Path(path)
    if path.suffix == ".h5" and not path.exists():
        raise StoreError(f"there is no checkpoint {named(path)}")
    if not path.is_file():
        return path
    folder, here = path.resolve().parent.parent, Path.cwd()
    return folder.relative_to(here) if folder.is_relative_to(here) else folder
