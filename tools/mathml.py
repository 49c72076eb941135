# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
MkDocs hook: formulas of the pages as MathML, which browsers since 2023 draw without a script.

Pages write ``$...$`` and ``$$...$$``, as forges show them too; ``pymdownx.arithmatex`` marks them.
"""

from html import unescape
import re
from typing import Any

from latex2mathml.converter import convert

FORMULA = re.compile(
    r'<(?:div|span) class="arithmatex">\\([\[(])(.*?)\\[\])]</(?:div|span)>', re.DOTALL
)


def on_page_content(html: str, **_: Any) -> str:
    """Return the HTML of a page with its formulas as MathML."""
    return FORMULA.sub(_mathml, html)


def _mathml(found: re.Match[str]) -> str:
    formula = unescape(found[2]).strip()
    if found[1] == '(':
        return convert(formula)
    # Wide formulas scroll on a phone, by keyboard too.
    return f'<div class="formula" tabindex="0">{convert(formula, display="block")}</div>'
