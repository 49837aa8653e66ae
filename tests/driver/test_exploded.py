"""A flow that explodes: its first rise of energy is told when it comes, and the run fails soon."""

from types import SimpleNamespace

import pytest

from parisph.base.errors import SolverDiverged, exit_code
from parisph.driver.diagnostics import Diagnostics
from tests.scenes import run_alone, scene


def test_a_run_that_explodes_says_so_at_once_and_fails_soon(tmp_path):
    """A surface that keeps its particles cannot break."""
    case = scene("dam_break", spacing=0.05, surface_rule="frozen")
    with pytest.raises(SolverDiverged, match="use a smaller spacing") as failed:
        run_alone(case, tmp_path / "run")
    assert exit_code(failed.value) == 3 and "energy first rose beyond its limit at t = 0." in str(failed.value)
    log = (tmp_path / "run" / "run.log").read_text()
    told = [line for line in log.splitlines() if "WARNING" in line and "the energy was +" in line]
    assert len(told) == 2, "once when the limit is passed, and in the end with the greatest value"
    assert float(told[0].partition("+")[2].partition("%")[0]) < float(told[1].partition("+")[2].partition("%")[0])


@pytest.mark.parametrize("driven, start, kinetic, fails", [
    (False, 2.0, 210.0, True), (False, 2.0, 190.0, False), (True, 2.0, 210.0, False), (False, 0.0, 210.0, False),
    (False, 2.0, None, False)])
def test_only_energy_without_a_source_is_an_explosion(driven, start, kinetic, fails):
    conservation = SimpleNamespace(driven=driven, energy=SimpleNamespace(start=start),
                                   kinetic=SimpleNamespace(now=kinetic))
    checks = SimpleNamespace(conservation=conservation, _preset="gentle")
    if not fails:
        return Diagnostics.check(checks)
    with pytest.raises(SolverDiverged, match='105 times all energy.*smaller spacing.*preset="violent"'):
        Diagnostics.check(checks)
