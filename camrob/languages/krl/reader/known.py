"""What a controller holds that a program may name: by the cell's word, since the program doesn't say it."""

from __future__ import annotations

from collections.abc import Mapping

from camrob.cell.controller_settings import ControllerSettings
from camrob.languages.krl.reader.expressions import Aggregate, Value

__all__ = ["MESSAGES", "controller_values"]

MESSAGES = frozenset(
    """MSGNOTIFY MSGQUIT MSGDIALOG SET_KRLMSG SET_KRLDLG CLEAR_KRLMSG EXISTS_KRLMSG EXISTS_KRLDLG""".split()
)
"""The controller's own routines that show a message (KUKA's MsgLib, user messages of KSS 8)."""

_AXES = ("A1", "A2", "A3", "A4", "A5", "A6", "E1", "E2", "E3", "E4", "E5", "E6")


def controller_values(controller: ControllerSettings | None) -> Mapping[str, Value]:
    """HOME by the name that `home_point` gives it, and the row of BASE_DATA that is the cell's base, where the cell has them."""
    if controller is None:
        return {}
    known: dict[str, Value] = {}
    point = controller.own.get("home_point")
    if isinstance(point, dict):
        axes = dict(zip(_AXES, map(float, point["axes"]), strict=False))
        known[str(point["name"]).upper()] = Aggregate("E6AXIS", axes)
    if controller.own.get("base_measured") is True:
        frame = controller.base_frame or (0.0,) * 6
        known[f"BASE_DATA[{controller.own.get('base_number')}]"] = Aggregate(
            "FRAME", dict(zip("XYZABC", frame, strict=True))
        )
    return known
