# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Alignments of real robot maps with their floorplans by ``fpnet align``, and their exports.

Run: python benchmarks/align_pairs.py ../shared/data [--without TEXT] [--work DIR] [--json OUT]

Data: the twelve robot maps of the development split with a fitted transform, and the office of
Open-RMF's demos, whose building file has the robot map as a layer. Files are read as a user has
them; the office has its scales stated, since its drawing alone leaves it ambiguous. Errors are
distances on the observed walls between the transform and the fitted one, in true metres. The
exported robot map is placed on the exported plan; the result should be the identity. The exported
layer, read as the traffic editor does, is compared with the transform.
"""

import json
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import yaml

from fpnet.api import align, match, read_plan
from fpnet_core.config import FpnetConfig
from fpnet_core.errors import NotPlacedError
from fpnet_core.geometry import Affine2D
from fpnet_core.io.maps import read_map, write_map
from fpnet_core.raster.pixels import pixel_to_xy
from fpnet_core.sites.open_rmf import read_open_rmf
from fpnet_lab.cli.reports import finish, script_parser
from fpnet_lab.evaluation.robots.robot_pairs import read_robot_pairs

OFFICE = 'office (Open-RMF)'
OFFICE_PLAN_M, OFFICE_MAP_M = 0.00847, 0.05064  # given: metres per pixel, by the data's notes
CENTRE = Affine2D(np.eye(2), np.full(2, 0.5))  # from pixels at centres to those from the corner


def layer_to_pixels(level, name):
    """Return the affine from a layer's pixels to those of the level's drawing, both at centres."""
    vertices = np.array([vertex[:2] for vertex in level['vertices']], dtype=float)
    scales = [
        told['distance'][1] / np.hypot(*(vertices[a] - vertices[b]))
        for a, b, told in level['measurements']
    ]
    t, metres = level['layers'][name]['transform'], np.mean(scales)
    c, s = np.cos(t['yaw']), np.sin(t['yaw'])
    linear = t['scale'] * np.array([[c, s], [-s, c]])
    moved = np.array([t['translation_x'], t['translation_y']])
    return CENTRE.inv() @ Affine2D(linear / metres, moved / metres) @ CENTRE


def cases(data, work):
    """Yield name, drawing, robot map, and the true affine from its pixels to the drawing's."""
    for pair in read_robot_pairs(data, 'tune'):
        to_pixels = pixel_to_xy(pair.plan).inv() @ pair.A_plan_robot @ pixel_to_xy(pair.robot)
        yield pair.name, lambda pair=pair: read_plan(pair.files[0]), pair.files[1], to_pixels
    folder = data / 'drawings'
    level = yaml.safe_load((folder / 'office.building.yaml').read_text())['levels']['L1']
    robot = work / 'office_scan.yaml'
    write_map(read_map(folder / 'office_scan.png', OFFICE_MAP_M), robot)
    to_pixels = layer_to_pixels(level, 'office_laserscan')
    yield (
        OFFICE,
        lambda: read_plan(folder / 'office.png', resolution=OFFICE_PLAN_M),
        robot,
        to_pixels,
    )


def off_m(aligned, A_plan_map):
    """Return the distances on the observed walls between two transforms, true metres."""
    xy = aligned.walls.xy
    placed = A_plan_map.apply(aligned.A_plan_map.inv().apply(xy))
    return aligned.metres * np.linalg.norm(placed - xy, axis=1)


def measured(plan, robot, to_pixels, out):
    """Return the figures of one alignment and of its exports, written to ``out``."""
    aligned = align(plan, robot)
    H = plan.H_plan_image / plan.H_plan_image[2, 2]
    layer = pixel_to_xy(aligned.robot)
    truth = Affine2D(H[:2, :2], H[:2, 2]) @ to_pixels @ layer.inv()
    errors_m = off_m(aligned, truth)
    aligned.write(out)
    back = match(out / 'plan.yaml', out / 'robot_map_in_plan.yaml')
    level = yaml.safe_load((out / 'aligned.building.yaml').read_text())['levels']
    (level,) = level.values()
    rmf = pixel_to_xy(plan.grid) @ layer_to_pixels(level, 'robot_map') @ layer.inv()
    site = read_open_rmf(out / 'aligned.building.yaml', FpnetConfig())
    sigma_m = aligned.metres * np.sqrt(np.diag(aligned.cov)[:2].mean())
    whole = aligned.walls.whole
    return {
        'status': 'aligned',
        'probability': aligned.match.probability,
        **{key: whole[key] for key in ('walls_m', 'furniture_m', 'median_m', 'p90_m')},
        **{key: whole[key] for key in ('deformed_m', 'explained')},
        'rooms': len([room for room in aligned.rooms if room['room'] is not None]),
        'error_m': float(np.median(errors_m)),
        'worst_m': float(errors_m.max()),
        'sigma_m': float(sigma_m),
        'similarity_m': aligned.similarity_error_m,
        'rmf_m': float(off_m(aligned, rmf).max()),
        'rmf_doors': len(site.storeys[0].doors),
        'back': back.status.value,
        'back_m': None if back.A_plan_sub is None else float(
            np.median(off_m(aligned, back.A_plan_sub @ aligned.A_plan_map))
        ),
    }  # fmt: skip


def figures_of(read, robot, to_pixels, out):
    """Return the figures of one case, or why it was refused."""
    try:
        return measured(read(), robot, to_pixels, out)
    except NotPlacedError as error:
        return {'status': 'refused', 'reason': str(error)}


def main():
    """Align every pair and report the figures of each."""
    parser = script_parser(__doc__)
    parser.add_argument('data', type=Path)
    parser.add_argument(
        '--without', action='append', default=[], metavar='TEXT', help='skip names with this text'
    )
    parser.add_argument('--work', type=Path, metavar='DIR', help='keep exports here, and resume')
    options = parser.parse_args()
    pairs = {}
    with TemporaryDirectory() as temporary:
        work = options.work or Path(temporary)
        for name, read, robot, to_pixels in cases(options.data, work):
            if any(text in name for text in options.without):
                continue
            out = work / name.partition(' ')[0]
            kept = out / 'figures.json'
            if not kept.exists():
                out.mkdir(parents=True, exist_ok=True)
                kept.write_text(json.dumps(figures_of(read, robot, to_pixels, out)))
            pairs[name] = json.loads(kept.read_text())
            print(name, pairs[name], flush=True)
    finish('align_pairs', options.json, {'split': 'tune', 'pairs': pairs})


if __name__ == '__main__':
    main()
