"""Labelled cases: drawings have joints that open outward, and their shells show every front."""

import numpy as np
import pytest

from benchmarks.articulate.draw import KINDS, draw
from benchmarks.articulate.labelled import fused


def test_drawn_fronts_open_outward(subtests: pytest.Subtests) -> None:
    for kind in list(KINDS):
        with subtests.test(kind=kind):
            for index in range(6):
                mesh = draw(kind, 5, index)
                assert mesh.truth["parts"]
                for row in mesh.truth["parts"]:
                    joint = row["joint"]
                    cloud = mesh.points[mesh.faces[mesh.part == row["id"]]].reshape(-1, 3)
                    assert len(cloud), row["name"]
                    assert np.linalg.norm(joint["axis"]) == pytest.approx(1.0)
                    is_front = row["type"] in ("door", "drawer", "lid")
                    if is_front and joint["range"][0] == 0.0 and joint["type"] == "revolute":
                        arm = cloud.mean(axis=0) - np.array(joint["origin"])
                        way = np.cross(joint["axis"], arm)
                        middle = (mesh.points.min(axis=0) + mesh.points.max(axis=0)) / 2
                        assert way @ (cloud.mean(axis=0) - middle) > 0 or kind == "laptop"
                    if row["type"] == "drawer":
                        np.testing.assert_allclose(joint["axis"], [0, -1, 0], atol=1e-9)


def test_fused_shell_shows_every_front() -> None:
    mesh, shell = fused(draw("cabinet", 2, 13))
    parts = mesh.truth["parts"]
    assert {row["type"] for row in parts} == {"door", "drawer"}
    assert all(row["visible"] > 0.1 for row in parts)
    assert {row["id"] for row in parts} <= set(shell.part.tolist())
