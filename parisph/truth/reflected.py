"""Incident and reflected waves of a run, from its gauges: the `reflection` of summary.json. Not collective."""

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.errors import CaseError, ParisphError
from parisph.base.reading import listed
from parisph.base.text import shown
from parisph.case.absorb import Relaxation, group_velocity
from parisph.case.bodies import Flap, Piston
from parisph.case.probes import Gauge, surface_gauges
from parisph.case.schema import Case
from parisph.case.shapes import Tank
from parisph.case.waves import Jonswap, SolitaryWave
from parisph.case.waves.linear import wave_number
from parisph.geometry import build, columns
from parisph.geometry.upper_faces import UpperFaces
from parisph.truth.recorded import Recorded, own_columns
from parisph.truth.reflection import separated, spectra, spread

PERIODS = 10       # of a regular wave, at the end of the run, that are analysed
SETTLED = 3.0      # periods between the arrival of the waves at the farthest gauge and the analysis
LONG = 0.75        # largest distance of the chosen gauges, in wave lengths
MANY = 30          # most gauges that are tried in groups
PAIR, TRIPLE = 2, 3
SAME_DEPTH = 0.01  # largest relative difference of the depths at a gauge and at the wavemaker
ENOUGH = 0.02      # least incident density of a band with a coefficient, over the greatest


def of_case(case: Case, run: Recorded) -> dict[str, Any] | None:
    """Return `analysed`, or {"reason": text} if it fails; None for a case without a wavemaker and two gauges."""
    if not _makers(case) or len(_gauges(case, float(_makers(case)[0][0].depth))) < PAIR:
        return None
    try:
        return analysed(case, run)
    except (ParisphError, ValueError) as problem:
        return {"reason": str(problem)}


def analysed(case: Case, run: Recorded, probes: Sequence[str] | None = None, period: float | None = None,
             depth: float | None = None, start: float | None = None, end: float | None = None) -> dict[str, Any]:
    """Return incident and reflected waves as {entry: value}.

    probes : names of two or more gauges, in arrays as "gauges.x1"; default the two or three that separate best
    period : of regular waves [s]; default that of the wavemaker. Without a period the waves are irregular
    depth : at the gauges [m]; default that of the wavemaker, or of the water at the start
    start, end : of the analysis [s]; default the last whole periods of regular waves, at most ten, and all times of
        irregular ones after their arrival at the farthest gauge

    Returns probes, places [m], depth [m], period, start, end [s]; length [m] of the waves; whether they are regular;
    heights `incident` and `reflected` [m], significant heights of irregular waves; coefficient and residual, relative.
    Waves towards +x are incident, unless the wavemaker faces -x. bands of irregular waves have frequency [Hz],
    incident, reflected [m2/Hz] and coefficient, None where the gauges do not separate.

    Raises CaseError for gauges or times that cannot be used.
    """
    made = next((wave for wave, _ in _makers(case)), None)
    if period is not None and not period > 0.0:
        raise CaseError(f"--period {period:g}: must be greater than 0")
    if period is None and made is not None and not isinstance(made, (Jonswap, SolitaryWave)):
        period = float(made.period)
    regular, depth, g = period is not None, _depth(case, made, depth), _gravity(case)
    peak = period or (float(made.period) if isinstance(made, Jonswap) else None)
    k = _wave_number(made, peak, depth, g) if peak else None
    names = _chosen(case, k, depth) if probes is None else list(probes)
    places = _places(case, names)
    time, rows = _series(run, names)
    start, end = _window(case, places, time, peak if regular else None, k, depth, (start, end))
    inside = (time >= start) & (time <= end)
    if np.count_nonzero(inside) < 3:
        raise CaseError(f"from {start:.4g} to {end:.4g} s there are fewer than three samples: give other times")
    time, rows = time[inside], rows[:, inside]
    about = {"probes": names, "places": places, "depth": depth, "regular": regular,
             "start": float(time[0]), "end": float(time[-1])}
    backwards = made is not None and bool(getattr(made, "leftward", False))
    try:
        if regular and period and k:
            found = separated(time, rows, places, period, k)
            heights = (2.0 * found.incident, 2.0 * found.reflected)
            about |= {"period": period, "length": 2.0 * np.pi / k, "residual": found.residual, "bands": None}
        else:
            many = spectra(time, rows, places, depth, g)
            heights = many.heights
            densities = (many.reflected, many.incident) if backwards else (many.incident, many.reflected)
            about |= {"period": peak, "length": 2.0 * np.pi / k if k else None, "residual": many.residual,
                      "bands": _bands(many.frequencies, *densities)}
    except ValueError as problem:
        raise CaseError(f"gauges {', '.join(names)}: {problem}; give others with --probes, or another time with "
                        "--from and --to") from None
    incident, reflected = heights[::-1] if backwards else heights
    return about | {"incident": incident, "reflected": reflected,
                    "coefficient": reflected / incident if incident > 0.0 else None}


