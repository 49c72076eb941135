# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Every reader of the product with a small valid input to start from."""

from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
import gzip
import hashlib
import importlib
import json
from pathlib import Path
import shutil
import struct
import tempfile
from types import SimpleNamespace
import zlib

import numpy as np

from fuzzing.mutations import damage_archive, damage_bytes, damage_npy, damage_text, damage_yaml

Damage = Callable[[bytes, np.random.Generator], bytes]

_STAMPS_NS = np.arange(6) * 100_000_000
_CARMEN_READINGS = 20
_BOMB_SHARE = 0.02  # of compressed files unpack to gigabytes
_E57_PAGE, _E57_CHECKSUM = 1024, 4  # bytes
_CASTAGNOLI = 0x82F63B78  # of the E57 pages' CRC-32C


@dataclass(frozen=True)
class Reader:
    """
    One reader and how its files are damaged.

    ``write`` makes a valid input in a folder and returns the path that ``read`` takes; the files
    of the folder that match ``damaged`` are mutated by one of ``damages``, the later ones knowing
    more of the format.
    """

    group: str
    name: str
    write: Callable[[Path], Path]
    read: Callable[[Path], object]
    damages: tuple[Damage, ...] = (damage_bytes,)
    damaged: str = '*'

    def damage(self, folder: Path, rng: np.random.Generator) -> Path:
        """Damage one file of a written input and return it."""
        files = sorted(path for path in folder.rglob(self.damaged) if path.is_file())
        chosen = files[rng.integers(len(files))]
        way = self.damages[rng.integers(len(self.damages))]
        chosen.write_bytes(way(chosen.read_bytes(), rng))
        return chosen


def _shades() -> np.ndarray:
    """Two rooms with a door in a field of unknown grey, 64 x 48 pixels."""
    shades = np.full((48, 64), 205, np.uint8)
    shades[4:44, 4:60] = 0
    shades[6:42, 6:30] = 254
    shades[6:42, 32:58] = 254
    shades[20:26, 30:32] = 254
    return shades


def _points(count: int = 40) -> np.ndarray:
    return np.random.default_rng(5).normal(0.0, 3.0, (count, 3))


def _poses() -> np.ndarray:
    poses = np.tile(np.eye(4), (len(_STAMPS_NS), 1, 1))
    poses[:, 0, 3] = np.arange(len(poses)) * 0.2
    return poses


def _grid():
    from fpnet_core.types import GridMap

    return GridMap(np.random.default_rng(2).choice([0, 100, -1], (12, 16)).astype(np.int8), 0.05)


# --- images and maps


def _image_writer(suffix: str, **options: object) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        from PIL import Image

        path = folder / f'plan{suffix}'
        Image.fromarray(_shades()).save(path, **options)
        return path

    return write


def _read_map(path: Path) -> object:
    from fpnet_core.io.maps import read_map
    from fpnet_core.io.outside import outside_as_unknown

    # The valid one lies on unknown ground: kernels for drawings on paper, which Numba unpickles
    # itself, are loaded all the same before a damaged one is read.
    outside_as_unknown(np.where(_shades() == 0, 100, 0).astype(np.int8), 0.05)
    return read_map(path)


def _damage_png_chunks(data: bytes, rng: np.random.Generator) -> bytes:
    """Damage what lies inside the chunks of a PNG and make their checksums right again."""
    header, rest, out = data[:8], data[8:], b''
    while len(rest) >= 12:
        (length,) = struct.unpack('>I', rest[:4])
        kind, body = rest[4:8], rest[8 : 8 + length]
        if rng.random() < 0.5:
            body = damage_bytes(body, rng)
        checksum = struct.pack('>I', zlib.crc32(kind + body))
        out += struct.pack('>I', len(body)) + kind + body + checksum
        rest = rest[12 + length :]
    return header + out


