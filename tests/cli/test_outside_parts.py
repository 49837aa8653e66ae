"""Parts and probes from outside the package: each is a class in a case file, in at most 25 lines. Parts run through
`parisph study`."""

import json

import pytest

from parisph import CaseError, open_run
from parisph.case.load import register_parts
from tests.launch import ROOT, mpirun, parisph, succeeded

HEAD = f"""
import importlib.util
import numpy as np
found = importlib.util.spec_from_file_location("sloshing", {str(ROOT / "cases" / "small_sloshing.py")!r})
sloshing = importlib.util.module_from_spec(found)
found.loader.exec_module(sloshing)
from parisph.methods import catalogue, parts

def case(method: str = "ISPH_R", spacing: float = 0.1, laplacian: str = "rankine", gradient: str = "mixed",
         surface_rule: str = "frozen", source: str = "mixed"):
    sets = dict(laplacian=laplacian, gradient=gradient, surface_rule=surface_rule, source=source)
    whole = sloshing.case(spacing=spacing, method=method, end_time=1.0)
    return whole.changed(**{{f"numerics.{{name}}": word for name, word in sets.items()}})
"""

PARTS = {
    "laplacian": '''
class NearestNeighbours(parts.Laplacian):
    """The mean of the neighbours within 1.2 spacings: finite differences on a lattice."""

    name, reach, linear = "nearest", 1.2, False

    def fill(self, rows, cloud, flux, u):
        s = cloud.spacing
        for i in np.flatnonzero(cloud.role[:len(cloud.indptr) - 1] == 0):
            near = cloud.indices[cloud.indptr[i]:cloud.indptr[i + 1]]
            near = near[(np.linalg.norm(cloud.x[near] - cloud.x[i], axis=1) < 1.2 * s) & (cloud.role[near] < 3)]
            first, n = cloud.indptr[i], len(near)
            rows.columns[first:first + n], rows.values[first:first + n] = near, 1.0 / n
            rows.count[i], rows.measure[i] = n, s * s / n


parts.LAPLACIANS.register(NearestNeighbours())
''',
    "gradient": '''
class Halved(type(parts.GRADIENTS["mixed"])):
    """Least squares within half as much more than a spacing."""

    name, reach = "close", 1.9


parts.GRADIENTS.register(Halved())
''',
    "surface_rule": '''
class Topmost(parts.Surface):
    """Fluid within half a spacing of the still level: for small waves."""

    name, fields = "topmost", ("closing",)

    def find(self, flow, seen):
        p = flow.particles
        fluid = p.kind == 0
        p.role[fluid] = np.where(p.x[fluid, -1] > 0.5 - 0.5 * flow.spacing, 1, 0)


parts.SURFACES.register(Topmost())
''',
    "source": '''
class Weaker(parts.Source):
    """Nine tenths of the divergence of the predicted velocity."""

    name = "weaker"

    def target(self, flow, dt):
        return 0.9 * flow.density / dt * flow.rows.div


parts.SOURCES.register(Weaker())
''',
}
WORD = {"laplacian": "nearest", "gradient": "close", "surface_rule": "topmost", "source": "weaker"}


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """The results of a study with none and with each of the parts, which are all registered in its case."""
    folder = tmp_path_factory.mktemp("parts")
    (folder / "exact").symlink_to(ROOT / "cases" / "exact")
    (folder / "mine.py").write_text(HEAD + "".join(PARTS.values()))
    (folder / "compare.py").write_text(f"""
from parisph.study import Study, TruthError, Variant
study = Study(case="mine.py", warm_up=False, errors=[TruthError("left")],
              variants=[Variant(label="ours")]
              + [Variant(parameters={{what: word}}, label=what) for what, word in {WORD!r}.items()])
""")
    succeeded(parisph("study", "compare.py", "-o", "out", cwd=folder, timeout=200))
    return dict(zip(["ours", *WORD], json.loads((folder / "out" / "results.json").read_text())["runs"], strict=True))


