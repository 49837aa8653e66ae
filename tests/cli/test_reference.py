"""The reference of the Python interface: pdoc makes it from the docstrings, without a warning. Skipped without pdoc."""

import re
import sys

import pytest

from tests.launch import ROOT, run

pytest.importorskip("pdoc", reason="pip install 'parisph[docs]'")

FILES = [path.relative_to(ROOT).with_suffix("") for path in (ROOT / "parisph").rglob("*.py")
         if path.name != "__main__.py"]
MODULES = sorted(".".join(path.parts).removesuffix(".__init__") for path in FILES)


def made(folder, *modules, **settings):
    """Make the pages of modules in a folder, as run_scripts/reference does; return CompletedProcess."""
    return run([sys.executable, "-W", "error", "-W", "ignore:The module specification", "-m", "pdoc",
                "--template-directory", "run_scripts/reference_pages", "--output-directory", folder, *modules],
               cwd=ROOT, timeout=300, **settings)


def test_all_modules_have_a_page_with_their_docstrings(tmp_path):
    done = made(tmp_path, *MODULES)
    assert done.returncode == 0, done.stderr
    listed = re.findall(r'href="([^"]+\.html)"', (tmp_path / "index.html").read_text(encoding="utf-8"))
    assert set(listed) == {name.replace(".", "/") + ".html" for name in MODULES}
    assert all((tmp_path / page).exists() for page in listed)
    assert "sqrt(2 S:S)" in (tmp_path / "parisph.html").read_text(encoding="utf-8"), "as it is written"


def test_a_warning_is_an_error(tmp_path):
    (tmp_path / "wrong.py").write_text('def f(a: "NotThere") -> None:\n    """Nothing."""\n', encoding="utf-8")
    done = made(tmp_path / "pages", "wrong", PYTHONPATH=str(tmp_path))
    assert done.returncode == 1 and "NotThere" in done.stderr
