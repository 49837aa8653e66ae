"""Ways to damage a file, and small runs whose files are damaged."""

import shutil

from parisph.kernels import jit
from tests.faults.dam import dam
from tests.launch import mpirun, parisph
from tests.scenes import run_alone

BLOCK = 512    # what a disk loses at once

CASE = """
from tests.faults.damage import case
"""


def case(density: float = 1000.0):
    """A column that begins to fall: four steps, snapshots and checkpoints at every other one."""
    return dam(spacing=0.1).changed(**{
        "end_time": 0.02, "numerics.time_step": 0.005, "fluid.density": density,
        "output.every": 0.02, "output.times": (), "output.checkpoint_every": 0.01})


def two_runs(folder, ranks):
    """Make two runs that differ in nothing that a name or a time could tell, and return their folders.

    ranks : 1 for this process, which is quick, or more for mpirun
    """
    made = []
    for name, density in (("run", 1000.0), ("other", 900.0)):
        made.append(folder / name)
        if ranks == 1:
            run_alone(case(density), made[-1])
            continue
        (folder / "case.py").write_text(CASE)
        done = mpirun(ranks, ["-m", "parisph", "run", folder / "case.py", "-q", "-o", made[-1], "--set",
                              f"density={density}"],
                      timeout=240)
        assert done.returncode == 0, done.stderr
    return made


def sound_run(folder):
    """Write case.py into a folder and make the run `sound` of it."""
    (folder / "case.py").write_text(CASE)
    done = parisph("run", "case.py", "-o", "sound", "-q", timeout=300, cwd=folder)
    if done.returncode != 0:
        raise RuntimeError(f"no sound run: {done.stderr}")


def copy_kernels(folder):
    """Make a folder with the compiled kernels of this machine, but for what another process writes at the moment."""
    folder.mkdir()
    if jit.FOLDERS.write is not None and jit.FOLDERS.write.exists():
        shutil.copytree(jit.FOLDERS.write, folder / jit.FOLDERS.write.name, ignore=shutil.ignore_patterns("*.tmp"))


def damaged(kind, content, others, random):
    """Return `content` damaged in one way of KINDS; never what it was.

    content : bytes of the file; others : bytes of files of the same form that may take its place
    random : numpy.random.Generator
    """
    while True:
        changed = bytes(KINDS[kind](bytearray(content), others, random))
        if changed != content:
            return changed


def _zeroed_blocks(content, others, random):
    for _ in range(random.integers(1, 4)):
        place = BLOCK * int(random.integers(0, -(-len(content) // BLOCK)))
        content[place:place + BLOCK] = bytes(len(content[place:place + BLOCK]))
    return content


def _flipped_bits(content, others, random):
    for _ in range(random.integers(1, 9)):
        content[random.integers(len(content))] ^= 1 << int(random.integers(8))
    return content


def _overwritten_bytes(content, others, random):
    place, count = int(random.integers(len(content) - 64)), int(random.integers(1, 65))
    content[place:place + count] = random.bytes(count)
    return content


def _cut_short(content, others, random):
    return content[: random.choice([random.integers(len(content)), len(content) - random.integers(1, 200)])]


def _swapped_blocks(content, others, random):
    size = int(random.choice([8, BLOCK, 4096]))
    first, second = (size * int(place) for place in random.choice(len(content) // size, 2, replace=False))
    one, two = content[first:first + size], content[second:second + size]
    content[first:first + size], content[second:second + size] = two, one
    return content


def _appended_bytes(content, others, random):
    tail = [bytes(BLOCK), b"\n", random.bytes(int(random.integers(1, 5000))), _line(content), bytes(content)]
    return content + tail[random.integers(len(tail))]


def _lost_bytes(content, others, random):
    place, count = int(random.integers(len(content))), int(random.choice([1, 8, BLOCK, 4096]))
    del content[place:place + count]
    return content


def _inserted_bytes(content, others, random):
    place, count = int(random.integers(len(content))), int(random.choice([1, 8, BLOCK, 4096]))
    content[place:place] = random.bytes(count)
    return content


def _broken_strings(content, others, random):
    """Zero a block of HDF5's heaps of strings, in which HDF5 1.10 may look forever."""
    places = [place for place in range(0, len(content), 8)
              if content[place:place + 4] in (b"GCOL", b"HEAP", b"FRHP", b"OHDR", b"SNOD", b"TREE")]
    place = places[random.integers(len(places))] + 16 * int(random.integers(0, 16))
    content[place:place + BLOCK] = bytes(len(content[place:place + BLOCK]))
    return content


def _another_file(content, others, random):
    return others[random.integers(len(others))]


def _end_of_another_file(content, others, random):
    """Two files in one, as after a copy that was broken off."""
    other = others[random.integers(len(others))]
    place = int(random.integers(1, len(content)))
    return content[:place] + other[place:]


def _line_of_another_file(content, others, random):
    return content.removesuffix(_line(content)) + _line(others[random.integers(len(others))])


def _altered_line(content, others, random):
    line = bytearray(_line(content))
    line[random.integers(len(line))] = int(random.choice(list(b"0123456789abcdef \nABC\0\xff")))
    return content.removesuffix(_line(content)) + line


def _no_line(content, others, random):
    return content.removesuffix(_line(content))


def _rubbish(content, others, random):
    what = [b"", b"\0", bytes(len(content)), random.bytes(len(content)), b"\x89HDF\r\n\x1a\n", b"title = 'a case'\n",
            random.bytes(3000) + _line(content), _line(content)]
    return what[random.integers(len(what))]


def _line(content):
    """Return the last line of a file, with the end of the line before it."""
    return bytes(content[content.rindex(b"\n", 0, len(content) - 1):])


KINDS = {
    "zeroed blocks": _zeroed_blocks, "flipped bits": _flipped_bits, "overwritten bytes": _overwritten_bytes,
    "cut short": _cut_short, "swapped blocks": _swapped_blocks, "appended bytes": _appended_bytes,
    "lost bytes": _lost_bytes, "inserted bytes": _inserted_bytes, "broken strings": _broken_strings,
    "another file": _another_file, "end of another file": _end_of_another_file,
    "line of another file": _line_of_another_file, "altered line": _altered_line, "no line": _no_line,
    "rubbish": _rubbish,
}
