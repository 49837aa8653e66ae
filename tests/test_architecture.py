"""Rules of the architecture that a test can check: which part may import which (the order is in parisph/README.md)."""

import ast
import subprocess
import sys
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from tests.launch import ROOT, clean_environment

# A module imports only from its own part and from those that stand before it.
ORDER = ("base", "case", "geometry", "kernels", "parallel", "pressure", "methods", "truth", "patch", "watch", "io",
         "pictures", "driver", "study", "report", "doctor",
         "arguments", "completion", "parser", "ranks", "verbs", "cli", "__main__")

# Where these may be imported, as beginnings of module names; nowhere else.
ONLY_IN = {
    "petsc4py": ("parallel.petsc",),    # which starts PETSc as it should be started
    "mpi4py": ("parallel", "pressure", "methods", "truth", "patch", "watch", "io", "pictures", "driver", "study",
               "doctor", "ranks", "__main__"),
    "numba": ("kernels", "parallel", "doctor"),
    "h5py": ("io", "doctor"),
    "scipy": ("driver.conservation", "geometry.triangles", "geometry.surface_checks", "methods.surface_load",
              "pictures.water"),
    "trimesh": ("geometry.surface_files",),
    "manifold3d": ("geometry.room",),
    "pymeshlab": ("base.libraries",),    # which loads h5py before it
    "matplotlib": ("pictures", "study"),
    "pyvista": ("pictures.rendering",),
    "vtkmodules": ("pictures.rendering",),
    "pysplashsurf": ("pictures.water",),
}
WHOLE_WORLD = "COMM_WORLD"
WHOLE_WORLD_IN = ("ranks", "__main__", "parallel.petsc")    # PETSc starts on all ranks together


def faults(package):
    """Return what in a package folder breaks the rules, one line each."""
    found, graph = [], {}
    for path in sorted(package.rglob("*.py")):
        module = ".".join(path.relative_to(package).with_suffix("").parts).removesuffix(".__init__")
        if module == "__init__":
            module = ""
        tree = ast.parse(path.read_text(encoding="utf-8"))
        graph[module] = set()
        for line, name in imports(tree, package.name, module, path.name == "__init__.py"):
            here = f"{path.relative_to(package.parent)}:{line}"
            found += [f"{here} imports {name}: {why}" for why in _import_faults(module, name, package.name)]
            graph[module].add(name.removeprefix(package.name).lstrip("."))
        found += [f"{path.relative_to(package.parent)}:{node.lineno} uses {word}: take the communicator as an argument"
                  for node, word in _worlds(tree) if module not in WHOLE_WORLD_IN]
    return found + _cycles(graph)