def _places(case: Case, names: Sequence[str]) -> list[float]:
    """Return x [m] of the named gauges. Raises CaseError for another name."""
    there = surface_gauges(case.probes)
    for name in names:
        if name not in there:
            raise CaseError(f"there is no SurfaceGauge {shown(name)} (there is {listed(list(there)) or 'none'})")
    return [there[name].at for name in names]


def text(found: Mapping[str, Any]) -> str:
    """Return the result of `analysed` as lines."""
    share = "no incident waves" if found["coefficient"] is None else f"{found['coefficient']:.3g}"
    kind = "height" if found["regular"] else "significant height"
    of = f"T = {found['period']:.4g} s, length {found['length']:.4g} m, " if found["period"] else ""
    lines = [f"gauges {', '.join(found['probes'])} at x = {', '.join(f'{x:.6g}' for x in found['places'])} m, "
             f"t = {found['start']:.6g} to {found['end']:.6g} s",
             f"{'regular' if found['regular'] else 'irregular'} waves, {of}depth {found['depth']:.4g} m",
             f"incident {kind:<20} {found['incident']:.4g} m",
             f"reflected {kind:<19} {found['reflected']:.4g} m",
             f"{'reflection coefficient':<29} {share}",
             f"{'residual':<29} {found['residual']:.3g} of the amplitudes at the gauges"]
    bands = found.get("bands") or ()
    if bands:
        lines.append(f"{'frequency [Hz]':>15}{'incident [m2/Hz]':>20}{'reflected [m2/Hz]':>20}{'coefficient':>14}")
        lines += ["".join(f"{'-' if band[name] is None else format(band[name], '.4g'):>{width}}" for name, width in
                          (("frequency", 15), ("incident", 20), ("reflected", 20), ("coefficient", 14)))
                  for band in bands]
    return "\n".join(lines)


def _bands(frequencies: Floats, incident: Floats, reflected: Floats) -> list[dict[str, float | None]]:
    least = ENOUGH * np.nanmax(incident)
    return [{"frequency": float(f), "incident": _known(a), "reflected": _known(b),
             "coefficient": float(np.sqrt(b / a)) if a >= least else None}
            for f, a, b in zip(frequencies, incident, reflected)]


def _known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _makers(case: Case) -> list[tuple[Any, float]]:
    """Return (wave, x of its wavemaker [m]) of all wavemakers whose waves have a period."""
    found: list[tuple[Any, float]] = [(body.wave, body.place) for body in case.bodies
                                      if isinstance(body, (Piston, Flap))]
    found += [(zone.wave, zone.end) for zone in case.zones if isinstance(zone, Relaxation)]
    return [(wave, place) for wave, place in found if wave is not None and hasattr(wave, "period")]


def _gauges(case: Case, depth: float) -> dict[str, Gauge]:
    """Return {name: gauge} outside zones, sorted by x, from the wavemaker to the first gauge in another depth [m]."""
    found = [(name, probe) for name, probe in surface_gauges(case.probes).items()
             if not any(zone.start <= probe.at <= zone.end for zone in case.zones)]
    mesh = None if all(isinstance(body, (Tank, Piston, Flap)) for body in case.bodies) else build.scene_mesh(case)
    if found and mesh is not None:
        start = _makers(case)[0][1] if _makers(case) else -np.inf
        found.sort(key=lambda one: abs(one[1].at - start))
        places = np.array([probe.place for _, probe in found])
        beds = (UpperFaces(mesh.corners()).highest(places) if mesh.dim == 3 else
                columns.beds(mesh.corners(), places[:, 0], np.inf))
        wrong = np.abs(float(case.fluid_bounds[1][-1]) - beds - depth) > SAME_DEPTH * depth
        found = found[:int(np.argmax(wrong)) if wrong.any() else None]    # behind a bar the waves differ
    return dict(sorted(found, key=lambda one: one[1].at))


