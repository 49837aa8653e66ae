"""What comparisons with a truth use of a run. io.reader.Run, which stands above, has it."""

from pathlib import Path
from typing import Protocol

import numpy as np


class Recorded(Protocol):
    """A run whose probes can be read."""

    folder: Path
    probe_names: list[str]

    def probe(self, name: str) -> np.ndarray:
        """Return the series of a probe, a structured array (samples,) with the columns `time`, `step` and its own."""

    def units(self, name: str) -> dict[str, str]:
        """Return {column: unit} of a probe."""