def _write_map(folder: Path) -> Path:
    from fpnet_core.io.maps import write_map

    write_map(_grid(), folder / 'map.yaml')
    return folder / 'map.yaml'


def _write_plan(folder: Path) -> Path:
    from fpnet_core.drawings.plan_files import write_plan
    from fpnet_core.drawings.types import Drawing, DrawingScale, Reading, ScaleSource

    scale = DrawingScale(0.05, 0.04, 0.07, ScaleSource.ESTIMATED, 'doors')
    drawing = Drawing(np.full((12, 16, 3), 255, np.uint8), 'sheet.png', 'png')
    write_plan(Reading(_grid(), scale, np.eye(3), 'dark walls', drawing), folder / 'plan.yaml')
    return folder / 'plan.yaml'


def _read_plan(path: Path) -> object:
    from fpnet_core.drawings.read import read_plan

    return read_plan(path)


# --- drawings


def _vector_writer(name: str) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        import plan_files

        suffix = name.rpartition('.')[2]
        path = folder / f'plan.{suffix}'
        if suffix == 'svgz':
            plan_files.write_svg(folder / 'plan.svg')
            path.write_bytes(gzip.compress((folder / 'plan.svg').read_bytes()))
            (folder / 'plan.svg').unlink()
            return path
        return getattr(plan_files, f'write_{suffix}')(path)

    return write


def _write_ifc(folder: Path) -> Path:
    """Write a model without walls: enough for the header, the parser and the storeys."""
    path = folder / 'plan.ifc'
    path.write_text(
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','"
        "');\nFILE_SCHEMA(('IFC4'));\nENDSEC;\nDATA;\n#1=IFCBUILDINGSTOREY('2O2Fr$t4X7Zf8NOew3FL"
        "Kl',$,'Ground',$,$,$,$,$,.ELEMENT.,0.);\nENDSEC;\nEND-ISO-10303-21;\n",
        encoding='ascii',
    )
    return path


def _write_geojson(folder: Path) -> Path:
    """Write a room and a door as IMDF has them."""
    ring = [[30.0, 60.0], [30.0001, 60.0], [30.0001, 60.0001], [30.0, 60.0001], [30.0, 60.0]]
    shapes = (('unit', 'Polygon', [ring]), ('opening', 'LineString', [ring[0], [30.00001, 60.0]]))
    features = [
        {
            'type': 'Feature', 'id': kind, 'feature_type': kind,
            'geometry': {'type': shape, 'coordinates': places}, 'properties': {'level_id': 'a'},
        }
        for kind, shape, places in shapes
    ]  # fmt: skip
    path = folder / 'plan.geojson'
    path.write_text(json.dumps({'type': 'FeatureCollection', 'features': features}))
    return path


def _write_building(folder: Path) -> Path:
    """Write a level of Open-RMF with a measurement, four walls and a door."""
    path = folder / 'plan.building.yaml'
    path.write_text(
        'name: b\nlevels:\n  L1:\n    elevation: 0.0\n'
        '    vertices: [[0, 0], [400, 0], [400, 300], [0, 300], [100, 0], [150, 0]]\n'
        '    walls: [[0, 4, {}], [5, 1, {}], [1, 2, {}], [2, 3, {}], [3, 0, {}]]\n'
        '    doors: [[4, 5, {type: [1, hinged], name: [1, D]}]]\n'
        '    measurements: [[0, 1, {distance: [3, 8.0]}]]\n'
        '    floors: [{vertices: [0, 1, 2, 3]}]\n'
    )
    return path


def _read_drawing(path: Path) -> object:
    """Open a drawing as users do, in a process of its own."""
    from fpnet_core.drawings.annotations import annotated_scale
    from fpnet_core.drawings.opening import open_drawing

    return annotated_scale(open_drawing(path))


