"""Histories of a run: balances of energy, momentum and mass with their defects, and errors of the fields."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from .record import Array, Series

BALANCES = (*((f"momentum{of}", f"impulse{of}") for of in ("", "_x", "_y", "_z")), ("mass", "inflow"))
"""Pairs of a conserved quantity and the history of its supply: momentum and impulse, mass and inflow."""


@dataclass(frozen=True)
class Balance:
    """Histories that share one chart and one unit.

    Parameters
    ----------
    title : str
    quantity, units : str
        Label and unit of the vertical axis.
    curves : mapping of str to Array
        Histories (N,) by name.
    time : Array, optional
        Times (N,) [s], where they are not those of the histories of the run.
    """

    title: str
    quantity: str
    units: str
    curves: Mapping[str, Array]
    time: Array | None = None


def balances(series: Series) -> Iterator[Balance]:
    """Yield the balances of the shown level of a series for which its solver recorded histories."""
    history, units = series.histories, series.history_units
    if {"kinetic_energy", "strain_energy"} <= history.keys():
        energy = history["kinetic_energy"] + history["strain_energy"]
        curves = {"kinetic": history["kinetic_energy"], "strain": history["strain_energy"]}
        work = history.get("external_work")
        if work is not None and work.any():
            curves["work"] = work
            energy = energy - work
        total = "kinetic + strain" + (" − external work" if "work" in curves else "")
        yield Balance(f"Energy; total: {total}", "energy", units["kinetic_energy"], curves | {"total": energy})
        yield Balance("Energy drift", "change of the total", units["kinetic_energy"], {"drift": energy - energy[0]})
    for stock, source in BALANCES:
        if stock not in history:
            continue
        change = history[stock] - history[stock][0]
        given = history[source] - history[source][0] if source in history else 0.0 * change
        curves = {stock: history[stock], source: history[stock][0] + given} if given.any() else {stock: history[stock]}
        name = stock.replace("_", " ")
        if given.any() or stock.startswith("momentum"):
            yield Balance(name.capitalize(), name, units[stock], curves)
        title = f"{name.capitalize()} less {source.replace('_', ' ')}" if given.any() else f"Change of {name}"
        yield Balance(title, "defect", units[stock], {"defect": change - given})


def errors(series: Series) -> Iterator[Balance]:
    """Yield the root mean square of the error over the points of the profile, relative to its largest one of the exact field."""
    profile = series.profile
    if profile is None or len(profile.time) < 3:
        return
    curves = {}
    for quantity, exact in profile.exact.items():
        largest = np.sqrt(np.max(np.mean(exact**2, axis=1)))
        if np.isfinite(largest) and largest > 0:
            curves[quantity] = np.sqrt(np.mean(profile.error(quantity) ** 2, axis=1)) / largest
    if curves:
        yield Balance("Error over time, relative", "root mean square error", "1", curves, profile.time)
