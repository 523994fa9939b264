"""What stays once the claimed effects are taken away: how large, at which stage, of which axis, and what it follows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from camrob.gap.effects.common import arm_axes
from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.discrepancy import PARTS
from camrob.gap.evidence.model import Model, members_of, whole_gap
from camrob.gap.evidence.shrink import Shrinkage, Trial
from camrob.gap.evidence.unknown import CONSTANT, LOAD, UNKNOWN
from camrob.gap.locate.again import not_by_posture
from camrob.gap.locate.axes_report import axes_report
from camrob.gap.locate.late_together import late_together
from camrob.gap.locate.likely_part import FOOT, INSTRUMENT, TOOL, LikelyPart, likely_part
from camrob.gap.locate.localise import axes_of, regimes_of
from camrob.gap.locate.periodic import TIME, periodic
from camrob.gap.locate.single_shape import SingleShape, single_shape
from camrob.gap.locate.sits_at import regime_followed, sits_at
from camrob.gap.verdict.plausible import unknown_text
from camrob.summaries.diagnosis_summary import EffectFound, RegimeLeft, Unknown, UnknownPlace, UnknownShape
from camrob.units import m_to_mm, rad_to_deg

__all__ = [
    "ARM",
    "NOWHERE",
    "at_drive",
    "beyond_noise",
    "claims",
    "left_everywhere",
    "left_panels",
    "of_changing",
    "remains",
    "removed_share",
    "residual_regimes",
    "stage_of",
]

NOWHERE = UnknownPlace(stage=None, axes=(), regimes=(), comes_back="")
"""Of an unknown that is not likely."""

Set = frozenset[int]


def claims(model: Model, probability: Mapping[str, float]) -> Set:
    """The units of the best set whose effects are more likely at work than not."""
    return frozenset(i for i in model.best.members if probability.get(model.units[i].effect, 0.0) >= 0.5)


ARM = "encoder_to_tcp"
"""The stage behind the encoders."""
_APART = 1000  # blocks of fitted logs are fewer
_CLEAR = 0.05  # p value under which what stays follows something
_WORTH = 0.1  # share of its energy from which that is worth a word
_LEAST_FIELD = 0.5  # of the noise: a discrepancy that is smaller tells nothing
_REGIME_OF = {"posture": "position", "direction": "direction", "force": "load", "time": "time", "travel": "position"}
_OF_AXIS = 0.5  # share of its energy that one axis has to explain to be named
_OF_NAME = 0.25  # the same of a name in doubt, beside which a smooth rest stays
_BY_POSTURE = (("position",), ("load",))
_MOSTLY = 0.5  # of its energy
_READ_OFF = 2.0  # times its energy, a drive's error: it is read off the log, with axis and course, and every arm leaves something
# the least share of a part's place, and by how much more than any other's it is: one with a period fits nothing else, a course
# in time or over postures much that is smooth
_OF_PART, _OF_PERIOD, _AHEAD, _PERIOD_AHEAD = 0.4, 0.15, 0.15, 0.03


def left_panels(model: Model, members: Set, panels: Sequence[Panel] | None = None) -> list[Panel]:
    """The fitted logs (or other panels of the same units) without what some units, and frames that are not known, explain."""
    values = model.values(members | model.evidence.always, model.best)
    left = []
    for p in model.panels if panels is None else panels:
        y_servo = None if p.y_servo is None or p.servo is None else p.y_servo - p.errors(values)
        known = ~p.unknown_rows(np.flatnonzero(values))
        left.append(replace(p, y_tcp=p.y_tcp - p.twists(values), y_servo=y_servo, w_tcp=p.w_tcp * known[:, None]))
    return left


def left_everywhere(model: Model, members: Set, trial: Trial) -> list[Panel]:
    """`left_panels` of the fitted logs and of those that are named as withheld: what the time and a posture share on one run they
    need not share on another, and what hardly moves the tool on one may do so there.
    """
    left = left_panels(model, members)
    if trial.named:
        left += [replace(p, block=p.block + _APART) for p in left_panels(model, members, trial.panels)]
    return left


def residual_regimes(model: Model, panels: Sequence[Panel]) -> list[RegimeLeft]:
    """What the residual still depends on."""
    found = regimes_of(panels, model.noise)
    return [RegimeLeft(regime=k, p_value=v.p_value, share=v.share) for k, v in found.items()]


def beyond_noise(together: Shrinkage, noise: float) -> tuple[float, float]:
    """m (rms) that stay on withheld samples beyond the noise (m), and the share of the gap's energy that this is."""
    rms = float(np.sqrt(max(0.0, together.rms_after**2 - noise**2)))
    return rms, min(1.0, (rms / max(together.rms_before, 1e-12)) ** 2)


