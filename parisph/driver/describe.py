"""What `parisph check` says of a case: particles, stages, memory, steps."""

import math

from parisph.case import geometry

# Measured: peak memory of the dam break on one rank, 231, 301 and 487 MB with 3840, 30,720 and 119,040
# particles, preconditioner included. A run that compiles its kernels first takes 110 MB more.
BYTES = 2500.0  # per particle
BASE = 223e6    # interpreter, libraries and kernels of one rank


def describe(case, parameters=None):
    """Return the description as text. Needs neither MPI nor compiled kernels.

    parameters : {name: value} of the case file (case.load.arguments), for those who will set others
    """
    numerics = case.numerics.resolved()
    count = geometry.counts(case)
    lines = [
        ("case", case.title),
        ("method", f"{numerics.method}, preset {numerics.preset}"),
        ("particles", f"{count['all']} ({count['fluid']} fluid, {count['wall']} wall), spacing {numerics.spacing:g} m"),
        ("stages", ", ".join(stages(case))),
        ("end time", f"{case.end_time:g} s"),
        ("steps", _steps(case, numerics)),
        ("memory", f"about {(BASE + BYTES * count['all']) / 1e6:.0f} MB on one rank"),
        ("probes", ", ".join(probe.name for probe in case.probes) or "none"),
    ]
    if parameters:
        lines.append(("--set", ", ".join(f"{name}={_text(value)}" for name, value in parameters.items())))
    return "\n".join(f"{name:<12}{text}" for name, text in lines)


def stages(case):
    """Return the names of the stages that a step of this case has, in order."""
    n = case.numerics.resolved()
    found = ["predict", "redistribute"]
    if n.surface_rule not in ("none", "frozen") and not case.closed:
        found.append(f"surface ({n.surface_rule})")
    source = ", strain source" if n.strain else ""
    surface = ", harmonic at the surface" if n.surface_gradient == "harmonic" else ""
    found += [f"assemble ({n.method}, {n.wall_rows} walls{source})", "solve" + (" (null space)" if case.closed else ""),
              f"correct ({n.gradient} gradient{surface})"]
    wanted = ((n.filter, "velocity filter"), (n.collision_distance, "pair collisions"), (n.wall_guard, "wall guard"),
              (n.kappa, "position projection"), (n.shift, "Fick shift"))
    return found + [name for value, name in wanted if value]


def _text(value):
    """A value as --set takes it."""
    if isinstance(value, (tuple, list)):
        return ",".join(map(_text, value))
    return "none" if value is None else f"{value:.15g}" if isinstance(value, float) else str(value)


def _steps(case, n):
    if n.time_step is not None:
        return f"{round(case.end_time / n.time_step)} of {n.time_step:.3g} s"
    longest = min(case.frame.longest_step, n.max_time_step or math.inf)
    return f"adaptive, at most {n.cfl:g} spacings a step" + (f" and {longest:.3g} s" if longest < math.inf else "")
