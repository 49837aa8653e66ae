"""What the files of a run say of how it was made and what each step did."""

import json

import numpy as np

from parisph.io import checkpoint
from parisph.io.snapshot import read_attributes
from parisph.pressure import options as opts
from tests.scenes import ran, scene

WORDS = ["-pressure_ksp_gmres_restart", "40", "-pressure_ksp_rtol", "1e-4"]


def fall(folder, words, **numerics):
    """Run a few steps of a dam break in folder/run and return the Run."""
    case = scene("dam_break", numerics, spacing=0.1, end_time=0.1)
    return ran(case, folder / "run", words)


def test_every_file_holds_the_options_in_force(tmp_path, monkeypatch):
    """Our defaults, which go with the size of the system, and the user's above them; also before the first step."""
    monkeypatch.setattr(opts, "SMALL", 10)
    found = fall(tmp_path, WORDS)
    stored = [found.about, read_attributes(checkpoint.paths(tmp_path / "run" / "checkpoints")[-1]), found.summary]
    for about in stored:
        options = about["petsc_options"] + " "
        for text in ("-pressure_ksp_gmres_restart 40 ", "-pressure_ksp_rtol 1e-4 ",
                     "-pressure_pc_hypre_type boomeramg ", "-pressure_pc_hypre_boomeramg_no_CF "):
            assert text in options
        assert options.count("-pressure_ksp_rtol ") == 1
    assert found.summary["driven"] is False
    assert found.summary["versions"] == json.loads(found.about["versions"])


def test_the_second_solve_of_a_step_leaves_a_record_too(tmp_path):
    found = fall(tmp_path, [], kappa=0.2).steps
    steps = {name: found[name][1:] for name in ("position_iterations", "position_residual", "position_fallback")}
    assert not found["position_iterations"][0], "at rest there is nothing to move"
    assert (steps["position_iterations"] > 0).all() and (steps["position_residual"] <= 1e-2).all()
    assert (steps["position_residual"] > 0.0).all() and np.isnan(steps["position_fallback"]).all()    # all empty


def test_a_step_with_one_solve_says_so(tmp_path):
    steps = fall(tmp_path, [], kappa=0.0).steps
    assert not steps["position_iterations"].any() and not steps["position_residual"].any()


def test_fallbacks_of_both_solves_count(tmp_path):
    found = fall(tmp_path, ["-pressure_pc_type", "none", "-pressure_ksp_max_it", "1"], kappa=0.2)
    counts = [np.count_nonzero(found.steps[name] == "gamg") for name in ("fallback", "position_fallback")]
    assert min(counts) > 0 and found.summary["fallbacks"] == sum(counts)