def removed_share(shrunk: Shrinkage, noise: float) -> float | None:
    """Share of the removable gap (before less noise) that is removed; None where nothing is removable."""
    removable = shrunk.rms_before - noise
    if removable < 0.2 * noise:
        return None
    return float(np.clip((shrunk.rms_before - shrunk.rms_after) / removable, -9.0, 1.0))


def remains(
    model: Model,
    panels: Sequence[Panel],
    together: Shrinkage,
    probability: float,
    shapes: Sequence[UnknownShape],
    regimes: Sequence[RegimeLeft],
    implausible: Mapping[str, str],
    unsure: Sequence[EffectFound],
) -> Unknown:
    """What is unknown. panels: without the claimed effects; together: by how much these shrink the gap; shapes: of the
    unexplained, where its place has one; regimes: of the residual; implausible: effects that would fit with such values; unsure:
    claims that are likely and no more.
    """
    rms, share = beyond_noise(together, model.noise)
    if probability < 0.5:
        where, text, shapes = NOWHERE, "", ()
    else:
        where, text, shapes = _placed(model, panels, rms, shapes, regimes)
        if where.stage == ARM and where.regimes[:1] in _BY_POSTURE and not where.comes_back:
            if not_by_posture(panels, model.noise, model.basis.axes):
                where, text, shapes = _of_no_posture(where, model, panels, rms)
        at = [e for e in unsure if not where.axes or where.axes[0] in ((e.stands_out or e.axes) or where.axes)]
        if at and not where.regimes:
            where, text = _at_unsure(where, text, max(at, key=lambda e: e.moves_mm))
    return Unknown(
        probability=probability,
        rms_mm=m_to_mm(rms),
        share=share,
        where=where,
        text=text,
        shapes=tuple(shapes),
        implausible=implausible,
    )


def _placed(
    model: Model,
    panels: Sequence[Panel],
    rms: float,
    shapes: Sequence[UnknownShape],
    regimes: Sequence[RegimeLeft],
) -> tuple[UnknownPlace, str, Sequence[UnknownShape]]:
    """Where what stays (rms, m) sits, in words too, and the shapes that show it: none where it comes back."""
    follows = sorted((r for r in regimes if r.p_value < _CLEAR and r.share > _WORTH), key=lambda r: -r.share)
    names = _first(_of_field(model), [r.regime for r in follows])
    one = single_shape(panels, model.noise)
    smooth = max(follows[0].share if follows else 0.0, 0.0 if one is None else one.share)
    where = UnknownPlace(stage=stage_of(panels, model), axes=_axis(panels), regimes=names, comes_back="")
    part = likely_part(panels, model.noise) if where.stage == ARM else None
    least = max(0.0 if one is None else one.share, _taken_by_shapes(model, panels) if shapes else 0.0)
    back = _returning(where, panels, model, max(smooth, 0.0 if part is None else part.share - _WORTH))
    if back is not None:
        where, shapes = back, ()
    elif part is not None and _stands_out(part, least) and not (shapes and _is_field(part)):
        return _of_part(where, part, model, rms)
    elif not shapes:
        where = _of_one(where, one, model)
        where = where if where.axes else _of_doubtful(where, model, panels, one)
        where = where if where.regimes else _followed_by_axis(where, panels, model.noise)
    text = f"{m_to_mm(rms):.3f} mm rms, {rms / model.noise:.1f} times the noise, stays unexplained"
    text += f", and comes back {where.comes_back}" if where.comes_back else ""
    led = where.regimes[:2]
    text += f", and follows {' and '.join(led)}" if led and not where.comes_back else ""
    if shapes:
        # the largest shape first; what moves the foot sits at the axis that it follows
        carriers = [s.moves if s.stage != ARM else sits_at(s.moves, s.follows, model) for s in shapes]
        named = model.scenes[0].axes if carriers[0] in model.scenes[0].axes else ()
        at = tuple(a for a in dict.fromkeys(carriers) if a in named)
        kinds = tuple(k for k in dict.fromkeys(regime_followed(s.follows) for s in shapes) if k)
        where = replace(where, stage=shapes[0].stage, axes=at, regimes=kinds)
        text = unknown_text(model, shapes)
    return where, text, shapes


