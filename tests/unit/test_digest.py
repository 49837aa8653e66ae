"""The digest at the end of a file tells any change of the file, and costs nothing but time."""

import hashlib
import os

import h5py
import numpy as np
import pytest
from mpi4py import MPI

from parisph.base.errors import StoreError
from parisph.io import digest

SELF = MPI.COMM_SELF


@pytest.fixture(params=[1 << 20, 64, 1000], ids="{0} byte chunks".format)
def chunk(request, monkeypatch):
    monkeypatch.setattr(digest, "CHUNK", request.param)
    return request.param


def written(path, content):
    path.write_bytes(content)
    digest.append(SELF, path)
    return path.read_bytes()


@pytest.mark.parametrize("length", [0, 1, 63, 64, 65, 1000, 4096])
def test_a_sound_file_of_any_length(tmp_path, chunk, length):
    content = np.random.default_rng(length).bytes(length)
    assert written(tmp_path / "a", content)[:length] == content
    digest.check(tmp_path / "a")
    digest.check_together(SELF, tmp_path / "a")


def test_the_line_is_the_one_that_is_documented(tmp_path):
    line = written(tmp_path / "a", b"some bytes")[10:]
    expected = hashlib.sha256(b"10 " + hashlib.sha256(b"some bytes").digest()).hexdigest()
    assert line == f"\nparisph digest 1 {10:020d} {expected}\n".encode() and len(line) == digest.LENGTH


def test_any_change_of_one_byte_is_found(tmp_path, chunk):
    """Of the content, of the length and of the digest."""
    path = tmp_path / "a"
    whole = written(path, np.random.default_rng(0).bytes(150))
    for place in range(len(whole)):
        for change in (1, 32, 255):
            path.write_bytes(whole[:place] + bytes([whole[place] ^ change]) + whole[place + 1:])
            with pytest.raises(StoreError, match=f"{path} "):
                digest.check(path)


@pytest.mark.parametrize("change", [
    lambda whole: b"",
    lambda whole: whole[:-1],
    lambda whole: whole[1:],
    lambda whole: whole[:3000] + whole[3001:],
    lambda whole: whole + b"\n",
    lambda whole: whole + whole[-digest.LENGTH:],
    lambda whole: whole[:2000] + whole[1000:2000] + whole[3000:],
    lambda whole: whole[1000:2000] + whole[:1000] + whole[2000:],
    lambda whole: whole[-digest.LENGTH:],
    lambda whole: whole[:1000] + whole[-digest.LENGTH:],
    lambda whole: bytes(len(whole)),
])
def test_larger_changes_are_found(tmp_path, chunk, change):
    path = tmp_path / "a"
    whole = written(path, np.random.default_rng(0).bytes(5000))
    path.write_bytes(change(whole))
    for check in (lambda: digest.check(path), lambda: digest.check_together(SELF, path)):
        with pytest.raises(StoreError, match=f"{path} is (damaged|not a whole file)"):
            check()


def test_what_is_no_file(tmp_path):
    os.mkfifo(tmp_path / "pipe")    # opening it would wait for a writer
    for name, message in (("pipe", "is not a file"), ("", "is not a file"), ("gone", "there is no file")):
        with pytest.raises(StoreError, match=message):
            digest.check(tmp_path / name)


def test_a_newer_digest_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(digest, "VERSION", 2)
    written(tmp_path / "a", b"some bytes")
    monkeypatch.setattr(digest, "VERSION", 1)
    with pytest.raises(StoreError, match="digest of version 2, this parisph knows 1"):
        digest.check(tmp_path / "a")


def test_hdf5_does_not_mind_the_line(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["x"] = np.arange(1000.0)
        file.attrs["name"] = "text"
    digest.append(SELF, tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5", "r") as file:
        np.testing.assert_array_equal(file["x"][()], np.arange(1000.0))
        assert file.attrs["name"] == "text"
    digest.check(tmp_path / "a.h5")    # reading has changed nothing
