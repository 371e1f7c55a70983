"""Random designs with known sources of error, and the rates of right and wrong verdicts on their separation."""

from collections import Counter
from itertools import product

import numpy as np

from mpmverify.convergence.levels import Array
from mpmverify.convergence.sources import judge_sources, separate
from mpmverify.convergence.synthetic.kinds import Truth
from mpmverify.convergence.synthetic.rates import Rate, rate_of_verdicts
from mpmverify.convergence.verdict import Verdict

EXPONENTS = (1.0, 1.5, 2.0, 3.0, 4.0)
NOISE = (0.0, 0.0, 0.002, 0.01, 0.02)
"""Standard deviations of log E."""
SHIFTS = (0.0, 0.0, 0.3, -0.3, 1.0, -1.0)
"""Distance between the true exponent and the nearest edge of one band; at zero every band is centred on the true exponent."""


def random_design(generator: np.random.Generator) -> tuple[dict[str, float], dict[str, Array], Array]:
    """Draw a design of n runs with known sources of error.

    The design has two or three sources, or one source and a constant. Near the middle of the design, each source is weighted by a
    random factor between 10^-1.5 and 10^1.5. The error fields add, lie at random angles, or partly cancel. The scatter is up to
    2 %. In one design of seven, one source is missing.

    Returns
    -------
    exponent : dict of str to float
        Exponent of each source by its size; NaN for the missing one.
    sizes : dict of str to Array
        Sizes of the runs (n,).
    error : Array
        Relative errors (n,).
    """
    kind = generator.choice(["h dt", "dt", "h dt 1/ppc"], p=[0.7, 0.2, 0.1])
    counts = {"h dt": (*generator.integers(3, 6, 2), 1), "dt": (1, generator.integers(6, 9), 1), "h dt 1/ppc": (3, 3, 3)}[kind]
    columns = (0.5 ** np.arange(counts[0]), generator.choice([0.5, 0.7]) ** np.arange(counts[1]), 1 + np.arange(counts[2]))
    h, dt, ppc = np.array(list(product(*columns)), dtype=float).T
    names = kind.split()
    exponent = {name: float(generator.choice(EXPONENTS)) for name in names}
    sizes = {"h": h, "dt": dt, "1/ppc": 1 / ppc}
    powers = [sizes[name] ** exponent[name] for name in names] + ([np.ones(len(h))] if kind == "dt" else [])
    parts = np.array([part / np.exp(np.log(part).mean()) * 10 ** generator.uniform(-1.5, 1.5) for part in powers])
    missing = generator.random() < 0.15
    if missing:
        parts[0], exponent[names[0]] = 0, np.nan
    angles = generator.choice(["add", "random", "cancel"])
    fields = generator.standard_normal((len(parts), len(parts))) if angles == "random" else np.ones((len(parts), 1))
    fields = fields * (generator.choice([-1, 1], (len(parts), 1)) if angles == "cancel" else 1)
    fields = fields / np.linalg.norm(fields, axis=1, keepdims=True)
    error = np.sqrt(np.maximum(np.einsum("in,ij,jn->n", parts, fields @ fields.T, parts), 1e-30))
    error = error * np.exp(generator.choice(NOISE) * generator.standard_normal(len(h)))
    error = np.maximum(error / error.max(), 1e-5) if missing else error / error.max()
    return exponent, {name: sizes[name] for name in names}, error * 10 ** generator.uniform(-6, 0)


def measure_designs(count: int = 300, seed: int = 0) -> list[Rate]:
    """Judge the exponents of random designs by bands around the true exponents.

    In some designs, the true exponent of one source lies 0.3 or 1 outside its band, or the source is missing; both count as outside.

    Parameters
    ----------
    count : int
        Number of designs.
    seed : int
        The same seed gives the same designs.
    """
    generator = np.random.default_rng(seed)
    found: Counter[tuple[Truth, Verdict]] = Counter()
    for _ in range(count):
        exponent, sizes, error = random_design(generator)
        shift, off = generator.choice(SHIFTS), generator.choice(list(exponent))
        bands = []
        for name, power in exponent.items():
            half = generator.uniform(0.1, 0.25)
            centre = (2.0 if np.isnan(power) else power) + (np.sign(shift) * (abs(shift) + half) if name == off else 0)
            bands.append((name, centre - half, centre + half))
        inside = shift == 0 and not np.isnan(list(exponent.values())).any()
        verdict, _ = judge_sources(separate(sizes, error), bands)
        found[Truth.INSIDE if inside else Truth.OUTSIDE, verdict] += 1
    return [
        rate_of_verdicts("design", truth, {verdict: number for (held, verdict), number in found.items() if held is truth})
        for truth in (Truth.INSIDE, Truth.OUTSIDE)
    ]
