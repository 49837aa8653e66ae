"""`report --into FILE` for any FILE: its own bytes stay, or it is refused with one error and nothing is changed."""

import os
import shutil
import socket
import stat

from parisph.io.layout import INDEX
from parisph.report import gallery
from tests.faults import text_files

START, END = gallery.START.encode(), gallery.END.encode()
LONGEST = 600    # characters of a message


def make(count, random, folder):
    """See table.Part."""
    (folder / "case.py").write_text(text_files.CASE)
    code, said = text_files._command(["run", str(folder / "case.py"), "-o", str(folder / "a [run](1)"), "-q"])
    if code != 0:
        raise RuntimeError(said)
    shutil.copytree(folder / "a [run](1)", folder / "bare" / "a [run](1)")    # without pictures, which take long
    shutil.rmtree(folder / "bare" / "a [run](1)" / "snapshots")
    (folder / "bare" / "a [run](1)" / INDEX).unlink()
    kinds = list(REFUSED)
    for attempt in range(count):
        place = folder / f"try{attempt}"
        place.mkdir()
        if attempt % 2:
            yield _refused(place, kinds[attempt // 2 % len(kinds)], folder / "a [run](1)", random)
        else:
            yield _kept(place, folder / ("bare" if random.random() < 0.9 else "") / "a [run](1)", random)


def _kept(place, run, random):
    """Put the gallery into a text of random pieces; all else must stay, twice."""
    newline = (b"\n", b"\r\n", b"\r")[int(random.integers(3))]
    pieces = (b"", b"words", b"\f", b"\x0b", b"\x85".decode("latin-1").encode(), "\u2028".encode(), b"\t", b"  ",
              "é漢🌊".encode(), b"\n", b"\r\n", b"\r", b"# Mine", b"<!-- gallery --> in words", b"`<!-- gallery -->`",
              b"\x00"[:0], b"[a](b)", b"\\")

    def words(least):
        return b"".join(pieces[int(random.integers(len(pieces)))] for _ in range(int(random.integers(least, 12))))
    before, after = words(0), words(0)
    before = before + newline if before or random.random() < 0.5 else (b"\xef\xbb\xbf" * int(random.integers(2)))
    after = newline + after if random.random() < 0.8 else b""
    file, path = place / "real.md", place / "page.md"
    file.write_bytes(before + START + newline + b"old" + words(0) + newline + END + after)
    mode = (0o644, 0o600, 0o664)[int(random.integers(3))]
    file.chmod(mode)
    linked = random.random() < 0.5
    path = path if linked else file
    if linked:
        path.symlink_to("real.md")
    what = f"{file.read_bytes()[:200]!r}"
    for _ in range(2):
        code, said = text_files._command(["report", str(run), "--into", str(path)])
        found = file.read_bytes()
        if code != 0 or said:
            return f"{what}: ends with {code}: {said[-500:]}"
        if not found.startswith(before + START + newline) or not found.endswith(END + after):
            return f"{what}: has changed to {found[:300]!r}"
        inside = found[len(before + START):len(found) - len(END + after)]
        if b"a \\[run\\](1)" not in inside or {*b"\r\n"} & {*inside.replace(newline, b"")}:
            return f"{what}: holds {inside[:300]!r}"
    if path.is_symlink() != linked or stat.S_IMODE(file.stat().st_mode) != mode:
        return f"{what}: link or mode has changed"
    left = {one.name for one in place.iterdir()} - {"real.md", "page.md", "pictures"}
    return f"{what}: leaves {left}" if left else None


def _refused(place, kind, run, random):
    """Try a file that cannot hold a gallery; it must be said, and nothing may change."""
    path = place / "page.md"
    REFUSED[kind](path, random)
    before = _state(place)
    code, said = text_files._command(["report", str(run), "--into", str(path)])
    if code not in (2, 5) or said.count("parisph: error: ") != 1 or "Traceback" in said or len(said) > LONGEST:
        return f"{kind}: ends with {code}: {said[-500:]!r}"
    if "page.md" not in said:
        return f"{kind}: does not name the file: {said[-300:]!r}"
    return None if _state(place) == before else f"{kind}: is refused, but has changed"


def _state(place):
    """Return {name: (mode, link, content)} of all there is."""
    return {path.name: (path.lstat().st_mode, os.readlink(path) if path.is_symlink() else None,
                        path.read_bytes() if path.is_file() else None) for path in place.iterdir()}


def _write(make):
    return lambda path, random: path.write_bytes(make(random))


def _socket(path, random):
    with socket.socket(socket.AF_UNIX) as one:
        here = os.getcwd()
        os.chdir(path.parent)    # a name of a socket has at most 108 bytes
        try:
            one.bind(path.name)
        finally:
            os.chdir(here)


def _huge(path, random):
    path.write_bytes(START + b"\n" + END)
    os.truncate(path, 2 * 10**7)


REFUSED = {
    "a pipe": lambda path, random: os.mkfifo(path), "a folder": lambda path, random: path.mkdir(), "a socket": _socket,
    "a link to a device": lambda path, random: path.symlink_to(("/dev/zero", "/dev/full")[int(random.integers(2))]),
    "a link to itself": lambda path, random: path.symlink_to(path.name), "nothing": lambda path, random: None,
    "a link to nothing": lambda path, random: path.symlink_to("nowhere.md"), "huge": _huge,
    "Latin-1": _write(lambda random: START + b"\ncaf\xe9\n" + END),
    "UTF-16": _write(lambda random: f"{gallery.START}\n{gallery.END}\n".encode("utf-16")),
    "random bytes": _write(lambda random: START + b"\n" + random.bytes(300) + b"\n" + END),
    "a zero": _write(lambda random: START + b"\n\0\n" + END), "empty": _write(lambda random: b""),
    "one mark": _write(lambda random: (START, END)[int(random.integers(2))] + b"\n"),
    "marks the wrong way round": _write(lambda random: END + b"\n" + START + b"\n"),
    "marks twice": _write(lambda random: (START + b"\n" + END + b"\n") * 2),
    "marks in a line": _write(lambda random: b"see " + START + END + b"\n"),
    "JSON": _write(lambda random: b'{"a": 1}\n'),
}
