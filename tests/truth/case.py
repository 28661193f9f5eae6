"""A scene and the light that it must have."""
import math
import pathlib
import sys

import numpy as np

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parent.parent / part) for part in ("hard_cases", "peers")]
import gltf_file  # noqa: E402
from made_scene import MadeScene, box, quad  # noqa: E402, F401

from forms import unit  # noqa: E402

UP = (0, 1, 0)


class Case:
    """light: form of all irradiance, in the scene's own coordinates; receivers: (point, normal). over_texels: what a perfect
    lightmap shows there (means over texels, bilinear) is asked for instead of the form at the point, for light that is uneven
    within a texel. placed: the root's 4 x 4 matrix. sky: nits, or rows of an equirectangular map. density: texels a metre of
    the scene's own coordinates; 0: lightbatch's own."""

    def __init__(self, name, scene, light, receivers, tolerance=0.01, sky=0, density=20, over_texels=False, placed=None):
        self.name, self.scene, self.light, self.tolerance, self.sky = name, scene, light, tolerance, sky
        self.receivers = [(np.asarray(p, float), unit(n)) for p, n in receivers]
        self.density, self.over_texels = density, over_texels
        self.matrix = np.eye(4) if placed is None else np.asarray(placed, float)
        if placed is not None:
            scene.root["matrix"] = [float(v) for v in self.matrix.T.ravel()]

    def scale(self):
        return abs(np.linalg.det(self.matrix[:3, :3])) ** (1 / 3)

    def to_world(self, point, normal):
        turn = self.matrix[:3, :3]
        return turn @ point + self.matrix[:3, 3], unit(np.linalg.inv(turn).T @ normal)

    def from_world(self, points):
        return (np.asarray(points) - self.matrix[:3, 3]) @ np.linalg.inv(self.matrix[:3, :3]).T


def placement(scale=1.0, turn=(0, 0, 0, 1), move=(0, 0, 0), mirror=False):
    matrix = gltf_file.trs(move, turn, [scale, scale, scale])
    return matrix @ np.diag([-1, 1, 1, 1]) if mirror else matrix


def turned(axis, degrees):
    """Quaternion."""
    half = math.radians(degrees) / 2
    return [*(math.sin(half) * unit(axis)), math.cos(half)]


def towards(direction):
    """Rotation that turns -Z to a direction: of lamps."""
    d = unit(direction)
    axis, cosine = np.cross((0, 0, -1), d), -d[2]
    if cosine < -0.999999:
        return [0, 1, 0, 0]
    return [float(v) for v in unit([*axis, 1 + cosine])]


def rectangle(middle, along, across):
    """Corners; along and across from edge to edge, the front is that of along x across."""
    m, u, v = (np.asarray(x, float) for x in (middle, along, across))
    return [tuple(float(x) for x in m + a * u / 2 + b * v / 2) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]


def polygon(middle, along, across, sides, radius):
    """A regular polygon in the plane of two unit vectors, front that of along x across."""
    m, u, v = (np.asarray(x, float) for x in (middle, along, across))
    return [tuple(m + radius * (math.cos(a) * u + math.sin(a) * v)) for a in (2 * math.pi * i / sides for i in range(sides))]


def fan(corners):
    return [(corners[0], corners[i], corners[i + 1]) for i in range(1, len(corners) - 1)]


def floor_at(height=0.0, side=4.0):
    """Corners of a floor that faces up."""
    return rectangle((0, height, 0), (0, 0, side), (side, 0, 0))


def with_floor(side=4.0, height=0.0, **material):
    scene = MadeScene()
    scene.mesh(fan(floor_at(height, side)), scene.material(**material))
    return scene


SPREAD = ((0, 0), (0.13, 0.07), (-0.31, 0.22), (0.41, -0.12), (-0.05, -0.37), (0.27, 0.33), (-0.42, -0.41), (0.44, 0.43))


def on_floor(side=4.0, height=0.0, spread=SPREAD):
    return [((side * x, height, side * z), UP) for x, z in spread]
