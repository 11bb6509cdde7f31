"""Control of the step size: estimators of the error of a step, and controllers that choose the next one."""
