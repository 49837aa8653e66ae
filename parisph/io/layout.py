"""The names of what stands in the folder of a run.

    DIR/case.json                      the resolved case
    DIR/steps.csv                      one line a step
    DIR/probes/NAME.csv                one file a probe
    DIR/snapshots/NNNNNN.vtkhdf        the particles at one time
    DIR/flow.vtkhdf.series             the list of snapshots, to open in ParaView
    DIR/checkpoints/NNNNNNNN.h5        the last two; the number is that of the step
    DIR/summary.json                   at the end of the run, also of one that failed
    DIR/run.log                        the driver's log
"""

INDEX = "flow.vtkhdf.series"
FILES = ("case.json", "summary.json", "steps.csv", INDEX, "run.log")
FOLDERS = ("probes", "snapshots", "checkpoints")
