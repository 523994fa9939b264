"""Text of any origin stays text: never a KRL statement, never a path outside of --out, never active content of a report."""

from __future__ import annotations

import json
import re
import shutil
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from camrob import post
from camrob.cli import app as cli
from camrob.errors import CamrobError
from camrob.languages.krl.reader.read_krl import read_krl

ROOT = Path(__file__).resolve().parents[2]
CELL = ROOT / "cells" / "kr15_track_table"

PAYLOADS = {
    "a newline": "X\nPTP {A1 0}",
    "a carriage return": "X\rPTP {A1 0}",
    "both": "X\r\nEND\r\nDEF Y ( )\r\nHALT",
    "a form feed and a vertical tab": "X\fHALT\vHALT",
    "a next line": "X\x85HALT",
    "Unicode line separators": "X\u2028HALT\u2029HALT",
    "a semicolon": "X; HALT",
    "a closing fold": "X\n;ENDFOLD\nHALT",
    "a fold's tail": "X;%{PE}%MKUKATPBASIS,%CMOVE,%VLIN,%P 1:LIN, 2:P1",
    "braces": "X} HALT {",
    "quotes": 'X" HALT "\'',
    "a backslash": "X\\nHALT\\",
    "a null": "X\0HALT",
    "an escape": "X\x1b[2JHALT",
    "a path": "../../../etc/X",
    "an absolute path": "/etc/X",
    "a drive": "C:\\X",
    "script": "</script><script>alert(1)</script>",
    "an image": '"><img src=http://127.0.0.1/ onerror=alert(1)>',
    "a style": "</style><style>*{background:url(http://127.0.0.1/)}",
    "a template": "${alert(1)} {{7*7}} %{x} {speed} {base}",
    "right to left": "X\u202eTLAH",
    "a surrogate": "X\ud800",
    "very long": "X" * 5000,
    "a formula": '=HYPERLINK("http://127.0.0.1")',
}

HEAD = "TLDATA/MILL,10,0,50,0,0\nMSYS/0,0,0,1,0,0,0,1,0\n"
WAY = "RAPID\nGOTO/0,0,50,0,0,1\nFEDRAT/MMPM,500\nGOTO/0,0,0\nGOTO/40,0,0\n"
END = "RAPID\nGOTO/40,0,50\nEND-OF-PATH\n"


def with_text(text: str, place: str) -> str:
    """A CL file with some text in one of the places that hold text."""
    region, tool, note, comment, shown = (
        text if place == p else "A" for p in ("region", "tool", "note", "comment", "shown")
    )
    return (
        f"TOOL PATH/{region},TOOL,{tool}\n{HEAD}$$ {comment}\nPPRINT/{note}\nPPRINT {note}\n{WAY}INSERT/{note}\nDISPLY/{shown}\n"
        f"PARTNO/{note}\n{END}"
    )


ACTIVE = ("script", "an image", "a style", "a template", "right to left")
"""Payloads whose report is looked at, too."""


def post_text(text: str, place: str, folder: Path, *, report: bool = True) -> Path | None:
    """Post it; the program, or None where the file was refused in one line."""
    folder.mkdir()
    (folder / "setup.toml").write_text("part_in_base = [0, 0, 200, 0, 0, 0]\n")
    cl = folder / "part.cls"
    cl.write_bytes(with_text(text, place).encode("utf-8", "surrogatepass"))
    try:
        post(cl, cell=CELL, out=folder / "out", report=report)
    except CamrobError as error:
        assert str(error).isprintable() and "\n" not in str(error)
        assert not (folder / "out").exists()
        return None
    return folder / "out" / "part.src"


