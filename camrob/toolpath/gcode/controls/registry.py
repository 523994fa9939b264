"""The controls whose programs camrob reads: a new one is a file and a line here."""

from __future__ import annotations

from camrob.toolpath.gcode.controls.control import Control
from camrob.toolpath.gcode.controls.heidenhain import HEIDENHAIN
from camrob.toolpath.gcode.controls.iso import ISO
from camrob.toolpath.gcode.controls.linuxcnc import LINUXCNC
from camrob.toolpath.gcode.controls.okuma import OKUMA
from camrob.toolpath.gcode.controls.siemens import SIEMENS

__all__ = ["CONTROLS", "choose_control"]

CONTROLS: dict[str, Control] = {c.name: c for c in (ISO, LINUXCNC, OKUMA, SIEMENS, HEIDENHAIN)}
_BY_NAME = 2  # above ISO's 1, below the words that another control has for itself


def choose_control(text: str, suffix: str) -> Control:
    """The control whose program the text and the file's suffix look most like: ISO's, where nothing shows another one's."""
    return max(CONTROLS.values(), key=lambda c: c.recognise(text) + _BY_NAME * (suffix.lower() in c.suffixes))
