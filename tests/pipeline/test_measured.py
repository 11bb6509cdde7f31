"""What a job took, against a job of known work."""

import os
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

PROJECT = Path(__file__).parents[2]

#: A job that works for 0.3 s of processor time, sleeps for 0.3 s and holds 200 MB.
WORK = """
import sys, time
held = bytearray(200 * 2**20)
while time.process_time() < 0.3:
    pass
time.sleep(0.3)
print(sys.argv[1:])
sys.exit({code})
"""


@pytest.mark.parametrize("code", ["0", "None", "1", "'the job is wrong.'"])
def test_a_job_that_succeeds_states_what_it_took(tmp_path, code):
    (tmp_path / "work.py").write_text(WORK.format(code=code))
    file = tmp_path / "benchmarks" / "work.tsv"
    command = [sys.executable, "-m", "pipeline.measured", file, "work", "a", "b"]
    environment = os.environ | {"PYTHONPATH": f"{PROJECT}:{tmp_path}"}
    done = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True)
    assert done.stdout == "['a', 'b']\n" and done.returncode == (code not in ("0", "None"))
    assert file.exists() == (done.returncode == 0) and ("wrong" in code) == ("the job is wrong." in done.stderr)
    if file.exists():
        taken = pd.read_csv(file, sep="\t").iloc[0]
        assert 200 < taken.max_rss < 300 and 0.3 <= taken.cpu_time < 2 and taken.s >= 0.3
