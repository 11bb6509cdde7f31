"""Files of the paper, which appear whole or not at all."""

import os
import secrets
import shutil
from pathlib import Path


def write(path: Path, content: str | bytes) -> None:
    """Write a file under a name that nobody can guess, and give it its own when it is complete and on the disk.

    Raises
    ------
    SystemExit
        If the disk is full, or the file cannot be written for another reason. What was there before stays.
    """
    unfinished = path.with_name(f".{path.name}.{os.getpid()}.{secrets.token_hex(8)}.unfinished")
    try:
        with unfinished.open("xb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
        unfinished.replace(path)
    except OSError as error:
        free = shutil.disk_usage(path.parent).free
        raise SystemExit(f"'{path}' cannot be written: {error.strerror}, {free:,} bytes are free.") from None
    finally:
        unfinished.unlink(missing_ok=True)
