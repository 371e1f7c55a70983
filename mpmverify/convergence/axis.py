"""What a set of runs refines, read from its runs: the cell size, the time step, particles per cell, or several of them."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mpmverify.convergence.levels import Array

UNITS: Mapping[str, str] = {"h": "m", "dt": "s", "1/ppc": "1", "h/ppc": "m"}
"""Unit of every size that an error may vanish with; the last one is the spacing of particles."""


@dataclass(frozen=True)
class Axis:
    """The sizes that vary over some runs.

    Parameters
    ----------
    varied : tuple of str
        Of h, dt and 1/ppc, those that vary; h when none does.
    together : bool
        Whether they all fall from one run to the next: a ladder. Otherwise the runs are a design.
    power : float
        Of a ladder in h and dt: dt falls as h to this power.
    """

    varied: tuple[str, ...]
    together: bool = True
    power: float = 1.0

    @property
    def size(self) -> str:
        """The size that orders are measured in; "" for a design."""
        return self.varied[0] if self.together else ""

    @property
    def note(self) -> str:
        """What an order over these runs means, for its reason; "" for one in h alone."""
        named = " and ".join(self.varied)
        if not self.together:
            return f"{named} vary independently: such runs have no single order"
        if len(self.varied) == 1:
            return "" if self.varied == ("h",) else f"in {named} alone"
        if self.varied == ("h", "dt"):
            return f"h and dt together: min(p, {'' if abs(self.power - 1) < 0.05 else f'{self.power:.2g} '}q)"
        return f"{named} together: the least of their orders"


def axis(h: ArrayLike, dt: ArrayLike, ppc: ArrayLike) -> Axis:
    """Tell what some runs refine.

    Parameters
    ----------
    h, dt, ppc : array-like
        Cell size, time step and particles per cell (n,). Runs whose time step is not known, since they never began, are left out.
    """
    runs = np.stack([np.asarray(size, dtype=float) for size in (h, dt, ppc)])
    runs = np.unique(runs[:, np.all(np.isfinite(runs) & (runs > 0), axis=0)], axis=1)  # sorted by h, then by dt, then by ppc
    if runs.shape[1] < 2:
        return Axis(("h",))
    logs = dict(zip(("h", "dt", "1/ppc"), np.log(runs) * [[1], [1], [-1]], strict=True))
    varied = {name: log for name, log in logs.items() if np.ptp(log) > 1e-9} or {"h": logs["h"]}
    steps = np.array([np.diff(log[np.argsort(next(iter(varied.values())), kind="stable")]) for log in varied.values()])
    together = len(varied) == 1 or bool(np.all(steps > 1e-9))
    power = float(np.polyfit(logs["h"], logs["dt"], 1)[0]) if together and tuple(varied) == ("h", "dt") else 1.0
    return Axis(tuple(varied), together, power)


def sizes(h: Array, dt: Array, ppc: Array) -> dict[str, Array]:
    """Every size that an error may vanish with, by its name (n,)."""
    return {"h": h, "dt": dt, "1/ppc": 1 / ppc, "h/ppc": h / ppc}
