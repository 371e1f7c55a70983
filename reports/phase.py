"""Phase and amplitude errors over time of a motion of one frequency in one dimension."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .balances import Balance
from .record import Array, Profile, Series

OUTPUTS, POINTS = 6, 3
"""Least numbers of outputs and of points. Three outputs determine an ellipse; the others show whether the motion follows one."""
HARMONIC = 1e-4
"""Largest deviation of the exact motion from one of a single frequency, relative to its size; fields are stored in single precision."""
SLENDER = 0.05
"""Least ratio of the squared axes of the ellipse that the exact motion follows: one that hardly turns determines no phase."""
REST = 0.2
"""Largest part of a numerical motion beside the mode, relative to its amplitude in the mode."""
GROWN = 2.0
"""Largest amplitude, relative to the exact one, of a motion that is stable."""


@dataclass(frozen=True)
class Motion:
    """Phase and amplitude of a numerical motion against the exact one.

    Parameters
    ----------
    time : Array
        Output times (T,) [s].
    phase : Array
        Phase by which the numerical motion is ahead of the exact one (T,) [rad].
    amplitude : Array
        Amplitude of the numerical motion, relative to that of the exact one (T,) [1]. Both are NaN once the motion has left the mode.
    """

    time: Array
    phase: Array
    amplitude: Array


def motion(profile: Profile) -> Motion | None:
    """Return phase and amplitude of a numerical motion; None unless the exact motion has a single frequency, and the other one follows it.

    Parameters
    ----------
    profile : Profile
        With the velocity, and with the displacement or else the stress.

    Notes
    -----
    The displacement d and the velocity v of all points, each divided by its root mean square in the exact solution, are one vector
    w = (d, v). An exact motion of a single frequency omega, a standing wave or a harmonic wave that travels, has

        w(t) = a cos(psi) + b sin(psi),    psi = omega t + constant,

    so that w stays in a plane, on the ellipse that the constant vectors a and b span there. They are found from the outputs: the plane
    from the two largest singular values, the ellipse q . Q q = 1 by least squares. If either does not fit, the motion has no single
    frequency. The direction of rotation follows from d' = v, where d' is the rate of d: it makes b_d . a_v - a_d . b_v positive. In
    place of d, the stress s serves as well: its rate is E dv/dx with a positive modulus E.

    The numerical w is projected on the plane, w = alpha a + beta b + rest, and alpha + i beta = g exp(i (psi + delta)) gives its
    amplitude g and its phase delta ahead of the exact motion. For w = g (a cos(psi + delta) + b sin(psi + delta)) this is exact. A
    numerical standing wave of another frequency, omega (1 + epsilon), has a velocity that is larger by 1 + epsilon at the same
    displacement: delta, which grows as epsilon omega t, is then off by at most about epsilon/2 [rad], and the amplitude by the factor
    1 + epsilon.

    From the first output on where the rest exceeds `REST` of the amplitude, the motion has left the mode, and both are NaN. The phase is
    made continuous from output to output, between which it must change by less than half a turn; an unstable mode turns faster, and is
    told by its amplitude.
    """
    first = "displacement" if "displacement" in profile.exact else "stress"
    names = (first, "velocity")
    points = len(profile.reference)
    if not set(names) <= profile.exact.keys() or len(profile.time) < OUTPUTS or points < POINTS:
        return None
    scale = [float(np.sqrt(np.mean(profile.exact[name] ** 2))) for name in names]
    if not all(np.isfinite(size) and size > 0 for size in scale):
        return None
    exact, numerical = (
        np.hstack([fields[name] / size for name, size in zip(names, scale, strict=True)])
        for fields in (profile.exact, profile.fields)
    )
    found = _ellipse(exact)
    if found is None:
        return None
    spanning, inverse = found
    a, b = spanning
    slope = spanning[:, points:]
    if first == "stress":
        slope = np.gradient(slope, profile.reference, axis=1)
    turn = float(b[:points] @ slope[0] - a[:points] @ slope[1])
    if not (np.isfinite(turn) and turn != 0):
        return None
    shown, known = numerical @ inverse, exact @ inverse
    rest = np.sqrt(np.sum((numerical - shown @ spanning) ** 2, axis=1) / np.mean(np.sum(exact**2, axis=1)))
    rotating = np.array([1, 1j * np.sign(turn)])
    ratio = (shown @ rotating) / (known @ rotating)
    amplitude = np.abs(ratio)
    kept = np.logical_and.accumulate((rest <= REST * amplitude) & (amplitude > 0))
    if kept.sum() < OUTPUTS or (amplitude > GROWN).any():
        return None
    phase = np.full(len(ratio), np.nan)
    phase[kept] = np.unwrap(np.angle(ratio[kept]))
    return Motion(profile.time, phase, np.where(kept, amplitude, np.nan))


def _ellipse(exact: Array) -> tuple[Array, Array] | None:
    """Return the vectors a and b (2, N) of motions (T, N) on the ellipse a cos(psi) + b sin(psi), and the coordinates (N, 2) by them.

    None if the motions are on no ellipse.
    """
    # The decomposition of a small matrix: there are few outputs, and hundreds of series on the pages of a report.
    sizes, coordinates = np.linalg.eigh(exact @ exact.T)
    if sizes[-3] > HARMONIC**2 * sizes[-1] or sizes[-2] <= HARMONIC**2 * sizes[-1]:
        return None
    modes = (coordinates[:, -2:] / np.sqrt(sizes[-2:])).T @ exact
    places = exact @ modes.T
    x, y = places.T
    (xx, xy, yy), *_ = np.linalg.lstsq(np.column_stack([x**2, 2 * x * y, y**2]), np.ones(len(x)), rcond=None)
    squares, directions = np.linalg.eigh([[xx, xy], [xy, yy]])
    if squares[0] < SLENDER * squares[1]:
        return None
    to_circle = directions * np.sqrt(squares)
    if np.abs(np.linalg.norm(places @ to_circle, axis=1) - 1).max() > HARMONIC:
        return None
    return np.linalg.solve(to_circle, modes), modes.T @ to_circle


def motions(series: Series) -> Iterator[Balance]:
    """Yield the phase and the amplitude error over time of the shown level of a series, if its exact motion has a single frequency."""
    found = motion(series.profile) if series.profile else None
    if found:
        ahead = {"phase error": np.degrees(found.phase)}
        yield Balance("Phase ahead of the exact motion, up to whole turns", "phase error", "degree", ahead, found.time)
        yield Balance("Amplitude error, relative", "amplitude error", "1", {"amplitude error": found.amplitude - 1}, found.time)
