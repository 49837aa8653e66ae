"""Cases as JSON text with a schema version, as stored in case.json, snapshots and checkpoints."""

import json

from parisph.base.errors import CaseError
from parisph.base.seal import opened
from parisph.base.text import shown
from parisph.case.schema import READ_ONLY, Case

# Version of the fields of a case. Raise it when a field is renamed, removed or changes its meaning;
# a new field with a default needs no new version. Texts without a version are from before 1 and have the same fields.
SCHEMA = 1


def to_json(case: Case) -> str:
    """Return the case as JSON text with its schema version."""
    return json.dumps({"schema": SCHEMA, **json.loads(case.model_dump_json())})


def from_json(text: str, read_only: bool = False) -> Case:
    """Return the Case of a JSON text of this version or an older one.

    read_only : whether the run is only looked at; a case that this release cannot run is then no error

    Raises CaseError: the text is not JSON, not a case, or of a newer version.
    """
    try:
        content = json.loads(text, object_pairs_hook=_each_once)
    except (ValueError, RecursionError) as error:
        raise CaseError(f"not a stored case: {_first_line(error)}") from None
    if not isinstance(content, dict):
        raise CaseError(f"not a stored case: it holds a {type(content).__name__}, not an object")
    version = content.get("schema", 0)
    if not isinstance(version, int) or isinstance(version, bool) or version < 0:
        raise CaseError(f"schema = {version!r:.40}: must be a whole number; the file was not written by parisph")
    if version > SCHEMA:
        raise CaseError(f"schema = {version}: was written by a newer parisph; this one reads up to schema {SCHEMA}, so update parisph")
    content, sound = opened(content)
    if not sound:
        raise CaseError('it does not match its digest: it is damaged, or was edited. After an edit take the line "digest" out')
    content.pop("schema", None)
    content.pop("run", None)    # which run it is of (io.store); the case is the same in every run
    # through the text again: JSON has no tuples, and pydantic takes lists for them only from JSON
    return Case.model_validate_json(json.dumps(content), context=READ_ONLY if read_only else None)


def _each_once(pairs: list) -> dict:
    """Make the dict of a JSON object; of two values for one name, the last would win in silence."""
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        raise ValueError(f"{shown(next(name for name in found if names.count(name) > 1))} is given twice")
    return found


def _first_line(error: Exception) -> str:
    return str(error).partition("\n")[0][:80] or type(error).__name__
