# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Texts that others wrote, as names of topics and frames, fit for a terminal or a log."""

from __future__ import annotations


def printable(text: str) -> str:
    r"""
    Return a text whose control characters are written out, as ``\x1b``; line breaks stay.

    Raw ones move a terminal's cursor, hide lines or change its title.
    """
    if text.isprintable():
        return text
    return ''.join(c if c.isprintable() or c == '\n' else _written_out(c) for c in text)


def _written_out(character: str) -> str:
    return character.encode('unicode_escape').decode()
