"""run_scripts/setup knows when there is nothing to do."""

import shutil
import subprocess
import sys

import pytest

from tests.launch import ROOT, clean_environment


@pytest.fixture
def clone(tmp_path):
    """A clone with an environment that is up to date; `packages` stands for its site-packages."""
    clone = tmp_path / "clone"
    (clone / ".venv" / "bin").mkdir(parents=True)
    shutil.copy(ROOT / "pyproject.toml", clone)
    (clone / "run_scripts").mkdir()
    text = (ROOT / "run_scripts" / "setup").read_text(encoding="utf-8")
    assert text.endswith("\nmain\n")
    (clone / "run_scripts" / "setup").write_text(text.removesuffix("main\n") + 'fingerprint python3 >"$stamp"\n'
                                                                               'ready python3\n')
    python = clone / ".venv" / "bin" / "python"
    python.write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
    python.chmod(0o755)
    for folder in (clone, tmp_path / "packages"):
        (folder / "parisph").mkdir(parents=True)
        (folder / "parisph" / "__init__.py").touch()
    (tmp_path / "packages" / "shtab.py").touch()
    return clone


@pytest.mark.parametrize(("first", "code"), [("clone", 0), ("packages", 1)])
def test_it_is_ready_only_while_parisph_is_that_of_the_clone(clone, first, code):
    """`pip install .` puts a copy in place of the clone, which later changes would not reach."""
    path = ":".join(str(clone.parent / name) for name in dict.fromkeys((first, "packages")))
    done = subprocess.run(["bash", "run_scripts/setup"], cwd=clone, timeout=60,
                          env={**clean_environment(), "PYTHONPATH": f"{path}:{clean_environment()['PYTHONPATH']}"})
    assert done.returncode == code
