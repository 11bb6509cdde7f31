"""Lines of progress if the output is not a terminal."""

import time

from study.assessment.progress import PAUSE, Progress


def test_lines_are_rare_and_what_takes_long_is_announced(capsys, monkeypatch):
    now = 100.0
    monkeypatch.setattr(time, "monotonic", lambda: now)
    progress = Progress(4)
    progress.bar.disable = True
    progress.report("first")
    progress.report("soon after")
    progress.report("long", ahead=2 * PAUSE)
    now += 12.0
    progress.update()
    progress.report("later")
    assert capsys.readouterr().err.splitlines() == ["first", "long", "later (1 of 4 schemes, about 36 s to go)"]
