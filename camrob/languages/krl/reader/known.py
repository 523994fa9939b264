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
    """HOME by the name that `home_point` gives it, where the cell has one."""
    point = None if controller is None else controller.own.get("home_point")
    if not isinstance(point, dict):
        return {}
    return {str(point["name"]).upper(): Aggregate("E6AXIS", dict(zip(_AXES, map(float, point["axes"]), strict=False)))}
