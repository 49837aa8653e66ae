"""JSON files that show whether they have been changed: an object contains the digest of all its other entries.

How a run was made has a digest of its own, so that the digest of a case is the same whoever runs it.
"""

import hashlib
import json
from collections.abc import Mapping
from typing import Any

KEY, MADE = "digest", "made"


def sealed(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return a JSON object with its digest as the last entry."""
    content = {name: value for name, value in content.items() if name != KEY}
    made = content.get(MADE)
    if isinstance(made, dict):
        content[MADE] = sealed(made)
    return {**content, KEY: _digest(content)}


def opened(content: Mapping[str, Any]) -> tuple[dict[str, Any], bool]:
    """Return a JSON object without its digest, and whether it is unchanged. True if it has no digest."""
    rest = {name: value for name, value in content.items() if name != KEY}
    sound = content.get(KEY, None) in (None, _digest(rest))
    if isinstance(rest.get(MADE), dict):
        rest[MADE], whole = opened(rest[MADE])
        sound = sound and whole
    return rest, sound


def _digest(content: dict[str, Any]) -> str:
    content = {name: value for name, value in content.items() if name != MADE}
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return hashlib.blake2b(text.encode("utf-8", "surrogatepass"), digest_size=16).hexdigest()
