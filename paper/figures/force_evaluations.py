"""What accuracy costs in forces evaluated, where a force is dear: each Newton iteration takes one."""

from functools import partial

from paper.figures.style import main
from paper.figures.work_precision import draw

if __name__ == "__main__":
    main(partial(draw, cost="force_evaluations", label="forces in 100 periods"))
