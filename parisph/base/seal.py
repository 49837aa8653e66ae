"""JSON files that show whether they have been changed: an object contains the digest of all its other entries."""

import hashlib
import json

KEY = "digest"


def sealed(content: dict) -> dict:
    """Return a JSON object with its digest as the last entry."""
    content = {name: value for name, value in content.items() if name != KEY}
    return {**content, KEY: _digest(content)}


def opened(content: dict) -> tuple[dict, bool]:
    """Return a JSON object without its digest, and whether it is unchanged. True if it has no digest."""
    rest = {name: value for name, value in content.items() if name != KEY}
    return rest, content.get(KEY, None) in (None, _digest(rest))


def _digest(content):
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return hashlib.blake2b(text.encode("utf-8", "surrogatepass"), digest_size=16).hexdigest()