def _read_drawing_here(path: Path) -> object:
    """Read a drawing in this process, where nothing hides what its reader raises."""
    from fpnet_core.drawings.formats.vector import drawing_of
    from fpnet_core.drawings.opening import drawing_kind
    from fpnet_core.drawings.types import ReadOptions

    kind = drawing_kind(path)
    if kind not in ('svg', 'dxf', 'geojson', 'rmf'):
        return _read_drawing(path)
    module = importlib.import_module(f'fpnet_core.drawings.formats.{kind}')
    page = getattr(module, f'read_{kind}')(path, ReadOptions())
    return drawing_of(page, path.name, kind, ReadOptions())


def _read_ifc(path: Path) -> object:
    """Read a model; the valid one here has no walls, and IfcOpenShell is optional."""
    from fpnet_core.errors import MapFormatError

    try:
        return _read_drawing(path)
    except MapFormatError as error:
        if 'no walls' in str(error) or 'IfcOpenShell' in str(error):
            return None
        raise


# --- configuration


def _write_config(folder: Path) -> Path:
    from fpnet_core.config_docs import render_yaml

    (folder / 'fpnet.yaml').write_text(render_yaml(), encoding='utf-8')
    return folder / 'fpnet.yaml'


def _read_config(path: Path) -> object:
    from fpnet_core.config import load_config

    return load_config(path)


# --- recordings


def _read_scans(path: Path) -> object:
    from fpnet.recordings.opening import open_scans

    return list(open_scans(path))


def _examine(path: Path) -> object:
    from fpnet.doctor.bag import observe_bag
    from fpnet.doctor.examine import examine
    from fpnet_core.config import OdometryConfig
    from fpnet_core.odometry import KissOdometry

    # The valid bag is too short to be registered: the kernel, which Numba unpickles itself,
    # is loaded all the same before a damaged one is listened to.
    KissOdometry(OdometryConfig())
    return examine(observe_bag(path, 10.0))


def _bag_writer(storage: str) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        from fpnet.bag_writer import BagWriter

        with BagWriter(folder / 'bag', storage) as bag:
            for stamp_ns, pose in zip(_STAMPS_NS.tolist(), _poses(), strict=True):
                bag.write_odometry('/odom', stamp_ns, 'odom', 'base', pose)
                bag.write_transform('/tf_static', stamp_ns, 'base', 'lidar', np.eye(4))
                time_s = np.linspace(0.0, 0.1, 40)
                bag.write_cloud('/points', stamp_ns, 'lidar', _points(), time_s=time_s)
        return folder / 'bag'

    return write


def _write_laser_bag(folder: Path) -> Path:
    from fpnet.bag_writer import BagWriter
    from fpnet_core.io.laserscan import LaserReadings

    readings = LaserReadings(-1.0, 0.05, 1e-3, 0.1, 30.0, np.linspace(0.0, 40.0, 40))
    with BagWriter(folder / 'bag', 'mcap') as bag:
        for frame in ('front', 'rear'):
            bag.write_transform('/tf_static', 0, 'base', frame, np.eye(4))
        for stamp_ns in _STAMPS_NS.tolist():
            bag.write_laser_scan('/front/scan', stamp_ns, 'front', readings)
            bag.write_laser_scan('/rear/scan', stamp_ns, 'rear', readings)
    return folder / 'bag'


def _message_writer(storage: str) -> Damage:
    """Return a damage that writes a storage file anew, with damaged messages in it."""

    def damage(data: bytes, rng: np.random.Generator) -> bytes:
        with tempfile.TemporaryDirectory() as scratch:
            path = Path(scratch) / f'all.{storage}'
            path.write_bytes(data)
            return _rewritten(path, Path(scratch) / 'bag', rng)

    return damage


