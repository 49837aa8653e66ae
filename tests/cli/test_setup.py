"""run_scripts/setup knows when there is nothing to do."""

import configparser
import shutil
import subprocess
import sys
from urllib.parse import urlparse
from urllib.request import url2pathname

import numpy as np
import pytest

from tests.launch import ROOT, clean_environment


@pytest.fixture
def clone(tmp_path):
    """A clone with an environment that is up to date; `packages` stands for its site-packages."""
    clone = tmp_path / "a clone"
    (clone / ".venv" / "bin").mkdir(parents=True)
    shutil.copy(ROOT / "pyproject.toml", clone)
    (clone / "run_scripts").mkdir()
    text = (ROOT / "run_scripts" / "setup").read_text(encoding="utf-8")
    assert text.endswith("\nmain\n")
    (clone / "run_scripts" / "setup").write_text(text.removesuffix("main\n") + 'eval "$1"\n')
    python = clone / ".venv" / "bin" / "python"
    python.write_text(f'#!/bin/sh\n[ "$2" != pip ] || {{ echo "$@"; exit; }}\nexec "{sys.executable}" "$@"\n')
    python.chmod(0o755)
    (clone / ".venv" / "constraints.txt").write_text(f"numpy=={np.__version__}\n")
    (clone / ".venv" / "pip.conf").touch()
    for folder in (clone, tmp_path / "packages"):
        (folder / "parisph").mkdir(parents=True)
        (folder / "parisph" / "__init__.py").touch()
    (tmp_path / "packages" / "shtab.py").touch()
    return clone


READY = 'fingerprint python3 >"$stamp"; ready python3'


@pytest.mark.parametrize(("first", "code"), [("a clone", 0), ("packages", 1)])
def test_it_is_ready_only_while_parisph_is_that_of_the_clone(clone, first, code):
    """`pip install .` puts a copy in place of the clone, which later changes would not reach."""
    path = ":".join(str(clone.parent / name) for name in dict.fromkeys((first, "packages")))
    assert do(clone, READY, path).returncode == code


def do(clone, what, path=None):
    """Carry out a part of the script; return CompletedProcess."""
    path = path or f"{clone}:{clone.parent / 'packages'}"
    return subprocess.run(["bash", "run_scripts/setup", what], cwd=clone, timeout=60, capture_output=True, text=True,
                          env={**clean_environment(), "PYTHONPATH": f"{path}:{clean_environment()['PYTHONPATH']}"})


@pytest.mark.parametrize("file", ["constraints.txt", "pip.conf"])
def test_it_is_not_ready_once_numpy_has_been_replaced(clone, file):
    """`pip install` of something else brings its own, which petsc4py and h5py were not compiled for."""
    if file == "pip.conf":
        (clone / ".venv" / file).unlink()
    else:
        (clone / ".venv" / file).write_text("numpy==0.0\n")
    assert do(clone, READY).returncode == 1


def test_pip_in_the_environment_keeps_to_the_versions_of_the_machine(clone):
    """And what is in front of them is removed, and installed again what was installed for it."""
    (clone / ".venv" / "pip.conf").write_text("[global]\nindex-url = https://mirror/%20simple\n")
    (clone / ".venv" / "lib" / "python3" / "site-packages" / "numpy-99.0.dist-info").mkdir(parents=True)
    done = do(clone, f'log="$root/log" unfit=; keep_versions "{sys.executable}" ""; cat "$log"')
    assert done.returncode == 0 and done.stdout.endswith("-m pip uninstall --yes numpy\n"), done.stderr
    assert f"numpy=={np.__version__}\n" in (clone / ".venv" / "constraints.txt").read_text()
    conf = configparser.RawConfigParser()    # as pip does
    conf.read(clone / ".venv" / "pip.conf")
    address = conf["global"]["constraint"]    # pip would take a path with blanks for two
    assert conf["global"]["index-url"] == "https://mirror/%20simple"
    assert url2pathname(urlparse(address).path) == str(clone / ".venv" / "constraints.txt") and " " not in address
