"""Cases as JSON text with a schema version, as stored in case.json, snapshots and checkpoints."""

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
    """Return the case as JSON text with its schema version, and how its run was made (io.made), which is no part of it.
    """
    return json.dumps({"schema": SCHEMA, **json.loads(case.model_dump_json()), **({MADE: made} if made else {})})


def from_json(text: str, read_only: bool = False) -> Case:
    """Return the Case of a JSON text of this version or an older one.

    read_only : whether the run is only looked at; a case that this release cannot run is then no error

    Raises CaseError: the text is not JSON, not a case, or of a newer version; or its numerics differ from those asked
    for.
    """
    try:
        content = json.loads(text, object_pairs_hook=_each_once)
    except (ValueError, RecursionError) as error:
        said = str(error).partition("\n")[0][:80] or type(error).__name__
        raise CaseError(f"not a stored case: {said}") from None
    if not isinstance(content, dict):
        raise CaseError(f"not a stored case: it holds a {type(content).__name__}, not an object")
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
    content.pop("run", None)    # which run it is of (io.store); the case is the same in every run
    made = content.pop(MADE, None)    # how the run was made
    _keep_meaning(content, version)
    # through the text again: JSON has no tuples, and pydantic takes lists for them only from JSON
    case = Case.model_validate_json(json.dumps(content), context=READ_ONLY if read_only else None)
    case = case.of(made) if isinstance(made, dict) else case
    if case.asked is None:
        return case if version else _with_asked(case)
    if not read_only:
        _check_asked(case.numerics, case.asked)
    return case


def _keep_meaning(content: dict[str, Any], version: int) -> None:
    """Give an older stored text, where it is resolved, what it computed with before later fields existed."""
    numerics, probes = content.get("numerics"), content.get("probes")
    if not isinstance(numerics, dict) or numerics.get("kappa") is None:    # as the user gave it, not resolved
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
            probe.setdefault("radius", numerics.get("spacing"))    # the wall particles beside it


def _check_asked(used: Numerics, asked: Numerics) -> None:
    """Raise CaseError if a value that the user gave differs from the one that is used, as after an edit of only one."""
    given = asked.model_dump()
    own = {*PRESETS[asked.preset], *METHODS[asked.method].values}
    for name, value in used.model_dump().items():
        if given[name] != value and (given[name] is not None or name not in own):
            remedy = "edit both alike"
            if name in ("preset", "method"):    # the other values would stay those of the old one
                remedy = 'change it in "asked", remove "numerics" and rename "asked" to "numerics"'
            raise CaseError(f"numerics.{name} = {shown(value)}, but asked.{name} = {shown(given[name])}: {remedy}")


def _with_asked(case: Case) -> Case:
    """Return a case from before `asked` was stored with it: values of the preset were not given by the user."""
    numerics = case.numerics
    if numerics.resolved().model_dump() != numerics.model_dump():
        return case    # not resolved: these are the values that the user gave
    preset = preset_values(numerics.preset, case.closed)
    same = [name for name, value in preset.items() if getattr(numerics, name) == value]
    return case.model_copy(update={"asked": Numerics(**numerics.model_dump(exclude=set(same)))})


def _each_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Make the dict of a JSON object; of two values for one name, the last would win in silence."""
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        raise ValueError(f"{shown(next(name for name in found if names.count(name) > 1))} is given twice")
    return found
