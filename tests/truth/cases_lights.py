"""Points, spots and suns over plain receivers."""
import math

import numpy as np

from case import UP, Case, MadeScene, box, fan, floor_at, on_floor, placement, rectangle, towards, turned, with_floor
from forms import FaceMean, Lamp, Point, Sum, Sun

PLACES = {
    "": None, "tiny": placement(1e-3), "huge": placement(1e4), "far": placement(move=(7e5, -3e5, 9e5)),
    "turned": placement(turn=turned((1, 2, 3), 70)), "mirrored": placement(turn=turned((1, 0, 2), 40), mirror=True)}


def near(spread, around, size):
    return [((around[0] + size * x, 0, around[1] + size * z), UP) for x, z in spread]


def points():
    spread = ((0, 0), (0.5, 0.2), (-0.7, 0.9), (2.1, -1.3), (-3.1, -2.9), (4.4, 3.7))
    for height in (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 10.0):
        for name, at in (("centre", (0.025, 0.025)), ("border", (0.5, -0.4)), ("off", (0.337, 0.211))):
            if name != "off" and height not in (0.001, 0.01, 0.1):
                continue
            scene = with_floor()
            scene.light("point", 100, translation=[at[0], height, at[1]])
            yield Case(f"point/{height:g}m_{name}", scene, Point((at[0], height, at[1]), 100),
                       near(spread, at, max(0.08, min(height, 0.35))), over_texels=True)
    for height in (0.001, 0.02):  # lightbatch's own density
        scene = with_floor()
        scene.light("point", 100, translation=[0.3, height, 0.2])
        yield Case(f"point/{height:g}m_default", scene, Point((0.3, height, 0.2), 100), near(spread, (0.3, 0.2), 0.02),
                   over_texels=True, density=0)
    for name, place in PLACES.items():
        if not name:
            continue
        size = 1e-3 if name == "tiny" else 1e4 if name == "huge" else 1
        scene = MadeScene()
        floor, wall = floor_at(), rectangle((-2, 1, 0), (0, 2, 0), (0, 0, 4))
        scene.mesh(fan(floor) + fan(wall), scene.material())
        lamps = [((0.4, 1.1, 0.3), (50, 40, 10)), ((-1.5, 0.4, -1), (7, 8, 9))]
        for at, candela in lamps:
            scene.light("point", max(candela) * size ** 2, {"color": [c / max(candela) for c in candela]},
                        translation=list(at))
        on_wall = [((-2, 0.3, 0.7), (1, 0, 0)), ((-2, 1.7, -1.3), (1, 0, 0)), ((-2, 0.45, -0.9), (1, 0, 0))]
        yield Case(f"point/{name}", scene, Sum(*(Point(a, c) for a, c in lamps)), on_floor() + on_wall, placed=place,
                   over_texels=True)
    for reach in (0.8, 1.5, 2.5, 20):
        scene = with_floor()
        scene.light("point", 100, {"range": reach}, translation=[0.1, 0.6, 0.1])
        yield Case(f"range/{reach:g}m", scene, Point((0.1, 0.6, 0.1), 100, reach), on_floor(), over_texels=True)
    scene = with_floor()  # more lamps than are asked one by one
    lamps = [((0.35 * i - 1.6, 0.5 + 0.1 * ((3 * i + j) % 5), 0.4 * j - 1.5), 1 + (i * j) % 4) for i in range(10) for j in range(8)]
    for at, candela in lamps:
        scene.light("point", candela, translation=list(at))
    yield Case("point/eighty", scene, Sum(*(Point(a, c) for a, c in lamps)), on_floor(), over_texels=True)
    scene = with_floor()  # ... of which the weakest is near
    lamps = [((1.5 - 0.1 * i, 3, 1.5), 500) for i in range(20)] + [((-1.7, 0.05, -1.7), 0.02)]
    for at, candela in lamps:
        scene.light("point", candela, translation=list(at))
    yield Case("point/candle_among_twenty", scene, Sum(*(Point(a, c) for a, c in lamps)),
               on_floor() + near(spread[:4], (-1.7, -1.7), 0.06), over_texels=True)


def spot(name, position, target, inner, outer, receivers, candela=1000, side=4.0, density=20, reach=0, **more):
    direction = np.subtract(target, position)
    scene = with_floor(side)
    properties = {"spot": {"innerConeAngle": inner, "outerConeAngle": outer}}
    if reach:
        properties["range"] = reach
    scene.light("spot", candela, properties, translation=list(position), rotation=towards(direction))
    return Case(f"spot/{name}", scene, Point(position, candela, reach, direction, inner, outer), receivers, density=density,
                over_texels=True, **more)


