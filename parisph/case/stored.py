"""Cases as JSON text with a schema version, as in case.json, snapshots and checkpoints."""

import json
from collections.abc import Mapping
from typing import Any

from parisph.base.errors import CaseError
from parisph.base.json_digest import MADE, without_digest
from parisph.base.text import shown
from parisph.case.methods import METHODS
from parisph.case.numerics import Numerics
from parisph.case.presets import PRESETS, WITHOUT_FILMS, preset_values
from parisph.case.schema import READ_ONLY, Case

# Version of the fields of a case. Raise it when a field is renamed, removed or changes its meaning;
# a new field with a default needs no new version. Texts without a version are from before 1 and have the same fields.
# 2: regularisation in proportion to the strain of a step.
# 3: the amplitude of a Roll, which was its angle.
SCHEMA = 3


def to_json(case: Case, made: Mapping[str, Any] | None = None) -> str:
    """Return the case as JSON text with its schema version; made : how its run was made (io.made)"""
    return json.dumps({"schema": SCHEMA, **json.loads(case.model_dump_json()), **({MADE: made} if made else {})})


def from_json(text: str, read_only: bool = False) -> Case:
    """Return the Case of a JSON text of this version or an older one.

    read_only : whether to accept a case that this release cannot run, to open its run for reading

    Raises CaseError: the text is not JSON, not a case, or of a newer version; or `numerics` and `asked` differ.
    """
    try:
        content = json.loads(text, object_pairs_hook=_each_once)
    except (ValueError, RecursionError) as error:
        said = str(error).partition("\n")[0][:80] or type(error).__name__
        raise CaseError(f"not a stored case: {said}") from None
    if not isinstance(content, dict):
        raise CaseError(f"not a stored case: it contains a {type(content).__name__}, not an object")
    version = content.get("schema", 0)
    if not isinstance(version, int) or isinstance(version, bool) or version < 0:
        raise CaseError(f"schema = {version!r:.40}: must be a whole number; the file was not written by parisph")
    if version > SCHEMA:
        raise CaseError(f"schema = {version}: was written by a newer parisph; this one reads up to schema {SCHEMA}, "
                        "so update parisph")
    content, sound = without_digest(content)
    if not sound:
        raise CaseError('it does not match its digest: it is damaged or was edited. If you edited it, '
                        'remove the line "digest"')
    content.pop("schema", None)
    content.pop("run", None)    # the run that stored it (io.store)
    made = content.pop(MADE, None)
    _keep_meaning(content, version)
    # as text again: pydantic accepts lists for tuples only from JSON
    case = Case.model_validate_json(json.dumps(content), context=READ_ONLY if read_only else None)
    case = case.of(made) if isinstance(made, dict) else case
    if case.asked is None:
        return case if version else _with_asked(case)
    if not read_only:
        _check_asked(case.numerics, case.asked)
    return case


def _keep_meaning(content: dict[str, Any], version: int) -> None:
    """Add the values of later fields that an older, resolved text was computed with."""
    numerics, probes = content.get("numerics"), content.get("probes")
    if not isinstance(numerics, dict) or numerics.get("kappa") is None:    # not resolved
        return
    later = ["residual_strain", "pressure_mean", "volume_time", "wave_step"]
    if version < 2:
        later += ["kappa_strain", "shift_strain", "filter_strain", "fall", "surface_offset"]
    for name in later:
        numerics.setdefault(name, 0.0)
    if numerics.get("regularisers") is None:
        numerics["regularisers"] = list(WITHOUT_FILMS)
    for probe in probes if isinstance(probes, list) else ():
        if isinstance(probe, dict) and probe.get("kind") == "pressure_tap":
            probe.setdefault("radius", numerics.get("spacing"))    # beside it


def _check_asked(used: Numerics, asked: Numerics) -> None:
    """Raise CaseError if a value given by the user differs from the used one, as after an edit of only one."""
    given = asked.model_dump()
    own = {*PRESETS[asked.preset], *METHODS[asked.method].values}
    for name, value in used.model_dump().items():
        if given[name] != value and (given[name] is not None or name not in own):
            remedy = "edit both equally"
            if name in ("preset", "method"):    # or the values of the old one would stay
                remedy = 'change it in "asked", remove "numerics" and rename "asked" to "numerics"'
            raise CaseError(f"numerics.{name} = {shown(value)}, but asked.{name} = {shown(given[name])}: {remedy}")


def _with_asked(case: Case) -> Case:
    """Return a case stored before `asked` existed, with it: values of the preset were not given by the user."""
    numerics = case.numerics
    if numerics.resolved().model_dump() != numerics.model_dump():
        return case    # not resolved: all values are the user's
    preset = preset_values(numerics.preset, case.closed)
    same = [name for name, value in preset.items() if getattr(numerics, name) == value]
    return case.model_copy(update={"asked": Numerics(**numerics.model_dump(exclude=set(same)))})


def _each_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Make the dict of a JSON object. Raises ValueError if a name is given twice."""
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        raise ValueError(f"{shown(next(name for name in found if names.count(name) > 1))} is given twice")
    return found
