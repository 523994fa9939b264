"""What stands beside a log, in LOG.toml: who measured what, in which frame, how well."""

from __future__ import annotations

import difflib
import json
import math
from collections.abc import Callable
from dataclasses import dataclass, fields
from datetime import UTC, date, datetime
from enum import StrEnum
from pathlib import Path
from typing import Any

from camrob.errors import LogError
from camrob.toml.key_line import key_line
from camrob.toml.read_toml import read_toml
from camrob.units import deg_to_rad, m_s_to_mm_min, m_to_mm, mm_min_to_m_s, mm_to_m, rad_to_deg

__all__ = ["LogInfo", "MeasuredFrame", "Target", "info_text", "read_info", "wrong_key"]


class MeasuredFrame(StrEnum):
    """The frame that measured poses are in."""

    WORLD = "world"
    BASE = "base"  # turns with the table
    UNKNOWN = "unknown"  # the instrument's own, to be fitted


class Target(StrEnum):
    """What was measured."""

    TOOL = "tool"
    UNKNOWN = "unknown"  # a reflector somewhere on the flange, to be fitted


@dataclass(frozen=True, slots=True)
class LogInfo:
    """The facts of LOG.toml, SI; NaN or "" where the file says nothing.

    sigma_position (m) and sigma_angle (rad): the instrument's 1-sigma noise an axis; sigma_axis (rad) and sigma_axis_length
    (m): that of encoders against set-points. tolerance: m at the tool that nobody cares about. payload: kg. feed: m/s.
    program: name of the program file beside the log. poses: rows are single poses at rest, not a path. same_poses_as: the
    log of another target on the same postures; same_frame_as, same_target_as: the log whose instrument stood where this
    one's stood, and whose reflector sat where this one's sat. state: of the machine, in any words: logs that name one alike are
    of one. recorded: when; of one that gives an offset from UTC, in UTC. along: unit vector of what a distance d counts along;
    distance_from: m, the place that it is from; distance_from_unknown, distance_zero_unknown: that, and by how much it is short,
    are to be fitted.
    """

    measured_frame: MeasuredFrame = MeasuredFrame.WORLD
    target: Target = Target.TOOL
    sigma_position: float = math.nan
    sigma_angle: float = math.nan
    payload: float = math.nan
    feed: float = math.nan
    program: str = ""
    instrument: str = ""
    note: str = ""
    poses: bool = False
    sigma_axis: float = math.nan
    sigma_axis_length: float = math.nan
    tolerance: float = math.nan
    same_poses_as: str = ""
    same_frame_as: str = ""
    same_target_as: str = ""
    state: str = ""
    recorded: datetime | None = None
    along: tuple[float, float, float] | None = None
    distance_from: tuple[float, float, float] | None = None
    distance_from_unknown: bool = False
    distance_zero_unknown: bool = False


_NUMBERS: dict[str, tuple[str, Callable[[float], float], Callable[[float], float]]] = {
    "sigma_mm": ("sigma_position", mm_to_m, m_to_mm),
    "sigma_deg": ("sigma_angle", deg_to_rad, rad_to_deg),
    "sigma_axis_deg": ("sigma_axis", deg_to_rad, rad_to_deg),
    "sigma_axis_mm": ("sigma_axis_length", mm_to_m, m_to_mm),
    "tolerance_mm": ("tolerance", mm_to_m, m_to_mm),
    "payload_kg": ("payload", float, float),
    "feed_mm_min": ("feed", mm_min_to_m_s, m_s_to_mm_min),
}
_TEXTS = ("program", "instrument", "note", "same_poses_as", "same_frame_as", "same_target_as", "state")
_CHOICES: dict[str, type[StrEnum]] = {"measured_frame": MeasuredFrame, "target": Target}
_FARTHEST = 1e6  # mm
_TABLE = "table"  # of a log that another recorder wrote: `camrob.measurement.table_facts`
_RECORDED = "recorded"
_FROM, _ALONG, _ZERO = "d_from_mm", "d_along", "d_zero"  # of a distance d
_KEYS = (*_CHOICES, *_NUMBERS, *_TEXTS, _RECORDED, "poses", _FROM, _ALONG, _ZERO)


def read_info(path: Path) -> LogInfo:
    """The facts in a LOG.toml. Keys that are not the format's are left aside, unless they look like a misspelt one.

    Raises LogError naming file, line, key, and hint.
    """
    data = read_toml(path, LogError)
    values: dict[str, Any] = {}
    for key, value in data.items():
        if key in _CHOICES:
            values[key] = _choice(path, key, value)
        elif key in _NUMBERS:
            values[_NUMBERS[key][0]] = _NUMBERS[key][1](_number(path, key, value))
        elif key in _TEXTS:
            if not isinstance(value, str) or not all(c.isprintable() or c in "\n\t" for c in value):
                raise wrong_key(path, key, "is not a text", "give a text in quotes")
            values[key] = " ".join(value.split())
        elif key == "poses":
            if not isinstance(value, bool):
                raise wrong_key(path, key, "is neither true nor false", "write true or false")
            values[key] = value
        elif key == _RECORDED:
            values[key] = _moment(path, key, value)
        elif key in (_FROM, _ALONG, _ZERO):
            values |= _of_distance(path, key, value)
        elif key != _TABLE and (near := _meant(key)):
            raise wrong_key(path, key[:40], "is not a key of a log", f"is {near} meant?")
    if _FROM in data and _ALONG in data:
        raise wrong_key(path, _ALONG, f"stands beside {_FROM}", "a distance is from a place, or along a direction")
    if values.get("distance_from_unknown"):
        values["measured_frame"] = MeasuredFrame.UNKNOWN  # where it is from is where the instrument stands
    return LogInfo(**values)


