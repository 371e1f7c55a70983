"""Any solver on any problem: what it claims of itself is what must hold, limited by the smoothness of the exact solution."""

import math
import pickle
import tempfile
from collections.abc import Mapping, Sequence, Set
from numbers import Real
from pathlib import Path

import numpy as np

from mpmverify import pool
from mpmverify.criteria import Balance, Order
from mpmverify.criteria.metrics import Metrics
from mpmverify.dataset.files import Results
from mpmverify.dataset.level import Level
from mpmverify.errors import UsageError
from mpmverify.evaluation import Task
from mpmverify.exact import VerificationProblem
from mpmverify.gate import Criterion, Evidence, Finding, judge
from mpmverify.problem import UNITS, Inflow, Outflow, Transport
from mpmverify.solution import Solver
from mpmverify.study import Case, Refinement, Study

MARGIN = 0.15
"""How far an observed order may lie from the formal one on smooth data."""
INVARIANTS = ("mass", "momentum")
"""What a solver may declare to conserve."""
THEORY = (
    "a scheme of order p on data with s derivatives in L1 has at most the order s p/(p+1) in L1, and at least its order in L2, "
    "(s-1/2) p/(p+1): Brenner, Thomee and Wahlbin (1975), doi:10.1007/BFb0068125"
)


def order_band(order: float, derivatives: float) -> tuple[float, float]:
    """Band of observed orders of a scheme: L2 on smooth data, L1 where `derivatives` is finite.

    Parameters
    ----------
    order : float
        Formal order p on smooth data.
    derivatives : float
        The number s of derivatives that the exact field has in L1.

    Returns
    -------
    (float, float)
        p - 0.15 and p + 0.15 on smooth data. Else the upper edge is no more than s p/(p+1) + 0.15, the order that a front smeared over
        h^(p/(p+1)) leaves, and the lower edge no more than (s - 1/2) p/(p+1), the order in L2, which bounds the one in L1 from below.

    Notes
    -----
    At a jump the bands of all orders overlap: a high order is proved on smooth data alone.

    References
    ----------
    Brenner P., Thomee V., Wahlbin L. B. (1975). Besov Spaces and Applications to Difference Methods for Initial Value Problems.
    Springer, doi:10.1007/BFb0068125
    """
    gain = order / (order + 1)
    return min(order - MARGIN, (derivatives - 0.5) * gain), min(order, derivatives * gain) + MARGIN


def expectations(solver: Solver, problem: VerificationProblem) -> tuple[Criterion, ...]:
    """Criteria that follow from what a solver declares: its formal orders and what it conserves.

    Parameters
    ----------
    solver : Solver
    problem : VerificationProblem
        Its exact solution says how smooth the fields are.

    Returns
    -------
    tuple of Criterion
        An `Order` for every declared quantity that the exact solution has, and a `Balance` for every invariant.

    Raises
    ------
    UsageError
        If it declares what is unknown, or no order of a quantity that the exact solution has.
    """
    if not isinstance(solver.orders, Mapping):
        raise UsageError(
            f"solver {solver.name!r} declares its orders as {solver.orders!r}: give a mapping of quantity to order"
        )
    if not isinstance(solver.conserves, Set):
        raise UsageError(f"solver {solver.name!r} declares that it conserves {solver.conserves!r}: give a set of names")
    for quantity, order in solver.orders.items():
        if quantity not in UNITS:
            raise UsageError(
                f"solver {solver.name!r} declares the order of an unknown {quantity!r}: known are {', '.join(UNITS)}"
            )
        if not isinstance(order, Real) or isinstance(order, bool | np.bool_) or not (math.isfinite(order) and order > 0):
            raise UsageError(
                f"solver {solver.name!r} declares the order {order!r} of {quantity}: an order is positive and finite"
            )
    if unknown := sorted(set(solver.conserves) - set(INVARIANTS), key=str):
        raise UsageError(f"solver {solver.name!r} conserves an unknown {unknown[0]!r}: known are {', '.join(INVARIANTS)}")
    declared = {quantity: order for quantity, order in solver.orders.items() if quantity in problem.exact.fields}
    if not declared:
        raise UsageError(
            f"solver {solver.name!r} declares no order of {' or '.join(problem.exact.fields)}, so that nothing can be expected of "
            f"it on {problem.problem.name!r}: declare its orders, or give criteria"
        )
    return (
        *(_order(quantity, order, problem) for quantity, order in declared.items()),
        *(
            Balance(invariant, source, f"declared by {solver.name}")
            for invariant, source in _sources(problem).items()
            if invariant in solver.conserves
        ),
    )


def _order(quantity: str, order: float, problem: VerificationProblem) -> Order:
    derivatives = _derivatives(quantity, problem)
    low, high = (round(edge, 3) for edge in order_band(order, derivatives))
    declared = f"the solver declares order {order:g} of {quantity} on smooth data"
    if math.isinf(derivatives):
        return Order(quantity, "L2", low, high, f"{declared}; where it is better than that on this problem, give criteria")
    return Order(quantity, "L1", low, high, f"{declared}; here s = {derivatives:g}; {THEORY}")


def _derivatives(quantity: str, problem: VerificationProblem) -> float:
    """Regularity of one field: the displacement is an integral, and has one derivative more than velocity and stress."""
    integrated = quantity == "displacement" and problem.exact.fields.keys() & {"velocity", "stress"}
    return problem.exact.derivatives + (1 if integrated else 0)


