# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Commands that the documents tell people to type."""

from pathlib import Path
import re
import shlex

ROOT = Path(__file__).resolve().parents[1]

_BLOCK = re.compile(r'^```bash\n(.*?)^```', re.DOTALL | re.MULTILINE)


def commands(document: str) -> list[str]:
    """
    Return the commands in the bash blocks of a document, in their order.

    Comments are cut off, continued lines joined, ``a && b`` taken apart, and ``fpnet bench a|b``
    is two commands.
    """
    text = (ROOT / document).read_text(encoding='utf-8')
    found: list[str] = []
    for block in _BLOCK.findall(text):
        for line in block.replace('\\\n', ' ').splitlines():
            joined = ' '.join(shlex.split(line, comments=True))
            found += [choice for part in joined.split(' && ') for choice in _choices(part)]
    return [command for command in found if command]


def _choices(command: str) -> list[str]:
    head, _, last = command.rpartition(' ')
    return [f'{head} {choice}'.strip() for choice in last.split('|')]
