"""The process that forks a child for each job of a local run: ``python -m pipeline.worker LISTENER < PIPE``.

It imports the study, JAX, the solvers, pydantic and matplotlib once, which would take every job two seconds.
LISTENER is the number of a listening socket, and the run of Snakemake holds the other end of PIPE. Worker and children
end when that run ends, even if it is killed. A child also ends with the command that requested it
(:mod:`pipeline.job`).
"""

import gc
import json
import os
import select
import signal
import socket
import sys
import threading
import traceback
from pathlib import Path
from typing import Any

import matplotlib.backends.backend_pdf
import matplotlib.pyplot  # noqa: F401

from pipeline import configuration, measured  # noqa: F401
from study.declaration.experiment import discover


def _end_with(*ends: Any) -> None:
    """End this process as soon as the other end of one of these pipes or connections is closed."""
    select.select(ends, [], [])
    os._exit(1)


def _say(message: str, terminal: int) -> None:
    """Print a message to the log of the job, or to the terminal if the disk of the log is full."""
    try:
        print(message, file=sys.stderr, flush=True)
    except OSError:
        os.write(terminal, f"{message}\n".encode())


def _run(connection: socket.socket) -> None:
    """Run the command that a connection sends, with the output streams that it sends; reply 0 on success, else 1."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    _, streams, _, _ = socket.recv_fds(connection, 1, 2)
    terminal = os.dup(2)
    for stream, number in zip(streams, (1, 2), strict=True):
        os.dup2(stream, number)
    command = json.loads(connection.makefile().readline())
    threading.Thread(target=_end_with, args=(connection, sys.stdin), daemon=True).start()
    status = b"1"
    try:
        measured.run(*command)
        status = b"0"
    except SystemExit as end:
        if isinstance(end.code, str):
            _say(end.code, terminal)
    except BaseException:
        _say(traceback.format_exc(), terminal)
    sys.stdout.flush()
    connection.sendall(status)


def main(listener: socket.socket) -> None:
    """Fork a child for each connection until the run of Snakemake ends."""
    discover()
    gc.freeze()  # imported objects are never freed, so the garbage collector of a child skips them
    gc.set_threshold(50_000, 20, 50)  # by Python's own thresholds it takes one twentieth of the time of a job
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    while True:
        ready, _, _ = select.select([listener, sys.stdin], [], [])
        if sys.stdin in ready:
            Path(listener.getsockname()).unlink(missing_ok=True)
            return
        connection, _ = listener.accept()
        if os.fork() == 0:
            listener.close()
            try:
                _run(connection)
            finally:
                os._exit(0)
        connection.close()


if __name__ == "__main__":
    main(socket.socket(fileno=int(sys.argv[1])))
