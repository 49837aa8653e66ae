"""A few attempts of each part of the fault campaign; `python -m tests.faults` makes all of them."""

import numpy as np
import pytest

from tests.faults.parts import PARTS

# Enough to see that a part works and that nothing obvious misbehaves, and quick.
FEW = {"inputs": 30, "near_spacing": 24, "kills": 1, "checkpoints": 15, "snapshots": 15, "text_files": 10,
       "report_into": 12, "signals": 1, "one_rank": 1, "folders": 2, "environment": 2}


@pytest.mark.parametrize("name", PARTS)
def test_a_few_attempts(tmp_path, name):
    count = FEW.get(name, 3)
    found = list(PARTS[name].make(count, np.random.default_rng(1), tmp_path))
    assert len(found) == count
    assert [line for line in found if line is not None] == []