def _stands_out(part: LikelyPart, others: float) -> bool:
    """Whether a part explains enough, and clearly more than any one shape, whose share is at most `others`."""
    if part.period is not None:
        return part.share > max(_OF_PERIOD, others + _PERIOD_AHEAD)
    return part.share > max(_OF_PART, others + _AHEAD)


def _is_field(part: LikelyPart) -> bool:
    """Whether a part is a smooth field over postures, as the discrepancy is: shapes of the best set have stood out beside it."""
    return part.follows == "position" and part.moves in (FOOT, TOOL, INSTRUMENT)


def _of_part(
    where: UnknownPlace, part: LikelyPart, model: Model, rms: float
) -> tuple[UnknownPlace, str, Sequence[UnknownShape]]:
    """The place of a part that explains more than any one shape does, in words, and no shape."""
    axis = part.moves not in (FOOT, TOOL, INSTRUMENT)
    scene = model.scenes[0]
    linear = not part.along or scene.cell.joints[scene.cell.index(part.moves)].prismatic
    size = f"{m_to_mm(part.size):.3g} mm" if linear else f"{rad_to_deg(part.size):.3g} degrees"
    back = "" if part.period is None else f"every {part.period:.3g} s"
    hung = arm_axes(scene.cell)[-1:] if part.moves == TOOL and part.follows == LOAD else ()
    name = part.moves if axis else f"the {part.moves}{f', or the flange of {hung[0]},' if hung else ''}"
    text = f"{m_to_mm(rms):.3f} mm rms, {rms / model.noise:.1f} times the noise, stays unexplained"
    text += f"; most of it is as if {name} were off by {size} rms, which follows the {part.follows}"
    text += f" and comes back {back}" if back else ""
    rest = tuple(n for n in where.regimes if n != part.follows)
    axes = (part.moves,) if axis else hung
    return replace(where, axes=axes, regimes=(part.follows, *rest), comes_back=back), text, ()


def _of_no_posture(
    where: UnknownPlace, model: Model, panels: Sequence[Panel], rms: float
) -> tuple[UnknownPlace, str, Sequence[UnknownShape]]:
    """The place of what is another one when the arm comes to a posture again: with what explains it best but postures, else the
    time, at no axis.
    """
    part = likely_part(panels, model.noise, but="position")
    if part is not None and part.share > _OF_NAME and part.follows != TIME:
        return _of_part(replace(where, axes=(), regimes=()), part, model, rms)
    text = f"{m_to_mm(rms):.3f} mm rms, {rms / model.noise:.1f} times the noise, stays unexplained; it is another one each time "
    text += "that the arm comes to a posture, and changes smoothly in between: it comes and goes with the time"
    return replace(where, axes=(), regimes=("time",)), text, ()


def _at_unsure(where: UnknownPlace, text: str, claim: EffectFound) -> tuple[UnknownPlace, str]:
    """The place of what stays beside a claim that may be a likeness of it and follows nothing of its own: the claim's."""
    axes = where.axes or claim.stands_out or claim.axes[:1]
    of = f" of {' and '.join(axes)}" if axes else ""
    text += f"; {claim.effect.replace('_', ' ')}{of}, which is not sure, is likely to be a part of it"
    return replace(where, axes=tuple(axes), regimes=tuple(claim.regimes)), text


