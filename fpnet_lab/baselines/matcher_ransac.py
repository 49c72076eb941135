# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The paper's pose estimate from matches: RANSAC on centroids, without the rasters."""

from __future__ import annotations

import cv2
import numpy as np

from fpnet_core.geometry import Affine2D
from fpnet_core.matches import MatchResult
from fpnet_core.types import RegionGraph
from fpnet_lab.baselines.answer import Answer

INLIER_M = 0.5
"""Largest distance of an inlier; the paper uses eight pixels of 5 cm, 0.4 m. Chosen."""

# Chosen, not measured:
MIN_INLIERS = 3
_CONFIDENCE = 0.99


def place_by_ransac(plan: RegionGraph, sub: RegionGraph, match: MatchResult) -> Answer | None:
    """
    Return the similarity with the most inlier centroids; None for fewer than two matches.

    It is accepted with three or more inliers; the score is the share of inliers.
    """
    if len(match.pairs) < 2:
        return None
    plan_xy = np.array([plan.regions[i].centroid for i in match.pairs[:, 0]])
    sub_xy = np.array([sub.regions[j].centroid for j in match.pairs[:, 1]])
    matrix, inliers = cv2.estimateAffinePartial2D(
        sub_xy,
        plan_xy,
        method=cv2.RANSAC,
        ransacReprojThreshold=INLIER_M,
        confidence=_CONFIDENCE,
    )
    if matrix is None or abs(np.linalg.det(matrix[:, :2])) < np.finfo(np.float32).eps:
        return None
    count = int(np.count_nonzero(inliers))
    score = count / len(match.pairs)
    return Answer(Affine2D.from_matrix(matrix), score, is_accepted=count >= MIN_INLIERS)