def _sources(problem: VerificationProblem) -> dict[str, str]:
    """Invariants of a problem, each with the history that accounts for its change; "" where nothing may change it."""
    stated = problem.problem
    if isinstance(stated.material, Transport):
        open_ended = any(isinstance(condition, Inflow | Outflow) for condition in stated.boundary.values())
        return {"mass": "inflow" if open_ended else ""}
    return {"mass": "", "momentum": "impulse"}


def evidence_of(levels: Sequence[Level]) -> Evidence:
    """Evidence of one series as it was measured; a quantity that a level lacks is absent, a metric that it lacks is NaN.

    Parameters
    ----------
    levels : sequence of Level
        Of one solver, at least one.
    """
    quantities = [quantity for quantity in levels[0].errors if all(quantity in level.errors for level in levels)]
    metrics = sorted({name for level in levels for name in level.metrics})
    return Evidence(
        h=np.array([level.h for level in levels]),
        dt=np.array([level.dt for level in levels]),
        courant=np.array([level.courant for level in levels]),
        ppc=np.array([level.ppc for level in levels]),
        outcomes=tuple(level.outcome for level in levels),
        error={quantity: np.array([level.errors[quantity][0] for level in levels]) for quantity in quantities},
        reference={quantity: np.array([level.errors[quantity][1] for level in levels]) for quantity in quantities},
        metrics=Metrics({name: np.array([level.metrics.get(name, np.nan) for level in levels]) for name in metrics}),
    )


def verify(
    solver: Solver,
    study: Study,
    case: str = "",
    *,
    refinement: Refinement | None = None,
    criteria: Sequence[Criterion] | None = None,
    tier: str = "quick",
    timeout: float | None = None,
) -> tuple[Finding, ...]:
    """Solve one case of a study with a solver of any origin, and judge it; nothing is stored and nothing is read back.

    Parameters
    ----------
    solver : Solver
        Any object that keeps the protocol.
    study : Study
    case : str
        May be left out where the study has one case.
    refinement : Refinement, optional
        By default the first ladder of the case; where `criteria` is absent, the first in h at one Courant number, for such is
        the ladder of which a solver declares its orders.
    criteria : sequence of Criterion, optional
        By default what follows from the solver's declarations; see `expectations`.
    tier : str
        "quick" or "full".
    timeout : float, optional
        Limit for one run [s]. The runs are then solved in a worker process, which must be able to import the solver and sees nothing
        that this process has patched; by default they are solved in this process, without a limit.

    Returns
    -------
    tuple of Finding
        One for each criterion, and at least one.

    Raises
    ------
    UsageError
        If nothing could be judged: the solver lacks a part of the protocol or cannot take the problem, the case is unknown, no
        criterion is given or follows from what it declares, or no ladder shows the orders that it declares.
    """
    if isinstance(solver, type):
        raise UsageError(f"{solver.__name__} is a class and no solver: give an instance of it")
    missing = [part for part in ("name", "orders", "conserves", "solve") if not hasattr(solver, part)]
    if missing:
        raise UsageError(f"{type(solver).__name__} is no solver: it lacks {', '.join(missing)}")
    chosen = _case(study, case)
    demanded = expectations(solver, chosen.problem) if criteria is None else tuple(criteria)
    ladders = [series.refinement for series in chosen.series] if refinement is None else [refinement]
    refinement = _in_h(chosen, ladders) if criteria is None else ladders[0]
    if not demanded:
        raise UsageError(f"no criterion is given for solver {solver.name!r} on {chosen.problem.problem.name!r}: give one")
    with tempfile.TemporaryDirectory(prefix="mpmverify-") as folder:
        tasks = [
            Task(
                results=Path(folder),
                study=study.name,
                index=index,
                case=chosen.name,
                refinement=refinement.label,
                problem=chosen.problem,
                solver=solver,
                discretisation=discretisation,
                criteria=demanded,
                key=f"{index}",
                reuse=False,
            )
            for index, discretisation in enumerate(refinement.tier(tier))
        ]
        levels = _levels(tasks, timeout)
    seen = evidence_of(levels)
    table = []
    for criterion in demanded:
        verdict, reason = judge(criterion, seen)
        where = (study.name, chosen.name, solver.name, refinement.label, "verification", criterion.title)
        table.append(Finding(*where, verdict, reason, criterion.source))
    return tuple(table)


def _case(study: Study, name: str) -> Case:
    cases = {case.name: case for case in study.cases}
    if not name and len(cases) == 1:
        return study.cases[0]
    if name not in cases:
        which = f"has no case {name!r}" if name else "has several cases"
        raise UsageError(f"study {study.name!r} {which}: choose from {', '.join(cases)}")
    return cases[name]


def _in_h(case: Case, ladders: Sequence[Refinement]) -> Refinement:
    """First of some ladders in h whose dt is proportional to h: others show other orders than a solver declares."""
    for ladder in ladders:
        if len({(level.courant, level.ppc) for level in ladder.levels}) == 1:
            return ladder
    raise UsageError(
        f"{ladders[0].label!r} on case {case.name!r} is no ladder in h at one Courant number, of which a solver declares its "
        "orders: give such a one by refinement=, or criteria= for this one"
    )


def _levels(tasks: Sequence[Task], timeout: float | None) -> list[Level]:
    Results(tasks[0].results).create()
    if timeout is None:
        return [evaluated.level for _, evaluated in pool.inline(tasks)]
    try:
        pickle.dumps(tasks)
    except Exception as error:  # pickle raises what it likes
        solver = tasks[0].solver.name
        raise UsageError(
            f"solver {solver!r} cannot travel to a worker process ({error}): define it in a module, or give no timeout"
        ) from error
    found = {task.index: evaluated.level for task, evaluated in pool.over_processes(tasks, 1, timeout)}
    return [found[index] for index in range(len(tasks))]