def imports(tree, package, module, is_package):
    """Return (line, dotted name) of every import anywhere in a module; ours as package.part.module[.name]."""
    names = []
    # what the front of the package imports for type checkers alone is never loaded
    parts = [part for part in tree.body
             if module or ast.unparse(part).partition(":")[0] != "if TYPE_CHECKING"]
    for node in (node for part in parts for node in ast.walk(part)):
        if isinstance(node, ast.Import):
            names += [(node.lineno, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            start = node.module or ""
            if node.level:
                parts = [package, *module.split(".")] if module else [package]
                up = parts[: len(parts) - node.level + is_package]
                start = ".".join(up + ([node.module] if node.module else []))
            names += [(node.lineno, f"{start}.{alias.name}") for alias in node.names]
    return names


def _import_faults(module, name, package):
    top = name.split(".")[0]
    if top in ONLY_IN and not _starts(module, ONLY_IN[top]):
        yield f"{top} belongs in {', '.join(ONLY_IN[top])}"
    if top != package or name in (package, f"{package}.__version__"):
        return
    part = name.split(".")[1]
    if module == "":
        yield "the front of the package loads its parts only when they are asked for"
    elif part not in ORDER:
        yield "inside the package a name is imported from the module where it lives"
    elif module.split(".")[0] not in ORDER:
        yield f"{module} has no place in the order of parts"
    elif ORDER.index(part) > ORDER.index(module.split(".")[0]):
        yield f"{part} stands above {module.split('.')[0]}"


def _starts(module, beginnings):
    return any(module == start or module.startswith(start + ".") for start in beginnings)


def _worlds(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and node.attr == WHOLE_WORLD:
            yield node, node.attr
        elif isinstance(node, ast.ImportFrom):
            yield from ((node, alias.name) for alias in node.names if alias.name == WHOLE_WORLD)


def _cycles(graph):
    """Modules of one part may use each other, but not in a circle."""
    edges = {module: {_known(name, graph) for name in names} - {None, "", module} for module, names in graph.items()}
    try:
        TopologicalSorter(edges).prepare()
    except CycleError as error:
        return [f"imports in a circle: {' -> '.join(error.args[1])}"]
    return []


def _known(name, graph):
    """Return the module that a dotted name is, or is in."""
    while name and name not in graph:
        name = name.rpartition(".")[0]
    return name or None


def test_package_keeps_the_rules():
    assert faults(ROOT / "parisph") == []


@pytest.mark.parametrize(("module", "text", "word"), [
    ("base/a.py", "from parisph.case import schema", "case stands above base"),
    ("kernels/a.py", "def f():\n    import parisph.pressure.rows", "pressure stands above kernels"),
    ("kernels/a.py", "from ..io import store", "io stands above kernels"),
    ("kernels/a.py", "from .. import io", "io stands above kernels"),
    ("kernels/a.py", "from mpi4py import MPI", "mpi4py belongs in"),
    ("parallel/migrate.py", "from petsc4py import PETSc", "petsc4py belongs in"),
    ("pressure/solver.py", "import petsc4py", "petsc4py belongs in"),
    ("driver.py", "import petsc4py", "petsc4py belongs in"),
    ("driver.py", "from mpi4py import MPI\ncomm = MPI.COMM_WORLD", "uses COMM_WORLD"),
    ("driver.py", "from mpi4py.MPI import COMM_WORLD", "uses COMM_WORLD"),
    ("driver.py", "from parisph import Case", "from the module where it lives"),
    ("extra.py", "from parisph.base import errors", "has no place"),
    ("__init__.py", "from parisph.case.schema import Case", "only when they are asked for"),
    ("io/__init__.py", "from ..driver import run", "driver stands above io"),
    ("base/a.py", "from parisph.base import b", "circle"),
])
def test_rules_find_a_fault(tmp_path, module, text, word):
    package = tmp_path / "parisph"
    for folder in ("base", "kernels", "parallel", "io", "case", "pressure"):
        (package / folder).mkdir(parents=True)
    (package / "base" / "b.py").write_text("from parisph.base import a\n")
    (package / "base" / "a.py").write_text("import os\n")
    (package / module).write_text(text + "\n")
    assert [fault for fault in faults(package) if word in fault], faults(package)


@pytest.mark.parametrize(("module", "text"), [
    ("parallel/petsc.py", "from petsc4py import PETSc"),
    ("pressure/solver.py", "from parisph.parallel.petsc import PETSc\nfrom parisph.base import errors"),
    ("ranks.py", "from mpi4py import MPI\ncomm = MPI.COMM_WORLD\nfrom parisph import __version__"),
    ("io/a.py", "import parisph\nfrom .. import __version__\nfrom . import b\nfrom ..base.errors import CaseError"),
])
def test_rules_allow_what_is_right(tmp_path, module, text):
    path = tmp_path / "parisph" / module
    path.parent.mkdir(parents=True)
    path.write_text(text + "\n")
    assert faults(tmp_path / "parisph") == []


def loaded_by(statement, libraries=("mpi4py", "petsc4py", "numba", "h5py")):
    """Return which of some libraries a fresh Python has loaded after a statement."""
    program = f"import sys\n{statement}\nprint([name for name in {libraries} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, env=clean_environment(),
                          capture_output=True, text=True, timeout=60, check=True)
    return ast.literal_eval(done.stdout)


@pytest.mark.parametrize("statement", [
    "import parisph",
    "from parisph import Case, Fluid, PressureTap, CaseError",
    "import parisph.case.load, parisph.geometry.build",
    "import parisph.cli, parisph.__main__, parisph.doctor",
])
def test_describing_a_case_loads_no_engine(statement):
    assert loaded_by(statement) == []


def test_a_loaded_engine_is_seen():
    assert loaded_by("import numba") == ["numba"]


def test_a_command_sets_the_threads_before_it_loads_numpy():
    """BLAS reads their number when it is loaded (base.environment.prepare)."""
    assert loaded_by("import parisph.__main__", ("numpy",)) == []


def test_cases_describe_and_nothing_else():
    allowed = {"parisph", "numpy", "math", "pathlib", "__future__", "typing", "trimesh"}    # which makes STL files
    for path in sorted(Path(ROOT, "cases").glob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        assert {name.split(".")[0] for _, name in imports(tree, "parisph", "", False)} <= allowed, path.name


def test_no_two_parts_have_a_module_of_the_same_name():
    places = {}
    for path in (ROOT / "parisph").rglob("*.py"):
        if path.stem not in ("__init__", "__main__"):
            places.setdefault(path.stem, []).append(str(path.relative_to(ROOT)))
    assert [found for found in places.values() if len(found) > 1] == []
