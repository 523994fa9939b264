"""What the planner knows of a machine's errors: read from calibration, diagnosis and force model, or taken for granted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibration_file import read_calibration
from camrob.calibration.error_model import ErrorModel
from camrob.calibration.terms import ErrorTerm, TermKind, term_of
from camrob.cell.cell import Cell
from camrob.errors import InputError
from camrob.gap.effects.robot_size import COMPLIANCE_RATIO
from camrob.gap.evidence.discrepancy import LENGTHS, unit_of
from camrob.gap.fitted_units import FittedUnits
from camrob.gap.observation.scene import axis_values
from camrob.gap.unexplained import SHORTER, SIZE_DOUBT, UnexplainedField
from camrob.jobs.files.diagnosed import diagnosed
from camrob.jobs.solving.chain_constants import ChainConstants, chain_constants
from camrob.jobs.solving.sought import Sought
from camrob.jobs.solving.surface_of_path import SurfaceOfPath
from camrob.prediction.deflection import GRANTED, Granted, granted_compliance, known_compliance
from camrob.prediction.force_model import CuttingForce
from camrob.prediction.true_path import claimed_constants
from camrob.redundancy.accuracy.posture_errors import ARM_AXES, NoForce, PostureErrors, UnexplainedRest
from camrob.units import m_to_mm

__all__ = ["machine_errors", "unexplained_rest"]

Array = NDArray[np.float64]

_ANY_FORCE = 100.0  # N, of a cut that nobody has said anything of: an ordinary one for arms of this class


def machine_errors(
    sought: Sought, cell: Cell, surface: SurfaceOfPath | None, force: CuttingForce | None = None
) -> PostureErrors:
    """The errors of a cell with its tool; surface: what counts of them, None where nobody knows; force: what pushes on the tool.

    Raises InputError and its kin for files that are wrong or don't belong together.
    """
    calibration = None if sought.calibration is None else read_calibration(sought.calibration, cell)
    found, rest = None, 0.0
    if sought.diagnosis is not None:
        found, rest = diagnosed(sought.diagnosis, calibration, sought.cell, cell)
    if calibration is None:
        model, constants = ErrorModel.of(cell, ()), np.zeros(0)
    else:
        model, constants = calibration.model(cell)
    if force is not None and force.asks_removal and (surface is None or not surface.of_stock):
        hint = "give depth_mm and width_mm, or stock and cutter in the set-up"
        raise InputError("leaves depth or width to the removal", hint=hint, path=force.path)
    yields = known_compliance(found, model, constants)
    known = {a: v for a, (v, _k) in yields.items() if a in _arm(cell)}
    axes, (terms, values) = _AxisErrors(cell, model, constants, found), _terms(cell, model, constants, found)
    chain = chain_constants(cell, terms)
    root, by_root = _roots(terms, chain, found)
    nothing_yields = not known and force is None and not axes.empty
    taken, alike = Granted({}, 0.0) if nothing_yields else granted_compliance(cell, yields, found)
    sagging = np.array([known.get(a, 0.0) for a in _arm(cell)])
    compliance = np.array([taken.get(a, known.get(a, 0.0)) for a in _arm(cell)])
    return PostureErrors(
        compliance=compliance,
        sagging=sagging,
        shift=chain.shift(values),
        swing=np.sqrt(axes.variance),
        mark=axes.mark,
        couples=chain.couples,
        coupling=chain.coupling(values),
        places=chain.places(values),
        granted=GRANTED * np.array([taken.get(a, 0.0) for a in _arm(cell)]),
        root=root,
        tip=np.zeros(2) if force is None else force.give,
        force=NoForce() if force is None else force,
        # what scales all compliances scales the deflection, as the force does
        doubt=0.0 if force is None else float(np.hypot(force.doubt, alike)),
        any_force=_ANY_FORCE / np.sqrt(3.0) if force is None else 0.0,
        rest=rest,
        unexplained=None if found is None else unexplained_rest(cell, found, by_root),
        corrected=sought.corrected,
        normals=surface,
        counted=(
            *(("of all that follows, what compensation leaves: its doubt",) if sought.corrected else ()),
            _stiffness(_arm(cell), {a: v for a, v in known.items() if a not in taken}, compliance),
            *axes.counted,
            _pushed(force),
            *((f"{m_to_mm(rest):.3f} mm in each direction that nobody has explained",) if rest > 0.0 else ()),
            *(() if found is None or found.unexplained is None else (_far_from(found.unexplained),)),
            _counts(surface),
        ),
        left_out=axes.left_out,
    )


def _arm(cell: Cell) -> tuple[str, ...]:
    return tuple(cell.names[cell.arm_slice])


def unexplained_rest(cell: Cell, found: FittedUnits, by_root: Array) -> UnexplainedRest | None:
    """The diagnosis' field over posture in the chain's q; by_root: (3 M, K), by how much less it is in K directions of what was
    fitted.
    """
    field = found.unexplained
    if field is None:
        return None
    last, scale = cell.arm_slice.stop, unit_of(cell, field.axes)
    larger = float(np.exp(2.0 * SIZE_DOUBT**2))  # the mean square of sizes in doubt, far from what was measured
    values, per = np.zeros((len(field.postures), len(cell.axis_names))), np.zeros(len(cell))
    turns = np.zeros(len(cell), np.bool_)
    for k, axis in enumerate(field.axes):
        values[:, cell.axis_names.index(axis)] = field.postures[:, k] * scale[k]
        per[cell.index(axis)], turns[cell.index(axis)] = 1.0 / scale[k], k in field.tables
    return UnexplainedRest(
        postures=cell.to_q(axis_values(cell, cell.axis_names, values))[:, :last],
        per=per[:last],
        turns=turns[:last],
        length=SHORTER * LENGTHS[-1],
        variance=larger * field.variance,
        same=larger * field.same,
        values=field.mean,
        cov=field.cov,
        own=larger * field.among,
        by_root=by_root.reshape(len(field.postures), 3, by_root.shape[1]),
        in_base=field.in_base,
    )


def _far_from(field: UnexplainedField) -> str:
    near, far = (m_to_mm(float(np.sqrt(v))) for v in (np.diag(field.cov).mean(), field.variance + field.same))
    return f"what is unexplained and follows posture: to {near:.3f} mm where it was measured, to {far:.3f} mm far from there"


def _stiffness(arm: tuple[str, ...], known: dict[str, float], compliance: Array) -> str:
    if known:
        values = ", ".join(f"{a} {1e6 * v:.2g}" for a, v in known.items())
        rest = ", ".join(f"{a} {1e6 * v:.2g}" for a, v in zip(arm, compliance, strict=True) if a not in known)
        others = f", under the force others as such axes have beside these ({rest})" if rest else ""
        return f"compliances as found ({values} x 1e-6 rad/Nm) under gravity and the force{others}"
    if not compliance.any():
        return "no compliance, as none was found"
    ratio = " : ".join(f"{v:g}" for v in COMPLIANCE_RATIO)
    return f"compliances that nobody measured, taken as {ratio} from A1 to A6, {1e6 * compliance[0]:.2g} x 1e-6 rad/Nm the first"


def _pushed(force: CuttingForce | None) -> str:
    return f"{_ANY_FORCE:g} N from any side" if force is None else f"a force: {force.words}"


def _counts(surface: SurfaceOfPath | None) -> str:
    if surface is None:
        return "all that lies across the feed, as the set-up does not say the cutter's shape"
    return f"what lies along the normal of the surface that is left of {surface.of}"


class _AxisErrors:
    """What constants and found units say of the arm's axes, but compliance; what is of other things is left out."""

    def __init__(self, cell: Cell, model: ErrorModel, constants: Array, found: FittedUnits | None) -> None:
        self.variance, self.mark = (np.zeros(ARM_AXES) for _ in range(2))
        self._known = False
        self._counted: list[str] = []
        self._left: list[str] = []
        first = cell.arm_slice.start
        for term, value in zip(model.terms, constants, strict=True):
            i = term.joint - first
            if term.kind is TermKind.COMPLIANCE:
                continue
            if 0 <= i < ARM_AXES and term.kind in (TermKind.COS, TermKind.SIN):
                self.variance[i] += 0.5 * value**2
                self._counted.append(f"ripple of {cell.joints[term.joint].name}")
            elif chain_constants(cell, (term,)).counts[0]:
                self._counted.append(
                    f"where {term.name.split('.')[0]} stands" if term.kind is TermKind.PLACE else term.name
                )
                self._known = True
            else:
                self._left.append(term.name)
        if found is not None:
            self._units(cell, found)

    def _units(self, cell: Cell, found: FittedUnits) -> None:
        for own, (unit, effect, state) in enumerate(zip(found.units, found.effects, found.states, strict=True)):
            if effect.terms(unit, state) or not effect.of_machine:
                continue
            values = np.abs(found.values[found.owner == own])
            name = f"{unit.effect.replace('_', ' ')} of {unit.axis}" if unit.axis else unit.effect.replace("_", " ")
            if unit.axis not in _arm(cell) or not effect.at_reversals:
                self._left.append(name)
                continue
            i = _arm(cell).index(unit.axis)
            self.variance[i] += values[0] ** 2
            self.mark[i] += 2.0 * values.sum()  # from one side to the other
            self._counted.append(name)

    @property
    def empty(self) -> bool:
        """True where nothing is known of any axis."""
        return not (self._known or self.variance.any())

    @property
    def counted(self) -> tuple[str, ...]:
        """Names, each once."""
        return tuple(dict.fromkeys(self._counted))

    @property
    def left_out(self) -> tuple[str, ...]:
        """Names, each once."""
        return tuple(dict.fromkeys(self._left))


