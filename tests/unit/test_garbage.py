"""The search for garbage is put off during a start, and is as usual in the steps."""

import subprocess
import sys

from tests.launch import clean_environment

PUT_OFF = """
import gc
from parisph.base import garbage

usual = garbage.USUAL
garbage.as_usual()
assert gc.get_threshold() == usual and not gc.get_freeze_count()
garbage.put_off()
garbage.put_off()
assert gc.get_threshold() == (garbage.SELDOM, *usual[1:])
garbage.as_usual()
assert gc.get_threshold() == usual and gc.get_freeze_count()
frozen = gc.get_freeze_count()
kept = [[] for _ in range(100)]
garbage.as_usual()
assert gc.get_threshold() == usual and gc.get_freeze_count() <= frozen
"""


def test_search_is_put_off_and_then_as_usual():
    subprocess.run([sys.executable, "-c", PUT_OFF], env=clean_environment(), check=True)
