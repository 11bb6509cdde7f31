"""What is being done during an assessment."""

import sys
import time

from tqdm import tqdm

#: Seconds between two lines of progress where there is no terminal.
PAUSE = 5.0


class Progress:
    """What is being done: on a terminal a bar, elsewhere a line every few seconds at most."""

    def __init__(self, schemes: int):
        self.bar = tqdm(total=schemes, disable=None, leave=False, unit="scheme")
        self.stopped, self._told = False, -PAUSE

    def tell(self, what: str) -> None:
        """Tell what is being done; the place at which a thread ends after Ctrl-C."""
        if self.stopped:
            raise KeyboardInterrupt
        if not self.bar.disable:
            self.bar.set_postfix_str(what)
        elif time.monotonic() >= self._told + PAUSE:
            self._told = time.monotonic()
            print(what, file=sys.stderr, flush=True)
