# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Count the numeric module constants by their stated kind.

Usage::

    python tools/constants.py            # a table: kinds by package
    python tools/constants.py fitted     # those of one kind; `unsaid`: those without a kind
    python tools/constants.py --write    # the table into notes/constants.md

A constant states its kind at the beginning of a clause of its comment or docstring, for example
``# of the page; chosen``, or is in one paragraph with a comment above that ends in a colon, for
example ``# Chosen, not measured:``.
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import takewhile
from pathlib import Path
import re
import sys

from fpnet_lab.evaluation.published.figures import pages as pages_of
from fpnet_lab.evaluation.published.figures import write_figures
from fpnet_lab.provenance import Provenance
from fpnet_lab.scores import Table

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ('fpnet_core', 'fpnet_ros', 'msg_adapters', 'fpnet', 'fpnet_lab')

KINDS = {
    'physical': 'of buildings, robots, sensors, paper; says which',
    'given': 'by a file format, a message, a library or a paper; codes and versions of our own',
    'numerical': 'of the computation: steps, tolerances, sample sizes, limits of memory and time',
    'fitted': 'to data; says to which, and the page or command that tells how',
    'chosen': 'by judgement; nobody measured that another value is worse',
}
UNSAID = 'unsaid'

_KIND = re.compile(rf'(?:^|[;:.,(]\s+|\()({"|".join(KINDS)})\b', re.IGNORECASE)
_HEADING = re.compile(rf'#\s*({"|".join(KINDS)})\b', re.IGNORECASE)
# Calls whose numbers are shapes, loop steps or array columns, and not quantities.
_GEOMETRY = {'slice', 'range', 'ones', 'zeros', 'empty', 'eye', 'full', 'ix_', 'arange', 'compile'}


@dataclass(frozen=True)
class Constant:
    """Name, location, comment text and kind of a numeric constant."""

    path: Path
    line: int
    name: str
    text: str
    kind: str


def constants(package: str) -> Iterator[Constant]:
    """Yield the numeric module constants of a package."""
    for path in sorted((ROOT / package).rglob('*.py')):
        yield from module_constants(path)


def module_constants(path: Path, root: Path = ROOT) -> Iterator[Constant]:
    """Yield the constants of one module, one for each name."""
    source = path.read_text(encoding='utf-8')
    lines = source.splitlines()
    body = ast.parse(source).body
    for index, statement in enumerate(body):
        names = list(_names(statement))
        if names:
            text, kind = _text_and_kind(body, index, lines)
        for name in names:
            yield Constant(path.relative_to(root), statement.lineno, name, text, kind)


def _names(statement: ast.stmt) -> Iterator[str]:
    """Yield the names that a statement assigns numbers to."""
    if not isinstance(statement, ast.Assign | ast.AnnAssign) or statement.value is None:
        return
    target = statement.targets[0] if isinstance(statement, ast.Assign) else statement.target
    pairs = [(target, statement.value)]
    if isinstance(target, ast.Tuple) and isinstance(statement.value, ast.Tuple):
        pairs = list(zip(target.elts, statement.value.elts, strict=True))
    for bound, value in pairs:
        if any(_numbers(value)):
            yield from (node.id for node in ast.walk(bound) if isinstance(node, ast.Name))


def _numbers(node: ast.expr) -> Iterator[ast.Constant]:
    """Yield the quantities in an expression; keys of dicts are not counted."""
    if isinstance(node, ast.Call) and ast.unparse(node.func).rpartition('.')[2] in _GEOMETRY:
        return
    if isinstance(node, ast.Subscript | ast.JoinedStr | ast.Compare | ast.ListComp | ast.Lambda):
        return
    if isinstance(node, ast.Constant):
        if isinstance(node.value, int | float) and not isinstance(node.value, bool):
            yield node
        return
    inner = node.values if isinstance(node, ast.Dict) else ast.iter_child_nodes(node)
    for child in inner:
        if isinstance(child, ast.expr):
            yield from _numbers(child)
        elif isinstance(child, ast.keyword):
            yield from _numbers(child.value)


def _text_and_kind(body: list[ast.stmt], index: int, lines: list[str]) -> tuple[str, str]:
    """Return comment text and kind of a constant, from comment, docstring or heading."""
    statement = body[index]
    beside = ' '.join(f'{_above(statement, lines)} {_beside(statement, lines)}'.split())
    docstring = ' '.join(_docstring(body, index, beside).split())
    text = f'{beside} {docstring}'.strip()
    for words in (beside, docstring):
        if found := _KIND.search(words):
            return text, found.group(1).lower()
    return text, _heading(statement, lines)


def _above(statement: ast.stmt, lines: list[str]) -> str:
    """Return the comment directly above, without its heading."""
    end = statement.lineno - 1
    first = end
    while first and lines[first - 1].startswith('#'):
        first -= 1
    first += _heading_length(lines[first:end])
    return ' '.join(line.lstrip('# ') for line in lines[first:end])


def _heading_length(comment: list[str]) -> int:
    """Return the number of heading lines of a comment: from a kind to a colon at a line's end."""
    if not comment or not _HEADING.match(comment[0]):
        return 0
    return next((i for i, line in enumerate(comment, 1) if line.endswith(':')), 0)


def _beside(statement: ast.stmt, lines: list[str]) -> str:
    spanned = lines[statement.lineno - 1 : statement.end_lineno]
    return ' '.join(
        line.partition('  # ')[2].replace('fmt: skip', '').lstrip(' #') for line in spanned
    )


def _docstring(body: list[ast.stmt], index: int, beside: str) -> str:
    """Return the docstring after a constant, or after a group of constants without comments."""
    for statement, following in zip(body[index:], body[index + 1 :], strict=False):
        if following.lineno != (statement.end_lineno or 0) + 1:
            break
        if isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant):
            return str(following.value.value)
        if beside:
            break
    return ''


def _heading(statement: ast.stmt, lines: list[str]) -> str:
    """Return the kind of the last heading in the paragraph above a statement."""
    end = statement.lineno - 1
    for first in range(end - 1, -1, -1):
        if not lines[first].strip():
            break
        comment = list(takewhile(lambda line: line.startswith('#'), lines[first:end]))
        if _heading_length(comment) and (found := _HEADING.match(lines[first])):
            return found.group(1).lower()
    return UNSAID


def table() -> str:
    """Return the number of constants by kind and package as a Markdown table."""
    counts = {package: Counter(c.kind for c in constants(package)) for package in PACKAGES}
    kinds = [*KINDS, *([UNSAID] if any(UNSAID in count for count in counts.values()) else [])]
    header = ['constants', *(f'`{package}`' for package in PACKAGES), 'all']
    rows = []
    for kind in kinds:
        row = [counts[package][kind] for package in PACKAGES]
        title = f'{kind}: {KINDS[kind]}' if kind in KINDS else kind
        rows.append([title, *map(str, row), str(sum(row))])
    return Table(header, rows).markdown()


def write() -> None:
    """Write the table into the pages that contain it."""
    made = replace(Provenance.now(), command='python tools/constants.py')
    for page in write_figures(pages_of(ROOT), {'constants': f'{made}:\n\n{table()}\n\n'}):
        print(f'wrote {page}')


def main() -> None:
    """Print the table, or the constants of the kind given on the command line."""
    if len(sys.argv) == 1:
        print(table())
        return
    if sys.argv[1] == '--write':
        write()
        return
    for package in PACKAGES:
        for constant in constants(package):
            if constant.kind == sys.argv[1]:
                print(f'{constant.path}:{constant.line} {constant.name}  {constant.text}')


if __name__ == '__main__':
    main()
