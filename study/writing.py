"""Files that appear whole or not at all, with a sentence where they cannot be written."""

import errno
import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

#: Bytes that are written to find out why a library failed to write.
_PROBE = 1 << 16
#: Bytes that a folder must have free for work in it.
_ROOM = 1 << 24


class NotWritten(OSError):
    """A file could not be written; the message names it, the reason, and the space that is free."""


def check_writable(path: str | Path) -> Path:
    """Make the folder of a file and check that the file can be written.

    Raises
    ------
    NotWritten
        If it cannot; the message says why.
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise NotWritten(f"the results folder '{path.parent}' cannot be made: {error.strerror}.") from None
    if not os.access(path.parent, os.W_OK):
        raise NotWritten(f"the results folder '{path.parent}' is not writable; choose one that is.")
    if path.is_dir():
        raise NotWritten(f"'{path}' is a folder, and the name of a file is needed.")
    return path


def lack_of_room(*folders: Path) -> str:
    """A sentence on the first folder with too little room to work in; none if all have more."""
    for folder in folders:
        free = shutil.disk_usage(folder).free
        if free < _ROOM:
            return f"only {free:,} bytes are free in '{folder}': make room, and call again."
    return ""


@contextmanager
def whole(path: str | Path) -> Iterator[Path]:
    """A new file beside ``path`` to write to, which takes its place when it is complete and on the disk.

    Each writer has a file of its own, whose name holds its process and cannot be guessed, and removes that file alone:
    of several writers the last one wins, and readers see one of the complete files.

    Raises
    ------
    NotWritten
        If the disk is full, or the file cannot be written for another reason. What was there before stays.
    """
    path = check_writable(path)
    unfinished = path.with_name(f".{path.name}.{os.getpid()}.{secrets.token_hex(8)}.unfinished")
    try:
        unfinished.open("x").close()
        yield unfinished
        with unfinished.open("rb") as file:
            os.fsync(file.fileno())
        os.replace(unfinished, path)
    except (OSError, RuntimeError) as error:  # netCDF raises both, and does not tell of a full disk
        reason, free = _reason(error, unfinished), shutil.disk_usage(path.parent).free
        raise NotWritten(f"'{path}' cannot be written: {reason}, {free:,} bytes are free.") from error
    finally:
        unfinished.unlink(missing_ok=True)


def _reason(error: OSError | RuntimeError, unfinished: Path) -> str:
    """Why the file could not be written, in the words of the system.

    Libraries tell of a full disk in other words, or of a lack of permission, so some bytes more are tried first.
    """
    try:
        with unfinished.open("ab") as probe:  # what is written keeps its place
            probe.write(bytes(_PROBE))
            probe.flush()
            os.fsync(probe.fileno())
    except OSError as found:
        return str(found.strerror)
    return str(error.strerror) if isinstance(error, OSError) and error.errno in errno.errorcode else str(error)
