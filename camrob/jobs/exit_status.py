"""What a failed job means to its user: a status, and one line. Light, for the command line imports it at its start."""

from __future__ import annotations

import errno

from camrob.errors import CamrobError, InputError, StaleInputError
from camrob.text import printable

__all__ = ["CHECK_FAILED", "DONE", "INPUT_WRONG", "NOT_SAFE", "disk_full", "failure_line", "failure_status"]

DONE, CHECK_FAILED, INPUT_WRONG, NOT_SAFE = 0, 1, 2, 3
"""The contract's statuses; the larger, the worse."""


def failure_status(error: BaseException) -> int:
    """The status that an error of a job stands for: 2 for a wrong input, 3 for a job that can't be done safely."""
    return INPUT_WRONG if isinstance(error, InputError | StaleInputError | OSError) else NOT_SAFE


def disk_full(error: OSError) -> bool:
    """Whether there is no room left for what was to be written, on the disk, in its owner's quota or in one file."""
    return error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def failure_line(error: BaseException) -> str:
    """What the user reads, in one line of printable characters."""
    if isinstance(error, CamrobError):
        text = str(error)
    elif isinstance(error, OSError) and disk_full(error):
        where = "" if error.filename is None else f"{error.filename}: "
        text = f"{where}disk full; free some space where the job writes and where temporary files are kept"
    elif isinstance(error, OSError) and error.filename is not None:
        text = f"{error.filename}: {error.strerror or 'input or output failed'}; check the path and its permissions"
    elif isinstance(error, MemoryError):
        text = "there is not enough memory for this job; split the CL file into operations"
    else:
        text = f"internal error ({type(error).__name__}: {error}); please report it with the files that led to it"
    return " ".join(printable(text).split())
