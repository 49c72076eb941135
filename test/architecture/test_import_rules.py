# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Who may import whom: layers inside core and lab, and what stays out of them altogether."""

import ast
from functools import cache
from pathlib import Path
import re
import subprocess
import sys

ROOT = Path(__file__).resolve().parents[2]

LAYERS = {
    'fpnet_core': [
        {'arguments', 'errors', 'frozen', 'geometry', 'matches', 'types', 'config', 'config_docs'}
        | {'plain_files', 'plain_yaml', 'printable', 'pose_covariance', 'small_networks', 'stamps'}
        | {'trajectory', 'kernel_cache'}
        | {'freed_memory'},
        {'raster'},
        {'io', 'submaps', 'segmentation', 'graphs', 'odometry'},
        {'models', 'matching', 'pose', 'scoring', 'drawings', 'doctor'},
        {'localizer'},
        {'sites', 'differences'},
    ],
    'fpnet': [
        {
            'accuracy',
            'alignment',
            'bag_writer',
            'doctor',
            'exports',
            'geojson',
            'library',
            'plan_check',
            'recordings',
            'rooms',
            'site_check',
        },
        {'viz', 'report'},
        {'api'},
        {'cli'},
    ],
    'fpnet_lab': [
        {'kept', 'metrics', 'nodes', 'pool', 'provenance', 'scores'},
        {'sim', 'baselines'},
        {'evaluation'},
        {'training', 'viz'},
        {'cli'},
    ],
}
LEVEL = {
    f'{package}.{module}': level
    for package, layers in LAYERS.items()
    for level, modules in enumerate(layers)
    for module in modules
}

ROS_PACKAGES = (
    'rclpy', 'tf2_ros', 'tf2_msgs', 'std_msgs', 'geometry_msgs', 'nav_msgs', 'sensor_msgs',
    'visualization_msgs', 'diagnostic_msgs', 'builtin_interfaces', 'rosidl_runtime_py',
)  # fmt: skip
TORCH = ('torch', 'lightning_fabric')
TORCH_HOMES = ('fpnet_lab.training',)
ROBOT = ('fpnet_core', 'msg_adapters', 'fpnet_ros')
PACKAGES = (*ROBOT, 'fpnet', 'fpnet_lab')
HEAVY = ('torch', 'matplotlib', 'open3d', 'cv2', 'numba', 'ezdxf', 'pypdfium2', 'ifcopenshell')
STAGES = tuple(f'fpnet_core.{stage}' for stage in ('submaps', 'segmentation', 'graphs', 'pose'))
ADAPTERS_MAY = (
    'fpnet_core.types', 'fpnet_core.geometry', 'fpnet_core.errors', 'fpnet_core.io.pointcloud2',
    'fpnet_core.io.laserscan', 'fpnet_core.io.messages',
    'fpnet_core.stamps',
)  # fmt: skip


def module_name(path):
    parts = path.relative_to(ROOT).with_suffix('').parts
    return '.'.join(parts[:-1] if parts[-1] == '__init__' else parts)


def sources(package):
    return sorted((ROOT / package).rglob('*.py'))


class _WithoutAnnotations(ast.NodeTransformer):
    """Drops what is imported for type checkers only."""

    def visit_If(self, node):
        is_for_types = isinstance(node.test, ast.Name) and node.test.id == 'TYPE_CHECKING'
        return None if is_for_types else self.generic_visit(node)


@cache
def imported(path, with_annotations=True):
    """Absolute names of everything that a file imports, at any depth."""
    tree = ast.parse(path.read_text(encoding='utf-8'))
    if not with_annotations:
        tree = _WithoutAnnotations().visit(tree)
    name = module_name(path)
    package = name if path.name == '__init__.py' else name.rpartition('.')[0]
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ''
            if node.level:
                parent = package.rsplit('.', node.level - 1)[0] if node.level > 1 else package
                base = f'{parent}.{base}'.rstrip('.')
            # `from fpnet_core import io` imports a module, too.
            names.update(f'{base}.{alias.name}' for alias in node.names)
    return names


FILES = {module_name(path): path for package in PACKAGES for path in sources(package)}


def imports(with_annotations=True):
    """What each module imports; read when a test asks, and not in every worker."""
    return {module: imported(path, with_annotations) for module, path in FILES.items()}


def within(name, packages):
    return any(name == package or name.startswith(f'{package}.') for package in packages)


def offences(importers, is_forbidden):
    return sorted(
        f'{module} imports {name}'
        for module, names in imports().items()
        if importers(module)
        for name in names
        if is_forbidden(name)
    )


def part_of(name):
    """``fpnet_core.io`` of ``fpnet_core.io.maps``; None for names outside of core and lab."""
    part = '.'.join(name.split('.')[:2])
    return part if part in LEVEL else None


def file_of(name):
    """The module whose name or whose member's name this is; None for those of libraries."""
    while name and name not in FILES:
        name = name.rpartition('.')[0]
    return name


def is_there(name):
    """Whether it is a module, or named in the module that it is imported from."""
    if name in FILES:
        return True
    module, _, member = name.rpartition('.')
    return module in FILES and re.search(rf'\b{member}\b', FILES[module].read_text()) is not None


def circles(graph):
    """What is left of a graph of imports after all that imports nothing left is taken away."""
    left = {module: neighbours - {module} for module, neighbours in graph.items()}
    while free := [module for module, neighbours in left.items() if not neighbours & left.keys()]:
        for module in free:
            del left[module]
    return sorted(left)


