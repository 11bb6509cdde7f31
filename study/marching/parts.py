"""An ensemble in parts, each of which is one file: for ensembles that exceed the memory, and for jobs on a cluster.

A file appears whole or not at all. A part whose file exists is not run again, so a run that was killed goes on with the
first missing part. The attribute ``run`` of each file identifies the run: the traced program of one lane, the
arguments of all lanes and the number of parts.
"""

import hashlib
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np
import xarray as xr
from tqdm import tqdm

from study.algebra.reads import reads_of_program
from study.io import opened, opened_together, write

#: Largest number of lanes of a part, and of bytes of its results, by default.
MOST_LANES, MOST_BYTES = 2**16, 2**28


class Parts(NamedTuple):
    """The files of an ensemble that ``study.run(..., save=study.Parts(...))`` writes part by part.

    The lanes of the parts follow one another, and the sizes of two parts differ by at most one lane. The files are
    ``part_0.nc``, ``part_1.nc``, …; the numbers have as many digits as the last one.

    Parameters
    ----------
    folder
        Folder of the files.
    number
        Number of parts. By default a part has at most 65,536 lanes, and results of at most 256 MiB.
    only
        Number of a part, from 0, that alone is run; its dataset is returned. A job on a cluster runs one part.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> import study
    >>> parts = study.Parts(tempfile.mkdtemp(), 3)
    >>> run = dict(dt=0.0075, steps=100, observe="peak", u0=np.linspace(0.5, 1.5, 10))
    >>> study.run("hardening", "rk4", save=parts._replace(only=1), **run).lane.values
    array([3, 4, 5])
    >>> study.run("hardening", "rk4", save=parts, **run).peak.shape
    (10,)
    """

    folder: str | Path
    number: int | None = None
    only: int | None = None

    def written(self, marched: Callable[[slice], xr.Dataset], lanes: int, lane: "Lane") -> xr.Dataset:
        """March and write the missing parts, and open all parts as one dataset.

        Parameters
        ----------
        marched
            Function that marches the lanes of a slice.
        lanes
            Number of lanes.
        lane
            The program of a lane.

        Raises
        ------
        ValueError
            If the number of parts or of the part is out of range, or if the folder holds parts of another run.
        NotRead, NotWritten
            If a file is damaged or cannot be written.
        """
        count = self.number
        if count is None:
            count = max(math.ceil(lanes / MOST_LANES), math.ceil(lanes * lane.size / MOST_BYTES))
        if not 1 <= count <= lanes:
            raise ValueError(f"an ensemble of {lanes} lanes has 1 to {lanes} parts, not {count!r}.")
        if self.only is not None and not 0 <= self.only < count:
            raise ValueError(
                f"the number of one of {count} parts is at least 0 and less than {count}, not {self.only!r}."
            )
        ends = np.linspace(0, lanes, count + 1).astype(int).tolist()
        slices = {self._path(k, count): slice(*ends[k : k + 2]) for k in range(count)}
        run = lane.digest(count)
        chosen = list(slices) if self.only is None else [self._path(self.only, count)]
        paths = sorted(Path(self.folder).glob("part_*.nc"))
        # a job that opened all files of many jobs would keep the file system busy
        files = {path: _opened(path, run) for path in paths if self.only is None or path in (paths[0], *chosen)}
        missing = [path for path in chosen if path not in files]
        for path in tqdm(missing, disable=None if len(missing) > 1 else True, leave=False):
            for unfinished in path.parent.glob(f".{path.name}.*.unfinished"):  # left by a run that was killed
                unfinished.unlink(missing_ok=True)
            part = marched(slices[path])
            numbers = np.arange(lanes)[slices[path]]
            part = part.assign_coords(lane=("lane", numbers, {"long_name": "number of the lane", "units": "1"}))
            write(part.assign_attrs(run=run), path, compressed=False)
            files[path] = _opened(path, run)
        return opened_together([files[path] for path in chosen], "lane")

    def _path(self, k: int, count: int) -> Path:
        return Path(self.folder) / f"part_{k:0{len(str(count - 1))}}.nc"


def _opened(path: Path, run: str) -> xr.Dataset:
    """A part, opened; one of another run is refused."""
    part = opened(path)
    if part.attrs.get("run") != run:
        raise ValueError(
            f"'{path}' is of another run, with another problem, scheme, argument or number of parts, or of another "
            "version: give this run another folder."
        )
    return part


class Lane(NamedTuple):
    """The traced program of one lane of an ensemble, and what distinguishes its run from others.

    Attributes
    ----------
    program
        The program.
    size
        Number of bytes of the results and arguments of a lane.
    arguments
        Arguments of all lanes.
    """

    program: Any
    size: int
    arguments: Any

    @classmethod
    def traced(cls, march_of: Callable, make: Callable, first: tuple, samples: int, arguments: Any) -> "Lane":
        """Trace the program of a lane.

        Parameters
        ----------
        march_of
            Function that returns the march of a problem.
        make, first
            Function that makes the problem of a lane; u₀, v₀ and Δt of the first lane, and its arguments of ``make``.
        samples
            Number of samples of each record.
        arguments
            Arguments of all lanes.
        """

        def lane(u0, v0, dt, arguments):
            march = march_of(make(**arguments))
            progress, initial, stored = march.start(u0, v0, dt, 0)
            progress, stored = march.proceed(progress, stored, initial, dt, 1, 1, 0, False)
            return stored, march.result(progress)

        program, results = jax.make_jaxpr(lane, return_shape=True)(*first)
        sample, remainder = (
            sum(x.size * x.dtype.itemsize for x in jax.tree.leaves(arrays))
            for arrays in (results[0], (results[1], first))
        )
        return cls(program, samples * sample + remainder, arguments)

    def digest(self, *others: Any) -> str:
        """A digest of program, arguments and other values, equal in every process."""
        digest = hashlib.blake2b(repr((reads_of_program(self.program), others)).encode(), digest_size=16)
        for name, value in jax.tree.leaves_with_path(self.arguments):
            array = np.ascontiguousarray(value)
            digest.update(repr((jax.tree_util.keystr(name), array.shape, array.dtype.str)).encode())
            digest.update(array.tobytes())
        return digest.hexdigest()
