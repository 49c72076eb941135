# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Generation of a sheet from a seed: the drawing, its picture and ground truth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.pixels import growth_at, map_points
from fpnet_lab.sim.drawn.render import paint_rings
from fpnet_lab.sim.drawn.styles import MAX_SEED
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.plans.gates import reaching, with_gates
from fpnet_lab.sim.plans.special import generate_special_plan
from fpnet_lab.sim.population.floors import room_rings
from fpnet_lab.sim.sheets.artwork import Array, Artwork, box_ring
from fpnet_lab.sim.sheets.compose import Beside, compose
from fpnet_lab.sim.sheets.looks import Look, SheetKind, Trait, draw_look, with_room_for
from fpnet_lab.sim.sheets.painting import rasterise
from fpnet_lab.sim.sheets.paper import weather
from fpnet_lab.sim.sheets.picture_effects import marked, taken
from fpnet_lab.sim.sheets.storeys import PlacedStorey, drawn_wall_m
from fpnet_lab.sim.sheets.surround import surrounded
from fpnet_lab.sim.types import BuildingPlan

MAX_ROOMS = 60
MAX_AREA_M2 = 2500.0
"""Largest storey that fits on a single sheet. Chosen."""

_SLOW = {Trait.FURNITURE, Trait.TILES, Trait.TEXTS, Trait.FILLS, Trait.SITE}
_WOBBLE = 0.4  # displacement of lines as a share of the wall thickness; chosen
_USUAL_PX, _LARGE_PX, _USUAL_SHARE = (850.0, 1900.0), (1800.0, 3500.0), 0.85  # chosen
_IN_PIECES = 'disconnected'
_JPEG_QUALITY = (45, 92)  # chosen
_PAPER_MEDIA = (SheetKind.SCAN, SheetKind.PHONE)
_SCREEN_SHARE = 0.55  # share of varied sheets without a print; chosen
_SPECIAL_SHARE, _HOME_SHARE = 0.5, 0.12  # shares of varied sheets' storeys; chosen
_KIND_NUMBERS = {kind: number for number, kind in enumerate(SheetKind)}


@dataclass(frozen=True, eq=False)
class Sheet:
    """
    A generated sheet and its ground truth.

    Parameters
    ----------
    kind, seed : arguments that reproduce the sheet
    look : drawing style
    artwork : all marks, frame ``page``
    storeys : storeys with their poses on the page
    beside : page elements beside the building
    pixels : (H, W, 3), or (H, W, 4) if the paper is transparent, uint8, row 0 at the top
    H_image_page : (3, 3)
        Homography from page metres to pixels (x right, y down, integers at pixel centres).
    jpeg_quality : quality if stored as JPEG
    medium : ``scan`` or ``phone`` for a picture of paper, else None
    """

    kind: SheetKind
    seed: int
    look: Look
    artwork: Artwork
    storeys: tuple[PlacedStorey, ...]
    beside: tuple[Beside, ...]
    pixels: NDArray[np.uint8]
    H_image_page: Array
    jpeg_quality: int
    medium: SheetKind | None = None

    @property
    def is_photo(self) -> bool:
        """Return whether it is a picture of paper, which is usually stored as JPEG."""
        return self.medium is not None

    def H_image_building(self, storey: int = 0) -> Array:
        """Return the homography (3, 3) from a storey's building metres to pixels."""
        T = self.storeys[storey].T_page_building
        return np.asarray(self.H_image_page @ T.matrix)

    def resolution_m(self, storey: int = 0) -> float:
        """Return the edge of a pixel [m] at the centre of a storey."""
        H = self.H_image_building(storey)
        middle = self.storeys[storey].plan.extent.mean(axis=0)
        return 1.0 / growth_at(H, middle)

    def room_labels(self) -> NDArray[np.int32]:
        """Return true room labels (H, W): 1 and up across all storeys, 0 outside."""
        labels = np.zeros(self.pixels.shape[:2], np.int32)
        number = 0
        for index, storey in enumerate(self.storeys):
            H = self.H_image_building(index)
            for rings in room_rings(storey.plan):
                number += 1
                for ring in rings:
                    paint_rings(labels, [map_points(H, ring)], number)
        return labels

    def truth(self) -> dict[str, Any]:
        """Return the ground truth as plain values for JSON."""
        return {
            'kind': self.kind.value,
            'seed': self.seed,
            'traits': sorted(trait.value for trait in self.look.traits),
            'walls': self.look.walls,
            'doors': self.look.doors,
            'drawn_at': f'1:{self.look.denominator}',
            'size_px': [self.pixels.shape[1], self.pixels.shape[0]],
            'resolution_m': self.resolution_m(),
            'rooms': sum(len(room_rings(storey.plan)) for storey in self.storeys),
            'H_image_page': self.H_image_page.tolist(),
            'storeys': [self._storey_truth(index) for index in range(len(self.storeys))],
            'beside': [
                {
                    'what': item.what,
                    'outline_px': map_points(self.H_image_page, box_ring(item.box)).tolist(),
                }
                for item in self.beside
            ],
        }

    def _storey_truth(self, index: int) -> dict[str, Any]:
        plan = self.storeys[index].plan
        return {
            'family': plan.family,
            'resolution_m': self.resolution_m(index),
            'H_image_building': self.H_image_building(index).tolist(),
            'T_page_building': self.storeys[index].T_page_building.matrix.tolist(),
            'rooms': [[ring.tolist() for ring in rings] for rings in room_rings(plan)],
            'doors': [door.ends.tolist() for door in plan.doors if not door.is_open],
        }


