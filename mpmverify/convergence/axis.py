"""Refinement axis of a set of runs: which of the cell size, the time step and the particles per cell they vary."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mpmverify.convergence.levels import Array

UNITS: Mapping[str, str] = {"h": "m", "dt": "s", "1/ppc": "1", "h/ppc": "m"}
"""Unit of every size with which an error may vanish; h/ppc is the particle spacing."""


@dataclass(frozen=True)
class Axis:
    """Sizes that vary over a set of runs.

    Parameters
    ----------
    varied : tuple of str
        Those of h, dt and 1/ppc that vary; h when none does.
    together : bool
        True for a ladder: all varied sizes decrease from each run to the next. False for a design.
    power : float
        In a ladder in h and dt, dt is proportional to h to this power.
    """

    varied: tuple[str, ...]
    together: bool = True
    power: float = 1.0

    @property
    def size(self) -> str:
        """Size in which orders are measured; "" for a design."""
        return self.varied[0] if self.together else ""

    @property
    def note(self) -> str:
        """Meaning of an order over these runs, for the reason of a verdict; "" for refinement in h alone."""
        named = " and ".join(self.varied)
        if not self.together:
            return f"{named} vary independently: such runs have no single order"
        if len(self.varied) == 1:
            return "" if self.varied == ("h",) else f"in {named} alone"
        if self.varied == ("h", "dt"):
            return f"h and dt together: min(p, {'' if abs(self.power - 1) < 0.05 else f'{self.power:.2g} '}q)"
        return f"{named} together: the least of their orders"


def axis(h: ArrayLike, dt: ArrayLike, ppc: ArrayLike) -> Axis:
    """Determine the refinement axis of n runs.

    Parameters
    ----------
    h, dt, ppc : array-like
        Cell size [m], time step [s] and particles per cell (n,). Runs that never began have no known time step and are left out.
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
    """Every size with which an error may vanish, by name (n,)."""
    return {"h": h, "dt": dt, "1/ppc": 1 / ppc, "h/ppc": h / ppc}