def _moment(path: Path, key: str, value: Any) -> datetime:
    """A day, or a day and a time; text is taken as ISO 8601 has it."""
    hint = "write a day, 2026-11-28, or one with a time, 2026-11-28T14:30:00"
    wrong = wrong_key(path, key, f"is {str(value)[:40]!r}", hint)
    try:
        given = datetime.fromisoformat(value) if isinstance(value, str) else value
        if isinstance(given, date) and not isinstance(given, datetime):
            given = datetime(given.year, given.month, given.day)
        if not isinstance(given, datetime):
            raise wrong
        return given if given.tzinfo is None else given.astimezone(UTC).replace(tzinfo=None)
    except (ValueError, OverflowError):
        raise wrong from None


def _of_distance(path: Path, key: str, value: Any) -> dict[str, Any]:
    """What a key says of where a distance d is from."""
    if key == _ZERO:
        if value != "unknown":
            raise wrong_key(path, key, f"is {str(value)[:40]}", 'write "unknown", or leave it out')
        return {"distance_zero_unknown": True}
    if key == _FROM and value == "unknown":
        return {"distance_from_unknown": True}
    three = isinstance(value, list) and len(value) == 3 and all(_plain(v) and abs(v) <= _FARTHEST for v in value)
    if not three or (key == _ALONG and not any(value)):
        hint = "give [X, Y, Z]" + (' of the place, in mm, or "unknown"' if key == _FROM else " of the direction")
        raise wrong_key(path, key, f"is {str(value)[:40]}", hint)
    if key == _FROM:
        return {"distance_from": tuple(mm_to_m(float(v)) for v in value)}
    size = math.hypot(*value)
    return {"along": tuple(float(v) / size for v in value)}


def _meant(key: str) -> str:
    """The format's key that another is a slip of the pen for, or that one without its unit; "" where there is none."""
    small = key.lower()
    near = difflib.get_close_matches(small, (*_KEYS, _TABLE), n=1, cutoff=0.8)
    parts = [known for known in _KEYS if known.startswith(f"{small}_") or known.endswith(f"_{small}")]
    return (near or parts or [""])[0]


def wrong_key(path: Path, key: str, what: str, hint: str, *, below: tuple[str, ...] = ()) -> LogError:
    """What is wrong with a key, by the line that it stands on; below: the tables around it."""
    return LogError(f"{key}: {what}", hint=hint, path=path, line=key_line(path, (*below, key)))


def _choice(path: Path, key: str, value: Any) -> StrEnum:
    choices = _CHOICES[key]
    if value not in list(choices):
        raise wrong_key(path, key, f"is {str(value)[:40]!r}", f"use one of {', '.join(choices)}")
    return choices(value)


def _plain(value: Any) -> bool:
    """Whether a value is a number."""
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _number(path: Path, key: str, value: Any) -> float:
    if not _plain(value) or not 0.0 <= value <= 1e9:
        raise wrong_key(path, key, f"is {str(value)[:40]}", "give a number that is not negative")
    return float(value)


def info_text(info: LogInfo) -> str:
    """LOG.toml for some facts; those that are the defaults are left out."""
    plain = LogInfo()
    given = {f.name for f in fields(LogInfo) if getattr(info, f.name) not in ("", getattr(plain, f.name))}
    lines = [f"measured_frame = {json.dumps(str(info.measured_frame))}", f"target = {json.dumps(str(info.target))}"]
    for key, (name, _, to_edge) in _NUMBERS.items():
        if not math.isnan(getattr(info, name)):
            lines.append(f"{key} = {to_edge(getattr(info, name)):.15g}")
    lines += [f"{key} = {json.dumps(getattr(info, key))}" for key in _TEXTS if key in given]
    if info.distance_from_unknown or info.distance_from is not None:
        told = [f"{m_to_mm(v):.15g}" for v in info.distance_from or ()]
        lines.append(f"{_FROM} = " + (f"[{', '.join(told)}]" if told else '"unknown"'))
    if info.along is not None:
        lines.append(f"{_ALONG} = [{', '.join(f'{v:.15g}' for v in info.along)}]")
    if info.distance_zero_unknown:
        lines.append(f'{_ZERO} = "unknown"')
    if info.recorded is not None:
        lines.append(f"{_RECORDED} = {info.recorded.isoformat()}")
    if info.poses:
        lines.append("poses = true")
    return "\n".join(lines) + "\n"
