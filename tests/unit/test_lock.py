"""One process at a time writes into the folder of a run."""

import fcntl
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import threading
import time
from contextlib import ExitStack

import pytest

from parisph.base.errors import StoreError
from parisph.io import lock
from parisph.io.lock import Lock
from tests.launch import clean_environment

HOLDER = """
import sys, time
from parisph.io.lock import Lock
held = Lock(sys.argv[1])
print("held", flush=True)
time.sleep(60)
"""


@pytest.fixture
def holder(tmp_path):
    """Another process that has the lock of the folder."""
    process = subprocess.Popen([sys.executable, "-c", HOLDER, str(tmp_path)], env=clean_environment(),
                               stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "held\n"
    yield process
    process.kill()
    process.wait()
    process.stdout.close()


def test_the_lock_is_gone_when_it_is_given_back(tmp_path):
    held = Lock(tmp_path)
    with pytest.raises(StoreError, match=f"in use by process {os.getpid()} .*still runs: wait"):
        Lock(tmp_path)
    held.release()
    assert not list(tmp_path.iterdir())
    Lock(tmp_path).release()


def test_a_process_that_runs_keeps_its_lock_even_against_force(tmp_path, holder):
    for force in (False, True):
        with pytest.raises(StoreError, match=f"process {holder.pid} .*still runs"):
            Lock(tmp_path, force)


@pytest.mark.parametrize("reaped", [False, True])
def test_the_lock_of_a_killed_process_is_taken_over(tmp_path, holder, reaped):
    os.kill(holder.pid, signal.SIGKILL)
    if reaped:
        holder.wait()
    else:
        os.waitid(os.P_PID, holder.pid, os.WEXITED | os.WNOWAIT)    # it is a zombie now
    Lock(tmp_path).release()
    assert not list(tmp_path.iterdir())


def change(folder, **values):
    path = folder / lock.NAME
    path.write_text(json.dumps({**json.loads(path.read_text()), **values}))


@pytest.mark.parametrize("values", [{"began": "1"}, {"host": f"{lock._host().partition(' ')[0]} 0-0"}])
def test_another_process_of_that_number_and_a_restart_of_the_host_are_no_sign_of_life(tmp_path, holder, values):
    change(tmp_path, **values)
    Lock(tmp_path).release()


@pytest.mark.parametrize("content", [{"host": "elsewhere 1-2", "process": 1}, {}, {"host": 7, "process": "x"}])
def test_what_cannot_be_seen_from_here_is_left_to_the_user(tmp_path, content):
    (tmp_path / lock.NAME).write_text(json.dumps(content) if content else "")
    os.utime(tmp_path / lock.NAME, (time.time() - 600, time.time() - 600))
    with pytest.raises(StoreError, match="last sign of life was 10 min ago, .* repeat the command with --force"):
        Lock(tmp_path)
    held = Lock(tmp_path, force=True)
    assert str(os.getpid()) in (tmp_path / lock.NAME).read_text()
    held.release()


def test_the_lock_of_a_living_process_in_another_container_is_kept(tmp_path):
    """There it has a number that means another process here, or none."""
    alone = ["unshare", "--pid", "--fork", "--mount-proc"]
    if shutil.which("unshare") is None or subprocess.run([*alone, "true"], capture_output=True).returncode:
        pytest.skip("no PID namespace can be made here")
    process = subprocess.Popen([*alone, "--kill-child", sys.executable, "-c", HOLDER, str(tmp_path)],
                               env=clean_environment(), stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout.readline() == "held\n"
        before = (tmp_path / lock.NAME).read_bytes()
        with pytest.raises(StoreError,
                           match="cannot be seen from here .*, in another container.* repeat the command with --force"):
            Lock(tmp_path)
        assert (tmp_path / lock.NAME).read_bytes() == before
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


@pytest.mark.parametrize("processes", ["pid:[1]", None])
def test_in_another_numbering_of_processes_a_number_says_nothing(tmp_path, holder, processes):
    change(tmp_path, processes=processes, process=2**22 + 1)    # no process here has this number
    with pytest.raises(StoreError, match="cannot be seen from here"):
        Lock(tmp_path)
    Lock(tmp_path, force=True).release()


def test_a_lock_that_cannot_be_written_is_not_left_behind(tmp_path):
    """A real refusal by the kernel, as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, hard))
    try:
        with pytest.raises(OSError, match="File too large"):
            Lock(tmp_path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert not list(tmp_path.iterdir())
    Lock(tmp_path).release()


def test_who_has_lost_the_lock_stops(tmp_path, monkeypatch):
    monkeypatch.setattr(lock, "BEAT", 0.0)
    held = Lock(tmp_path)
    os.utime(tmp_path / lock.NAME, (1.0, 1.0))
    held.check()
    assert time.time() - (tmp_path / lock.NAME).stat().st_mtime < 60.0
    change(tmp_path, token="other")
    with pytest.raises(StoreError, match="taken from this process with --force"):
        held.check()
    held.release()
    assert (tmp_path / lock.NAME).exists()    # of the other
    (tmp_path / lock.NAME).unlink()
    with pytest.raises(StoreError, match="removed or moved the folder"):
        held.check()


def test_a_link_is_not_followed(tmp_path):
    (tmp_path / "target").write_text("mine")
    (tmp_path / lock.NAME).symlink_to(tmp_path / "target")
    with pytest.raises(StoreError):
        Lock(tmp_path, force=True)
    assert (tmp_path / "target").read_text() == "mine"


RACE = """
import sys
from parisph.base.errors import StoreError
from parisph.io.lock import Lock
print("ready", flush=True)
sys.stdin.readline()
try:
    held = Lock(sys.argv[1])
    print("taken", flush=True)
except StoreError:
    print("refused", flush=True)
sys.stdin.readline()    # who has it lives until all have tried
"""


def test_a_process_waits_while_another_looks_at_the_lock(tmp_path):
    """Between reading a stale lock and removing it, nobody else takes it."""
    looks = os.open(tmp_path, os.O_RDONLY)
    fcntl.flock(looks, fcntl.LOCK_EX)
    late = threading.Thread(target=lambda: Lock(tmp_path))
    late.start()
    late.join(0.3)
    assert late.is_alive() and not list(tmp_path.iterdir())
    os.close(looks)
    late.join(10.0)
    assert (tmp_path / lock.NAME).exists()


def test_of_several_processes_that_find_a_stale_lock_one_takes_it(tmp_path, holder):
    os.kill(holder.pid, signal.SIGKILL)
    holder.wait()
    with ExitStack() as ends:
        racers = [ends.enter_context(subprocess.Popen([sys.executable, "-c", RACE, str(tmp_path)], text=True,
                                                      env=clean_environment(), stdin=subprocess.PIPE,
                                                      stdout=subprocess.PIPE)) for _ in range(4)]
        assert [racer.stdout.readline() for racer in racers] == ["ready\n"] * 4
        for racer in racers:
            racer.stdin.write("go\n")
            racer.stdin.flush()
        said = sorted(racer.stdout.readline() for racer in racers)
    assert said == ["refused\n", "refused\n", "refused\n", "taken\n"]
