"""Digests in JSON files, which show later changes. The digest of an object is that of its other entries.

The entry `made` (how a run was made) has its own digest, so that equal cases have equal digests.
"""

import hashlib
import json
from collections.abc import Mapping
from typing import Any

KEY, MADE, OF_MADE = "digest", "made", "made_digest"


def with_digest(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return a JSON object with its digest as the first entry. The file stays valid JSON without that line."""
    content = {name: value for name, value in content.items() if name not in (KEY, OF_MADE)}
    made = content.get(MADE)
    return {KEY: _digest(content), **content, **({OF_MADE: _digest(made)} if isinstance(made, dict) else {})}


def without_digest(content: Mapping[str, Any]) -> tuple[dict[str, Any], bool]:
    """Return a JSON object without its digest, and whether it is unchanged. True if it has no digest."""
    rest = {name: value for name, value in content.items() if name not in (KEY, OF_MADE)}
    if content.get(KEY) is None:
        return rest, True
    made = rest.get(MADE)
    sound = not isinstance(made, dict) or content.get(OF_MADE) == _digest(made)
    return rest, sound and content[KEY] == _digest(rest)


def _digest(content: dict[str, Any]) -> str:
    content = {name: value for name, value in content.items() if name != MADE or not isinstance(value, dict)}
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return hashlib.blake2b(text.encode("utf-8", "surrogatepass"), digest_size=16).hexdigest()
