"""Branches and loops of RAPID whose course the program itself says."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from camrob.errors import ProgramError
from camrob.languages.rapid.reader.data import Data
from camrob.languages.rapid.reader.expressions import UnknownError, Value, number
from camrob.languages.rapid.reader.module import Node
from camrob.languages.rapid.reader.tokens import Statement, Token

__all__ = ["BLOCKS", "parts_of", "run_block"]

BLOCKS = {"IF": "ENDIF", "FOR": "ENDFOR", "WHILE": "ENDWHILE", "TEST": "ENDTEST"}
"""By the word that begins it: what ends it."""

_Part = tuple[Statement, Sequence[Node]]
_PARTS = ("ELSEIF", "ELSE", "CASE", "DEFAULT")


def parts_of(nodes: Sequence[Node], at: int) -> tuple[list[_Part], int]:
    """The parts of the block that begins at `at`, each with its head, and the place behind it; none of one without an end, and of
    IF with one statement behind it, whose condition nothing ends.
    """
    if not _opens(nodes[at]):
        return [], at + 1
    parts: list[_Part] = []
    open_ = list[str]()
    begun = at
    for k in range(at, len(nodes)):
        node = nodes[k]
        word = node.word if isinstance(node, Statement) else ""
        if _opens(node):
            open_.append(BLOCKS[word])
        elif word in BLOCKS.values() and (not open_ or open_.pop() != word):
            return [], len(nodes)
        if not open_ or (len(open_) == 1 and k > at and word in _PARTS):
            head = nodes[begun]
            if isinstance(head, Statement):
                parts.append((head, nodes[begun + 1 : k]))
            begun = k
        if not open_:
            return parts, k + 1
    return [], len(nodes)


def _opens(node: Node) -> bool:
    """Whether a statement begins a block: IF without THEN begins none."""
    if not isinstance(node, Statement) or node.word not in BLOCKS:
        return False
    return node.word == "TEST" or node.tokens[-1].text in ("THEN", "DO")


def run_block(
    head: Statement,
    parts: Sequence[_Part],
    data: Data,
    run: Callable[[Sequence[Node]], None],
    passed: Callable[[], None],
) -> None:
    """Runs what the program says of a block. Raises UnknownError where it doesn't say it, which may be in a later pass."""
    if head.word == "IF":
        run(next((nodes for part, nodes in parts if part.word == "ELSE" or _truth(part.tokens[1:-1], data)), ()))
    elif head.word == "TEST":
        run(_chosen(head, parts[1:], data))
    elif head.word == "WHILE":
        _while(head, parts[0][1], data, run, passed)
    else:
        _count(head, parts[0][1], data, run, passed)


def _while(
    head: Statement,
    nodes: Sequence[Node],
    data: Data,
    run: Callable[[Sequence[Node]], None],
    passed: Callable[[], None],
) -> None:
    """WHILE. Raises ProgramError for one that never ends, as one or two rounds of it leave all data as they found them."""
    passes, kept, before = 0, 0, ""
    while _truth(head.tokens[1:-1], data):
        passed()
        passes += 1
        if passes <= kept + 2 and data.shown() == before:
            raise ProgramError("WHILE never ends", hint="post what one round of it does", line=head.line)
        if not passes & (passes - 1):  # 1, 2, 4, 8, ..: looking at all data takes its time
            kept, before = passes, data.shown()
        run(nodes)


def _truth(tokens: Sequence[Token], data: Data) -> bool:
    value = data.value(tokens)
    if not isinstance(value, bool):
        raise UnknownError("neither TRUE nor FALSE")
    return value


def _chosen(head: Statement, parts: Sequence[_Part], data: Data) -> Sequence[Node]:
    """What TEST runs."""
    tested = head.tokens[1:]
    for part, nodes in parts:
        if part.word == "DEFAULT":
            return nodes
        for tokens in _apart(part.tokens[1:-1], ","):
            both = (Token("sign", "("), *tested, Token("sign", ")"), Token("sign", "="), *tokens)
            if _truth(both, data):
                return nodes
    return ()


def _apart(tokens: Sequence[Token], mark: str) -> list[Sequence[Token]]:
    """Tokens between marks that stand in no bracket."""
    out, depth = [list[Token]()], 0
    for token in tokens:
        depth += (token.text in "([{") - (token.text in ")]}") if token.kind == "sign" else 0
        if token.text == mark and not depth:
            out.append([])
        else:
            out[-1].append(token)
    return list(out)


def _count(
    head: Statement,
    nodes: Sequence[Node],
    data: Data,
    run: Callable[[Sequence[Node]], None],
    passed: Callable[[], None],
) -> None:
    """FOR name FROM a TO b [STEP c] DO: the counter is known within it alone; without STEP it goes down where a is above b."""
    words = {t.text: k for k, t in enumerate(head.tokens) if t.kind == "name" and t.text in ("FROM", "TO", "STEP")}
    if not {"FROM", "TO"} <= set(words) or words["FROM"] != 2 or data.own is None:
        raise UnknownError("no FOR")
    end = words.get("STEP", len(head.tokens) - 1)
    first, last = (_whole(data.value(head.tokens[a:b])) for a, b in ((3, words["TO"]), (words["TO"] + 1, end)))
    given = head.tokens[words["STEP"] + 1 : -1] if "STEP" in words else None
    step = _whole(data.value(given)) if given is not None else 1 if first <= last else -1
    if step == 0:
        raise UnknownError("a step of 0")
    name, own = head.tokens[1].text, data.own
    kept = own.get(name)
    for value in range(first, last + (1 if step > 0 else -1), step):
        passed()
        own[name] = ("NUM", float(value))
        data.changes += 1
        run(nodes)
        if own.get(name) != ("NUM", float(value)):
            raise UnknownError("a counter that is set within its loop")
    own.pop(name, None)
    if kept is not None:
        own[name] = kept
    data.changes += 1


def _whole(value: Value) -> int:
    given = number(value)
    if given != int(given):
        raise UnknownError(f"a count of {given:g}")
    return int(given)
