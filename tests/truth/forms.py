"""Closed forms of irradiance: lux, RGB, at a point of a surface with unit normal. Metres, candela, nits.

All are calls (point, normal) -> array of 3; `mean`, where a form has it, is that of a plane quadrilateral.
"""
import math

import numpy as np


def unit(v):
    v = np.asarray(v, float)
    return v / np.linalg.norm(v)


def rgb(value):
    return np.broadcast_to(np.asarray(value, float), 3)


def clip(polygon, normal, offset):
    """The part of a polygon where normal . v > offset (Sutherland and Hodgman 1974)."""
    kept, heights = [], [float(np.dot(normal, v)) - offset for v in polygon]
    for i, v in enumerate(polygon):
        w, a, b = polygon[i - 1], heights[i - 1], heights[i]
        if (a > 0) != (b > 0):
            kept.append(w + (v - w) * (a / (a - b)))
        if b > 0:
            kept.append(v)
    return kept


def clip_to_view(polygon, point, window):
    """The part of a polygon that a point sees through a convex window."""
    middle = np.mean(window, 0) - point
    for i in range(len(window)):
        side = np.cross(window[i - 1] - point, window[i] - point)
        side = side if np.dot(side, middle) > 0 else -side
        polygon = clip(polygon, side, float(np.dot(side, point))) if np.any(side) else polygon
    # What lies before the window is not seen through it.
    plane = np.cross(window[1] - window[0], window[2] - window[1])
    plane = plane if np.dot(plane, middle) > 0 else -plane
    return clip(polygon, plane, float(np.dot(plane, window[0])))


def factor(polygon, point, normal):
    """Form factor of a polygon from a point (Lambert 1760), either of its sides, clipped to the horizon."""
    polygon = clip(polygon, normal, float(np.dot(normal, point)))
    rays = [v - point for v in polygon]
    total = 0.0
    for i, b in enumerate(rays):
        a = rays[i - 1]
        across = np.cross(a, b)
        size = np.linalg.norm(across)
        if size > 0:
            total += math.atan2(size, float(np.dot(a, b))) * float(np.dot(across, normal)) / size
    return abs(total) / (2 * math.pi)


def front_of(polygon, point):
    return np.dot(np.cross(polygon[1] - polygon[0], polygon[2] - polygon[1]), point - polygon[0]) > 0


class Lamp:
    """A convex polygon of uniform luminance, front counter-clockwise. through: convex windows, all of which its light passes;
    behind: convex polygons that hide it, apart from each other as seen from every receiver."""

    def __init__(self, polygon, nits, two_sided=False, through=(), behind=()):
        self.polygon, self.nits, self.two_sided = [np.asarray(v, float) for v in polygon], rgb(nits), two_sided
        self.through = [np.asarray(w, float) for w in through]
        self.behind = [np.asarray(w, float) for w in behind]

    def __call__(self, point, normal):
        if not self.two_sided and not front_of(self.polygon, point):
            return np.zeros(3)
        seen = self.polygon
        for window in self.through:
            seen = clip_to_view(seen, point, window)
        share = factor(seen, point, normal) if len(seen) > 2 else 0.0
        for blocker in self.behind:
            hidden = clip_to_view(seen, point, blocker)
            share -= factor(hidden, point, normal) if len(hidden) > 2 else 0.0
        return math.pi * share * self.nits


class Sky:
    """Uniform; blockers: convex black polygons, apart from each other as seen from every receiver."""

    def __init__(self, nits, blockers=()):
        self.nits, self.blockers = nits, [[np.asarray(v, float) for v in b] for b in blockers]

    def __call__(self, point, normal):
        return rgb(math.pi * self.nits * (1 - sum(factor(b, point, normal) for b in self.blockers)))


class Point:
    """A point light, with range and cone as KHR_lights_punctual says."""

    def __init__(self, position, candela, reach=0, direction=None, inner=0, outer=0):
        self.position, self.candela, self.reach = np.asarray(position, float), rgb(candela), reach
        self.direction = None if direction is None else unit(direction)
        self.inner, self.outer = inner, outer

    def __call__(self, point, normal):
        to = self.position - point
        d = np.linalg.norm(to)
        value = max(0.0, float(np.dot(to, normal))) / d ** 3
        if self.reach:
            value *= min(max(1 - (d / self.reach) ** 4, 0), 1)
        if self.direction is not None:
            angle = math.atan2(np.linalg.norm(np.cross(-to, self.direction)), float(np.dot(-to, self.direction)))
            value *= self.cone(angle) ** 2
        return value * self.candela

    def cone(self, angle):
        if self.inner == self.outer:
            return float(angle < self.outer)
        # 1 - cos, without cancellation.
        dip = [2 * math.sin(a / 2) ** 2 for a in (angle, self.inner, self.outer)]
        return min(max((dip[2] - dip[0]) / (dip[2] - dip[1]), 0), 1)

    def mean(self, corners, normal):
        """Over a quadrilateral that faces the light: its solid angle over its area; None for lights with range or cone."""
        if self.reach or self.direction is not None:
            return None
        angle = sum(solid_angle(corners[0], corners[i], corners[i + 1], self.position) for i in (1, 2))
        area = sum(np.linalg.norm(np.cross(corners[i] - corners[0], corners[i + 1] - corners[0])) / 2 for i in (1, 2))
        return angle / area * self.candela


