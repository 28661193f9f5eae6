"""Emitting polygons, plain and textured, over black receivers."""
import numpy as np

from case import UP, Case, MadeScene, fan, floor_at, on_floor, placement, polygon, rectangle, turned, with_floor
from forms import Lamp, Sum, cells, linear

PLACES = {
    "tiny": placement(1e-3), "huge": placement(1e4), "far": placement(move=(7e5, -3e5, 9e5)),
    "turned": placement(turn=turned((1, 2, 3), 70)), "mirrored": placement(turn=turned((1, 0, 2), 40), mirror=True)}


def ceiling(middle, along=1.0, across=0.6):
    """A rectangle that faces down."""
    return rectangle(middle, (along, 0, 0), (0, 0, across))


def lit_floor(name, lamps, receivers=None, **more):
    """lamps: (corners, nits, two-sided)."""
    scene = with_floor(more.pop("side", 4.0))
    for corners, nits, two_sided in lamps:
        color = np.broadcast_to(np.asarray(nits, float), 3)
        scene.mesh(fan(corners), scene.material(0, float(color.max()), two_sided,
                                                emissiveFactor=[float(c) for c in color / color.max()]))
    return Case(f"emitter/{name}", scene, Sum(*(Lamp(*lamp) for lamp in lamps)), receivers or on_floor(), **more)


def plain():
    for height in (0.001, 0.01, 0.1, 0.5, 2, 10, 100):
        where = on_floor(side=1.5 if height < 0.05 else 4)
        yield lit_floor(f"parallel_{height:g}m", [(ceiling((0.05, height, 0.02)), 100, False)], where,
                        over_texels=height < 0.6, density=40)
    for height in (0.0, 0.001, 0.5):  # upright, from the floor up
        wall = rectangle((-0.5, height + 0.5, 0), (0, 1, 0), (0, 0, 1.2))
        where = [((-0.5 + d, 0, 0.1), UP) for d in (0.04, 0.11, 0.3, 1.0, 2.3)]
        yield lit_floor(f"upright_{height:g}m", [(wall, 100, False)], where, density=40, over_texels=True)
    leaning = rectangle((0.2, 0.1, 0.3), (0, 1, 0.7), (1.5, 0, 0))  # partly below the floor
    yield lit_floor("below_horizon", [(leaning, (100, 60, 20), True)], [(p, n) for p, n in on_floor() if abs(p[2]) > 0.4],
                    over_texels=True)
    both = rectangle((0, 0.7, 0), (0, 0.8, 0.2), (1, 0, 0.3))
    yield lit_floor("two_sided", [(both, 40, True)], over_texels=True)
    yield lit_floor("one_sided", [(both, 40, False)], [(p, n) for p, n in on_floor() if abs(p[2] - 0.3 * p[0]) > 0.3],
                    over_texels=True)
    yield lit_floor("triangle", [([(-0.5, 1, -0.4), (0.7, 1.2, -0.3), (0.1, 0.8, 0.6)], (10, 20, 90), False)])
    yield lit_floor("sliver", [([(-1.5, 1, 0), (1.5, 1, 0.0), (1.5, 1, 0.002)], 5000, False)])
    yield lit_floor("disc", [(polygon((0.1, 0.9, 0), (1, 0, 0), (0, 0, 1), 48, 0.4), 100, False)])
    panels = [(ceiling((0.5 * i - 1.5, 1.3 + 0.1 * ((i + 2 * j) % 3), 0.45 * j - 1.3), 0.2, 0.15), 20 + 30 * ((i * j) % 3), False)
              for i in range(7) for j in range(7)]
    yield lit_floor("forty_nine", panels)
    low = ceiling((-1.2, 0.05, -1.2), 0.06, 0.06)  # hides the others
    scene = with_floor()
    high = [ceiling((0.5 * i - 1.5, 3, 1.2), 0.3, 0.3) for i in range(7)]
    scene.mesh([t for c in high for t in fan(c)], scene.material(0, 1000))
    scene.mesh(fan(low), scene.material(0, 3))
    yield Case("emitter/dim_one_near", scene, Sum(Lamp(low, 3), *(Lamp(c, 1000, behind=[low]) for c in high)),
               on_floor() + [((-1.2, 0, -1.2), UP), ((-1.16, 0, -1.23), UP)], over_texels=True)
    for name, place in PLACES.items():
        lamps = [(ceiling((0.3, 1.2, 0.1)), (100, 50, 25), False), (rectangle((-1.2, 0.5, 0), (0, 0.6, 0), (0, 0, 0.5)), 40, True)]
        yield lit_floor(f"placed_{name}", lamps, placed=place, over_texels=True)
    # Receivers of every kind of storage.
    tile = rectangle((0, 0, 0), (0, 0, 1), (1, 0, 0))
    places = [(1.1 * i - 1.65, 0, 1.1 * j - 1.65) for i in range(4) for j in range(4)]
    lamp = ceiling((0.3, 1.2, 0.1))
    on_tiles = [((x + 0.21, 0, z - 0.17), UP) for x, _, z in places]
    for name, options in (("instanced", {"instances": places}), ("instanced_quantised", {"instances": places, "grid": 1 / 1024})):
        scene = MadeScene()
        if "grid" in options:  # the node scales translations, too
            options = {**options, "instances": [tuple(c * 1024 for c in p) for p in places]}
        scene.mesh(fan(tile), scene.material(), **options)
        scene.mesh(fan(lamp), scene.material(0, 100))
        yield Case(f"emitter/{name}", scene, Lamp(lamp, 100), on_tiles)
    scene = with_floor()
    spots = [(0.9 * i - 1.3, 1.0, 0.8 * j - 1.2) for i in range(4) for j in range(4)]
    scene.mesh(fan(ceiling((0, 0, 0), 0.3, 0.2)), scene.material(0, 100), instances=spots)
    yield Case("emitter/lamps_instanced", scene, Sum(*(Lamp(ceiling(at, 0.3, 0.2), 100) for at in spots)), on_floor())
    scene = MadeScene()
    scene.mesh(fan(floor_at()), scene.material(1.0), colors=lambda p: (abs(p[0]) % 1, 0.0, 0.5, 1))
    scene.mesh(fan(ceiling((0, 1, 0))), scene.material(0, 100))
    yield Case("emitter/over_vertex_colours", scene, Lamp(ceiling((0, 1, 0)), 100), on_floor())