def _rewritten(path: Path, bag: Path, rng: np.random.Generator) -> bytes:
    from rosbags.rosbag2 import Reader as Bag
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    plugin = StoragePlugin.MCAP if path.suffix == '.mcap' else StoragePlugin.SQLITE3
    store = get_typestore(Stores.ROS2_JAZZY)
    with Bag(path) as reader, Writer(bag, version=9, storage_plugin=plugin) as writer:
        made = {
            # Channels are told apart by their QoS as well: with another, no message would be read.
            c.id: writer.add_connection(
                c.topic,
                c.msgtype,
                typestore=store,
                offered_qos_profiles=c.ext.offered_qos_profiles,
            )
            for c in reader.connections
        }
        for connection, stamp_ns, message in reader.messages():
            is_hit = rng.random() < 0.2
            content = damage_bytes(bytes(message), rng) if is_hit else bytes(message)
            writer.write(made[connection.id], stamp_ns, content)
    return next(bag.glob(f'*{path.suffix}')).read_bytes()


def _write_carmen(folder: Path) -> Path:
    readings = ' '.join(['2.50'] * _CARMEN_READINGS)
    lines = [
        f'FLASER {_CARMEN_READINGS} {readings} {0.1 * k} 0 0 {0.1 * k} 0 0 {1e9 + k} host {k}'
        for k in range(6)
    ]
    lines += [
        f'ROBOTLASER1 0 -1.57 3.14 0.1 80 0.01 0 {_CARMEN_READINGS} {readings} 0 0 0 0 0 0 0 0 '
        f'0 0 0 0 {1e9 + k} host {k}'
        for k in range(3)
    ]
    (folder / 'drive.log').write_text('# log\n' + '\n'.join(lines) + '\n', encoding='ascii')
    return folder / 'drive.log'


def _write_carmen_gz(folder: Path) -> Path:
    plain = _write_carmen(folder)
    (folder / 'drive.log.gz').write_bytes(gzip.compress(plain.read_bytes()))
    plain.unlink()
    return folder / 'drive.log.gz'


def _damage_gzipped(data: bytes, rng: np.random.Generator) -> bytes:
    if rng.random() < _BOMB_SHARE:  # three gigabytes in three megabytes
        return data + gzip.compress(b'#' * 2**20) * (3 * 2**10)
    return gzip.compress(damage_text(gzip.decompress(data), rng))


def _write_scan_folder(folder: Path) -> Path:
    for index in range(len(_STAMPS_NS)):
        np.save(folder / f'scan{index}.npy', _points())
    (folder / 'notes.txt').write_text('Tuesday\n', encoding='ascii')
    _write_tum(folder)
    return folder


def _write_scan_archive(folder: Path) -> Path:
    np.savez_compressed(folder / 'scans.npz', **{f'scan{k}': _points() for k in range(6)})
    _write_kitti(folder)
    return folder


# --- point files


def _write_ply(form: str) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        header = (
            f'ply\nformat {form} 1.0\nelement vertex 40\nproperty double x\n'
            'property double y\nproperty double z\nend_header\n'
        )
        rows = '\n'.join(' '.join(map(str, p)) for p in _points().tolist()).encode()
        body = rows if form == 'ascii' else _points().astype('<f8').tobytes()
        (folder / 'cloud.ply').write_bytes(header.encode() + body)
        return folder / 'cloud.ply'

    return write


def _write_pcd(encoding: str) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        import open3d as o3d

        cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(_points()))
        path = folder / 'cloud.pcd'
        o3d.io.write_point_cloud(
            str(path),
            cloud,
            write_ascii=encoding == 'ascii',
            compressed=encoding == 'binary_compressed',
        )
        return path

    return write


def _write_npy(folder: Path) -> Path:
    np.save(folder / 'cloud.npy', _points())
    return folder / 'cloud.npy'


def _damage_npy_file(data: bytes, rng: np.random.Generator) -> bytes:
    import io

    return damage_npy(np.load(io.BytesIO(data)), rng)


def _table_writer(name: str, columns: int, header: str = '') -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        values = np.abs(np.tile(_points(), 2))[:, :columns] / 10.0
        path = folder / name
        np.savetxt(path, values, header=header, comments='', fmt='%.4f')
        return path

    return write


