"""Metrics: numbers that criteria measured on the runs of a series, by name."""

from collections.abc import Mapping

from mpmverify.problem import Array

HISTORIES: Mapping[str, str] = {
    "mass_defect": "the history 'mass', with 'inflow' where a scalar has open ends",
    "momentum_defect": "the histories 'momentum' and 'impulse'",
    "momentum_error": "the history 'momentum'",
    "angular_momentum_error": "the history 'angular_momentum'",
    "angular_momentum_defect": "the history 'angular_momentum'",
    "energy_drift": "the histories 'kinetic_energy', 'strain_energy' and 'external_work'",
    "energy_rise": "the histories 'kinetic_energy', 'strain_energy' and 'external_work'",
}
"""Histories that a solver must return for a metric whose name does not contain a field."""


class Metrics(dict[str, Array]):
    """Metrics (n,) by name; a missing one raises a `NotMeasuredError` that names the histories it needs."""

    def __missing__(self, name: str) -> Array:
        raise NotMeasuredError(name)


class NotMeasuredError(KeyError):
    """Raised for a metric that no run of a series has; its argument is the name of the metric."""

    def __str__(self) -> str:
        (name,) = self.args
        return f"{name!r}, made of {HISTORIES[name]}," if name in HISTORIES else repr(name)
