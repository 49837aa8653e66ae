"""Another user of this machine, as whom root can run a command, and a folder that all users may enter."""

import os
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.launch import ROOT

NOBODY, UNKNOWN = 65534, 12345    # one without a home, and one that the machine does not know


@contextmanager
def open_folder():
    """Yield a new folder that all users may enter; those of pytest are for their owner alone."""
    with tempfile.TemporaryDirectory(prefix="parisph-open-", ignore_cleanup_errors=True) as name:
        os.chmod(name, 0o755)
        yield Path(name)


def as_user(number):
    """Return what subprocess.run needs to be another user; skip the test where that, or to read this clone, fails."""
    if os.geteuid() != 0:
        pytest.skip("only root can become another user")
    user = {"user": number, "group": number, "extra_groups": []}
    try:
        subprocess.run([sys.executable, "-c", f"open({str(ROOT / 'pyproject.toml')!r})"], cwd="/", check=True,
                       capture_output=True, **user)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("another user cannot read this clone or the libraries")
    return user


def become(user):
    """Become another user, for good."""
    os.setgroups([])
    os.setgid(user)
    os.setuid(user)
