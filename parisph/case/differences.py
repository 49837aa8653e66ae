"""Short labels that distinguish stored cases, for runs drawn in one picture."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

FIRST = ("spacing", "preset", "method", "time_step", "jitter", "seed")    # numerics that runs usually compare
ASIDE = ("run", "schema", "digest", "made", "made_digest", "probes", "output", "asked")    # do not change the flow
LAST = ("end_time", "title")    # named only if nothing else distinguishes two cases
MOST = 3    # fields of a label, unless more are needed
MANY = 6    # most differing fields of one scene; if more differ, labels start with the title
Fields = dict[str, Any]


def labels(cases: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return a label of each of several cases (dicts, as in case.json) that tells it from the others, else "".

    Labels name the parameters of case(...), such as "spacing 0.01, seed 2", if these distinguish the cases, else the
    fields of the cases. Equal cases have the same label.
    """
    given = [_parameters(case) for case in cases]
    found = _labels(given) if all(given) else []
    fields = [_fields(case) for case in cases]
    if found and len(set(found)) == len(set(map(str, fields))):
        return found
    return _labels(fields)


def _labels(fields: Sequence[Fields]) -> list[str]:
    names = list(dict.fromkeys(name for one in fields for name in one))
    differing = sorted((name for name in names if any(_value(one, name) != _value(fields[0], name) for one in fields)),
                       key=_rank)
    scenes = "title" in differing and len(differing) > MANY
    if scenes:
        differing = ["title", *(name for name in differing if name != "title")]
    kept: list[str] = []
    for name in differing:
        separates = len({_key(one, [*kept, name]) for one in fields}) > len({_key(one, kept) for one in fields})
        if separates or not (scenes or len(kept) >= MOST or _follows(name, kept)):
            kept.append(name)
    words = {name: _short(name, kept) for name in kept}
    columns = {name: _texts([_value(one, name) for one in fields]) for name in kept}
    return [", ".join(f"{words[name]} {columns[name][k]}".strip() for name in kept) for k in range(len(fields))]


def _parameters(case: Mapping[str, Any]) -> Fields:
    about = case.get("made")
    found = about.get("parameters") if isinstance(about, Mapping) else None
    return dict(found) if isinstance(found, Mapping) else {}


def _fields(case: Mapping[str, Any]) -> Fields:
    """Return the fields of a case that affect the flow, {name with dots: value}; the numerics as the user gave them."""
    content = {name: value for name, value in case.items() if name not in ASIDE}
    if case.get("asked"):
        content["numerics"] = case["asked"]
    return dict(_flat(content, ""))


def _flat(value: Any, name: str) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for key, part in value.items():
            yield from _flat(part, f"{name}.{key}" if name else str(key))
    elif isinstance(value, list) and any(isinstance(part, Mapping) for part in value):
        for number, part in enumerate(value):
            yield from _flat(part, f"{name}.{part.get('name') or number}" if isinstance(part, Mapping) else name)
    else:
        yield name, value


def _value(fields: Fields, name: str) -> Any:
    return fields.get(name, "none")


def _key(fields: Fields, names: Sequence[str]) -> str:
    return str([_value(fields, name) for name in names])


def _rank(name: str) -> tuple[int, int]:
    """Return the sort key of a field that differs: what runs usually compare comes first."""
    leaf = name.removeprefix("numerics.")
    if leaf in FIRST:
        return 0, FIRST.index(leaf)
    return (3 if name in LAST else 2 if name.startswith("numerics.") else 1), 0 if name.endswith(".kind") else 1


def _follows(name: str, kept: Sequence[str]) -> bool:
    """Return whether a field differs only because the kind of its record does, which the label names."""
    return name in LAST or any(other.endswith("kind") and name.startswith(other.removesuffix("kind")) for other in kept)


def _short(name: str, names: Sequence[str]) -> str:
    """Return the shortest unique end of a name: at least one word for numerics, else two."""
    if name == "title":
        return ""
    words = name.split(".")
    few = 1 if words[0] == "numerics" else 2
    while any(other != name and other.split(".")[-few:] == words[-few:] for other in names) and few < len(words):
        few += 1
    return ".".join(words[-few:])


def _texts(values: Sequence[Any]) -> list[str]:
    """Return values as short texts, with as many digits as distinguish them."""
    different = len(set(map(str, values)))
    for digits in (4, 6, 9, 12):
        texts = [_text(value, digits) for value in values]
        if len(set(texts)) == different:
            return texts
    return [_text(value, 17) for value in values]


def _text(value: Any, digits: int) -> str:
    if value is None:
        return "none"
    if isinstance(value, float):
        return f"{value:.{digits}g}"
    if isinstance(value, list):
        text = ", ".join(_text(part, digits) for part in value[:4]) + ", ..." * (len(value) > 4)
        return f"({text})"
    text = str(value)
    return text if len(text) <= 24 else f"{text[:21]}..."
