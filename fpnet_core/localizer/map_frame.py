# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Frame ``map``: the floorplan at its true scale, for users of rigid transforms.

A placement ``A_plan_odom = (P R, t)`` has a symmetric factor ``P``, the scale error of the
drawing. ``map`` is the drawing corrected by it about the drawing's origin: ``A_map_plan = P^-1``
and ``T_map_odom = (R, P^-1 t)``. If the drawing's scale is trusted, ``map`` is ``plan``.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import HintError
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.localizer.hint import PoseHint
from fpnet_core.types import GridMap, LocalizerOutput

# Estimates of the scale vary slightly between updates. ``map`` keeps the drawing's size until a
# corner of it would move by more than this [m]. Chosen.
_HOLD_M = 0.25


@dataclass(frozen=True, eq=False)
class Located:
    """
    Pose of a robot by one output, in all frames.

    ``T_plan_base`` is in the floorplan grid's own frame and nominal metres; ``cov (3, 3)`` over
    x, y [m] and yaw [rad] is that of ``T_map_base``, None if unknown.
    """

    T_plan_base: SE2
    T_map_base: SE2
    T_map_odom: SE2
    cov: NDArray[np.float64] | None


@dataclass(frozen=True, eq=False)
class MapFrame:
    """
    Frame ``map`` of one floorplan.

    Parameters
    ----------
    plan
        Floorplan; a new scale is applied if it moves its corners enough.
    plan_id, map_id
        Frame ids of the floorplan's own frame and of this one.
    A_map_plan
        About the drawing's origin.
    """

    plan: GridMap
    plan_id: str = 'plan'
    map_id: str = 'map'
    A_map_plan: Affine2D = field(default_factory=Affine2D.identity)

    @property
    def is_trusted(self) -> bool:
        """Whether the drawing's scale is trusted: it came in the map's own frame."""
        return self.plan_id == self.map_id

    def followed(self, A_plan_odom: Affine2D) -> MapFrame:
        """Return the frame with the scale of a placement; itself if the change is small."""
        if self.is_trusted:
            return self
        A_map_plan = Affine2D(A_plan_odom.stretch, np.zeros(2)).inv()
        rows, columns = self.plan.shape
        corners = self.plan.rc_to_xy([[0, 0], [0, columns], [rows, 0], [rows, columns]])
        moved = A_map_plan.apply(corners) - self.A_map_plan.apply(corners)
        if np.linalg.norm(moved, axis=1).max() <= _HOLD_M:
            return self
        return replace(self, A_map_plan=A_map_plan)

    def located(
        self, output: LocalizerOutput, T_odom_base: NDArray[np.float64], stamp_ns: int
    ) -> Located | None:
        """Return the pose of ``base`` at a scan, by one output; None unless LOCALIZED."""
        T_plan_base = output.pose(T_odom_base)
        if T_plan_base is None or output.A_plan_odom is None:
            return None
        base = SE2.from_matrix4(T_odom_base)
        T_map_odom = self.T_map_odom(output.A_plan_odom, base.translation)
        cov = output.covariance_at(T_odom_base, stamp_ns)
        cov = None if cov is None else self.covariance(cov)
        return Located(T_plan_base, T_map_odom @ base, T_map_odom, cov)

    def T_map_odom(self, A_plan_odom: Affine2D, xy_odom: NDArray[np.float64]) -> SE2:
        """
        Return the rigid transform that is exact at the robot, ``xy_odom (2,)``.

        ``A_map_plan @ A_plan_odom`` is rigid except for the part of the newest scale not applied.
        """
        A_map_odom = self.A_map_plan @ A_plan_odom
        yaw = A_map_odom.heading
        turned = SE2.from_xy_yaw(0.0, 0.0, yaw)
        x, y = A_map_odom.apply(xy_odom) - turned.apply(xy_odom)
        return SE2.from_xy_yaw(float(x), float(y), yaw)

    def to_plan(self, T_map_body: SE2) -> SE2:
        """Return a pose given in ``map`` in ``plan``, nominal metres."""
        A_plan_map = self.A_map_plan.inv()
        x, y = A_plan_map.apply(T_map_body.translation)
        return SE2.from_xy_yaw(float(x), float(y), A_plan_map.apply_yaw(T_map_body.yaw))

    def hint(
        self,
        T_frame_base: SE2,
        frame_id: str,
        cov: NDArray[np.float64],
        T_odom_base: NDArray[np.float64],
    ) -> PoseHint:
        """
        Return the hint that the robot is at ``T_frame_base`` for the localizer.

        ``cov (3, 3)`` is of x, y [m] and yaw [rad]; ``T_odom_base (4, 4)`` is the pose of the
        robot by odometry at that time.

        Raises
        ------
        HintError
            If the frame is neither the floorplan's nor the map's, or the pose is off the drawing.
        """
        if frame_id not in (self.map_id, self.plan_id):
            known = ' or '.join(repr(name) for name in dict.fromkeys((self.map_id, self.plan_id)))
            raise HintError(f'its frame is {frame_id!r}, expected {known}')
        is_in_plan = frame_id == self.plan_id
        T_plan_base = T_frame_base if is_in_plan else self.to_plan(T_frame_base)
        sigma = np.sqrt(np.maximum(np.diag(cov), 0.0))
        hint = PoseHint(
            T_plan_base, SE2.from_matrix4(T_odom_base), float(sigma[:2].max()), float(sigma[2])
        )
        if (off_m := self._off_plan_m(T_plan_base)) > hint.radius_m:
            x, y = T_frame_base.translation
            raise HintError(f'({x:.1f}, {y:.1f}) is {off_m:.0f} m outside the floorplan')
        return hint

    def _off_plan_m(self, T_plan_base: SE2) -> float:
        """Return the distance of a place from the drawing [m], 0 inside."""
        at = self.plan.xy_to_rc(T_plan_base.translation)
        inside = np.clip(at, 0.0, self.plan.shape)
        return float(np.linalg.norm(at - inside)) * self.plan.resolution

    def covariance(self, cov_plan: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return a covariance ``(3, 3)`` of x, y [m] and yaw [rad] on the plan in ``map``."""
        to_map = np.eye(3)
        to_map[:2, :2] = self.A_map_plan.linear
        return np.asarray(to_map @ cov_plan @ to_map.T, dtype=np.float64)
