"""One bad input: what is typed, in which folder, and what must be said of it."""

from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class Attempt:
    """A command line that must be refused.

    what : for people
    words : the command line behind `parisph`; '{run}' in it stands for a sound run, not to be changed
    says : texts of which the message must hold one: the field, or the path
    files : {name: text, bytes, None for a folder, or function(path, sound run) that makes it} of the current folder
    codes : exit codes that are right
    """

    what: str
    words: list
    says: list
    files: dict = field(default_factory=dict)
    codes: tuple = (2,)

    def prepare(self, folder: Path, sound: Path) -> None:
        """Make the files in an empty folder."""
        for name, content in self.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            if content is None:
                path.mkdir()
            elif callable(content):
                content(path, sound)
            else:
                path.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8", "surrogateescape"))
