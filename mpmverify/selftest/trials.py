"""Trials: series of the quick studies that a faulty solver runs, ordered by how likely they are to detect a fault."""

import dataclasses
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from mpmverify.errors import UsageError
from mpmverify.study import Study


@dataclass(frozen=True)
class Trial:
    """All series of one solver, given by name, in one case of a study."""

    study: str
    case: str
    solver: str

    def of(self, get: Callable[[str], Study]) -> Study:
        """Return the study reduced to this trial, with its criteria.

        Parameters
        ----------
        get : callable
            Returns a study by name.

        Raises
        ------
        UsageError
            If the study has no such series.
        """
        study = get(self.study)
        cases = [case for case in study.cases if case.name == self.case]
        series = tuple(entry for case in cases for entry in case.series if entry.solver.name == self.solver)
        if not series:
            raise UsageError(f"the study {self.study!r} does not run {self.solver!r} in a case {self.case!r}")
        return dataclasses.replace(study, cases=(dataclasses.replace(cases[0], series=series),))


def merged(studies: Iterable[Study]) -> list[Study]:
    """Merge studies of the same name into one study with all their series."""
    table: dict[str, Study] = {}
    for study in studies:
        known = table.setdefault(study.name, study)
        if known is study:
            continue
        cases = {case.name: case for case in known.cases}
        for case in study.cases:
            before = cases.get(case.name, dataclasses.replace(case, series=()))
            cases[case.name] = dataclasses.replace(before, series=(*before.series, *case.series))
        table[study.name] = dataclasses.replace(known, cases=tuple(cases.values()))
    return list(table.values())


