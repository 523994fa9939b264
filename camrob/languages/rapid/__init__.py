"""RAPID, ABB's robot language. What it is made of is loaded when it is asked for."""

from __future__ import annotations

from camrob.languages.rapid.rapid_language import LANGUAGE

__all__ = ["LANGUAGE"]
