"""Rules of style that a tool checks: see [tool.ruff] in pyproject.toml."""

import subprocess
import sys

from tests.launch import ROOT


def test_ruff_finds_no_fault():
    done = subprocess.run([sys.executable, "-m", "ruff", "check", "--no-cache", "parisph", "tests", "cases", "run_scripts"],
                          cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
