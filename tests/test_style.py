"""Rules of style that a tool checks: see [tool.ruff] and [tool.mypy] in pyproject.toml."""

import subprocess
import sys

from tests.launch import ROOT


def said(*words):
    """Return what a Python tool prints about the clone if it finds a fault, else nothing."""
    done = subprocess.run([sys.executable, "-m", *words], cwd=ROOT, capture_output=True, text=True, timeout=300)
    return "" if done.returncode == 0 else done.stdout + done.stderr


def test_ruff_finds_no_fault():
    assert said("ruff", "check", "--no-cache", "parisph", "tests", "cases", "run_scripts") == ""


def test_mypy_finds_no_fault(tmp_path):
    assert said("mypy", "--no-error-summary", "--cache-dir", str(tmp_path)) == ""
