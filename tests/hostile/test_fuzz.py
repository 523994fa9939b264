"""Readers under fire, for seconds; bench/fuzz.py does the same for a hundred thousand inputs a reader."""

from __future__ import annotations

import random
import resource
from pathlib import Path

import numpy as np
import pytest
from fuzz_mutations import HOSTILE_NUMBERS, HOSTILE_TEXTS, mutated
from fuzz_readers import FINDINGS, READERS, FlawError, Reader, check_message, fire, guarded
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from camrob.errors import InputError

FEW = settings(
    max_examples=120,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
names = pytest.mark.parametrize("name", list(READERS))
FOUND = [(reader, file) for reader in READERS for file in sorted((FINDINGS / reader).glob("*"))]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path


@names
def test_our_samples_keep_the_laws(name: str, folder: Path) -> None:
    reader = READERS[name]
    seeds = reader.seeds()
    read = sum(fire(reader, data, folder) == "" for data in seeds)
    assert read, f"of {len(seeds)} samples none is read: there is nothing to mutate"


@pytest.mark.parametrize(("name", "file"), FOUND, ids=[f"{r}-{f.name}" for r, f in FOUND])
def test_what_was_found_once(name: str, file: Path, folder: Path) -> None:
    fire(READERS[name], file.read_bytes(), folder)


@names
def test_damage(name: str, folder: Path) -> None:
    """Samples with numbers, words, lines and bytes damaged, by chance that is always the same."""
    reader = READERS[name]
    seeds = reader.seeds()

    @FEW
    @given(number=st.integers(0, 2**32 - 1))
    def run(number: int) -> None:
        rng = random.Random(number)
        fire(reader, mutated(rng.choice(seeds), rng, seeds), folder)

    run()


def statements(words: list[bytes]) -> st.SearchStrategy[bytes]:
    """Lines of a format's own words, with numbers and texts that readers don't like."""
    atom = st.one_of(
        st.sampled_from(words),
        st.sampled_from(HOSTILE_NUMBERS),
        st.sampled_from(HOSTILE_TEXTS),
        st.integers(-999, 999).map(lambda v: b"%d" % v),
        st.binary(max_size=6),
    )
    line = st.lists(atom, max_size=8).flatmap(
        lambda parts: st.sampled_from([b",", b" ", b"", b"="]).map(lambda s: s.join(parts))
    )
    return st.lists(line, max_size=12).map(b"\n".join)


@names
def test_statements_of_our_own_making(name: str, folder: Path) -> None:
    reader = READERS[name]
    words = sorted({word for seed in reader.seeds() for line in seed.split(b"\n") for word in line.split()})[:400]

    @FEW
    @given(head=st.sampled_from(reader.seeds()), body=statements(words), where=st.integers(0, 2))
    def run(head: bytes, body: bytes, where: int) -> None:
        lines = head.split(b"\n")
        at = (0, len(lines) // 2, len(lines))[where]
        fire(reader, b"\n".join([*lines[:at], body, *lines[at:]]), folder)

    run()


# ---- the laws can be broken


def broken(read) -> Reader:
    return Reader("broken", ("x.txt",), read, lambda: [b""])


def endless(path: Path) -> None:
    while True:
        path.stat()


def swallows(path: Path) -> None:
    while True:
        try:
            path.stat()
        except Exception:
            continue


def writes(path: Path) -> None:
    path.with_suffix(".new").touch()


def fails(message: str):
    def read(path: Path) -> None:
        raise InputError(message) if message else KeyError("x")

    return read


@pytest.mark.parametrize(
    ("read", "match"),
    [
        (endless, "more than"),
        (swallows, "more than"),
        (writes, "behind"),
        (fails(""), "KeyError"),
        (fails("no name"), "names no file"),
        (lambda path: np.array([1e308]) * 10, "RuntimeWarning"),
        (lambda path: (_ for _ in ()).throw(RecursionError), "RecursionError"),
    ],
)
def test_the_laws_bite(read, match: str, folder: Path) -> None:
    with pytest.raises(FlawError, match=match):
        fire(broken(read), b"", folder, seconds=0.2)


def test_memory_is_held_to_its_bound() -> None:
    with pytest.raises(FlawError, match="MiB"), guarded(seconds=60.0, memory=64 << 20):
        held = np.ones(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024, np.int8)
        assert held[-1] == 1


@pytest.mark.parametrize("message", ["", "a\nb", "a\x1b[2J", "part.cls " + "x" * 2000, "file missing"])
def test_messages_are_held_to_their_law(message: str) -> None:
    with pytest.raises(FlawError):
        check_message(message, ("part.cls",))


# ---- end to end


WHOLE = (
    b"FEDRAT/300,MMPM\nRAPID\nGOTO/0,0,9\nGOTO/0,0,0\nGOTO/20,0,0\nGOTO/20,10,0\nRAPID\nGOTO/20,10,9\n",
    b"SPINDL/3000,CLW\nFEDRAT/300,MMPM\nRAPID\nGOTO/10,0,9\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10\nGOTO/0,10,0\nRAPID\nGOTO/0,10,9\n",
    b"FEDRAT/300,MMPM\nRAPID\nGOTO/0,0,9,0,0,1\nGOTO/0,0,0\nGOTO/9,0,0,0,0.6,0.8\nDELAY/2\nRAPID\nGOTO/9,0,9\n",
    b"RAPID\nGOTO/0,0,9\nCYCLE/DRILL,25.,300.,MMPM,5.\nGOTO/0,0,0\nCYCLE/OFF\n",
)
"""Of our own and of no other test's, so that a test written elsewhere changes nothing in what is drawn. The last one is slow and
short: its feed's curve was not unique once."""


def test_what_is_released_passes_verify(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """CL files are posted whole, then damaged; each is refused in one line with nothing left, or `verify --against` agrees."""
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1] / "bench"))
    from fuzz import post_and_verify

    post = post_and_verify(folder)
    assert [post(data) for data in WHOLE] == [""] * len(WHOLE)
    rng = random.Random(1)
    released = sum(post(mutated(rng.choice(WHOLE), rng, WHOLE)) == "" for _ in range(20))
    assert released, "of 20 damaged files none was released: the law was tried on refusals alone"