def test_the_scan_sees_imports():
    assert 'numpy' in imports()['fpnet_core.types']
    assert 'fpnet_core.geometry.Affine2D' in imports()['fpnet_core.types']
    assert len(imports()) > 40


def test_every_module_has_a_layer():
    parts = {'.'.join(name.split('.')[:2]) for name in imports() if within(name, LAYERS)}
    assert parts - set(LEVEL) - set(LAYERS) <= {'fpnet_core.weights', 'fpnet.__main__'}


def test_the_page_says_where_every_module_has_its_home():
    page = (ROOT / 'docs' / 'architecture.md').read_text(encoding='utf-8')
    written = ' '.join(re.findall(r'`([^`\n]+)`', page))
    named = {word.removesuffix('.py') for word in re.findall(r'[\w.]+', written)}
    assert {part.partition('.')[2] for part in LEVEL} - named == set()


def test_names_that_scripts_import_are_there():
    """Most scripts run once in weeks, and no type checker reads them."""
    scripts = [*sources('benchmarks'), *sources('tools'), *sources('test')]
    assert len(scripts) > 200
    missing = {
        f'{script.name} imports {name}'
        for script in scripts
        for name in imported(script)
        if within(name, PACKAGES) and not is_there(name)
    }
    assert sorted(missing) == []


def test_nothing_imports_from_further_right():
    found = [
        f'{module} (layer {LEVEL[own]}) imports {name} (layer {LEVEL[other]})'
        for module, names in imports().items()
        if (own := part_of(module))
        for name in names
        if (other := part_of(name))
        and own.split('.')[0] == other.split('.')[0]
        and LEVEL[other] > LEVEL[own]
    ]
    assert sorted(found) == []


def test_stages_of_a_tick_meet_in_values_only():
    """What two of them need is true of rasters, transforms or types: it has its home there."""
    found = [
        f'{module} imports {name}'
        for module, names in imports().items()
        if within(module, STAGES)
        for name in names
        if within(name, STAGES) and part_of(name) != part_of(module)
    ]
    assert sorted(found) == []


def test_formats_of_drawings_and_the_reading_of_pictures_do_not_know_each_other():
    formats, pictures = ['fpnet_core.drawings.formats'], ['fpnet_core.drawings.pictures']
    assert offences(lambda m: within(m, formats), lambda n: within(n, pictures)) == []
    assert offences(lambda m: within(m, pictures), lambda n: within(n, formats)) == []


def test_no_circles_between_packages():
    graph = {part: set() for part in LEVEL}
    for module, names in imports().items():
        if own := part_of(module):
            graph[own] |= {other for name in names if (other := part_of(name))}
    assert circles(graph) == []


def test_no_circles_between_files():
    graph = {
        module: {file for name in names if (file := file_of(name))}
        for module, names in imports(with_annotations=False).items()
    }
    assert circles(graph) == []


def test_what_a_robot_runs_knows_neither_desk_nor_lab():
    found = offences(lambda m: within(m, ROBOT), lambda n: within(n, ['fpnet', 'fpnet_lab']))
    assert found == []


def test_the_desk_knows_no_lab():
    assert offences(lambda m: within(m, ['fpnet']), lambda n: within(n, ['fpnet_lab'])) == []


def test_core_desk_and_lab_know_no_ros_and_nothing_that_does():
    """But for one place of the lab, which starts real nodes, and which nothing imports."""
    nodes = ['fpnet_lab.nodes']
    forbidden = (*ROS_PACKAGES, 'msg_adapters', 'fpnet_ros', *nodes)
    plain = ('fpnet_core', 'fpnet', 'fpnet_lab')
    is_plain = lambda m: within(m, plain) and not within(m, nodes)  # noqa: E731
    assert offences(is_plain, lambda n: within(n, forbidden)) == []


def test_torch_stays_where_networks_are():
    found = offences(
        lambda m: within(m, PACKAGES) and not within(m, TORCH_HOMES), lambda n: within(n, TORCH)
    )
    assert found == []


def test_adapters_need_no_rclpy_and_little_of_the_core():
    is_adapter = lambda m: within(m, ['msg_adapters'])  # noqa: E731
    assert offences(is_adapter, lambda n: within(n, ['rclpy', 'fpnet_ros'])) == []
    core = offences(
        is_adapter, lambda n: within(n, ['fpnet_core']) and not within(n, ADAPTERS_MAY)
    )
    assert core == []


LIGHT = (
    'fpnet', 'fpnet.cli', 'fpnet_core', 'fpnet_core.types', 'fpnet_core.config', 'fpnet_core.io',
    'fpnet_core.io.pointcloud2',
    'fpnet_core.io.laserscan', 'fpnet_core.io.maps', 'fpnet_core.io.scans',
    'fpnet_core.drawings.types', 'fpnet_core.drawings.opening', 'fpnet_core.drawings.annotations',
)  # fmt: skip


def test_importing_leaves_heavy_libraries_unloaded():
    code = (
        'import importlib, sys\n'
        f'for name in {LIGHT!r}:\n'
        '    importlib.import_module(name)\n'
        f'    print(name, [m for m in {HEAVY!r} if m in sys.modules])'
    )
    result = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert result.stdout.splitlines() == [f'{name} []' for name in LIGHT]


def test_a_localizer_on_the_packaged_weights_needs_no_torch():
    """Its import takes longer than matching two maps."""
    code = (
        'import sys, fpnet.api, fpnet.api.run;'
        'from fpnet_core.config import FpnetConfig;'
        'from fpnet_core.localizer import create_localizer; create_localizer(FpnetConfig());'
        'print("torch" in sys.modules)'
    )
    result = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert result.stdout.strip() == 'False'
