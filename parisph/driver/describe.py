"""What `parisph check` says of a case: particles, stages, memory, steps."""

from parisph.case import geometry

BYTES = 3500.0  # measured: peak memory per particle of a large run, preconditioner included
BASE = 223e6    # interpreter, libraries and compiled kernels of one rank


def describe(case):
    """Return the description as text. Needs neither MPI nor compiled kernels."""
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


def _steps(case, n):
    if n.time_step is not None:
        return f"{round(case.end_time / n.time_step)} of {n.time_step:.3g} s"
    return f"adaptive, at most {n.cfl:g} spacings a step" + (
        f" and {n.max_time_step:g} s" if n.max_time_step is not None else "")
