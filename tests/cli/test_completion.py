"""Completion in a shell: the script is sound, and bash completes verbs, options, cases and runs with it."""

import shutil
import subprocess

import pytest

from parisph import completion, parser
from parisph.__main__ import main

pytest.importorskip("shtab")


def completed(folder, script, *words):
    """Return what bash offers for the last of the words."""
    (folder / "completion.bash").write_text(script)
    program = ('. ./completion.bash; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMP_LINE="$*"; '
               'COMP_POINT=${#COMP_LINE}; _shtab_parisph parisph "${@: -1}" "${@: -2:1}" 2>/dev/null; printf "%s\\n" '
               '"${COMPREPLY[@]}"')
    done = subprocess.run(["bash", "--norc", "-c", program, "bash", "parisph", *words], cwd=folder, capture_output=True,
                          text=True, timeout=30)
    return set(done.stdout.split())


@pytest.mark.parametrize("shell", completion.SHELLS)
def test_script_is_sound(shell, tmp_path, capsys):
    assert main(["completion", shell]) == 0
    text = capsys.readouterr().out
    assert "restart" in text and "--until" in text
    if shutil.which(shell):
        (tmp_path / "script").write_text(text)
        subprocess.run([shell, "-n", "script"], cwd=tmp_path, check=True, timeout=30)


@pytest.mark.parametrize(("words", "offered", "not_offered"), [
    ([""], {"run", "restart", "check", "study", "info", "plot", "movie", "report", "compare", "doctor",
            "completion"},
     {"tank.py"}),
    (["re"], {"restart"}, {"run"}),
    (["run", "ta"], {"tank.py"}, {"table.csv"}),
    (["run", "tank.py", "--"], {"--set", "--out", "--quiet"}, {"--until"}),
    (["study", "ta"], {"tank.py"}, {"table.csv"}),
    (["study", "tank.py", "--"], {"--list", "--only", "--jobs", "--limit"}, {"--until"}),
    (["restart", "runs/t"], {"runs/tank"}, set()),
    (["restart", "runs/tank", "--u"], {"--until"}, {"--out"}),
    (["info", "r"], {"runs"}, {"read.me"}),
    (["compare", "runs/tank", "ta"], {"table.csv"}, {"tank.py"}),
    (["completion", "b"], {"bash"}, {"zsh"}),
], ids=lambda value: " ".join(sorted(value) if isinstance(value, set) else value))
def test_bash_completes(tmp_path, words, offered, not_offered):
    (tmp_path / "runs" / "tank").mkdir(parents=True)
    for name in ("tank.py", "table.csv", "read.me"):
        (tmp_path / name).touch()
    found = completed(tmp_path, completion.script(parser.build(), "bash"), *words)
    assert offered <= found and not not_offered & found, found


def test_unknown_shell(capsys):
    assert main(["completion", "csh"]) == 2
    assert "bash" in capsys.readouterr().err
