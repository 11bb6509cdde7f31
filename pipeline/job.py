"""Run a module as a job of the pipeline: ``python -S pipeline/job.py FILE MODULE ARGUMENT...``.

The worker of the run, which has imported the study, forks a child for the job (:mod:`pipeline.worker`). If there is no
worker to use, the script runs ``python -m pipeline.measured FILE MODULE ARGUMENT...``. This is the case on a node of a
cluster, in a call by hand, and in an environment other than the environment of the worker. FILE receives the time and
the memory of the job (:mod:`pipeline.measured`). The script imports nothing of the study, so it starts in hundredths of
a second.
"""

import json
import os
import socket
import sys

worker = socket.socket(socket.AF_UNIX)
uses_worker = "STUDY_WORKER" in os.environ and os.path.dirname(sys.executable) == os.environ["STUDY_BIN"]
if not uses_worker or worker.connect_ex(os.environ["STUDY_WORKER"]):
    os.environ["PYTHONPATH"] = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    os.execv(sys.executable, [sys.executable, "-m", "pipeline.measured", *sys.argv[1:]])
socket.send_fds(worker, [b"\0"], [sys.stdout.fileno(), sys.stderr.fileno()])
worker.sendall(json.dumps(sys.argv[1:]).encode() + b"\n")
status = worker.recv(1)
if not status:
    raise SystemExit("the process of this job was killed.")
sys.exit(status != b"0")
