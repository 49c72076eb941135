# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Generator of the documented parameter file of all nodes, ``config/fpnet.yaml``.

Keys of the configuration tree have their defaults. Other parameters of the nodes are in comments,
so that the command line can read the same file and nodes keep their own defaults.
"""

from __future__ import annotations

import sys

from fpnet_core.config_docs import render_section, render_yaml
from fpnet_ros.known_parameters import node_sections

_HEAD = """\
    # Parameters of the nodes only, with defaults. Delete the first "# " of those that you set, in
    # a file for the nodes: fpnet localize --config refuses these keys.
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