PATCH, WAVES, LOADS, MOVING, LARGE = (
    "patch-tests",
    "plane-waves",
    "loads-and-supports",
    "moving-bodies",
    "large-deformation",
)
COMBINED = "combinations"
VIBRATION, DRIVEN, BAR, ADVECTION, DECK, MANUFACTURED, DISPERSION = (
    "axial-vibration",
    "driven-bar",
    "elastic-bar",
    "advection",
    "gehojerez-deck",
    "manufactured-1d",
    "dispersion",
)
TRIALS: dict[str, tuple[Trial, ...]] = {
    "mpm": (
        Trial(DRIVEN, "loaded-right", "mpm-ul-linear-musl-flip"),
        Trial(PATCH, "translation, 1D", "mpm-ul-linear-musl-flip"),
        Trial(PATCH, "free fall from edges, 1D", "mpm-ul-linear-usl-flip"),
        Trial(PATCH, "shear, 2D", "mpm-ul-linear-musl-flip"),
        Trial(PATCH, "translation across joined ends, 2D", "mpm-ul-linear-musl-flip"),
        Trial(LOADS, "block, plane", "mpm-tl-linear-musl-flip"),
        Trial(WAVES, "clamped", "mpm-ul-linear-musl-flip"),
        Trial(DRIVEN, "loaded-left", "mpm-tl-quadratic-usf-flip"),
        Trial(DRIVEN, "accelerated", "mpm-ul-linear-musl-flip"),
        Trial(VIBRATION, "small-strain", "mpm-ul-linear-musl-flip"),
        Trial(MANUFACTURED, "published", "mpm-tl-linear-musl-flip-nodalforce"),
        Trial(BAR, "pulse", "mpm-ul-linear-musl-flip"),
        Trial(MANUFACTURED, "crossing", "mpm-ul-quadratic-musl-flip"),
        Trial(MANUFACTURED, "poisson", "mpm-tl-linear-musl-flip"),
        Trial(VIBRATION, "small-strain", "mpm-ul-linear-musl-pic"),
        Trial(VIBRATION, "small-strain", "mpm-ul-linear-usf-flip"),
        Trial(VIBRATION, "small-strain", "mpm-ul-linear-usl-flip"),
        Trial(VIBRATION, "small-strain", "mpm-tl-quadratic-usl-flip"),
        Trial(BAR, "pulse", "mpm-ul-quadratic-musl-flip"),
        Trial(BAR, "pulse", "mpm-tl-linear-musl-flip"),
        Trial(BAR, "pulse", "mpm-ul-linear-musl-pic"),
        Trial(MANUFACTURED, "no-crossing", "mpm-ul-linear-musl-blend95"),
        Trial(MANUFACTURED, "crossing", "mpm-tl-quadratic-usf-flip"),
        Trial(DISPERSION, "fixed-fixed", "mpm-tl-linear-usl-flip"),
        Trial(DISPERSION, "beyond-the-limit", "mpm-tl-linear-usl-flip"),
        Trial(WAVES, "yeoh-bar", "mpm-tl-linear-musl-flip"),
        Trial(WAVES, "neo-hookean-split-bar", "mpm-tl-linear-musl-flip"),
        Trial(WAVES, "saint-venant-kirchhoff-bar", "mpm-tl-linear-musl-flip"),
        Trial(WAVES, "yeoh", "mpm-tl-linear-musl-flip"),
        Trial(WAVES, "hencky", "mpm-tl-linear-musl-flip"),
        Trial(WAVES, "kelvin-voigt", "mpm-ul-linear-musl-flip"),
        Trial(WAVES, "maxwell", "mpm-ul-linear-musl-flip"),
        Trial(WAVES, "plane-stress", "mpm-ul-linear-musl-flip"),
        Trial(VIBRATION, "small-strain", "mpm-tl-linear-usl-xpic2"),
        Trial(VIBRATION, "small-strain", "mpm-tl-linear-usl-fmpm2"),
        Trial(PATCH, "translation, 1D", "mpm-ul-cubic-usl-flip"),
        Trial(MOVING, "ring", "mpm-ul-cubic-usl-flip"),
        Trial(PATCH, "shear, 1D", "mpm-ul-cpdi-musl-flip"),
        Trial(PATCH, "shear, 1D", "mpm-ul-ugimp-musl-flip"),
        Trial(MOVING, "square", "mpm-ul-cpdi-usl-flip"),
        Trial(MOVING, "square", "mpm-ul-cpgimp-usl-flip"),
        Trial(MOVING, "square", "mpm-ul-quadratic-usl-tpic"),
        Trial(MOVING, "square", "mpm-tl-linear-musl-flip-nodalforce"),
        Trial(LOADS, "block, plane", "mpm-ul-ugimp-usl-flip"),
        Trial(LOADS, "block, pair", "mpm-ul-linear-usl-flip"),
        Trial(MOVING, "blocks, plane", "mpm-ul-linear-musl-flip"),
        Trial(MOVING, "disk", "mpm-ul-quadratic-usl-apic"),
        Trial(PATCH, "rotation, 2D", "mpm-ul-quadratic-musl-apic"),
        Trial(MOVING, "cube, spinning", "mpm-ul-quadratic-usl-apic"),
        Trial(LARGE, "bases", "mpm-ul-mls-quadratic-usl-flip"),
        Trial(VIBRATION, "small-strain", "mpm-ul-tls-linear-usl-flip"),
        Trial(VIBRATION, "small-strain", "mpm-ul-tls-quadratic-usl-flip"),
        Trial(WAVES, "clamped", "mpm-ul-tls-linear-usl-flip"),
        Trial(MOVING, "square, several threads", "mpm-ul-quadratic-usl-apic"),
        Trial(WAVES, "yeoh-cuboid", "mpm-tl-linear-musl-flip"),
        Trial(COMBINED, "CPDI, sheared", "mpm-ul-cpdi-usl-flip"),
        Trial(COMBINED, "CPDI, space", "mpm-ul-cpdi-usl-flip"),
        Trial(COMBINED, "cpGIMP, stretched", "mpm-ul-cpgimp-usl-flip"),
        Trial(COMBINED, "uGIMP, affine", "mpm-ul-ugimp-usl-apic"),
        Trial(COMBINED, "TPIC, spinning", "mpm-ul-quadratic-usl-tpic"),
        Trial(COMBINED, "splines, joined under a load", "mpm-ul-quadratic-usl-apic"),
        Trial(COMBINED, "moving least squares, plane", "mpm-ul-mls-quadratic-usl-flip"),
        Trial(COMBINED, "Taylor least squares, finite strain", "mpm-tl-tls-linear-usl-flip"),
        Trial(COMBINED, "Taylor least squares, quadratic", "mpm-ul-tls-quadratic-usl-flip"),
        Trial(COMBINED, "FMPM(4)", "mpm-tl-linear-musl-fmpm4"),
        Trial(COMBINED, "heat, several threads", "mpm-ul-quadratic-usl-apic"),
        Trial(COMBINED, "force at the position, several threads", "mpm-ul-quadratic-usl-apic"),
    ),
    "taylor_galerkin": (
        Trial(DECK, "deck", "tg-lumped"),
        Trial(ADVECTION, "spectrum", "tg-consistent-3"),
        Trial(DRIVEN, "loaded-right", "tg-lumped"),
        Trial(DRIVEN, "loaded-left", "tg-consistent-3"),
        Trial(BAR, "pulse", "tg-lumped"),
        Trial(BAR, "pulse", "tg-consistent-3"),
        Trial(ADVECTION, "step", "tg-lumped"),
        Trial(ADVECTION, "step", "tg-consistent-3"),
        Trial(DRIVEN, "open-left", "tg-lumped"),
        Trial(DRIVEN, "open-left", "tg-consistent-3"),
        Trial(VIBRATION, "literature", "tg-lumped"),
        Trial(VIBRATION, "literature", "tg-consistent-3"),
        Trial(BAR, "step", "tg-consistent-3"),
        Trial(DISPERSION, "beyond-the-limit", "tg-lumped"),
        Trial(COMBINED, "step against the axis", "tg-lumped"),
    ),
    "fem": (
        Trial(DRIVEN, "loaded-right", "fem-p1-consistent-newmark"),
        Trial(DRIVEN, "loaded-left", "fem-p2-lumped-cd"),
        Trial(VIBRATION, "literature", "fem-p1-consistent-newmark"),
        Trial(BAR, "pulse", "fem-p1-lumped-cd"),
        Trial(MANUFACTURED, "no-crossing", "fem-p2-consistent-cd"),
        Trial(MANUFACTURED, "poisson", "fem-p2-lumped-cd"),
        Trial(VIBRATION, "literature", "fem-p2-consistent-newmark"),
        Trial(VIBRATION, "literature", "fem-p1-consistent-cd"),
        Trial(BAR, "pulse", "fem-p2-consistent-cd"),
        Trial(MANUFACTURED, "crossing", "fem-p1-consistent-cd"),
        Trial(DISPERSION, "beyond-the-limit", "fem-p1-consistent-cd"),
    ),
}
"""Trials of each family."""