class Page(HTMLParser):
    """What a browser would make of a page: tags with attributes; scripts that would run."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))


def outline(page: str) -> list[tuple[str, tuple[str, ...]]]:
    return [(tag, tuple(sorted(attributes))) for tag, attributes in Page(page).tags]


def inert(page: str) -> None:
    """Nothing of a page comes from elsewhere, and nothing runs that is not the page's own."""
    for tag, attributes in Page(page).tags:
        assert not [name for name in attributes if name.startswith("on")], (tag, attributes)
        for name in ("src", "href", "action", "data", "poster", "srcset"):
            value = attributes.get(name) or ""
            assert not value or value.startswith(("#", "data:image/")), (tag, name, value)
        assert tag not in ("iframe", "object", "embed", "base", "link", "form")
    styles = re.findall(r"<style[^>]*>.*?</style>|style=\"[^\"]*\"", page, flags=re.S)
    assert not [s for s in styles if re.search(r"@import|url\((?!['\"]?data:|['\"]?#)", s)]


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = post_text("A", "none", tmp_path_factory.mktemp("plain") / "in")
    assert made is not None
    return made


def does_the_same(program: Path, plain: Path) -> None:
    """The motions, and all that is done between them, are those of the plain program."""
    one, other = read_krl(program), read_krl(plain)
    for name in ("kind", "pose", "axes", "external", "speed", "blend", "wait"):
        assert np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True)
    assert one.actions == other.actions
    ours = [line for line in other_lines(plain)]
    assert [line for line in other_lines(program)] == ours
    data = program.read_bytes()
    assert data.isascii() and data.count(b"\n") == data.count(b"\r\n") == data.count(b"\r")
    assert all(len(line) <= 255 and not re.search(rb"[\x00-\x08\x0b-\x1f\x7f]", line) for line in data.split(b"\r\n"))


def other_lines(program: Path) -> list[str]:
    """Lines that are no comments."""
    return [line for line in program.read_text().splitlines() if not line.lstrip().startswith(";")]


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("place", ["region", "tool", "note", "comment", "shown"])
def test_text_of_a_cl_file(plain: Path, tmp_path: Path, place: str) -> None:
    posted = 0
    for number, (name, text) in enumerate(PAYLOADS.items()):
        report = name in ACTIVE and place != "shown"
        program = post_text(text, place, tmp_path / str(number), report=report)
        if program is None:
            continue
        posted += 1
        does_the_same(program, plain)
        assert {f.suffix for f in program.parent.iterdir()} <= {f.suffix for f in plain.parent.iterdir()}
        if report:
            page = program.with_suffix(".html").read_text()
            inert(page)
            assert outline(page)[:40] == outline(plain.with_suffix(".html").read_text())[:40]
        json.loads(program.with_suffix(".json").read_text())
    assert {f.name for f in tmp_path.iterdir()} == {str(k) for k in range(len(PAYLOADS))}
    assert posted >= 10


