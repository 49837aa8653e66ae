"""`report --into FILE`: the bytes of the user stay, and what is no text file with two marks is refused unread."""

import os
import socket
import stat

import pytest

from parisph.base.errors import CaseError, StoreError
from parisph.report import between, gallery

START, END = gallery.START.encode(), gallery.END.encode()


def put(file):
    """Put a gallery of no runs into a file; return what is between its marks."""
    assert gallery.put_into([], file) == [file]
    return file.read_bytes().partition(START)[2].partition(END)[0]


@pytest.mark.parametrize(("before", "newline", "after"), [
    (b"# Mine\n\n", b"\n", b"\nbehind\n"),
    (b"\xef\xbb\xbf", b"\r\n", b"\r\nno line end"),                           # a byte order mark just before the mark
    (b"a\fb\x0bc\xc2\x85d\xe2\x80\xa8e\r\n\n", b"\n", b""),                   # no lines end at a form feed, NEL or LS
    (b"mixed\r\n\n", b"\r\n", b"\nlast"),
    (b"old Macs\r", b"\r", b"\r"),
], ids=["plain", "Windows", "form feed", "mixed", "Mac"])
def test_all_other_bytes_stay(tmp_path, before, newline, after):
    file = tmp_path / "README.md"
    file.write_bytes(before + START + newline + b"old" + newline + END + after)
    inside = put(file)
    assert file.read_bytes() == before + START + inside + END + after and b"old" not in inside
    assert inside.replace(newline, b"").count(b"\n") == inside.replace(newline, b"").count(b"\r") == 0
    assert inside.count(newline) == 4 and put(file) == inside


def test_a_link_stays_a_link_and_a_mode_stays(tmp_path):
    (tmp_path / "docs").mkdir()
    file, link = tmp_path / "docs" / "real.md", tmp_path / "README.md"
    file.write_bytes(START + b"\nold\n" + END + b"\n")
    file.chmod(0o640)
    link.symlink_to("docs/real.md")
    assert b"old" not in put(link) and os.readlink(link) == "docs/real.md"
    assert b"old" not in file.read_bytes() and stat.S_IMODE(file.stat().st_mode) == 0o640
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["README.md", "docs", "real.md"]


def test_an_edit_made_meanwhile_is_kept(tmp_path):
    file = tmp_path / "README.md"
    file.write_bytes(START + b"\nold\n" + END + b"\n")
    place = between.Between(file, gallery.START, gallery.END, "the gallery")
    file.write_bytes(b"new words\n" + file.read_bytes())
    place.put(["new lines"])
    assert file.read_bytes() == b"new words\n" + START + b"\nnew lines\n" + END + b"\n"


def _socket(path):
    place = socket.socket(socket.AF_UNIX)
    os.chdir(path.parent)    # a name of a socket has at most 108 bytes
    place.bind(path.name)
    place.close()


def _what_it_is(path):
    """What a change of the file would change (its time of reading is none of it), or None without a file."""
    if not os.path.lexists(path):
        return None
    found = path.lstat()
    return found.st_mode, found.st_ino, found.st_nlink, found.st_size, found.st_mtime_ns


@pytest.mark.parametrize(("make", "says"), [
    (os.mkfifo, "not a regular file"), (os.mkdir, "is a folder"), (_socket, "not a regular file"),
    (lambda path: path.symlink_to("/dev/zero"), "not a regular file"), (lambda path: path.symlink_to(path), "links"),
    (lambda path: None, "No such file"),
    (lambda path: path.write_bytes(START + b"\ncaf\xe9\n" + END), "UTF-8: see byte 20: convert it first, for example "
                                                                   "Latin-1 with iconv -f LATIN1"),
    (lambda path: path.write_text(f"{gallery.START}\n", "utf-16"), "not text in UTF-8"),
    (lambda path: path.write_bytes(START + b"\n\0\n" + END), "not text: see character 17"),
    (lambda path: (path.touch(), os.truncate(path, 10**9)), "at most 16 MB"),
], ids=["pipe", "folder", "socket", "device", "loop", "nothing", "Latin-1", "UTF-16", "zero", "large"])
def test_what_is_no_text_file_is_refused_unchanged(tmp_path, monkeypatch, make, says):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "README.md"
    make(file)
    before = _what_it_is(file)
    with pytest.raises(StoreError, match=f"cannot read .*README.md: .*{says}"):
        gallery.put_into([], file)
    assert _what_it_is(file) == before and len(list(tmp_path.iterdir())) == (before is not None)


@pytest.mark.parametrize(("text", "says"), [
    ("# Mine\n", "0 and 0 of these lines"), (f"{gallery.END}\n{gallery.START}\n", "second line is above the first"),
    (f"{gallery.START}\nmine\n{gallery.START}\n{gallery.END}\n", "2 and 1 of these lines"),
    (f"in words: {gallery.START}\n{gallery.END}\n", "0 and 1 of these"),
])
def test_a_file_without_two_marks_is_refused_unchanged(tmp_path, text, says):
    file = tmp_path / "README.md"
    file.write_text(text)
    with pytest.raises(CaseError, match=f"must have one line <!-- gallery --> and, below it, .*{says}"):
        gallery.put_into([], file)
    assert file.read_text() == text
