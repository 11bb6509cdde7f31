"""A fragility sample of ten million oscillators in a hundred parts.

The second command runs part 17 alone, which is how ``parts.smk`` makes a job of each part.

    python examples/parts.py runs 10000000 100
    python examples/parts.py runs 10000000 100 17
"""

import sys

from intensities import fragility

import study

folder, lanes, count, *only = sys.argv[1:]
ds = fragility(int(lanes), save=study.Parts(folder, int(count), *map(int, only)))
for limit in (0.02, 0.04, 0.08):
    print(f"{100 * float((ds.drift > limit).mean()):.2f} % of {ds.sizes['lane']} exceed {1e3 * limit:.0f} mm")
