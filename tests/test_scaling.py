"""The simulation of a study on many cores, for graphs of jobs whose duration is known."""

import pytest

from tools.scaling import Job, critical_path, makespan, resources


def _graph(**jobs: tuple[float, tuple[str, ...]]) -> dict[str, Job]:
    return {name: Job(name, seconds, after) for name, (seconds, after) in jobs.items()}


DIAMOND = _graph(a=(1.0, ()), b=(5.0, ("a",)), c=(3.0, ("a",)), d=(1.0, ("b", "c")), alone=(2.0, ()))


@pytest.mark.parametrize("cores, seconds", [(1, 12.0), (2, 7.0), (3, 7.0)])
def test_a_diamond_of_jobs(cores, seconds):
    assert makespan(DIAMOND, cores) == seconds


def test_its_critical_path():
    assert critical_path(DIAMOND) == ["a", "b", "d"]


@pytest.mark.parametrize("cores, seconds", [(1, 9.0), (2, 6.0), (9, 6.0)])
def test_of_a_group_one_runs_at_a_time(cores, seconds):
    figures = {f"figure{i}": Job(f"figure{i}", 2.0, (), "paper") for i in range(3)}
    assert makespan(figures | _graph(other=(3.0, ())), cores) == seconds


def test_a_profile_requests_more_than_was_measured():
    jobs = [Job("a", 400.0, (), rule="long", memory=900.0), Job("b", 20.0, (), rule="long", memory=1400.0)]
    jobs.append(Job("c", 10.0, (), rule="short", memory=500.0))
    text = resources({job.name: job for job in jobs})
    assert text.splitlines() == ["set-resources:", "  long: {mem_mb: 2500 * attempt, runtime: 20 * attempt}"]


@pytest.mark.parametrize("cores", [1, 3, 7, 100])
def test_equal_jobs_without_order_share_the_cores(cores):
    jobs = _graph(**{f"job{i}": (1.0, ()) for i in range(21)})
    assert makespan(jobs, cores) == -(-21 // cores)