def draw_sheet(seed: int, kind: SheetKind | str, plan: BuildingPlan | None = None) -> Sheet:
    """
    Generate a sheet of a kind; equal seeds give equal sheets.

    Parameters
    ----------
    seed : seed of the whole sheet
    kind : origin of the sheet
    plan : the storey to draw; None generates one
    """
    kind = SheetKind(kind)
    rng = np.random.default_rng([seed, _KIND_NUMBERS[kind]])
    first = plan or _storey_of(rng, kind)
    extent = first.extent[1] - first.extent[0]
    look = draw_look(rng, kind, float(extent.max()))
    is_double = plan is None and Trait.TWO_STOREYS in look.traits
    plans: tuple[BuildingPlan, ...] = (first,)
    if is_double:
        plans = (first, _storey_of(rng, kind))
    layout_seed = int(rng.integers(MAX_SEED))
    layout = compose(plans, _sized(look), np.random.default_rng(layout_seed), is_blank=True)
    look = with_room_for(look, max(layout.artwork.size_m))
    look = _coarser(look, max(layout.artwork.size_m))
    plans = tuple(reaching(storey, outer_wall_m(storey, look)) for storey in plans)
    layout = compose(plans, look, np.random.default_rng(layout_seed))
    pixels = rasterise(layout.artwork, look.resolution_m)
    H = _image_from_page(pixels.shape[0], look.resolution_m)
    if layout.artwork.paper is not None:
        pixels = pixels[..., :3]
    if look.surround is not None and layout.artwork.paper is not None:
        outer_m = max(outer_wall_m(storey, look) for storey in plans)
        pixels, H = surrounded(pixels, H, layout.storeys, look, outer_m)
        wobble_px = _WOBBLE * min(drawn_wall_m(storey, look) for storey in plans)
        pixels = marked(pixels, look.surround, wobble_px * growth_at(H, np.zeros(2)))
    medium = _medium(kind, artwork_has_paper=layout.artwork.paper is not None, rng=rng)
    if medium is not None:
        pixels, H_image_drawn = weather(pixels, medium, rng)
        H = H_image_drawn @ H
    if look.surround is not None and layout.artwork.paper is not None:
        pixels, H_image_drawn = taken(pixels, look.surround)
        H = H_image_drawn @ H
    quality = int(rng.integers(*_JPEG_QUALITY))
    return Sheet(
        kind,
        seed,
        look,
        layout.artwork,
        layout.storeys,
        layout.beside,
        pixels,
        H,
        quality,
        medium,
    )


def _sized(look: Look) -> Look:
    """Return a look of equal paper size; varied sheets omit slow components."""
    if look.surround is None:
        return look
    return replace(look, traits=look.traits - _SLOW, interior=None)


def _coarser(look: Look, long_side_m: float) -> Look:
    """Return a varied look with fewer pixels in most cases, as users' pictures are small."""
    if look.surround is None:
        return look
    rng = np.random.default_rng([look.surround.seed, 3])
    low, high = np.log(_USUAL_PX if rng.random() < _USUAL_SHARE else _LARGE_PX)
    pixels = float(np.exp(rng.uniform(low, high)))
    return replace(look, resolution_m=max(look.resolution_m, long_side_m / pixels))


def _medium(
    kind: SheetKind, *, artwork_has_paper: bool, rng: np.random.Generator
) -> SheetKind | None:
    """Return the medium of a picture of paper, or None for a sheet that is not printed."""
    if kind in _PAPER_MEDIA:
        return kind
    if kind is not SheetKind.VARIED or not artwork_has_paper or rng.random() < _SCREEN_SHARE:
        return None
    return _PAPER_MEDIA[int(rng.integers(len(_PAPER_MEDIA)))]


def _storey_of(rng: np.random.Generator, kind: SheetKind) -> BuildingPlan:
    """Sample a storey; varied sheets include special buildings, homes and outside doors."""
    if kind is not SheetKind.VARIED:
        return _generate(rng)
    pick = rng.random()
    if pick < _SPECIAL_SHARE:
        return generate_special_plan(rng)
    if pick < _SPECIAL_SHARE + _HOME_SHARE:
        plan = generate_plan(rng, families=('home', 'practice', 'house'), min_rooms=2)
    else:
        plan = _generate(rng)
    return with_gates(rng, plan, int(rng.integers(0, 4)))


def _generate(rng: np.random.Generator) -> BuildingPlan:
    """Sample a connected storey, as two separate wings look like two storeys on a sheet."""
    while True:
        plan = generate_plan(rng, max_rooms=MAX_ROOMS, max_area_m2=MAX_AREA_M2)
        if plan.family != _IN_PIECES:
            return plan


def outer_wall_m(plan: BuildingPlan, look: Look) -> float:
    """Return the drawn thickness of outer walls [m]."""
    outer_m = max(plan.wall_m, drawn_wall_m(plan, look))
    return outer_m if look.walls == 'thin' else max(outer_m, look.outer_m)


def _image_from_page(rows: int, resolution_m: float) -> Array:
    """Return the map (3, 3) from page metres to pixels of the drawn sheet."""
    per_m = 1.0 / resolution_m
    return np.array([[per_m, 0.0, -0.5], [0.0, -per_m, rows - 0.5], [0.0, 0.0, 1.0]])