def spots():
    down, above = (0.1, 0, 0.1), (0.1, 2, 0.1)
    yield spot("wide", above, down, 0.3, 0.9, on_floor())
    yield spot("default_angles", above, down, 0, math.pi / 4, on_floor())
    yield spot("half_space", above, down, 0.5, math.pi / 2, on_floor())
    yield spot("slanted", (1.5, 1.2, -1.5), (-0.5, 0, 0.5), 0.2, 0.5, on_floor())
    yield spot("equal_cones", above, down, 0.4, 0.4, on_floor(spread=((0, 0), (0.1, 0.1), (0.2, 0.05), (0.4, 0.4))))
    yield spot("almost_equal_cones", above, down, 0.3999, 0.4, on_floor(spread=((0, 0), (0.1, 0.1), (0.2, 0.05), (0.4, 0.4))))
    yield spot("with_range", above, down, 0.3, 0.9, on_floor(), reach=2.6)
    for outer in (0.05, 0.02, 0.01, 0.004, 0.002, 0.001):
        for name, inner in (("", 0.0), ("_inner", 0.6 * outer), ("_equal", outer)):
            if name == "_equal" and outer not in (0.01, 0.001):
                continue
            # From 100 m, a floor that is about as wide as the cone's foot.
            radius = 100 * math.tan(outer)
            where = [((0.017 * radius, 0, 0), UP), ((0.3 * radius, 0, 0.2 * radius), UP), ((-0.5 * radius, 0, 0.1 * radius), UP),
                     ((0.1 * radius, 0, -0.7 * radius), UP)]
            yield spot(f"{outer:g}rad{name}", (0, 100, 0), (0, 0, 0), inner, outer, where, candela=1e5, side=3 * radius,
                       density=40 / radius)
    for outer in (0.004, 0.02):  # the foot is smaller than a texel, or a few
        yield spot(f"{outer:g}rad_thin", (0.012, 1.5, 0.021), (0.012, 0, 0.021), 0.0, outer,
                   [((0.012, 0, 0.021), UP), ((0.03, 0, 0.01), UP), ((-0.02, 0, 0.02), UP)])


def suns():
    for name, degrees in (("overhead", 90), ("slanted", 35), ("low", 5), ("grazing", 0.5)):
        a = math.radians(degrees)
        direction = (math.cos(a) * 0.8, -math.sin(a), math.cos(a) * 0.6)
        scene = with_floor()
        scene.light("directional", 1e5, {"color": [1, 0.9, 0.6]}, rotation=towards(direction))
        yield Case(f"sun/{name}", scene, Sun(direction, (1e5, 9e4, 6e4)), on_floor())
    for name in ("tiny", "huge", "far", "mirrored"):
        scene = with_floor()
        direction = (0.3, -0.7, 0.2)
        scene.light("directional", 800, rotation=towards(direction))
        yield Case(f"sun/{name}", scene, Sun(direction, 800), on_floor(), placed=PLACES[name])
    scene = with_floor()  # and a candle
    scene.light("directional", 1e5, rotation=towards((0.1, -1, 0.2)))
    scene.light("point", 1, translation=[0, 0.5, 0])
    yield Case("sun/candle", scene, Sum(Sun((0.1, -1, 0.2), 1e5), Point((0, 0.5, 0), 1)), on_floor())
    # Shadow of a post's wall: deep, sharp.
    scene = with_floor()
    wall = rectangle((0.5, 0.5, 0), (0, 0, 1.5), (0, 1, 0))
    scene.mesh(fan(wall), scene.material(double_sided=True))
    scene.light("directional", 1e4, rotation=towards((1, -1, 0)))
    scene.light("point", 2, translation=[1.2, 2, 1.2])
    dark = [((0.8, 0, 0.1), UP), ((1.2, 0, -0.5), UP), ((1.47, 0, 0.3), UP), ((1.53, 0, 0.3), UP), ((-0.3, 0, 0.2), UP)]

    class Shaded(Point):
        def __call__(self, point, normal):
            from forms import hits
            return np.zeros(3) if hits(point, self.position - point, np.asarray(wall)) else super().__call__(point, normal)
        mean = None

    lamp = Shaded((1.2, 2, 1.2), 2)
    yield Case("sun/lamp_in_its_shadow", scene, Sum(Sun((1, -1, 0), 1e4, [wall]), lamp), dark, density=40)


def small_things():
    """Faces smaller than half a texel, which each show their mean, and boards as narrow, which show that across them."""
    cube = box((0, 0, 0), (0.08, 0.08, 0.08), inwards=False)
    faces = [[cube[2 * k][0], cube[2 * k][1], cube[2 * k][2], cube[2 * k + 1][2]] for k in range(6)]
    lit = [((0.04, 0.08, 0.04), UP), ((0.08, 0.04, 0.04), (1, 0, 0))]
    lamp = rectangle((0.03, 0.13, 0.06), (0.06, 0, 0), (0, 0, 0.04))
    at = (0.11, 0.1, 0.02)
    for name, form in (("point", Point(at, 100)), ("emitter", Lamp(lamp, 1000))):
        scene = MadeScene()
        scene.mesh(cube, scene.material())
        if name == "point":
            scene.light("point", 100, translation=list(at))
        else:
            scene.mesh(fan(lamp), scene.material(0, 1000))
        yield Case(f"small/cube_{name}", scene, FaceMean(form, faces), lit if name == "point" else lit[:1], density=5)
    scene = MadeScene()
    board = rectangle((0, 0, 0), (0, 0, 2), (0.08, 0, 0))
    scene.mesh(fan(board), scene.material())
    lamp = rectangle((0.05, 0.04, 0), (0.03, 0, 0), (0, 0, 5))
    scene.mesh(fan(lamp), scene.material(0, 1000))
    across = [rectangle((0, 0, z), (0, 0, 1e-3), (0.08, 0, 0)) for z in (-0.83, -0.31, 0.07, 0.55)]
    yield Case("small/board", scene, FaceMean(Lamp(lamp, 1000), across), [(np.mean(a, 0), UP) for a in across], density=5)


def cases():
    yield from small_things()
    yield from points()
    yield from spots()
    yield from suns()