def _write_e57(folder: Path) -> Path:
    import pye57

    path, points = folder / 'cloud.e57', _points()
    file = pye57.E57(str(path), mode='w')
    file.write_scan_raw(
        dict(zip(('cartesianX', 'cartesianY', 'cartesianZ'), points.T, strict=True))
    )
    file.close()
    return path


def _damage_e57_pages(data: bytes, rng: np.random.Generator) -> bytes:
    """Damage an E57 file and make the checksums of its pages right again."""
    data = bytearray(damage_bytes(data, rng))
    for start in range(0, len(data) - _E57_PAGE + 1, _E57_PAGE):
        end = start + _E57_PAGE - _E57_CHECKSUM
        data[end : end + _E57_CHECKSUM] = struct.pack('>I', _crc32c(data[start:end]))
    return bytes(data)


def _crc32c(data: bytes) -> int:
    value = 0xFFFFFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = (value >> 1) ^ (_CASTAGNOLI if value & 1 else 0)
    return value ^ 0xFFFFFFFF


def _read_cloud(path: Path) -> object:
    from fpnet_core.io.clouds import read_cloud

    return read_cloud(path)


# --- poses


def _write_tum(folder: Path) -> Path:
    from fpnet.recordings.trajectories import write_tum

    write_tum(folder / 'poses.tum', _STAMPS_NS, _poses()[:, :2, 3], np.zeros(len(_STAMPS_NS)))
    return folder / 'poses.tum'


def _write_kitti(folder: Path) -> Path:
    np.savetxt(folder / 'poses_kitti.txt', _poses()[:, :3].reshape(-1, 12))
    return folder / 'poses_kitti.txt'


def _write_balm(folder: Path) -> Path:
    poses = _poses()
    poses[:, 3, 3] = _STAMPS_NS * 1e-9
    np.savetxt(folder / 'poses.csv', poses.reshape(-1, 4), delimiter=',')
    return folder / 'poses.csv'


def _write_npy_poses(folder: Path) -> Path:
    np.save(folder / 'poses.npy', _poses())
    return folder / 'poses.npy'


def _read_poses(path: Path) -> object:
    from fpnet.recordings.trajectories import read_poses

    return read_poses(path)


# --- weights, training


def _write_weights(folder: Path) -> Path:
    from fpnet_core.io.weights import write_weights
    from fpnet_core.models.config import InvariantConfig
    from fpnet_core.models.joint_attention import JointAttention
    from fpnet_core.types import FEATURE_SCHEMA

    config = InvariantConfig(width=8, heads=2, layers=1)
    shapes = JointAttention.shapes(config)
    tensors = {key: np.zeros(shape, np.float32) for key, shape in shapes.items()}
    path = folder / 'net.safetensors'
    facts = {'network': config.model_dump(mode='json'), 'training': {}}
    write_weights(path, tensors, FEATURE_SCHEMA, facts)
    return path


def _read_weights(path: Path) -> object:
    from fpnet_core.io.weights import read_weights
    from fpnet_core.models.inference import inference_of
    from fpnet_core.types import FEATURE_SCHEMA

    return inference_of(read_weights(path, FEATURE_SCHEMA))


def _read_weights_rehashed(path: Path) -> object:
    """Read weights whose manifest has been given the hash of the damaged file."""
    with suppress(OSError, ValueError):
        manifest_path = path.with_suffix('.json')
        manifest = json.loads(manifest_path.read_text(encoding='utf-8'))
        manifest['sha256'] = hashlib.sha256(path.read_bytes()).hexdigest()
        manifest_path.write_text(json.dumps(manifest), encoding='utf-8')
    return _read_weights(path)


def _write_training_state(folder: Path) -> Path:
    import torch

    from fpnet_lab.training.checkpoint import save_state

    network = torch.nn.Linear(8, 2)
    save_state(folder / 'state.safetensors', network, torch.optim.Adam(network.parameters()), {})
    return folder / 'state.safetensors'