@pytest.mark.parametrize("text", PAYLOADS.values(), ids=PAYLOADS)
def test_names_of_files_and_programs(text: str, plain: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """A CL file may be called anything; --name is held to what KRL can call a program."""
    folder = tmp_path / "in"
    folder.mkdir()
    (folder / "setup.toml").write_text("part_in_base = [0, 0, 200, 0, 0, 0]\n")
    cl = folder / "good.cls"
    cl.write_text(with_text("A", "none"))
    out = tmp_path / "out"
    command = ["--cell", str(CELL), "--out", str(out), "--quiet", "--setup", str(folder / "setup.toml")]
    assert cli.run(["post", str(cl), *command, "--name", text]) == 2
    assert capfd.readouterr().err.count("\n") == 1 and not out.exists()
    try:
        named = cl.rename(folder / f"{text.replace('/', '_').replace(chr(0), '_')[:120]}.cls")
    except (OSError, ValueError):
        pytest.skip("no file system takes this name")
    status = cli.run(["post", str(named), *command])
    shown = capfd.readouterr()
    assert status in (0, 2) and "Traceback" not in shown.err and shown.err.count("\n") <= 1
    assert sorted(f.name for f in tmp_path.iterdir()) in (["in"], ["in", "out"])
    for program in out.glob("*.src"):
        does_the_same(program, plain) if program.stem == "part" else None
        assert program.resolve().parent == out.resolve() and re.fullmatch(r"\w+", program.stem, re.ASCII)
        inert(program.with_suffix(".html").read_text())
        renamed = program.read_text().replace(f"DEF {program.stem} ", "DEF part ")
        assert [li for li in renamed.splitlines() if not li.startswith(";")] == other_lines(plain)


STRINGS = {
    "cell title": ("cell.toml", re.compile(r'^title = ".*"$', re.M), "title = {}"),
    "cell name": ("cell.toml", re.compile(r'^name = "kr15_track_table"$', re.M), "name = {}"),
    "axis name": ("cell.toml", re.compile(r'^name = "E2"$', re.M), "name = {}"),
    "orientation": ("cell.toml", re.compile(r'^ori_type = ".*"$', re.M), "ori_type = {}"),
    "base template": ("cell.toml", re.compile(r"^base_template = .*$", re.M), "base_template = {}"),
    "a hook": ("cell.toml", re.compile(r"^coolant_on = .*$", re.M), "coolant_on = [{}]"),
    "engine file": ("cell.toml", re.compile(r'^file = "weights_jnt.fis"$', re.M), "file = {}"),
    "tool name": ("setup.toml", re.compile(r'^name = "T"$', re.M), "name = {}"),
    "stock mesh": ("setup.toml", re.compile(r'^mesh = "s.stl"$', re.M), "mesh = {}"),
}


@pytest.mark.slow(after=3)
@pytest.mark.parametrize("place", STRINGS)
def test_strings_of_a_cell_and_a_set_up(
    plain: Path, tmp_path: Path, place: str, capfd: pytest.CaptureFixture[str]
) -> None:
    """Posted with the same motions, or refused in one line. (A hook's line is the cell owner's own KRL, one line long.)"""
    file, pattern, line = STRINGS[place]
    for number, (name, text) in enumerate(PAYLOADS.items()):
        if "\ud800" in text:
            continue  # no TOML
        report = [] if name in ACTIVE else ["--no-report"]
        folder = tmp_path / str(number)
        cell = Path(shutil.copytree(CELL, folder / "cell", ignore=shutil.ignore_patterns("*.stl", "*.md")))
        (folder / "part.cls").write_text(with_text("A", "none"))
        setup = 'part_in_base = [0, 0, 200, 0, 0, 0]\n[tool]\nname = "T"\ndiameter_mm = 10\nlength_mm = 50\n'
        if place == "stock mesh":
            setup += '[stock]\nmesh = "s.stl"\n'
        (folder / "setup.toml").write_text(setup)
        target = cell / file if file == "cell.toml" else folder / file
        before = target.read_text()
        changed = pattern.sub(lambda m, text=text: line.format(json.dumps(text)), before, count=1)
        assert changed != before
        target.write_text(changed)
        out = folder / "out"
        status = cli.run(["post", str(folder / "part.cls"), "--cell", str(cell), "--out", str(out), "--quiet", *report])
        shown = capfd.readouterr()
        assert status in (0, 2, 3) and "Traceback" not in shown.err and "internal error" not in shown.err, shown.err
        assert shown.err.count("\n") == (status != 0) and shown.err.replace("\n", "").isprintable()
        assert {f.name for f in folder.iterdir()} - {"out"} == {"cell", "part.cls", "setup.toml"}
        if status == 0:
            if not report:
                inert((out / "part.html").read_text())
            if place not in ("a hook", "axis name"):
                does_the_same(out / "part.src", plain)
        else:
            assert not out.exists()


def test_arrays_are_read_without_pickle(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """A .path.npz that holds a pickled object is refused, not run."""

    class Evil:
        def __reduce__(self) -> tuple[object, tuple[str]]:
            return (Path.touch, (tmp_path / "owned",))  # type: ignore[return-value]

    evil = tmp_path / "evil.path.npz"
    np.savez(evil, q=np.array([Evil()], dtype=object), axes=np.array(["E2"]))
    assert cli.run(["feed", "--cell", str(CELL), "--out", str(tmp_path / "out"), "--solution", str(evil)]) == 2
    shown = capfd.readouterr()
    assert shown.err.count("\n") == 1 and "evil.path.npz" in shown.err
    assert not (tmp_path / "owned").exists() and not (tmp_path / "out").exists()
