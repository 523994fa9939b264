"""A hundred thousand hostile inputs a reader: `python tests/bench/fuzz.py --reader cl --inputs 100000 --corpus DIR`.

Coverage-guided by atheris where it is installed (`pip install atheris`), over the modules of camrob that hold no compiled
kernels; half of the inputs come from libFuzzer's own mutations, half from ours, which know numbers, words and lines. The corpus
folder keeps what found new paths: a second run goes on from there. Without atheris, our mutations alone. Laws are those of
fuzz_readers.fire: no error but a CamrobError of one printable line that names the file, 2 s of processor time, 1 GiB. `--reader
post` posts small CL files and holds what is released to `verify --against`. What breaks a law goes to CORPUS/findings, one file a
kind, and the exit status is 1.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import io
import json
import os
import random
import re
import shutil
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]
MEMORY_FOLDER = Path("/dev/shm")
SHARED = {"cl": "cldata", "gcode": "gcode", "krl": "krl", "post": "cldata"}
LONGEST_INPUT = 8192
QUICK = 2.0  # s of processor time that an input may take
SLOW_SEED = 0.05  # s; samples that take longer are tried, but nothing is made from them

__all__ = ["main"]


class Tally:
    """What a run met."""

    def __init__(self, reader: str, corpus: Path, wanted: int) -> None:
        self.reader, self.corpus, self.wanted = reader, corpus, wanted
        self.inputs = self.refused = 0
        self.worst = 0.0
        self.kinds: dict[str, int] = {}
        self.started, self.cpu, self.told = time.monotonic(), time.process_time(), time.monotonic()

    def run(self, fire: Callable[[bytes], str], data: bytes) -> None:
        """One input."""
        from fuzz_readers import FlawError

        start = time.process_time()
        try:
            self.refused += bool(fire(data))
        except FlawError as flaw:
            self.found(flaw, data)
        self.worst = max(self.worst, time.process_time() - start)
        self.inputs += 1
        if time.monotonic() - self.told > 30.0:
            self.told = time.monotonic()
            print(self.line(), file=sys.stderr, flush=True)

    def found(self, flaw: Exception, data: bytes) -> None:
        """Keep the first input of each kind of flaw."""
        cause = flaw.__cause__
        frames = traceback.extract_tb(cause.__traceback__) if cause is not None else []
        own = [f"{Path(f.filename).name}:{f.lineno}" for f in frames if "/camrob/" in f.filename]
        kind = f"{type(cause).__name__} {own[-1]}" if own else re.sub(r"\d+|'.*", "", str(flaw))[:60]
        self.kinds[kind] = self.kinds.get(kind, 0) + 1
        if self.kinds[kind] == 1:
            folder = self.corpus / "findings"
            folder.mkdir(exist_ok=True)
            (folder / hashlib.sha256(data).hexdigest()[:16]).write_bytes(data)
            print(f"{self.reader}: {kind}: {str(flaw)[:300]}", file=sys.stderr, flush=True)

    def line(self) -> str:
        """The figures."""
        from fuzz_readers import peak_memory

        seconds = max(time.monotonic() - self.started, 1e-9)
        cpu = max(time.process_time() - self.cpu, 1e-9)
        return (
            f"{self.reader}: {self.inputs} inputs of {self.wanted}, {self.refused} refused, {sum(self.kinds.values())} flaws of "
            f"{len(self.kinds)} kinds; {seconds:.0f} s, {cpu:.0f} s of processor, {self.inputs / cpu:.0f} a second; worst "
            f"{self.worst:.3f} s, peak memory {peak_memory() >> 20} MiB"
        )


def compiled() -> list[str]:
    """Modules of camrob that hold compiled kernels, which bear no instruments."""
    files = sorted((ROOT / "camrob").rglob("*.py"))
    return [
        ".".join(f.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        for f in files
        if "numba" in f.read_text(encoding="utf-8")
    ]


def seeds_of(reader: str) -> list[bytes]:
    """Our samples, the findings of before, and the corpus of shared where it is there."""
    from fuzz_readers import FINDINGS, READERS

    own = READERS["cl" if reader == "post" else reader].seeds()
    own += [p.read_bytes() for p in sorted((FINDINGS / reader).glob("*"))]
    folder = ROOT.parent / "shared" / "corpus" / SHARED.get(reader, "none")
    suffixes = (".src",) if reader == "krl" else ()
    for file in sorted(folder.rglob("*")) if folder.is_dir() else ():
        if file.is_file() and (not suffixes or file.suffix in suffixes):
            own.append(b"\n".join(file.read_bytes()[: LONGEST_INPUT // 2].split(b"\n")[:-1]))
    return own


def fuzz(
    reader: str, tally: Tally, fire: Callable[[bytes], str], seed: int, finish: Callable[[], None], *, plain: bool
) -> None:
    """All inputs: by atheris, or by our mutations alone; then `finish`, for libFuzzer does not come back."""
    from fuzz_mutations import mutated

    seeds = seeds_of(reader)
    slow = set()
    for data in seeds:
        start = time.process_time()
        tally.run(fire, data)
        if time.process_time() - start > SLOW_SEED:
            slow.add(data)
    seeds = [data for data in seeds if data not in slow]
    try:
        if plain:
            raise ImportError
        import atheris
    except ImportError:
        rng = random.Random(seed + tally.inputs)
        while tally.inputs < tally.wanted:
            tally.run(fire, mutated(rng.choice(seeds), rng, seeds))
        finish()

    def one(data: bytes) -> None:
        tally.run(fire, data)
        if tally.inputs >= tally.wanted:
            finish()

    def mutate(data: bytes, size: int, number: int) -> bytes:
        rng = random.Random(number)
        if rng.random() < 0.5:
            return bytes(atheris.Mutate(data, size))
        start = data if rng.random() < 0.7 else rng.choice(seeds)
        return mutated(start, rng, seeds, size)

    folder = tally.corpus / "corpus"
    folder.mkdir(exist_ok=True)
    for data in seeds:
        (folder / hashlib.sha256(data).hexdigest()[:16]).write_bytes(data)
    options = [
        f"-seed={seed}",
        f"-max_len={LONGEST_INPUT}",
        "-len_control=0",
        "-timeout=300",
        "-rss_limit_mb=0",
        "-verbosity=0",
        "-print_final_stats=0",
        f"-artifact_prefix={tally.corpus}/",
    ]
    atheris.Setup([sys.argv[0], *options, str(folder)], one, custom_mutator=mutate)
    atheris.Fuzz()


def post_and_verify(folder: Path) -> Callable[[bytes], str]:
    """Post a CL file; a refusal's line, or "" where the program was released and `verify` finds nothing
    against it (what its reader of the file has left out, it leaves open). Raises FlawError."""
    from fuzz_readers import CELL, FlawError, check_message, guarded

    from camrob import post
    from camrob.errors import CamrobError
    from camrob.jobs.verify import verify

    (folder / "setup.toml").write_text("part_in_base = [0, 0, 200, 0, 0, 0]\n")
    cl, out = folder / "part.cls", folder / "out"

    def fire(data: bytes) -> str:
        shutil.rmtree(out, ignore_errors=True)
        cl.write_bytes(data)
        try:
            with guarded(60.0):
                post(cl, cell=CELL, out=out, report=False)
        except CamrobError as error:
            if out.exists():
                raise FlawError("something is left of a refused post") from error
            check_message(str(error), ())
            return str(error)
        except FlawError:
            raise
        except Exception as error:
            raise FlawError(f"{type(error).__name__}: {str(error)[:300]}") from error
        try:
            found = verify(out / "part.src", cell=CELL, against=cl)
        except Exception as error:
            raise FlawError(f"verify: {type(error).__name__}: {str(error)[:300]}") from error
        if found.ok is False or (found.ok is None and found.summary.errors):
            raise FlawError(f"released, and refused by verify: {json.dumps(found.summary.to_json()['errors'])[:300]}")
        return ""

    return fire


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--reader", required=True, help="cl, gcode, krl, cell, fis, setup, log, ..., or post")
    parser.add_argument("--inputs", type=int, default=100_000)
    parser.add_argument("--corpus", type=Path, help="a folder that is kept (default: a new one)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--plain", action="store_true", help="our mutations alone, at twice the speed")
    args = parser.parse_args()
    corpus = args.corpus or Path(tempfile.mkdtemp(prefix="camrob-fuzz-"))
    corpus.mkdir(parents=True, exist_ok=True)
    with contextlib.suppress(ImportError):
        if args.plain:
            raise ImportError
        import atheris

        with (
            atheris.instrument_imports(include=["camrob"], exclude=compiled()),
            contextlib.redirect_stderr(io.StringIO()),
        ):
            import fuzz_readers

            if args.reader == "post":
                import camrob.jobs.post  # noqa: F401
    import fuzz_readers

    if args.reader != "post" and args.reader not in fuzz_readers.READERS:
        parser.error(f"--reader is one of post, {', '.join(fuzz_readers.READERS)}")
    folder = Path(tempfile.mkdtemp(dir=MEMORY_FOLDER if MEMORY_FOLDER.is_dir() else None))
    tally = Tally(args.reader, corpus, args.inputs)

    def fire(data: bytes) -> str:
        return fuzz_readers.fire(fuzz_readers.READERS[args.reader], data, folder, seconds=QUICK)

    def finish() -> None:
        shutil.rmtree(folder, ignore_errors=True)
        print(tally.line())
        for kind, count in tally.kinds.items():
            print(f"  {kind}: {count}")
        sys.stdout.flush()
        os._exit(1 if tally.kinds else 0)

    fuzz(
        args.reader,
        tally,
        post_and_verify(folder) if args.reader == "post" else fire,
        args.seed,
        finish,
        plain=args.plain,
    )


if __name__ == "__main__":
    main()
