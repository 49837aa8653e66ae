"""The parts of the campaign, in their order. One module of this folder holds each of them."""

from importlib import import_module

from tests.faults.table import Part


def _part(module: str, what: str, attempts: int) -> Part:
    return Part(what, attempts, import_module(f"tests.faults.{module}").make)


PARTS: dict[str, Part] = {
    "inputs": _part("inputs", "bad case files, stored cases, command lines, references, folders", 500),
    "near_spacing": _part("near_spacing", "bodies and gaps near the spacing", 400),
    "kills": _part("kills", "ranks killed at random moments, then a restart", 100),
    "checkpoints": _part("checkpoints", "damaged checkpoints", 300),
    "snapshots": _part("snapshots", "damaged snapshots", 300),
    "text_files": _part("text_files", "damaged CSV and JSON files", 60),
    "report_into": _part("into", "report --into any file, kept or refused", 60),
    "signals": _part("signals", "two signals within 50 ms to one of 2 ranks or both", 100),
    "one_rank": _part("one_rank", "a fault in a step or between two on one of 2 ranks", 40),
    "folders": _part("folders", "full disk, files removed, no permission, while running", 42),
    "environment": _part("environment", "variables, limits and users that a process may meet", 120),
}
