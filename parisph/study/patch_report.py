"""Tables of a patch study in Markdown, and its files results.json and results.csv."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from parisph.base import markdown
from parisph.base.arrays import Ints
from parisph.study import study_folder
from parisph.study.fits import fitted_order
from parisph.study.patch_study import Histogram, PatchStudy
from parisph.study.patch_tasks import NORMS, PatchResult, tasks
from parisph.study.plan import code_version
from parisph.study.report import spread
from parisph.study.results import grouped

ROUNDING = 1e-11    # largest error of an exact operator

LOST = "- lost: particles without a value, which are left out; in a solution, their row is the mean of their neighbours"
KINDS = {"laplacian": "Laplacian", "gradient": "Gradient"}
PATCHES = {
    "interior": "in the interior", "square": "in the square, rim included",
    "dirichlet": "solution with p given on all sides", "neumann": "solution with walls on all sides but one",
    "closed": "solution with walls on all sides", "walls": "beside walls", "surface": "at a free surface",
}


def groups(results: Iterable[PatchResult]) -> dict[tuple[str, ...], list[PatchResult]]:
    """Return the results of each table, see Task.group."""
    return grouped(results, lambda one: one.task.group)


def curves(results: Iterable[PatchResult]) -> dict[str, list[PatchResult]]:
    """Return {label of the operator: results} in the given order."""
    return grouped(results, lambda one: one.task.operator.label)


def families(results: Iterable[PatchResult]) -> dict[tuple[str, float, float], list[PatchResult]]:
    """Return results that differ only by their seed, by operator, jitter and spacing."""
    return grouped(results, lambda one: (one.task.operator.label, one.task.jitter, one.task.spacing))


def heading(results: Sequence[PatchResult]) -> str:
    """Return the title of a group of results."""
    task = results[0].task
    formula = f" = {task.field.formula}" if task.field.formula else ""
    walls = f" ({task.operator.walls} rows)" if task.operator.walls else ""
    return f"{KINDS[task.operator.kind]} {PATCHES[task.patch]}{walls}: {task.field.name}{formula}"


def names_in(results: Iterable[PatchResult]) -> list[str]:
    """Return the names of the norms in the results, in the order of NORMS."""
    there = {name for one in results for name in one.norms}
    return [name for name in NORMS if name in there]


def table(results: Sequence[PatchResult], study: PatchStudy) -> str:
    """Return tables, fitted orders and counts of the histograms as text. Several seeds: mean (least to largest)."""
    if not results:
        return "nothing has been done yet"
    parts = []
    for group in groups(results).values():
        names = names_in(group)
        rows = [[label, f"{s:.4g}", f"{k:g}", str(len(family)), _many(family, "particles"), _many(family, "lost"),
                 *(spread(one.norms.get(name) for one in family) for name in names)]
                for (label, k, s), family in families(group).items()]
        head = ["operator", "spacing", "k", "seeds", "particles", "lost", *names]
        parts += [f"## {heading(group)}", markdown.table(head, rows)]
        parts += _orders(group, names)
        problems = [f"{one.task.described()}: {one.problem}" for one in group if one.problem]
        parts += ["\n".join(problems)] if problems else []
    for histogram in study.histograms:
        parts += _counted(results, histogram)
    parts.append("\n".join([*(f"- {name}: {NORMS[name]}" for name in names_in(results)), LOST]))
    return "\n\n".join(parts)


def orders(results: Sequence[PatchResult], name: str) -> dict[tuple[str, float], float]:
    """Return {(operator, jitter): fitted order of a norm in the spacing}, for two or more spacings.

    Exact operators are left out: rounding has no order.
    """
    found = {}
    for label, curve in curves(results).items():
        for k in dict.fromkeys(one.task.jitter for one in curve):
            dots = [(s, _mean(family, name)) for (_, jitter, s), family in families(curve).items() if jitter == k]
            order = fitted_order([s for s, _ in dots], [mean for _, mean in dots])
            if order is not None and not all(mean is None or mean < ROUNDING for _, mean in dots):
                found[label, k] = order
    return found


def _orders(results: Sequence[PatchResult], names: Sequence[str]) -> list[str]:
    """Return title and table of the fitted orders of each operator and jitter, [] without any."""
    found = {name: orders(results, name) for name in names}
    places = dict.fromkeys(place for one in found.values() for place in one)
    rows = [[label, f"{k:g}", *(f"{one[label, k]:.2f}" if (label, k) in one else "-" for one in found.values())]
            for label, k in places]
    return ["Fitted orders in the spacing:", markdown.table(["operator", "k", *names], rows)] if rows else []


def ranges(histogram: Histogram) -> list[str]:
    """Return the names of the ranges of a histogram, the open one last."""
    edges = [f"{100.0 * edge:g}" for edge in histogram.edges]
    return [*(f"{low}-{high} %" for low, high in zip(edges, edges[1:])), f"> {edges[-1]} %"]


def counts(results: Iterable[PatchResult], histogram: Histogram) -> dict[str, Ints]:
    """Return {field and operator: (seeds, ranges) numbers of particles}, of Laplacians in the interior."""
    found: dict[str, list[Ints]] = {}
    several = len({one.task.field.name for one in results}) > 1
    for one in results:
        task = one.task
        if len(one.sizes) and (task.spacing, task.jitter) == (histogram.spacing, histogram.jitter):
            label = f"{task.field.name}, {task.operator.label}" if several else task.operator.label
            found.setdefault(label, []).append(np.histogram(one.sizes, [*histogram.edges, np.inf])[0])
    return {label: np.array(seeds) for label, seeds in found.items()}


def _counted(results: Sequence[PatchResult], histogram: Histogram) -> list[str]:
    found = counts(results, histogram)
    if not found:
        return []
    rows = [[label, *(f"{mean:.0f} ({low} to {high})" if low != high else str(low) for mean, low, high in
                      zip(seeds.mean(axis=0), seeds.min(axis=0), seeds.max(axis=0)))] for label, seeds in found.items()]
    title = ("## Particles by the error of their Laplacian over its amplitude, "
             f"s = {histogram.spacing:.4g}, k = {histogram.jitter:g}")
    return [title, markdown.table(["operator", *ranges(histogram)], rows)]


def _many(family: Sequence[PatchResult], name: str) -> str:
    values = [getattr(one, name) for one in family]
    low, high = min(values), max(values)
    return str(low) if low == high else f"{low} to {high}"


def _mean(family: Sequence[PatchResult], name: str) -> float | None:
    values = [one.norms[name] for one in family if name in one.norms]
    return float(np.mean(values)) if values else None


def listing(study: PatchStudy, only: Sequence[str] = ()) -> str:
    """Return the tests of a study as text. Raises CaseError as patch_tasks.tasks."""
    found = groups(PatchResult(task) for task in tasks(study, only))
    rows = [[heading(group), ", ".join(dict.fromkeys(one.task.operator.label for one in group)), str(len(group)),
             str(len(families(group)))] for group in found.values()]
    return "\n\n".join([study.title or "patch study", markdown.table(["patch", "operators", "tests", "points"], rows)])


def save(results: Sequence[PatchResult], study: PatchStudy, folder: Path, missing: int) -> None:
    """Write results.json and results.csv. missing : tests without a result. Raises StoreError."""
    content: dict[str, Any] = {
        "title": study.title, "code_version": code_version(), "missing": missing, "norms": NORMS,
        "histograms": [{"spacing": one.spacing, "jitter": one.jitter, "ranges": ranges(one),
                        "counts": {label: seeds.tolist() for label, seeds in counts(results, one).items()}}
                       for one in study.histograms]}
    study_folder.save(folder, content, [one.line() for one in results], "tests")
