# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A word means one thing: no two modules define a public class of the same name."""

import ast
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = (
    *('fpnet', 'fpnet_core', 'fpnet_ros', 'msg_adapters', 'fpnet_lab'),
    *('benchmarks', 'tools'),
)


def classes(source):
    """Names of the public classes at the top of a module."""
    found = [node.name for node in ast.parse(source).body if isinstance(node, ast.ClassDef)]
    return [name for name in found if not name.startswith('_')]


def test_the_search_sees_public_classes_only():
    assert classes('class A:\n    class B:\n        pass\nclass _C:\n    pass\n') == ['A']


def test_every_class_has_a_name_of_its_own():
    homes = defaultdict(list)
    for path in (path for folder in FOLDERS for path in sorted((ROOT / folder).rglob('*.py'))):
        for name in classes(path.read_text(encoding='utf-8')):
            homes[name].append(path.relative_to(ROOT).as_posix())
    assert len(homes) > 500
    assert {name: paths for name, paths in homes.items() if len(paths) > 1} == {}
