"""Paths of published measurements that parisph does not contain.

The folder is a case's parameter `data`, else the environment variable PARISPH_MEASURED, else
`shared/reference/measured` beside the clone.
"""

import os
from pathlib import Path

from parisph.base import paths
from parisph.base.errors import CaseError
from parisph.base.log import logger
from parisph.base.text import named

VARIABLE = "PARISPH_MEASURED"
BESIDE = "../../shared/reference/measured"    # from the folder of a case file, cases/


def measured(file: str, data: str = "") -> str | None:
    """Return the path of a file of measured data, else log a warning and return None. Not collective.

    file : its name; data : folder given by the user, or ""
    Raises CaseError if the user gave a folder without the file.
    """
    path = _folder(data) / paths.checked(file, "file")
    if path.is_file():
        return str(path.resolve())
    if data:
        raise CaseError(f"data = {named(data)}: there is no {named(file)} in it")
    logger.warning(f"there is no {named(path)}: nothing is compared with it ({_remedy()})")
    return None


def needed(file: str, what: str, data: str = "") -> str:
    """Return the path of a file that a case needs. Raises CaseError if it is missing.

    what : name of the data, for the message
    """
    path = _folder(data) / paths.checked(file, "file")
    if not path.is_file():
        raise CaseError(f"{what} is missing: there is no {named(path)}; {_remedy()}")
    return str(path.resolve())


def _folder(data: str) -> Path:
    given = data or os.environ.get(VARIABLE, "")
    return paths.checked(given, "data") if given else (paths.FOLDER.get() / BESIDE).resolve()


def _remedy() -> str:
    return f"give the folder with --set data=FOLDER, or in the environment as {VARIABLE}"
