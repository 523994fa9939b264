"""Whether fitted values can be true, and what the unexplained looks like, in words."""

from __future__ import annotations

import numpy as np

from camrob.gap.model import Model, effect_rms
from camrob.gap.unknown import basis, quantities
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["implausible", "unknown_text"]

_SIGMAS = 4.0


def implausible(model: Model) -> dict[str, str]:
    """Effect to the reason, for effects of the best set with values beyond what such machines have."""
    found: dict[str, str] = {}
    deviation = np.sqrt(np.maximum(np.diag(model.best.cov), 0.0))
    for k, (parameter, owner) in enumerate(zip(model.design.parameters, model.design.owner, strict=True)):
        unit = model.units[int(owner)]
        if int(owner) not in model.best.members or unit.effect == "unknown":
            continue
        value, slack = float(model.best.mean[k]), _SIGMAS * float(deviation[k])
        moves = abs(value) * float(model.design.size[k])
        if moves < 0.3 * model.noise:
            continue
        if value + slack < parameter.lower or value - slack > parameter.upper:
            low, high = parameter.at_edge(parameter.lower), parameter.at_edge(parameter.upper)
            found[unit.effect] = (
                f"{parameter.name} is {parameter.at_edge(value):.3g} where {low:.3g} to {high:.3g} is plausible"
            )
    return found


def unknown_text(model: Model) -> str:
    """Where the unexplained sits, what it follows, and how large it is; "" where no shape was found."""
    parts = []
    for i in sorted(model.best.members):
        unit = model.units[i]
        if unit.effect != "unknown":
            continue
        target, _, quantity = unit.key.partition("|")
        state = model.states["unknown"]
        columns = np.flatnonzero(model.design.owner == i)
        shape = []
        for p in model.panels:
            X = basis(quantities(p.scene)[quantity], state[f"{unit.key}|lower"], state[f"{unit.key}|upper"], quantity)
            shape.append(X @ model.best.mean[columns[1:]])
        swing = float(np.ptp(np.concatenate(shape)))
        linear = unit.parameters[0].unit == "mm"
        size = f"{m_to_mm(swing):.3f} mm" if linear else f"{rad_to_deg(swing):.4f} degrees"
        rung = "between set-point and encoder" if target.startswith("drive") else "between encoder and TCP"
        name = target.removeprefix("drive ")
        parts.append(f"{rung}, {name} moves by {size} as a smooth function of {quantity}")
    if not parts:
        return ""
    rms = m_to_mm(effect_rms(model, model.panels, "unknown"))
    return "; ".join(parts) + f" ({rms:.3f} mm rms at the TCP)"