def solid_angle(a, b, c, point):
    """Of a triangle (Van Oosterom and Strackee 1983)."""
    a, b, c = (np.asarray(v) - point for v in (a, b, c))
    la, lb, lc = map(np.linalg.norm, (a, b, c))
    return 2 * math.atan2(abs(float(np.dot(a, np.cross(b, c)))),
                          la * lb * lc + np.dot(a, b) * lc + np.dot(b, c) * la + np.dot(c, a) * lb)


class Sun:
    """blockers: convex polygons; what they shade gets `passes` of the light, per channel."""

    def __init__(self, direction, lux, blockers=(), passes=0.0):
        self.direction, self.lux, self.passes = unit(direction), rgb(lux), rgb(passes)
        self.blockers = [np.asarray(b, float) for b in blockers]

    def __call__(self, point, normal):
        share = np.ones(3)
        for b in self.blockers:
            if hits(point, -self.direction, b):
                share = share * self.passes
        return max(0.0, -float(np.dot(self.direction, normal))) * self.lux * share


def hits(point, direction, polygon):
    plane = np.cross(polygon[1] - polygon[0], polygon[2] - polygon[1])
    across = np.dot(plane, direction)
    t = np.dot(plane, polygon[0] - point) / across if across else -1
    where = point + t * direction
    sides = [np.dot(np.cross(polygon[i] - polygon[i - 1], where - polygon[i - 1]), plane) for i in range(len(polygon))]
    return t > 0 and (all(s >= 0 for s in sides) or all(s <= 0 for s in sides))


class Constant:
    def __init__(self, lux):
        self.lux = rgb(lux)

    def __call__(self, point, normal):
        return self.lux


class FaceMean:
    """Of a form, over the quadrilateral that a point lies in the middle of, by the midpoints of a grid."""

    def __init__(self, form, faces, grid=64):
        self.form, self.faces, self.grid = form, [np.asarray(f, float) for f in faces], grid

    def __call__(self, point, normal):
        a, b, c, d = min(self.faces, key=lambda f: np.linalg.norm(np.mean(f, 0) - point))
        exact = self.form.mean([a, b, c, d], normal) if hasattr(self.form, "mean") else None
        if exact is not None:
            return exact
        steps = (np.arange(self.grid) + 0.5) / self.grid
        return np.mean([self.form((a * (1 - u) + b * u) * (1 - v) + (d * (1 - u) + c * u) * v, normal)
                        for u in steps for v in steps], 0)


class Sum:
    def __init__(self, *forms):
        self.forms = forms

    def __call__(self, point, normal):
        return sum((form(point, normal) for form in self.forms), np.zeros(3))

    def mean(self, corners, normal):
        parts = [form.mean(corners, normal) if getattr(form, "mean", None) else None for form in self.forms]
        return None if any(p is None for p in parts) else sum(parts)


class Scaled:
    """A form seen through something that lets a share of each channel through."""

    def __init__(self, form, share):
        self.form, self.share = form, rgb(share)

    def __call__(self, point, normal):
        return self.form(point, normal) * self.share


def cells(corner, along, across, nits, two_sided=False, **more):
    """Lamps of a rectangle's cells: nits[row][column], columns along `along`, rows along `across`; the front is that of
    along x across. More: of Lamp."""
    corner, along, across = (np.asarray(v, float) for v in (corner, along, across))
    rows, columns = len(nits), len(nits[0])
    lamps = []
    for j in range(rows):
        for i in range(columns):
            if np.any(nits[j][i]):
                o, u, v = corner + along * (i / columns) + across * (j / rows), along / columns, across / rows
                lamps.append(Lamp([o, o + u, o + u + v, o + v], nits[j][i], two_sided, **more))
    return Sum(*lamps)


def linear(byte):
    """sRGB byte to linear (IEC 61966-2-1)."""
    c = byte / 255
    return c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4