def _read_training_state(path: Path) -> object:
    import torch

    from fpnet_lab.training.checkpoint import load_state

    network = torch.nn.Linear(8, 2)
    return load_state(path, network, torch.optim.Adam(network.parameters()))


# --- saved state and run folders


def _localizer():
    from fpnet_core.config import FpnetConfig
    from fpnet_core.localizer.localizer import Localizer

    return Localizer(FpnetConfig(), SimpleNamespace())  # no matcher: there is no floorplan


def _write_state(folder: Path) -> Path:
    localizer = _localizer()
    ring = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
    points = 3.0 * np.column_stack([np.cos(ring), np.sin(ring), 0.0 * ring]).astype(np.float32)
    for stamp_ns, pose in zip(_STAMPS_NS.tolist(), _poses(), strict=True):
        localizer.add_scan(points, pose, stamp_ns)
    localizer.save_state(folder / 'state.npz')
    return folder / 'state.npz'


def _read_state(path: Path) -> object:
    localizer = _localizer()
    localizer.load_state(path)
    return localizer.update(0)


def _write_run(folder: Path) -> Path:
    from fpnet_core.geometry import SE2
    from fpnet_core.io.runs import write_output
    from fpnet_core.types import LocalizerOutput, Region, RegionLabel, Segmentation, Status, Submap

    grid = _grid()
    triangle = np.array([[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]])
    regions = (Region(0, RegionLabel.ROOM, triangle, triangle.mean(0), 6.0),)
    labels = np.zeros(grid.shape, np.int64)
    submap = Submap(
        grid, np.zeros(grid.shape, np.bool_), np.zeros((2, 2)), SE2.identity(), 10**9, 1
    )
    output = LocalizerOutput(
        10**9,
        Status.SEARCHING,
        segmentation=Segmentation(grid, labels, regions, ()),
        submap=submap,
        timings_ms={'total': 1.0},
    )
    write_output(folder / 'ticks' / '1.npz', output)
    _write_tum(folder)
    shutil.copy(folder / 'poses.tum', folder / 'truth.tum')
    session = {'ticks': [{'total_ms': 3.0}], 'scans': 6, 'registered_scans': 6}
    (folder / 'session.json').write_text(json.dumps(session), encoding='utf-8')
    truth = {'A_plan_building': [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]}
    (folder / 'truth.json').write_text(json.dumps(truth), encoding='utf-8')
    return folder


def _read_run(path: Path) -> object:
    from fpnet_lab.evaluation.demo import rate_demo, read_ticks

    return rate_demo(path, path), read_ticks(path)


_TEXT, _YAML = (damage_bytes, damage_text), (damage_yaml,)
_ARCHIVE = (damage_bytes, damage_archive, damage_archive)
_ARRAY = (damage_bytes, _damage_npy_file)

