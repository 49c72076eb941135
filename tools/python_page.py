# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Generate the reference in docs/python.md from the docstrings of ``fpnet``.

Run: python tools/python_page.py [--write]
"""

import argparse
import inspect
from pathlib import Path
import re

import fpnet

PAGE = Path(__file__).resolve().parents[1] / 'docs' / 'python.md'
SECTION = re.compile(r'(<!-- interface -->\n).*?(<!-- end -->)', re.DOTALL)
OWN = 'fpnet.api'


def main() -> None:
    """Print the reference, or write it into the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--write', action='store_true')
    if parser.parse_args().write:
        PAGE.write_text(with_reference(PAGE.read_text(encoding='utf-8')), encoding='utf-8')
    else:
        print(reference())


def with_reference(page: str) -> str:
    """Return the page with its reference regenerated."""
    return SECTION.sub(lambda match: f'{match[1]}\n{reference()}\n{match[2]}', page)


def reference() -> str:
    """Return one section per public name, functions first."""
    offered = [getattr(fpnet, name) for name in fpnet.__all__]
    functions = [each for each in offered if inspect.isfunction(each)]
    classes = [each for each in offered if inspect.isclass(each)]
    return '\n'.join([*map(of_function, functions), *map(of_class, classes)])


def of_function(function) -> str:
    """Return a function's signature and docstring."""
    return f'### `{function.__name__}`\n\n{code(signature(function))}\n{text(function)}\n'


def of_class(cls) -> str:
    """Return a class's docstring and, for classes of our API, its public members."""
    said = f'### `{cls.__name__}`\n\n{text(cls)}\n'
    if not cls.__module__.startswith(OWN):
        return said
    rows = [
        f'- `{name}`: {first_line(member)}'
        for name, member in vars(cls).items()
        if not name.startswith('_') and getattr(member, '__doc__', None)
    ]
    return '\n'.join([said, *rows, '']) if rows else said


def signature(function) -> str:
    """Return a function's name and parameters, one per line if they do not fit on one."""
    own = inspect.signature(function)
    parameters = [str(each).replace("'", '') for each in own.parameters.values()]
    returned = str(own.return_annotation).strip("'")
    line = f'{function.__name__}({", ".join(parameters)}) -> {returned}'
    if len(line) <= 100:
        return line
    named = [each.kind is each.KEYWORD_ONLY for each in own.parameters.values()]
    if any(named):
        parameters.insert(named.index(True), '*')
    inner = ''.join(f'    {each},\n' for each in parameters)
    return f'{function.__name__}(\n{inner}) -> {returned}'


def code(lines: str) -> str:
    """Return lines as a Python code block."""
    return f'```python\n{lines}\n```\n'


def text(member) -> str:
    """Return a docstring as Markdown: sections in bold, parameters as lists."""
    lines = re.sub(r'\n(\w+)\n-+\n', r'\n**\1**\n\n', inspect.getdoc(member) or '')
    lines = re.sub(r':(?:func|class):`(?:[\w.]+\.)?(\w+)`', r'`\1`', lines).replace('``', '`')
    lines = re.sub(r'^(\w+Error)\n {4}', r'\1 : ', lines, flags=re.MULTILINE)
    return re.sub(r'^([\w, ]+) : (.*(?:\n {4}.*)*)', as_item, lines, flags=re.MULTILINE)


def as_item(match) -> str:
    """Return a docstring's parameter as a list item."""
    names = ', '.join(f'`{name.strip()}`' for name in match[1].split(','))
    return f'- {names}: {" ".join(match[2].split())}'


def first_line(member) -> str:
    """Return the first line of a member's docstring."""
    function = member.func if hasattr(member, 'func') else member
    return (inspect.getdoc(function) or '').partition('\n')[0].replace('``', '`')


if __name__ == '__main__':
    main()
