"""The phase errors that the study "error-sources" assumes, from the spectra of the schemes."""

import numpy as np
import pytest
from scipy.linalg import eigh

from mpmverify import studies
from mpmverify.criteria import Separated

THETA = 0.05


def frequency(mass: str) -> float:
    """Return the first frequency of linear elements on a fixed bar of unit wave speed, relative to the exact one."""
    n = round(np.pi / THETA)
    stiffness = 2 * np.eye(n - 1) - np.eye(n - 1, k=1) - np.eye(n - 1, k=-1)
    matrix = np.eye(n - 1) if mass == "lumped" else (4 * np.eye(n - 1) + np.eye(n - 1, k=1) + np.eye(n - 1, k=-1)) / 6
    return float(np.sqrt(eigh(stiffness, matrix, eigvals_only=True, subset_by_index=[0, 0])[0]) / (np.pi / n))


@pytest.mark.parametrize(("mass", "sign"), [("consistent", 1), ("lumped", -1)])
def test_the_frequency_of_linear_elements(mass, sign):
    theta = np.pi / round(np.pi / THETA)
    assert frequency(mass) - 1 == pytest.approx(sign * theta**2 / 24, rel=1e-2)


def test_the_frequency_of_average_acceleration():
    """One step of a = -u rotates (u, v) by the angle 2 atan(dt/2)."""
    assert 2 * np.arctan(THETA / 2) / THETA - 1 == pytest.approx(-(THETA**2) / 12, rel=1e-2)


@pytest.mark.parametrize("ppc", [1, 2, 3, 8])
@pytest.mark.parametrize("courant", [0.1, 0.5])
def test_the_frequency_of_material_points_with_linear_functions(ppc, courant):
    xi = (np.arange(ppc) + 0.5) / ppc
    mean = np.mean(np.abs(1 - xi + xi * np.exp(1j * THETA)) ** 2)
    slope = np.abs(np.exp(1j * THETA) - 1) ** 2
    phase = 2 * np.arcsin(courant * np.sqrt(mean * slope) / 2) / (courant * THETA)
    expected = -(THETA**2) / 8 - THETA**2 / (24 * ppc**2) + courant**2 * THETA**2 / 24
    assert phase - 1 == pytest.approx(expected, rel=1e-2)


def test_every_design_of_the_study_varies_the_sizes_that_its_criteria_judge():
    for _, series in studies.get("error-sources").series():
        varied = set(series.refinement.axis.varied)
        judged = {size for entry in series.criteria if isinstance(entry, Separated) for size, _, _ in entry.bands}
        assert {size.replace("h/ppc", "1/ppc") for size in judged} == varied