READERS: tuple[Reader, ...] = (
    Reader('images', '.png', _image_writer('.png'), _read_map, (damage_bytes, _damage_png_chunks)),
    *(
        Reader('images', suffix, _image_writer(suffix), _read_map)
        for suffix in ('.pgm', '.jpg', '.bmp', '.tiff', '.webp', '.gif')
    ),
    Reader(
        'images',
        '.tiff, packed',
        _image_writer('.tiff', compression='tiff_deflate'),
        _read_map,
    ),
    *(
        Reader('drawings', f'.{suffix}', _vector_writer(f'a.{suffix}'), read, damages)
        for suffix, read, damages in (
            ('pdf', _read_drawing, _TEXT),
            ('svg', _read_drawing_here, _TEXT),
            ('svgz', _read_drawing_here, (damage_bytes, _damage_gzipped)),
            ('dxf', _read_drawing_here, _TEXT),
        )
    ),
    Reader('drawings', '.ifc', _write_ifc, _read_ifc, _TEXT),
    Reader('drawings', '.geojson', _write_geojson, _read_drawing_here, _TEXT),
    Reader('drawings', '.building.yaml', _write_building, _read_drawing_here, _YAML),
    Reader('map YAML', 'map.yaml', _write_map, _read_map, _YAML, '*.yaml'),
    Reader('plan records', 'plan.json', _write_plan, _read_plan, _TEXT, '*.json'),
    Reader('configuration', 'fpnet.yaml', _write_config, _read_config, _YAML),
    *(
        Reader('bags', kind, _bag_writer(storage), _read_scans, damages, pattern)
        for storage, suffix in (('sqlite3', '.db3'), ('mcap', '.mcap'))
        for kind, damages, pattern in (
            (storage, (damage_bytes, _message_writer(suffix[1:])), f'*{suffix}'),
            (f'{storage} metadata', _YAML, 'metadata.yaml'),
        )
    ),
    Reader(
        *('bags', 'laser scans', _write_laser_bag, _read_scans),
        (damage_bytes, _message_writer('mcap')),
        '*.mcap',
    ),
    *(
        Reader(
            *('doctor', storage, write, _examine),
            (damage_bytes, _message_writer('mcap')),
            '*.mcap',
        )
        for storage, write in (('clouds', _bag_writer('mcap')), ('laser scans', _write_laser_bag))
    ),
    Reader('CARMEN logs', '.log', _write_carmen, _read_scans, _TEXT),
    Reader(
        'CARMEN logs', '.log.gz', _write_carmen_gz, _read_scans, (damage_bytes, _damage_gzipped)
    ),
    *(
        Reader('point files', f'.ply {form}', _write_ply(form), _read_cloud, _TEXT)
        for form in ('ascii', 'binary_little_endian')
    ),
    *(
        Reader('point files', f'.pcd {form}', _write_pcd(form), _read_cloud, _TEXT)
        for form in ('ascii', 'binary', 'binary_compressed')
    ),
    Reader('point files', '.npy', _write_npy, _read_cloud, _ARRAY),
    *(
        Reader('point files', Path(name).suffix, write, _read_cloud, _TEXT)
        for name, write in (
            ('a.xyz', _table_writer('a.xyz', 3)),
            ('a.pts', _table_writer('a.pts', 3, '40')),
            ('a.xyzn', _table_writer('a.xyzn', 6)),
            ('a.xyzrgb', _table_writer('a.xyzrgb', 6)),
        )
    ),
    Reader('point files', '.e57', _write_e57, _read_cloud, (damage_bytes, _damage_e57_pages)),
    *(
        Reader('poses', name, write, _read_poses, damages)
        for name, write, damages in (
            ('TUM', _write_tum, _TEXT),
            ('KITTI', _write_kitti, _TEXT),
            ('BALM', _write_balm, _TEXT),
            ('.npy', _write_npy_poses, _ARRAY),
        )
    ),
    Reader('scan folders', 'point files', _write_scan_folder, _read_scans, _TEXT),
    Reader('scan folders', '.npz', _write_scan_archive, _read_scans, _ARCHIVE, '*.npz'),
    Reader('weights', 'both files', _write_weights, _read_weights, _TEXT),
    Reader(
        'weights',
        'rehashed',
        _write_weights,
        _read_weights_rehashed,
        (damage_bytes,),
        '*.safetensors',
    ),
    Reader('training state', '.safetensors', _write_training_state, _read_training_state),
    Reader('saved state', '.npz', _write_state, _read_state, _ARCHIVE),
    Reader('run folders', 'ticks', _write_run, _read_run, _ARCHIVE, '*.npz'),
    Reader('run folders', 'JSON and TUM', _write_run, _read_run, _TEXT, '*.[tj]*'),
)


def readers_of(groups: Iterable[str]) -> list[Reader]:
    """Return the readers of some groups, all of them if none is named."""
    wanted = set(groups)
    return [reader for reader in READERS if not wanted or reader.group in wanted]