@pytest.mark.parametrize("what", PARTS)
def test_a_part_from_outside_runs_through_study(runs, what):
    assert len(PARTS[what].strip().splitlines()) <= 25
    ours, mine = runs["ours"], runs[what]
    assert ours["survived"] and mine["survived"] and mine["left"] < 0.6, (ours, mine)
    # small waves keep their surface: the rule finds the same particles
    assert (mine["left"] != pytest.approx(ours["left"], rel=1e-9)) == (what != "surface_rule")


def test_a_word_that_no_part_has_is_an_error_that_lists_them(tmp_path):
    (tmp_path / "exact").symlink_to(ROOT / "cases" / "exact")
    (tmp_path / "mine.py").write_text(HEAD)
    done = parisph("check", "mine.py", "--set", "laplacian=nearest", cwd=tmp_path)
    assert done.returncode == 2 and "unknown laplacian 'nearest'; known are rankine, " in done.stderr


PROBE = '''
class MeanSpeed(Probe):
    """Mean speed of the fluid in a box."""

    columns = {"speed": "m/s"}
    quantity = "mean speed"

    kind: Literal["mean_speed"] = "mean_speed"
    low: Point
    high: Point

    def problems(self, case):
        if self.low[0] < case.wall_bounds[0][0]:
            yield f"low = {self.low} must lie in the tank; move it"

    def sums(self, view):
        p = view.particles
        inside = view.fluid & ((p.x >= self.low) & (p.x <= self.high)).all(axis=1)
        return np.hypot(*p.u[inside].T).sum(), inside.sum()

    def values(self, sums, rows, view):
        return (sums[0] / sums[1],)
'''
FALLING = f"""
from typing import Literal
import numpy as np
from parisph import Box, Case, Fluid, Numerics, Tank
from parisph.case.probes import Point, Probe
{PROBE}

def case(left: float = 0.0):
    return Case(title="A box of water falls", fluid=Fluid(Box(0.5, 0.5, at=(0.0, 0.5)), density=1000.0),
                walls=Tank(1.0, 1.5), gravity=(0.0, -10.0), numerics=Numerics(spacing=0.05), end_time=0.1,
                probes=[MeanSpeed("speed", low=(left, 0.0), high=(0.3, 1.5), arrival=0.5, peak=True)])
"""


def test_a_probe_from_outside_runs_on_two_ranks_and_is_checked_drawn_and_restarted(tmp_path):
    (tmp_path / "mine.py").write_text(FALLING)
    assert len(PROBE.strip().splitlines()) <= 25
    done = parisph("check", "mine.py", cwd=tmp_path)
    assert done.returncode == 0 and "\nprobes      speed\n" in done.stdout, done.stderr
    done = parisph("check", "mine.py", "--set", "left=-1", cwd=tmp_path)
    assert done.returncode == 2 and "probe 'speed': low = (-1.0, 0.0) must lie in the tank; move it" in done.stderr
    done = mpirun(2, ["-m", "parisph", "run", "mine.py", "-o", "out"], cwd=tmp_path)
    assert done.returncode == 0 and "arrival at speed 0.05 s" in done.stdout, done.stderr
    run = open_run(tmp_path / "out")
    assert (tmp_path / "out" / "probes" / "speed.csv").read_text().startswith("# Mean speed of the fluid in a box\n")
    assert run.units("speed")["speed"] == "m/s" and run.probe("speed")["speed"][-1] == pytest.approx(1.0, rel=1e-3)
    assert run.peak("speed")["peak"] == run.probe("speed")["speed"].max()
    # a run is looked at without its class; to go on it needs the file
    assert parisph("plot", "out", "-o", "out.png", cwd=tmp_path).returncode == 0
    done = parisph("restart", "out", "--until", "0.11", cwd=tmp_path)
    assert done.returncode == 2 and "or of a file that is named by --parts" in done.stderr
    assert parisph("restart", "out", "--until", "0.11", "--parts", "mine.py", cwd=tmp_path).returncode == 0


def test_a_probe_from_outside_has_a_kind_of_its_own(tmp_path):
    (tmp_path / "mine.py").write_text(FALLING.replace("mean_speed", "flux"))
    with pytest.raises(CaseError, match="there is another probe 'flux': give yours a kind of its own"):
        register_parts(tmp_path / "mine.py")
