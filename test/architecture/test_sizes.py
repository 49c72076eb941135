# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Code stays in pieces that one can read: short modules, short functions, few branches."""

import ast
from pathlib import Path
import subprocess
import sys

ROOT = Path(__file__).resolve().parents[2]
USED, LAB = ('fpnet_core', 'fpnet_ros', 'msg_adapters', 'fpnet'), ('fpnet_lab',)
MODULES = {
    path.relative_to(ROOT).as_posix(): path.read_text()
    for package in (*USED, *LAB)
    for path in (ROOT / package).rglob('*.py')
}

NODES = ('localizer', 'odometry', 'floorplan_server', 'seeder')

LONGEST_MODULE = 400
LONGEST_NODE = 300
LONGEST_FUNCTION = {**dict.fromkeys(USED, 60), **dict.fromkeys(LAB, 110)}
"""The longest of the lab are commands, half of whose lines are options and help."""
MOST_BRANCHES = 12


MOST_KERNELS = 38
"""Compiled functions of robot and desk, which an installation waits for."""


def functions(source):
    """Yield the name and length of each function, nested ones and methods included."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node.name, node.end_lineno - node.lineno + 1


def test_the_count_sees_functions():
    source = 'class A:\n    async def f(self):\n        def g():\n            pass\n'
    assert list(functions(source)) == [('f', 3), ('g', 2)]
    assert len(MODULES) > 100


def test_no_module_is_long():
    lengths = {name: source.count('\n') for name, source in MODULES.items()}
    assert {name: n for name, n in lengths.items() if n > LONGEST_MODULE} == {}


def test_a_node_is_wiring_and_short():
    """What a node thinks, publishes and keeps has modules of its own, beside it."""
    lengths = {
        name: len((ROOT / f'fpnet_ros/{name}.py').read_text().splitlines()) for name in NODES
    }
    assert {name: n for name, n in lengths.items() if n >= LONGEST_NODE} == {}


def test_no_function_is_long():
    found = {
        f'{module}: {name}': length
        for module, source in MODULES.items()
        for name, length in functions(source)
        if length > LONGEST_FUNCTION[module.partition('/')[0]]
    }
    assert found == {}


def test_no_function_branches_much():
    """Compiled kernels count as well: ruff tells, by McCabe's measure."""
    folders = [str(ROOT / package) for package in (*USED, *LAB)]
    limit = f'lint.mccabe.max-complexity={MOST_BRANCHES}'
    command = [sys.executable, '-m', 'ruff', 'check', '--isolated', '--no-cache', '--select=C901']
    result = subprocess.run(
        [*command, '--config', limit, '--output-format=concise', *folders],
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr


def is_compiled(function):
    return any('njit' in ast.unparse(each) for each in function.decorator_list)


def test_few_functions_are_compiled():
    found = [
        f'{module}: {node.name}'
        for module, source in MODULES.items()
        if not module.startswith('fpnet_lab/')
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.FunctionDef) and is_compiled(node)
    ]
    assert 0 < len(found) <= MOST_KERNELS, sorted(found)
