"""Progress of an assessment."""

import sys
import time

from tqdm import tqdm

#: Least time in s between two lines of progress without a terminal. Work that is expected to take longer gets a line at
#: once.
PAUSE = 5.0


class Progress:
    """Progress of an assessment: a bar on a terminal, otherwise lines."""

    def __init__(self, schemes: int):
        self.bar = tqdm(total=schemes, disable=None, leave=False, unit="scheme")
        self.stopped, self.done, self._reported, self._start = False, 0, -PAUSE, time.monotonic()

    def report(self, work: str, ahead: float = 0.0) -> None:
        """Show the present work: at once on a terminal, otherwise as a line if ``PAUSE`` seconds have passed.

        A line is also printed if ``ahead``, the expected time of this work in s, exceeds ``PAUSE``. After Ctrl-C this
        method raises ``KeyboardInterrupt``, which ends the work of the calling thread.
        """
        if self.stopped:
            raise KeyboardInterrupt
        if not self.bar.disable:
            self.bar.set_postfix_str(work)
        elif ahead > PAUSE or time.monotonic() >= self._reported + PAUSE:
            self._reported = time.monotonic()
            print(f"{work}{self._estimate()}", file=sys.stderr, flush=True)

    def say(self, line: str) -> None:
        """Print a line that stays."""
        self.bar.write(line, file=sys.stderr)

    def update(self) -> None:
        """Count a finished scheme."""
        self.done += 1
        self.bar.update()

    def _estimate(self) -> str:
        """Number of finished schemes, and the estimated time of the others; empty before the first scheme ends."""
        if not self.done:
            return ""
        remaining = (time.monotonic() - self._start) * (self.bar.total / self.done - 1)
        return f" ({self.done} of {self.bar.total} schemes, about {remaining:.2g} s to go)"
