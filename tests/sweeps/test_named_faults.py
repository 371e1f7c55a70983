"""Named faults of the self-test, each with the criterion that must see it."""

from pathlib import Path

import pytest
from planted import (
    ERROR,
    FAIL,
    FEM_NEO_HOOKEAN,
    FEM_POISSON,
    FEM_PULSE,
    FEM_VIBRATION,
    MPM_DISPERSION,
    MPM_FINITE_STRAIN,
    MPM_PULSE,
    MPM_VIBRATION,
    SOURCES,
    TG_DECK,
    TG_PULSE,
    TG_SPECTRUM,
    TG_STEP,
    TG_VIBRATION,
    Kill,
    assert_killed,
    verification,
)

from mpmverify.selftest.named import NAMED
from mpmverify.selftest.planting import copied, planted

KILLS: dict[tuple[str, str], tuple[Kill, ...]] = {
    ("mpm", "both Lame constants halved"): (
        Kill(MPM_VIBRATION, FAIL, "energy drift"),
        Kill(MPM_PULSE, FAIL, "order of displacement"),
    ),
    ("fem", "first Lame constant omitted, neo-Hookean law"): (Kill(FEM_POISSON, FAIL, "order of displacement"),),
    ("fem", "Newmark beta 1/6 instead of 1/4"): (Kill(FEM_VIBRATION, FAIL, "energy conserved"),),
    ("taylor_galerkin", "P-wave modulus halved"): (
        Kill(TG_VIBRATION, FAIL, "order of stress"),
        Kill(TG_DECK, FAIL, "stress exact"),
    ),
    ("fem", "P-wave modulus halved"): (
        Kill(FEM_PULSE, FAIL, "order of displacement"),
        Kill(FEM_VIBRATION, FAIL, "energy conserved"),
    ),
    ("fem", "shear modulus halved, neo-Hookean law"): (Kill(FEM_NEO_HOOKEAN, FAIL, "order of displacement"),),
    ("mpm", "strain increment not multiplied by the time step"): (Kill(MPM_VIBRATION, ERROR, "order of displacement"),),
    ("mpm", "sign of the traction reversed"): (Kill(MPM_PULSE, FAIL, "order of velocity"),),
    ("mpm", "body force omitted"): (Kill(MPM_FINITE_STRAIN, FAIL, "order of displacement"),),
    ("mpm", "FLIP and PIC swapped"): (Kill(MPM_VIBRATION, FAIL, "momentum less impulse"),),
    ("taylor_galerkin", "boundary flux omitted from the update"): (
        Kill(TG_VIBRATION, ERROR, "momentum less impulse"),
        Kill(TG_STEP, FAIL, "mass less inflow"),
    ),
    ("taylor_galerkin", "boundary flux omitted from the update and the recorded balance"): (
        Kill(TG_PULSE, FAIL, "order of stress"),
    ),
    ("taylor_galerkin", "dt instead of dt/2 in the predictor"): (
        Kill(TG_VIBRATION, FAIL, "order of velocity"),
        Kill(TG_SPECTRUM, FAIL, "amplification factor"),
    ),
    ("taylor_galerkin", "full nodal mass at the end nodes"): (Kill(TG_DECK, FAIL, "velocity exact"),),
    ("fem", "sign of the traction reversed"): (Kill(FEM_PULSE, FAIL, "order of velocity"),),
    ("fem", "sign of beta reversed in the predictor"): (Kill(FEM_VIBRATION, FAIL, "order of displacement"),),
    ("fem", "Newmark gamma 0.6 instead of 1/2"): (
        Kill(FEM_VIBRATION, FAIL, "energy conserved"),
        Kill(FEM_PULSE, FAIL, "order of velocity"),
    ),
    ("fem", "body force omitted"): (Kill(FEM_NEO_HOOKEAN, FAIL, "order of stress"),),
    ("mpm", "stress-update schedules USF and USL swapped"): (Kill(MPM_DISPERSION, FAIL, "dispersion of stress"),),
}
"""Kills by the family and the name of a fault."""


@pytest.mark.parametrize(("family", "name"), KILLS, ids=[" ".join(fault) for fault in KILLS])
def test_a_named_fault_is_seen_by_its_criterion(family: str, name: str, tmp_path: Path) -> None:
    (fault,) = (fault for fault in NAMED if (fault.family, fault.name) == (family, name))
    with planted(fault, SOURCES, tmp_path) as package:
        for k, kill in enumerate(KILLS[family, name]):
            findings = verification(kill.trial.with_solver(copied(package, kill.trial.solver)), tmp_path / str(k))
            assert_killed(findings, kill.verdict, kill.criterion)