def _roots(terms: Sequence[ErrorTerm], chain: ChainConstants, found: FittedUnits | None) -> tuple[Array, Array]:
    """Standard deviations of the chain's constants in the planner's numbers, in K directions, of what was fitted, and by how much
    less what is unexplained is in each of these at its postures (3 M, K).
    """
    if found is None or not len(found.values):
        known = 0 if found is None or found.unexplained is None else len(found.unexplained.postures)
        return np.zeros((2 * ARM_AXES + len(chain.couples), 0)), np.zeros((3 * known, 0))
    values, vectors = np.linalg.eigh(0.5 * (found.cov + found.cov.T))
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    index = {t.name: k for k, t in enumerate(terms)}
    own_root, counted = np.zeros((len(terms), len(values))), np.zeros(len(values), np.bool_)
    for own, (unit, effect, state) in enumerate(zip(found.units, found.effects, found.states, strict=True)):
        rows = np.flatnonzero(found.owner == own)
        for k, name in zip(rows, effect.terms(unit, state), strict=False):
            own_root[index[name]] += root[k]
            counted[k] = chain.counts[index[name]]
    if found.unexplained is None:
        return chain.root(own_root, np.zeros((0, len(values))))
    # of constants that the planner doesn't move, nothing is made up for either
    less = np.einsum("mdk,kl->mdl", found.unexplained.by_value[:, :, counted], root[counted])
    return chain.root(own_root, less.reshape(-1, len(values)))


def _terms(
    cell: Cell, model: ErrorModel, constants: Array, found: FittedUnits | None
) -> tuple[tuple[ErrorTerm, ...], Array]:
    """The calibration's constants and their values, and those that a diagnosis without one has fitted."""
    if found is None:
        return model.terms, constants
    fitted = {name: value for name, value in claimed_constants(found).items() if name not in model.names}
    return (*model.terms, *(term_of(cell, name) for name in fitted)), np.append(constants, list(fitted.values()))
