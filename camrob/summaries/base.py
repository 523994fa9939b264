"""The base of all summaries: a frozen dataclass that is also a JSON object.

The fields of a summary are the keys of its object, in their order; what a field holds is a plain value, another summary, a tuple
or a mapping of these. A field may say four things of itself: that its key is not its name (`keyed`), that the key is left out
where there is nothing to say (`left_out`), that another summary's keys stand among this one's own (`spread`), and that it holds
the keys which no field is there for (`further`).

    @dataclass(frozen=True, slots=True, kw_only=True)
    class Limits(Summary):
        margin_min: Mapping[str, float | None]
        violations: int
        worst: str = left_out("")
"""

from __future__ import annotations

import types
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, field, fields
from functools import cache
from typing import Any, Self, Union, get_args, get_origin, get_type_hints

from camrob.errors import InputError

__all__ = ["OpenSummary", "Summary", "further", "keyed", "left_out", "spread"]

_KEY, _LEFT_OUT, _SPREAD, _FURTHER = "key", "left out", "spread", "further"


def keyed(key: str, default: object = MISSING) -> Any:
    """A field whose key in the JSON object is `key`."""
    return field(default=default, metadata={_KEY: key})


def left_out(default: object = None) -> Any:
    """A field whose key is left out of the JSON object where it holds its default."""
    return field(default=default, metadata={_LEFT_OUT: True})


def spread() -> Any:
    """A field for a summary whose keys stand among those of the object that holds it; None for none of them."""
    return field(default=None, metadata={_SPREAD: True})


def further() -> Any:
    """A field for a mapping of keys that a JSON object may have beyond the others: they are kept, and stand last."""
    return field(default_factory=dict, metadata={_FURTHER: True})


@dataclass(frozen=True, slots=True)
class Summary:
    """What a result says, in attributes; `to_json` gives its JSON object, `from_json` reads one."""

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            value = getattr(self, name)
            if isinstance(value, list | tuple | Mapping):
                object.__setattr__(self, name, _frozen(value))

    def to_json(self) -> dict[str, Any]:
        """The JSON object: the keys in the order of the fields, tuples as lists."""
        out: dict[str, Any] = {}
        more: dict[str, Any] = {}
        for f in fields(self):
            value = getattr(self, f.name)
            if _SPREAD in f.metadata:
                out |= {} if value is None else value.to_json()
            elif _FURTHER in f.metadata:
                more = _plain(value)
            elif not (_LEFT_OUT in f.metadata and value == f.default):
                out[f.metadata.get(_KEY, f.name)] = _plain(value)
        return out | more

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """The summary that a JSON object was made from.

        Raises InputError for a key that is not there or not known, and for a value that is no object where one has to stand.
        """
        if not isinstance(data, Mapping):
            raise InputError(f"{data!r:.40} is not a {cls.__name__}", hint="give the JSON object that camrob wrote")
        unknown = sorted(set(data) - _keys(cls))
        if unknown and not any(_FURTHER in f.metadata for f in fields(cls)):
            raise InputError(f"{cls.__name__} has no key {unknown[0]!r}", hint="read it with the camrob that wrote it")
        return cls(**_arguments(cls, data))


@dataclass(frozen=True, slots=True, kw_only=True)
class OpenSummary(Summary):
    """A summary whose JSON object may have keys that no field is there for."""

    further: Mapping[str, Any] = further()


def _frozen(value: Any) -> Any:
    """A copy of a sequence or mapping that can't be changed."""
    if isinstance(value, Mapping):
        return types.MappingProxyType({key: _frozen(inner) for key, inner in value.items()})
    return tuple(_frozen(inner) for inner in value) if isinstance(value, list | tuple) else value


def _plain(value: Any) -> Any:
    """A value as JSON has it."""
    if isinstance(value, Summary):
        return value.to_json()
    if isinstance(value, Mapping):
        return {key: _plain(inner) for key, inner in value.items()}
    return [_plain(inner) for inner in value] if isinstance(value, list | tuple) else value


_hints: Callable[[Any], dict[str, Any]] = cache(get_type_hints)


def _keys(cls: type[Summary]) -> frozenset[str]:
    """All keys that the JSON object of a class may have."""
    hints = _hints(cls)
    own = {f.metadata.get(_KEY, f.name) for f in fields(cls) if not {_SPREAD, _FURTHER} & set(f.metadata)}
    return frozenset(own.union(*(_keys(_summary_in(hints[f.name])) for f in fields(cls) if _SPREAD in f.metadata)))


def _summary_in(hint: Any) -> type[Summary]:
    """The class of summaries in a hint such as `Figures | None`."""
    return next(one for one in (get_args(hint) or (hint,)) if one is not types.NoneType)  # type: ignore[no-any-return]


def _arguments(cls: type[Summary], data: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of a class by name, of a JSON object that has no keys but its own."""
    hints, out = _hints(cls), dict[str, Any]()
    for f in fields(cls):
        key, hint = f.metadata.get(_KEY, f.name), hints[f.name]
        if _SPREAD in f.metadata:
            inner = _summary_in(hint)
            its = {k: data[k] for k in data if k in _keys(inner)}
            out[f.name] = inner.from_json(its) if its or inner is hint else None
        elif _FURTHER in f.metadata:
            out[f.name] = {k: v for k, v in data.items() if k not in _keys(cls)}
        elif key in data:
            out[f.name] = _typed(hint, data[key])
        elif f.default is MISSING:
            raise InputError(f"{cls.__name__} lacks the key {key!r}", hint="give the JSON object that camrob wrote")
    return out


def _typed(hint: Any, value: Any) -> Any:
    """A JSON value as the type that a hint names: summaries, alone, in tuples and as values of mappings."""
    origin, inside = get_origin(hint), get_args(hint)
    if origin in (Union, types.UnionType):
        kinds = [one for one in inside if one is not types.NoneType]
        return value if value is None or len(kinds) != 1 else _typed(kinds[0], value)
    if origin is tuple and isinstance(value, list | tuple):
        each = inside[:1] * len(value) if inside[1:] == (...,) else inside
        return tuple(_typed(kind, one) for kind, one in zip(each, value, strict=True))
    if origin is not None and issubclass(origin, Mapping) and isinstance(value, Mapping):
        return {key: _typed(inside[1], one) for key, one in value.items()}
    return hint.from_json(value) if isinstance(hint, type) and issubclass(hint, Summary) else value
