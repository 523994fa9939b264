"""Hooks that a file's events need: what a cell can't switch at all is left out and said, what it could half do is refused."""

from __future__ import annotations

from camrob.cell.cell import Cell
from camrob.errors import JobError
from camrob.findings import Finding
from camrob.toolpath.region import Event, EventKind

__all__ = ["demand_hook"]

_SPINDLE = ("spindle_on", "spindle_on_ccw")
# what an event says, the hook that it is written by, and those of which one alone leaves the other half to nobody
_ASKED = {
    EventKind.SPINDLE_OFF: ("the file switches the spindle off", "spindle_off", _SPINDLE),
    EventKind.COOLANT_ON: ("the file switches the coolant on", "coolant_on", ("coolant_off",)),
    EventKind.COOLANT_OFF: ("the file switches the coolant off", "coolant_off", ("coolant_on",)),
    EventKind.STOP: ("the file stops for the operator", "stop", ()),
}
_ENDS = {EventKind.SPINDLE_ON: ("spindle", "spindle_off"), EventKind.COOLANT_ON: ("coolant", "coolant_off")}


def demand_hook(event: Event, cell: Cell) -> Finding | None:
    """What to say of an event that the cell has no hook for, None where there is nothing.

    Raises JobError for a stop without a hook, and where the cell could switch on and not off, or off and not on.
    """
    hooks = cell.controller.hooks
    what, hook, others = _ASKED.get(event.kind, ("", "", ()))
    missing = bool(hook) and not hooks.get(hook)
    if missing and (event.kind is EventKind.STOP or any(hooks.get(other) for other in others)):
        text = f"{what}, for which cell {cell.name} has no hook; add {hook} to [controller.hooks]"
        raise JobError(text, line=event.line)
    what, off = _ENDS.get(event.kind, ("", ""))
    if off and not missing and not hooks.get(off):
        text = f"the file switches the {what} on, and cell {cell.name} has no hook that ends it; add {off} to [controller.hooks]"
        raise JobError(text, line=event.line)
    if not missing or event.kind is EventKind.SPINDLE_OFF:  # which was never on
        return None
    return Finding("no-hook", f"the cell has no hook {hook}: what the file asks for there is left out", line=event.line)