def of_changing(stays: Unknown, claims: Sequence[EffectFound], changing: Mapping[str, str]) -> Unknown:
    """What stays where most of it is a claim's own pattern once more, that changes with the time or an axis (`changing`, by
    name): it sits at that axis, or follows the time.
    """
    own = [e for e in claims if e.claimed and e.effect in changing]
    if not own:
        return stays
    largest = max(own, key=lambda e: e.moves_mm)
    by = changing[largest.effect]
    where = (
        replace(stays.where, regimes=(TIME,)) if by == TIME else replace(stays.where, axes=(by,), regimes=("position",))
    )
    what = "the time" if by == TIME else f"the position of {by}"
    words = f"most of it is {largest.effect.replace('_', ' ')} once more, which is not constant and changes with {what}"
    return replace(stays, where=replace(where, comes_back=""), text="; ".join(filter(None, (stays.text, words))))


def _taken_by_shapes(model: Model, panels: Sequence[Panel]) -> float:
    """Share of the energy beyond the noise that the shapes of the unknown in the best set take of what stays."""
    own = members_of(model, UNKNOWN.name)
    return _taken(model, panels, own)


def _taken(model: Model, panels: Sequence[Panel], own: Set) -> float:
    """Share of the energy beyond the noise that some units of the best set take of what stays."""
    values, gained, energy = model.values(own, model.best), 0.0, 0.0
    for p in panels:
        rows = p.w_tcp[:, 0] > 0.0
        gap = whole_gap(p)[rows]
        energy += float(np.sum(gap**2)) - len(gap) * model.noise**2
        gained += float(np.sum(gap**2 - (gap - p.moves(values, rows)) ** 2))
    return gained / max(energy, 1e-30)


def at_drive(stays: Unknown, model: Model, panels: Sequence[Panel], axis: str, words: str) -> Unknown:
    """What stays, at an axis's drive: what its error follows most is read off the log, or is what the largest shape there
    follows; at no axis where all fall behind together. An error that stands, in a drive that always holds a load to one side,
    follows that load: a loop without its integrator. Where far more stays behind the encoders, beyond the noise, the place is
    there, and the drive is said beside it.
    """
    if stage_of(panels, model, _READ_OFF) == ARM and stays.rms_mm > m_to_mm(_LEAST_FIELD * model.noise):
        return replace(stays, text="; ".join(filter(None, (stays.text, words))))
    drive, k = axes_report(model.scenes)[axis].drive, model.scenes[0].index(axis)
    follows = "" if drive is None or drive.pattern.follows == CONSTANT else drive.pattern.follows
    load = np.concatenate([s.torque[:, k] for s in model.scenes])
    if drive is not None and not follows and _stands(drive.mean, drive.rms):
        follows = LOAD if _stands(float(load.mean()), float(np.sqrt(np.mean(load**2)))) else ""
    own = [regime_followed(s.follows) for s in stays.shapes if s.moves == axis and s.stage != ARM]
    regimes = tuple(dict.fromkeys(filter(None, (follows, *own))))
    axes: tuple[str, ...] = (axis,)
    if late_together(model.scenes):
        axes, regimes, words = (), ("speed",), f"all drives fall behind their set-points together; {words}"
    where = UnknownPlace(stage="setpoint_to_encoder", axes=axes, regimes=regimes, comes_back="")
    return replace(stays, where=where, text="; ".join(filter(None, (words, stays.text))))


def _stands(mean: float, rms: float) -> bool:
    """Whether what has this mean and rms mostly stands to one side."""
    return mean**2 > _MOSTLY * rms**2


def _of_field(model: Model) -> str:
    """The regime that most of the discrepancy beside the best set is a function of; "" where there is none."""
    field, sizes = model.evidence.field, model.evidence.sizes
    if field is None or sizes is None:
        return ""
    weights = field.fitted(model.best.mean, sizes)[:, :3]
    moved = dict.fromkeys(_REGIME_OF, 0.0)
    for k, part in enumerate(PARTS):
        own = model.basis.part == k
        for p in model.panels:
            if p.smooth is not None:
                moved[part] += float(np.sum((p.smooth[:, own] @ weights[own]) ** 2))
    rows = sum(len(p.scene) for p in model.panels)
    most = max(moved, key=lambda n: moved[n])
    return _REGIME_OF[most] if moved[most] > rows * (_LEAST_FIELD * model.noise) ** 2 else ""


def _first(name: str, names: Sequence[str]) -> tuple[str, ...]:
    """Names with one of them before all others, where it is among them."""
    return (name, *(n for n in names if n != name)) if name in names else tuple(names)


