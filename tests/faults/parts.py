"""The parts of the campaign, in their order. One module of this folder holds each of them."""

from tests.faults import (
    checkpoints,
    environment,
    folders,
    inputs,
    into,
    kills,
    near_spacing,
    one_rank,
    signals,
    snapshots,
    text_files,
)
from tests.faults.table import Part

PARTS: dict[str, Part] = {
    "inputs": Part("bad case files, stored cases, command lines, references, folders", 500, inputs.make),
    "near_spacing": Part("bodies and gaps near the spacing", 400, near_spacing.make),
    "kills": Part("ranks killed at random moments, then a restart", 100, kills.make),
    "checkpoints": Part("damaged checkpoints", 300, checkpoints.make),
    "snapshots": Part("damaged snapshots", 300, snapshots.make),
    "text_files": Part("damaged CSV and JSON files", 60, text_files.make),
    "report_into": Part("report --into any file, kept or refused", 60, into.make),
    "signals": Part("two signals within 50 ms to one of 2 ranks or both", 100, signals.make),
    "one_rank": Part("a fault in a step or between two on one of 2 ranks", 40, one_rank.make),
    "folders": Part("full disk, files removed, no permission, while running", 42, folders.make),
    "environment": Part("variables, limits and users that a process may meet", 120, environment.make),
}
