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
FIELDS: Mapping[str, str] = {
    "dispersion_defect_": "the field {field!r} of a bar at every time step",
    "phase_error_": "the field {field!r} of a bar, which the exact solution must have too",
    "amplitude_decay_": "the field {field!r} of a bar, which the exact solution must have too",
    "front_lag_": "the field {field!r} of a bar, which the exact solution must have too",
    "amplification_": "the field 'u' of a scalar that is transported in one dimension, after at least one step",
}
"""What a metric is made of, by the first part of its name; the rest names a field."""


class Metrics(dict[str, Array]):
    """Metrics (n,) by name; a missing one raises a `NotMeasuredError` that names the histories it needs."""

    def __missing__(self, name: str) -> Array:
        raise NotMeasuredError(name)


class NotMeasuredError(KeyError):
    """Raised for a metric that no run of a series has; its argument is the name of the metric."""

    def __str__(self) -> str:
        (name,) = self.args
        if name in HISTORIES:
            return f"{name!r}, made of {HISTORIES[name]},"
        made = next((text.format(field=name.removeprefix(part)) for part, text in FIELDS.items() if name.startswith(part)), "")
        return f"{name!r}, made of {made}," if made else repr(name)