def _returning(where: UnknownPlace, panels: Sequence[Panel], model: Model, share: float) -> UnknownPlace | None:
    """The place of what comes back with a period, where that explains more than any smooth function does (`share`)."""
    found = periodic(panels, model.noise)
    if found is None or found.share < max(_OF_AXIS, share + _WORTH):
        return None
    if found.quantity == TIME:
        return replace(where, axes=(), regimes=("time",), comes_back=f"every {found.period:.3g} s")
    linear = model.scenes[0].cell.joints[model.scenes[0].cell.index(found.quantity)].prismatic
    period = f"{m_to_mm(found.period):.3g} mm" if linear else f"{rad_to_deg(found.period):.3g} degrees"
    regimes = ("position", *(n for n in where.regimes if n != "position"))
    return replace(where, axes=(found.quantity,), regimes=regimes, comes_back=f"every {period} of {found.quantity}")


def _of_one(where: UnknownPlace, one: SingleShape | None, model: Model) -> UnknownPlace:
    """The place of what one part explains most of; as it was where none does."""
    if one is None or one.share < _OF_AXIS:
        return where
    axis, regime = sits_at(one.moves, one.follows, model), regime_followed(one.follows)
    axes = (axis,) if axis in model.scenes[0].axes else ()
    return replace(where, axes=axes, regimes=(regime, *(n for n in where.regimes if n != regime)))


def _followed_by_axis(where: UnknownPlace, panels: Sequence[Panel], noise: float) -> UnknownPlace:
    """The place with what its axis follows most, where that is worth a word."""
    one = single_shape(panels, noise, moves=where.axes[0]) if where.axes else None
    regime = "" if one is None or one.share < _WORTH else regime_followed(one.follows)
    return replace(where, regimes=(regime,)) if regime else where


def _of_doubtful(where: UnknownPlace, model: Model, panels: Sequence[Panel], one: SingleShape | None) -> UnknownPlace:
    """The axis of the name in the best set that takes most of what stays, and more than any one shape (`one`): a name may be in
    doubt, and its axis not. As it was where it has none, and of claims, which are taken away.
    """
    taken: dict[str, float] = {}
    for effect in model.evidence.effects_of(model.best.members) - {UNKNOWN.name}:
        members = members_of(model, effect)
        for axis in {model.units[i].axis for i in members}:
            own = frozenset(i for i in members if model.units[i].axis == axis)
            taken[axis] = max(taken.get(axis, 0.0), _taken(model, panels, own))
    best = max(sorted(taken), key=lambda a: taken[a], default="")
    least = max(_OF_NAME, 0.0 if one is None else one.share)
    return replace(where, axes=(best,)) if best and taken[best] > least else where


def stage_of(panels: Sequence[Panel], model: Model, counts: float = 1.0) -> str:
    """Where most of what stays sits. counts: times its energy, what lies at the drives."""
    drives, arm = 0.0, 0.0
    for p in panels:
        good = p.w_tcp[:, 0] > 0.0
        if p.y_servo is not None:
            drives += float(np.sum(p.carried(p.y_servo)[good] ** 2))
        arm += float(np.sum(p.y_tcp[good, :3] ** 2) - good.sum() * model.noise**2)
    return "setpoint_to_encoder" if counts * drives > max(arm, 0.0) else ARM


def _axis(panels: Sequence[Panel]) -> tuple[str, ...]:
    """The axis whose shift explains most of what stays; none where that is not the most part, or where it slides and a shift in
    one direction, whatever moves it, explains as much.
    """
    shares = axes_of(panels)
    best = max(shares, key=lambda a: shares[a].value, default="")
    if not best or shares[best].value <= _OF_AXIS:
        return ()
    scene = panels[0].scene
    if not scene.cell.joints[scene.cell.index(best)].prismatic:
        return (best,)
    gap = np.concatenate([whole_gap(p)[p.w_tcp[:, 0] > 0.0] for p in panels])
    along = float(np.linalg.eigvalsh(gap.T @ gap)[-1]) / max(float(np.sum(gap**2)), 1e-30)
    return (best,) if shares[best].value > along else ()
