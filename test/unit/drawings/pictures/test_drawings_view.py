# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Turn and perspective of photographs, told by walls or by the sheet that they are drawn on."""

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from fpnet_core.drawings.pictures.view import on_paper, view_of
from fpnet_core.raster.pixels import cut_from, map_points

SIZE = (1200, 900)
CORNERS = np.array([[0.0, 0.0], [1200.0, 0.0], [1200.0, 900.0], [0.0, 900.0]])
TILT_DEG = (24.0, -9.0)
FOCAL_PX, FAR = 1300.0, 1.45
TABLE = (96, 90, 84)


def drawn_by_hand(rng):
    """Return a sheet (H, W, 3) with rooms whose walls are wobbly strokes."""
    sheet = np.full((SIZE[1], SIZE[0], 3), 250, np.uint8)
    for start, end in (
        ((150, 150), (1050, 150)), ((1050, 150), (1050, 750)), ((1050, 750), (150, 750)),
        ((150, 750), (150, 150)), ((450, 150), (450, 400)), ((750, 150), (750, 400)),
        ((150, 400), (380, 400)), ((430, 400), (1050, 400)), ((600, 520), (600, 750)),
        ((150, 520), (520, 520)), ((570, 520), (1050, 520)),
    ):  # fmt: skip
        along = np.linspace(0.0, 1.0, 12)[:, None]
        points = np.array(start) * (1.0 - along) + np.array(end) * along
        points[1:-1] += rng.normal(scale=4.0, size=(10, 2))
        cv2.polylines(sheet, [np.rint(points).astype(np.int32)], False, (20, 20, 20), 5)
    return sheet


def seen_from(tilt_deg):
    """Return where a camera tilted about x and y sees the corners (4, 2) of a sheet before it."""
    middle = CORNERS.mean(axis=0)
    R = Rotation.from_euler('XYZ', [*tilt_deg, 4.0], degrees=True).as_matrix()
    points = np.c_[CORNERS - middle, np.zeros(4)] @ R.T + (0.0, 0.0, FAR * FOCAL_PX)
    return middle + FOCAL_PX * points[:, :2] / points[:, 2:]


def largest_skew(corners):
    """Return by how much the corners (4, 2) are off a right angle at most [degrees]."""
    along = np.roll(corners, -1, axis=0) - corners
    along /= np.linalg.norm(along, axis=1)[:, None]
    return np.degrees(np.arcsin(np.abs((along * np.roll(along, 1, axis=0)).sum(axis=1)))).max()


def test_a_hand_drawing_that_was_photographed_at_an_angle_is_square_by_its_sheet():
    seen = seen_from(TILT_DEG)
    H = cv2.getPerspectiveTransform(CORNERS.astype(np.float32), seen.astype(np.float32))
    sheet = drawn_by_hand(np.random.default_rng(4))
    photo = cv2.warpPerspective(sheet, H, SIZE, borderValue=TABLE)
    view = view_of(photo)
    assert view.is_straightened
    assert largest_skew(seen) > 8.0
    assert largest_skew(map_points(view.H_view_pixel, seen)) < 1.0


def test_a_building_that_is_no_rectangle_is_no_sheet():
    """White rooms in grey surroundings: the outer wall is oblique, the walls within are square."""
    picture = np.full((SIZE[1], SIZE[0], 3), TABLE, np.uint8)
    outline = np.rint(seen_from(TILT_DEG)).astype(np.int32)
    cv2.fillConvexPoly(picture, outline, (250, 250, 250))
    within = np.zeros(picture.shape[:2], np.uint8)
    cv2.fillConvexPoly(within, outline, 1)
    walls = np.zeros_like(within)
    walls[:, 250::150] = walls[200::120] = 1
    walls = cv2.dilate(walls, np.ones((5, 5), np.uint8))
    picture[(walls > 0) & (within > 0)] = 20
    cv2.polylines(picture, [outline], True, (20, 20, 20), 6)
    assert not view_of(picture).is_straightened


def test_a_picture_that_was_cut_at_its_walls_is_given_paper():
    sheet = drawn_by_hand(np.random.default_rng(3))
    whole, H = on_paper(sheet, np.eye(3))
    assert whole.shape == sheet.shape
    np.testing.assert_array_equal(H, np.eye(3))
    part, H = on_paper(sheet[138:764, 140:1062], cut_from(140, 138))
    by = round(0.06 * 922)
    assert part.shape == (626 + 2 * by, 922 + 2 * by, 3)
    left, top = (140 - by, 138 - by)
    np.testing.assert_array_equal(map_points(H, np.array([[left, top]])), [[0.0, 0.0]])
    np.testing.assert_array_equal(part[by:-by, by:-by], sheet[138:764, 140:1062])
    assert (part[:by] == 250).all()
    assert (part[:, -by:] == 250).all()


def test_a_sheet_on_a_table_is_given_no_paper():
    table = np.full((1200, 1500, 3), TABLE, np.uint8)
    table[120:1020, 140:1340] = drawn_by_hand(np.random.default_rng(3))
    part, _ = on_paper(table, np.eye(3))
    assert part.shape == table.shape
