"""The table of long runs: one row for each, one table for each part."""

from tests.hard.table import ENDED, Outcome


def text(outcomes: list[Outcome], before: list[Outcome] | None = None) -> str:
    """Return the outcomes as Markdown tables; what does not meet its requirement is marked NO.

    before : outcomes of an earlier time; their values follow in brackets
    """
    earlier = {found.scene: found for found in before or ()}
    parts = dict.fromkeys(found.scene.partition("-")[0] for found in outcomes)
    return "\n\n".join(_table([found for found in outcomes if found.scene.partition("-")[0] == part], earlier)
                       for part in parts)


def _table(outcomes, earlier):
    columns = list(dict.fromkeys(line.what for found in outcomes for line in found.lines))
    head = ["run", *(_head(what, outcomes) for what in columns), "steps", "CPU s", "end"]
    rows = [head, ["---"] * len(head)]
    for found in outcomes:
        old = earlier.get(found.scene)
        rows.append([found.scene, *(_cell(what, found, old) for what in columns),
                     _both(found.steps, old and old.steps), _both(found.cpu_seconds, old and old.cpu_seconds),
                     ("" if found.ended == ENDED else found.ended) + _old_end(old)])
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def _head(what, outcomes):
    limits = {line.limits()[0] for found in outcomes for line in found.lines if line.what == what} - {""}
    return f"{what} ({', '.join(sorted(limits))})" if limits else what


def _cell(what, found, old):
    line, past = _line(what, found), old and _line(what, old)
    if line is None:
        return ""
    return _both(line.value, past and past.value) + (" NO" if line.met is False else "")


def _line(what, outcome):
    return next((line for line in outcome.lines if line.what == what), None)


def _both(value, past):
    return f"{value:.3g}" + ("" if past is None else f" ({past:.3g})")


def _old_end(old):
    return "" if old is None or old.ended == ENDED else f" (before: {old.ended})"
