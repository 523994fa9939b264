"""What a KRL program sets once for all that follows, by the names that every language's program has for it."""

from __future__ import annotations

from collections.abc import Mapping

from camrob.languages.krl.reader.expressions import Unknown, Value
from camrob.program.program_text import Setting

__all__ = ["USUAL", "run_settings"]

_NAMES = {
    "$ADVANCE": "advance",
    "$VEL.ORI1": "turn_speed",
    "$VEL.ORI2": "roll_speed",
    "$ACC.ORI1": "turn_acceleration",
    "$ACC.ORI2": "roll_acceleration",
    "$APO.CVEL": "blend_speed",
    "$APO.CPTP": "blend_axes",
    "$APO.CORI": "blend_turn",
    "$ORI_TYPE": "turning",
    "$CIRC_TYPE": "arc_turning",
    **{
        f"${kind}_{axes}[{k}]": f"{name} {letter}{k}"
        for kind, name in (("VEL", "speed"), ("ACC", "acceleration"))
        for axes, letter in (("AXIS", "A"), ("EXTAX", "E"))
        for k in range(1, 7)
    },
}
USUAL = {"$ORI_TYPE": "#VAR", "$CIRC_TYPE": "#BASE"}
"""How the tool turns along paths, as everything here is read."""


def run_settings(variables: Mapping[str, Value]) -> dict[str, Setting]:
    """The settings among system variables at the program's end; one whose value the program doesn't hold is left out."""
    found = {}
    for variable, name in _NAMES.items():
        value = variables.get(variable)
        if value is None or isinstance(value, Unknown):
            continue
        plain = getattr(value, "text", value)
        if isinstance(plain, (int, float, str)):
            found[name] = Setting(variable, plain, USUAL.get(variable, ""))
    return found
