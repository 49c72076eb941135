# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The documented parameter file of all nodes, ``config/fpnet.yaml``.

Keys of the configuration tree are set to their defaults. What a node takes beside them is in
comments, so that the command line reads the same file, and what nobody sets stays the node's own.
"""

from __future__ import annotations

import sys

from fpnet_core.config_docs import render_section, render_yaml
from fpnet_ros.known_parameters import node_sections

_HEAD = """\
    # What only the nodes take, with defaults. Take the first # and space away from what you set,
    # in a file for the nodes: fpnet localize --config refuses these keys.
"""


def render_parameter_file() -> str:
    """Return the whole file."""
    lines = [
        f'    # {line}'.rstrip()
        for nodes, section in node_sections().items()
        for line in ('', f'## {nodes}', *render_section(section, section(), ''))
    ]
    return render_yaml() + _HEAD + '\n'.join(lines) + '\n'


if __name__ == '__main__':
    sys.stdout.write(render_parameter_file())