def _chosen(case: Case, k: float | None, depth: float) -> list[str]:
    """Return the names of the two or three gauges that separate the waves best."""
    gauges = dict(list(_gauges(case, depth).items())[:MANY])
    if len(gauges) < PAIR:
        raise CaseError(f"the run has {len(gauges) or 'no'} SurfaceGauge{'s' * (len(gauges) != 1)} over a level bed, "
                        f"{depth:.4g} m deep, outside sponges: two or three are needed")
    if k is None:
        raise CaseError("the case has no wavemaker with a period: give the period of regular waves with --period, or "
                        f"for irregular waves two or three gauges with --probes (there is {listed(list(gauges))})")
    for count in (TRIPLE, PAIR):
        groups = [group for group in combinations(gauges, count)
                  if gauges[group[-1]].at - gauges[group[0]].at <= LONG * 2.0 * np.pi / k]
        if groups:
            return list(max(groups, key=lambda group: spread([gauges[name].at for name in group], k)))
    raise CaseError(f"no two gauges are within {LONG:g} of the wave length, {2.0 * np.pi / k:.4g} m: put two or three "
                    "gauges a tenth to a third of it apart, or give others with --probes")


def _series(run: Recorded, names: Sequence[str]) -> tuple[Floats, Floats]:
    """Return the times (n,) of the first gauge, and the elevations of all gauges at these times (gauges, n)."""
    found: list[tuple[Floats, Floats]] = []
    for name in names:
        probe, _, inner = name.partition(".") if name not in run.probe_names else (name, "", "")
        table = run.probe(probe)
        found.append((table["time"], table[inner or own_columns(table)[0]]))
        if not np.isfinite(found[-1][1]).all():
            raise CaseError(f"the gauge {name} has no value at some times, without water there: give others with "
                            "--probes")
    time = found[0][0]
    if not len(time):
        raise CaseError(f"the gauge {names[0]} has no samples")
    return time, np.array([np.interp(time, *one) for one in found])


def _window(case: Case, places: Sequence[float], time: Floats, period: float | None, k: float | None, depth: float,
            asked: tuple[float | None, float | None]) -> tuple[float, float]:
    """Return start and end [s] of the analysis."""
    start, end = asked
    end = float(time[-1]) if end is None else end
    if start is None:
        start = float(time[0])
        if k is not None and _makers(case):
            away = max(abs(place - _makers(case)[0][1]) for place in places)
            length = 2.0 * np.pi / k
            slow = group_velocity(length, depth, _gravity(case))
            start = away / slow + SETTLED * (period or length / slow)
        if period is not None:
            whole = min(int((end - start) / period + 1e-6), PERIODS)
            if whole < 1:
                raise CaseError(f"the waves are settled at the farthest gauge from t = {start:.4g} s on, and the "
                                f"samples end at {end:.4g} s, less than a period later: run longer, or give --from")
            start = end - whole * period
    if not start < end:
        raise CaseError(f"from {start:.4g} to {end:.4g} s: the end must be after the start; the samples end at "
                        f"{time[-1]:.4g} s")
    return start, end


def _depth(case: Case, made: Any, depth: float | None) -> float:
    if depth is not None:
        if not depth > 0.0:
            raise CaseError(f"--depth {depth:g}: must be greater than 0")
        return depth
    if made is not None:
        return float(made.depth)
    return float(case.fluid_bounds[1][-1] - case.fluid_bounds[0][-1])


def _gravity(case: Case) -> float:
    force = case.constant_force
    if force is None or not force[-1] < 0.0:
        raise CaseError("the waves have no dispersion relation: gravity is not constant in the frame of the"
                        " tank, or does not point down")
    return -float(force[-1])


def _wave_number(made: Any, period: float, depth: float, g: float) -> float:
    """Return the wave number [1/m] of the wave that is made, else that of linear theory."""
    if made is not None and hasattr(made, "k") and made.period == period and made.depth == depth:
        return float(made.k)
    return float(wave_number(2.0 * np.pi / period, depth, g))
