# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Printable form of foreign text, such as topic and frame names, for terminals and logs."""

from __future__ import annotations


def printable(text: str) -> str:
    r"""
    Return a text with control characters escaped, as ``\x1b``; line breaks stay.

    Unescaped, they can move a terminal's cursor, hide lines or change its title.
    """
    if text.isprintable():
        return text
    return ''.join(c if c.isprintable() or c == '\n' else _written_out(c) for c in text)


def _written_out(character: str) -> str:
    return character.encode('unicode_escape').decode()
