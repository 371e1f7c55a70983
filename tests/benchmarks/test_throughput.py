"""Time of the loop over the steps, without compilation and setup: `pytest tests/benchmarks`.

The rates in million particle-steps per second are in the `extra_info` of `--benchmark-json`, and in the output of `-rP`.
"""

import numba
import pytest
from bandwidth import bandwidth
from bodies import periodic_body

from mpmverify.solvers.mpm import APIC, FLIP, MaterialPoint

PARTICLES, STEPS, ROUNDS = 250_000, 20, 3
VARIANTS = [
    (1, MaterialPoint("USL", FLIP, "linear")),
    (2, MaterialPoint("USL", FLIP, "linear")),
    (2, MaterialPoint("MUSL", FLIP, "linear")),
    (2, MaterialPoint("USL", FLIP, "linear", "total")),
    (2, MaterialPoint("USL", APIC, "quadratic")),
    (2, MaterialPoint("USL", FLIP, "cubic")),
    (3, MaterialPoint("USL", FLIP, "linear")),
    (3, MaterialPoint("USL", APIC, "quadratic")),
]


class StepClock:
    """Timer that counts the seconds which solvers spend in their loops over the steps."""

    __name__ = "StepClock"
    seconds = 0.0

    def __call__(self) -> float:
        return self.seconds


CLOCK = StepClock()


@pytest.fixture(params=sorted({1, numba.config.NUMBA_NUM_THREADS}), ids="threads{}".format)
def threads(request):
    numba.set_num_threads(request.param)
    yield request.param
    numba.set_num_threads(numba.config.NUMBA_NUM_THREADS)


@pytest.mark.benchmark(group="steps", timer=CLOCK)
@pytest.mark.parametrize(
    ("dimension", "solver"), VARIANTS, ids=lambda value: value.name if hasattr(value, "name") else f"{value}d"
)
def test_steps(benchmark, threads, dimension, solver):
    problem, at = periodic_body(dimension, PARTICLES, STEPS)

    def solve():
        solution = solver.solve(problem, at)
        CLOCK.seconds += solution.work.seconds
        return solution

    solution = benchmark.pedantic(solve, rounds=ROUNDS, warmup_rounds=1)
    assert solution.outcome.completed, str(solution.outcome)
    rate = 1e-6 * solution.work.point_steps / benchmark.stats.stats.median
    benchmark.extra_info["million particle-steps per second"] = rate
    print(f"{rate:.1f} million particle-steps per second")


@pytest.mark.benchmark(group="bandwidth")
def test_bandwidth(benchmark, threads):
    streamed, updated = benchmark.pedantic(bandwidth, rounds=1)
    benchmark.extra_info |= {"triad [byte/s]": streamed, "update in place [byte/s]": updated}
    print(f"triad {1e-9 * streamed:.1f} GB/s, update in place {1e-9 * updated:.1f} GB/s")
