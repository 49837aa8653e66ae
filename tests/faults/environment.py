"""Variables and limits of a process: parisph works, or says in one line what is wrong with them."""

import os
import resource
import shutil
import subprocess
import sys

from tests.faults import damage
from tests.launch import clean_environment
from tests.others import UNKNOWN, become, open_folder

SECONDS = 300.0    # where no kernels are found or kept, all are compiled
VALUES = ("", "0", "x", "-1", "1e9", " ", "\xe4", "7" * 300, "/proc/nothing", "/proc", "/dev/null", "relative", "1,2",
          "\x1b[1m", "nonsense:x", "1 2", "0x1")
# Variables that are read, in groups that belong together. With valid values of others, numba compiles all again.
VARIABLES = (
    ("NUMBA_NUM_THREADS",), ("OMP_NUM_THREADS",), ("OPENBLAS_NUM_THREADS",), ("MKL_NUM_THREADS",),
    ("OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"), ("PMI_RANK", "PMI_SIZE"),
    ("SLURM_PROCID", "SLURM_STEP_NUM_TASKS"), ("OMPI_COMM_WORLD_RANK",), ("SLURM_PROCID",), ("MPLBACKEND",),
    ("TMPDIR",), ("HOME",), ("XDG_CACHE_HOME",), ("MPLCONFIGDIR",), ("LANG",), ("LC_ALL",), ("NO_COLOR",), ("COLUMNS",),
    ("LINES",), ("TERM",), ("HOME", "TMPDIR"), ("HOME", "XDG_CACHE_HOME", "TMPDIR"), ("TZ",),
)
READ = ("NUMBA_OPT", "NUMBA_DISABLE_JIT", "NUMBA_DEBUG_CACHE")    # by numba, which must not get valid values
LIMITS = {"ulimit -n": (resource.RLIMIT_NOFILE, 5, 63), "ulimit -v": (resource.RLIMIT_AS, 100 * 10**6, 639 * 10**6),
          "ulimit -u": (resource.RLIMIT_NPROC, 0, 1)}
VERBS = (["check", "case.py"], ["info", "SOUND"], ["plot", "SOUND", "-o", "plot.png"],
         ["run", "case.py", "-q", "-o", "run"])


def make(count, random, folder):
    """See table.Part. Another user may not enter the folder that is given, so this has one of its own."""
    with open_folder() as own:
        yield from _make(count, random, own)


def _make(count, random, folder):
    damage.sound_run(folder)
    for attempt in range(count):
        place = folder / str(attempt)
        place.mkdir()
        shutil.copy(folder / "case.py", place)
        words = [word.replace("SOUND", str(folder / "sound")) for word in VERBS[int(random.integers(len(VERBS)))]]
        kind = (_variables, _variables, _variables, _limits, _unknown)[attempt % 5]
        settings, before, says = kind(random, place)
        yield _judge(f"{settings} {says}: {words[0]}", *_run(words, place, settings, before), says)
        shutil.rmtree(place, ignore_errors=True)


def _variables(random, place):
    """Return the settings, None, and what a message must have one of."""
    if random.random() < 0.1:
        name = str(random.choice(READ))
        return {name: "x" * int(random.integers(1, 40))}, None, [name]
    names = VARIABLES[int(random.integers(len(VARIABLES)))]
    return {name: str(random.choice(VALUES)) for name in names}, None, names


def _limits(random, place):
    name = str(random.choice(list(LIMITS)))
    which, least, most = LIMITS[name]
    limit = int(random.integers(least, most + 1))
    known = name == "ulimit -u"    # which does not hold for root

    def restrict():
        if known and os.geteuid() == 0:
            become(UNKNOWN)
        resource.setrlimit(which, (limit, limit))
    _give_to_all(place)
    return {"TMPDIR": str(place), "HOME": str(place)} if known else {}, restrict, [name]


def _unknown(random, place):
    """A user without an entry and without HOME, and perhaps without a folder that can be written."""
    _give_to_all(place)
    settings = {"HOME": None, "TMPDIR": str(random.choice([str(place), "", "/proc"]))}
    return settings, (lambda: become(UNKNOWN)) if os.geteuid() == 0 else None, ["HOME", "TMPDIR"]


def _give_to_all(place):
    place.chmod(0o777)


def _run(words, place, settings, before):
    variables = clean_environment(**{name: value for name, value in settings.items() if value is not None})
    for name in (name for name, value in settings.items() if value is None):
        variables.pop(name, None)
    try:
        done = subprocess.run([sys.executable, "-m", "parisph", *words], cwd=place, env=variables, preexec_fn=before,
                              capture_output=True, text=True, errors="replace", timeout=SECONDS,
                              stdin=subprocess.DEVNULL)
    except subprocess.TimeoutExpired:
        return None, "", f"no end after {SECONDS:g} s"
    return done.returncode, done.stdout, done.stderr


def _judge(what, code, out, said, says):
    """Return None if parisph worked, or has said what is wrong in one line that does not blame the case."""
    if code == 0 and "Traceback" not in said and "parisph: error" not in said:
        return None
    lines = said.strip().split("\n")
    right = (code in (1, 2) and len(lines) == 1 and lines[0].startswith("parisph: error: ") and not out.strip()
             and "case.py" not in said and "a fault in parisph" not in said and any(word in said for word in says))
    return None if right else f"{what}: exit code {code}: {said[-700:]!r}"
