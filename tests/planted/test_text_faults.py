"""`verify` against faults in program text and legal rewrites: a fixed part of tests/bench/text_faults.py."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bench"))

from text_faults.change import differences
from text_faults.deeds import OpaqueError
from text_faults.jobs import Posted, post_all
from text_faults.report import summary
from text_faults.run import Case, Outcome, judged, one_of_each, trees
from text_faults.tree import Tree

JOBS = ["arcs", "tools", "tilted", "split"]


@pytest.fixture(scope="module")
def posted(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Posted]:
    return post_all(tmp_path_factory.mktemp("text_faults"), JOBS)


@pytest.fixture(scope="module")
def drawn(posted: dict[str, Posted]) -> list[Case]:
    return one_of_each(posted)


def _run(drawn: list[Case], verdict: str, posted: dict[str, Posted], folder: Path) -> Iterator[Outcome]:
    for case in drawn:
        if case.verdict == verdict:
            yield judged(case, posted[case.job], folder / "case")


def test_what_was_posted_passes_and_reads_back_as_it_was(posted: dict[str, Posted], tmp_path: Path) -> None:
    for name, tree in trees(posted).items():
        assert tree.texts() == posted[name].files
        case = Case(name, name, "", "legal", (), tree.texts(), tree.main, "")
        assert judged(case, posted[name], tmp_path / name).answer == "pass"


@pytest.mark.slow
def test_no_fault_passes(drawn: list[Case], posted: dict[str, Posted], tmp_path: Path) -> None:
    outcomes = list(_run(drawn, "wrong", posted, tmp_path))
    assert len(outcomes) > 120
    assert not [o.key for o in outcomes if o.bad], summary(outcomes)


@pytest.mark.slow
def test_every_legal_rewrite_passes(drawn: list[Case], posted: dict[str, Posted], tmp_path: Path) -> None:
    outcomes = list(_run(drawn, "legal", posted, tmp_path))
    assert len(outcomes) > 60
    assert not [o.key for o in outcomes if o.bad], summary(outcomes)


def test_legal_rewrites_do_the_same_for_the_benchs_own_interpreter(drawn: list[Case]) -> None:
    """Else the bench would call something legal that is not."""
    followed = [c for c in drawn if c.verdict == "legal" and "opaque" not in c.differs]
    assert len(followed) > 30
    assert {
        c.key: set(c.differs) - {"settings", "posture"} for c in followed if set(c.differs) - {"settings", "posture"}
    } == {}


@pytest.mark.parametrize(
    ("old", "new", "differs"),
    [
        ("Z 200.000,A -138.8124", "Z 200.015,A -138.8124", {"path"}),
        ("Z 200.000,A -138.8124", "Z 200.005,A -138.8124", set()),
        ("$VEL.CP = 0.005000", "$VEL.CP = 0.005100", {"feed"}),
        ("WAIT SEC 0.800", "WAIT SEC 0.900", {"events"}),
        ("$OUT[2] = TRUE", ";$OUT[2] = TRUE", {"events"}),
        ("E1 65.0248,E2 -5.5125} C_DIS", "E1 66.0248,E2 -5.5125} C_DIS", {"posture"}),
        ("E1 65.0248,E2 -5.5125} C_DIS", "E1 1600.0,E2 -5.5125} C_DIS", {"posture", "limits"}),
    ],
)
def test_what_counts_as_a_fault(posted: dict[str, Posted], old: str, new: str, differs: set[str]) -> None:
    tree = trees(posted)["arcs"]
    texts = {name: text.replace(old, new, 1) for name, text in posted["arcs"].files.items()}
    assert any(text != posted["arcs"].files[name] for name, text in texts.items())
    assert differences(tree, Tree.of(tree.main, texts)) == differs


def test_what_the_benchs_interpreter_cannot_follow_it_does_not_judge(posted: dict[str, Posted]) -> None:
    tree = trees(posted)["arcs"]
    with pytest.raises(OpaqueError):
        differences(tree, tree.before(tree.lines_of_end(tree.main), "BRAKE"))