def upside(rows):
    return [[(r, g, b, 255) for r, g, b in row] for row in rows]


class Ramp:
    """A rectangle whose luminance runs linearly along it between two texels' middles, constant beyond: bilinear filtering."""

    def __init__(self, corner, along, across, dark, bright, steps=64):
        rows = []
        for i in range(steps):
            t = min(max(((i + 0.5) / steps - 0.25) * 2, 0), 1)
            rows.append([float(v) for v in np.asarray(dark) * (1 - t) + np.asarray(bright) * t])
        self.form = cells(corner, along, across, [rows])

    def __call__(self, point, normal):
        return self.form(point, normal)


def textured():
    rows = [[(255, 0, 0), (0, 128, 0), (10, 20, 200)], [(255, 255, 255), (0, 0, 0), (90, 60, 40)]]
    nits = [[[100 * linear(v) for v in pixel] for pixel in row] for row in rows]
    corner, along, across = (-0.6, 0.8, -0.4), (1.2, 0, 0), (0, 0, 0.8)
    lamp = rectangle((0, 0.8, 0), along, across)
    uv = lambda p: ((p[0] + 0.6) / 1.2, (p[2] + 0.4) / 0.8)

    def lit(name, rows, uv, form, nearest=True, transform=None, slot=None, more=None, **options):
        scene = with_floor()
        texture = scene.texture(upside(rows) if len(rows[0][0]) == 3 else rows, nearest)
        if transform:
            texture["extensions"] = {"KHR_texture_transform": transform}
        material = {"emissiveTexture": texture} if slot is None else slot(texture)
        scene.mesh(fan(lamp), scene.material(0, 100, **material), uv=uv)
        return Case(f"textured/{name}", scene, form, on_floor(), **options)

    plain_cells = cells(corner, along, across, nits)
    yield lit("nearest", rows, uv, plain_cells)
    fine = [[(int(255 * ((i * 7 + j * 3) % 5) / 4),) * 3 for i in range(8)] for j in range(8)]
    yield lit("chequered", fine, uv, cells(corner, along, across, [[100 * linear(p[0]) for p in row] for row in fine]))
    spark = [[(0, 0, 0)] * 64 for _ in range(64)]
    spark[20][41] = (255, 200, 100)
    yield lit("one_texel_of_4096", spark, uv, cells(corner, along, across, [
        [[100 * linear(v) for v in p] if any(p) else 0 for p in row] for row in spark]))
    # linear: a ramp of two texels, sRGB decoded first
    yield lit("linear", [[(255, 255, 255), (0, 0, 0)]], uv, Ramp(corner, along, across, (100,) * 3, (0,) * 3), nearest=False)
    # the right half of the picture, turned upside down by a negative scale
    shifted = [[nits[1][1], nits[1][2]], [nits[0][1], nits[0][2]]]
    yield lit("transformed", rows, uv, cells(corner, along, across, shifted),
        transform={"offset": [1 / 3, 1], "scale": [2 / 3, -1]})
    # alpha
    holes = [[(255, 255, 255, 255 if (i + j) % 2 else 100) for i in range(4)] for j in range(4)]
    base = lambda mode, **cut: lambda texture: {"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "baseColorTexture": texture},
                                                "alphaMode": mode, **cut}
    yield lit("mask", holes, uv, cells(corner, along, across, [[100.0 * ((i + j) % 2) for i in range(4)] for j in range(4)]),
              slot=base("MASK"))
    rare = [[(255, 255, 255, 255 if (i, j) in ((1, 2), (14, 9), (7, 15)) else 0) for i in range(16)] for j in range(16)]
    yield lit("mask_rare", rare, uv, cells(corner, along, across, [
        [100.0 * (p[3] > 0) for p in row] for row in rare]), slot=base("MASK", alphaCutoff=0.3))
    blend = [[(255, 255, 255, 51 * ((i + 2 * j) % 6)) for i in range(3)] for j in range(3)]
    yield lit("blend", blend, uv, cells(corner, along, across, [[100.0 * (p[3] / 255) for p in row] for row in blend]),
              slot=base("BLEND"))
    scene = with_floor()
    scene.mesh(fan(lamp), scene.material(0, 100, alphaMode="BLEND", pbrMetallicRoughness={"baseColorFactor": [0, 0, 0, 0.3]}))
    yield Case("textured/blend_even", scene, Lamp(lamp, 30), on_floor())


def cases():
    yield from plain()
    yield from textured()
