"""Sky, umbra and penumbra, cut-outs, sheets. Everything is black."""
import math

import numpy as np

import hdr_file
from case import UP, Case, MadeScene, fan, floor_at, on_floor, placement, polygon, rectangle, towards, turned, with_floor
from forms import Constant, Lamp, Scaled, Sky, Sum, Sun


def shelf(middle, along, across):
    return rectangle(middle, (along, 0, 0), (0, 0, across))


def sky():
    yield Case("sky/open", with_floor(), Sky(1000), on_floor(), sky=1000)
    for name, wall in (("low", rectangle((-1, 0.25, 0), (0, 0.5, 0), (0, 0, 3))), ("high", rectangle((-0.5, 2, 0), (0, 4, 0), (0, 0, 20))),
                       ("half", rectangle((0, 500, 0), (0, 1000, 0), (0, 0, 4000)))):
        scene = with_floor()
        scene.mesh(fan(wall), scene.material(double_sided=True))
        x = wall[0][0]
        where = [((x + d, 0, 0.13), UP) for d in (0.06, 0.2, 0.7, 1.5)]
        yield Case(f"sky/wall_{name}", scene, Sky(500, [wall]), where, sky=500, over_texels=True, density=25)
    scene = with_floor()
    lid = rectangle((0, 0.4, 0), (1.4, 0, 0), (0, 0, 1.4))
    scene.mesh(fan(lid), scene.material(double_sided=True))
    yield Case("sky/under_table", scene, Sky(500, [lid]), on_floor(), sky=500, over_texels=True)
    yield Case("sky/vertical_wall", upright(), Constant(math.pi * 200), [((0, 0.4, 0.3), (1, 0, 0)), ((0, -0.6, 0.7), (1, 0, 0))], sky=200)
    yield from windows()
    # map: rows of one luminance; the integral over the upper half is a sum over rows.
    for name, power in (("even", 0), ("cosine", 1), ("zenith", 8)):
        rows = 64
        heights = np.cos(math.pi * (np.arange(rows) + 0.5) / rows)
        image = np.zeros((rows, 2 * rows, 3))
        image[:] = (np.maximum(heights, 0) ** power * (heights > 0))[:, None, None] * np.array([100, 200, 400])
        kept = hdr_file.rounded(image)
        borders = np.cos(math.pi * np.arange(rows + 1) / rows)
        lux = sum(kept[j, 0] * math.pi * (borders[j] ** 2 - borders[j + 1] ** 2) for j in range(rows // 2))
        yield Case(f"sky/map_{name}", with_floor(), Constant(lux), on_floor(), sky=image)
    image = np.zeros((64, 128, 3))  # a small sun
    image[20, 37] = (1e6, 8e5, 4e5)
    kept = hdr_file.rounded(image)[20, 37]
    borders = np.cos(math.pi * np.array([20, 21]) / 64)
    # integral of the cosine over the pixel: (y0^2 - y1^2) / 2 times its width
    lux = kept * (borders[0] ** 2 - borders[1] ** 2) / 2 * (2 * math.pi / 128)
    yield Case("sky/map_sun", with_floor(), Constant(lux), on_floor(), sky=image)
    yield from suns_and_shadows()


def suns_and_shadows():
    """Suns of a few pixels beside the edge of something: wide ones cast penumbras."""
    for name, rows, pixels, sky, blocker in (("wide", 32, 1, 0, shelf((2.5, 0.8, 0), 5, 6)), ("narrow", 256, 2, 1000, shelf((0.4, 0.6, 0), 0.4, 6)),
                                             ("alone", 64, 3, 0, shelf((0.3, 1.5, 0), 0.5, 6))):
        image = np.full((rows, 2 * rows, 3), float(sky))
        first, left = round(0.29 * rows), round(1.9 * rows)  # 52 degrees high, about +X
        image[first:first + pixels, left:left + pixels] = 3e5 * 4 * (rows / 32 / pixels) ** 2
        nits = hdr_file.rounded(image)[first, left] - sky
        heights = np.cos(math.pi * np.array([first, first + pixels]) / rows)
        turns = (np.array([left, left + pixels]) / rows - 1) * math.pi
        corners = [(math.sqrt(1 - y * y) * math.cos(a), y, math.sqrt(1 - y * y) * math.sin(a))
                   for y, a in ((heights[0], turns[0]), (heights[0], turns[1]), (heights[1], turns[1]), (heights[1], turns[0]))]
        # Edges of pixels are no great circles: the light of the polygon is that of the pixels.
        lux = nits * (heights[0] ** 2 - heights[1] ** 2) / 2 * (turns[1] - turns[0])
        far = 1e5 * np.array(corners)
        sun = Lamp(far, lux / Lamp(far, 1, two_sided=True)(np.zeros(3), np.array(UP)), two_sided=True, behind=[blocker])
        scene = with_floor()
        scene.mesh(fan(blocker), scene.material(double_sided=True))
        where = [((x, 0, 0.07), UP) for x in (-1.6, -0.3, 0.41, 0.55, 0.61, 0.66, 0.72, 1.05, 1.2, 1.25, 1.7)]
        yield Case(f"sky/map_sun_{name}", scene, Sum(sun, Sky(sky, [blocker])), where, sky=image, over_texels=True, density=25)


def upright():
    scene = MadeScene()
    scene.mesh(fan(rectangle((0, 0, 0), (0, 2, 0), (0, 0, 2))), scene.material())
    return scene


def windows():
    """A closed black box with openings in one wall, receivers on its floor."""
    for name, holes in (("one", [(0.0, 1.2, 1.0, 0.8)]), ("small", [(0.1, 1.3, 0.12, 0.1)]), ("two", [(-0.9, 1.0, 0.5, 0.5), (0.8, 1.5, 0.3, 0.7)])):
        scene = MadeScene()
        black = scene.material()
        # wall at x = -2 with rectangular openings: strips about each in a grid of cuts
        zs = sorted({-2.0, 2.0, *(z + s * w / 2 for z, y, w, h in holes for s in (-1, 1))})
        ys = sorted({0.0, 2.5, *(y + s * h / 2 for z, y, w, h in holes for s in (-1, 1))})
        for z0, z1 in zip(zs, zs[1:]):
            for y0, y1 in zip(ys, ys[1:]):
                z, y = (z0 + z1) / 2, (y0 + y1) / 2
                if not any(abs(z - hz) < w / 2 and abs(y - hy) < h / 2 for hz, hy, w, h in holes):
                    scene.mesh(fan(rectangle((-2, y, z), (0, y1 - y0, 0), (0, 0, z1 - z0))), black)
        scene.mesh(fan(floor_at()), black)
        scene.mesh(fan(rectangle((0, 2.5, 0), (4, 0, 0), (0, 0, 4))), black)
        scene.mesh(fan(rectangle((2, 1.25, 0), (0, 0, 4), (0, 2.5, 0))), black)
        for z in (-2, 2):
            scene.mesh(fan(rectangle((0, 1.25, z), (4, 0, 0), (0, 2.5, 0))), black)
        openings = [rectangle((-2, y, z), (0, h, 0), (0, 0, w)) for z, y, w, h in holes]
        yield Case(f"sky/window_{name}", scene, Sum(*(Lamp(o, 1000) for o in openings)), on_floor(), sky=1000, density=12,
                   over_texels=True)


def shadows():
    lamp = shelf((0, 2, 0), 0.5, 0.5)
    blockers = {"half_plane": shelf((2.5, 0.8, 0), 5, 6), "strip": shelf((0.2, 0.8, 0), 0.2, 6), "small": shelf((0.1, 0.5, 0.05), 0.1, 0.1),
                "disc": polygon((0.1, 1.0, 0.1), (1, 0, 0), (0, 0, 1), 32, 0.3), "thin": shelf((0.1, 0.4, 0), 0.01, 3)}
    where = [((x, 0, 0.07), UP) for x in (-1.6, -0.7, -0.33, -0.12, 0.03, 0.17, 0.41, 0.72, 1.2)]
    for name, blocker in blockers.items():
        scene = with_floor()
        scene.mesh(fan(lamp), scene.material(0, 1000))
        scene.mesh(fan(blocker), scene.material(double_sided=True))
        yield Case(f"shadow/{name}", scene, Lamp(lamp, 1000, behind=[blocker]), where, over_texels=True, density=25)
    for name, place in (("far", placement(move=(7e5, 2e4, 1e5))), ("huge", placement(1e4)), ("turned", placement(turn=turned((3, 1, 2), 110)))):
        scene = with_floor()
        scene.mesh(fan(lamp), scene.material(0, 1000))
        scene.mesh(fan(blockers["disc"]), scene.material(double_sided=True))
        yield Case(f"shadow/placed_{name}", scene, Lamp(lamp, 1000, behind=[blockers["disc"]]), where, over_texels=True, placed=place)


def cutouts():
    """A grating of cells between lamp and floor."""
    lamp = shelf((0, 2, 0), 0.6, 0.6)
    side, n = 2.0, 4
    open_cells = lambda i, j: (i + j) % 2 == 1
    for name, alphas, nearest in (("nearest", [[0 if open_cells(i, j) else 255 for i in range(n)] for j in range(n)], True),
                                  ("blend", [[51 if open_cells(i, j) else 255 for i in range(n)] for j in range(n)], True)):
        scene = with_floor()
        scene.mesh(fan(lamp), scene.material(0, 1000))
        texture = scene.texture([[(0, 0, 0, a) for a in row] for row in alphas], nearest)
        mode = "BLEND" if name == "blend" else "MASK"
        material = scene.material(double_sided=True, alphaMode=mode, pbrMetallicRoughness={
            "baseColorFactor": [1, 1, 1, 1], "baseColorTexture": texture})
        scene.mesh(fan(shelf((0, 0.9, 0), side, side)), material, uv=lambda p: (p[0] / side + 0.5, p[2] / side + 0.5))
        holes = [shelf((side * ((i + 0.5) / n - 0.5), 0.9, side * ((j + 0.5) / n - 0.5)), side / n, side / n)
                 for i in range(n) for j in range(n) if open_cells(i, j)]
        passes = 0.8 if name == "blend" else 1.0
        form = Sum(Lamp(lamp, 1000, behind=[shelf((0, 0.9, 0), side, side)]),
                   *(Scaled(Lamp(lamp, 1000, through=[hole]), passes) for hole in holes))
        yield Case(f"cutout/{name}", scene, form, on_floor(), over_texels=True, density=25)
    # stripes by bilinear alpha: the border lies where it crosses the cutoff
    for cutoff in (0.5, 0.2):
        scene = with_floor()
        scene.mesh(fan(lamp), scene.material(0, 1000))
        texture = scene.texture([[(0, 0, 0, 255), (0, 0, 0, 0)]])
        scene.mesh(fan(shelf((0, 0.9, 0), 4, 4)), scene.material(double_sided=True, alphaMode="MASK", alphaCutoff=cutoff,
                   pbrMetallicRoughness={"baseColorFactor": [1, 1, 1, 1], "baseColorTexture": texture}),
                   uv=lambda p: (p[0] / 4 + 0.5, 0.5))
        edge = -2 + 4 * (0.25 + 0.5 * (1 - cutoff))
        blocker = shelf(((edge - 2) / 2, 0.9, 0), edge + 2, 4)
        yield Case(f"cutout/linear_{cutoff:g}", scene, Lamp(lamp, 1000, behind=[blocker]),
                   [((x, 0, 0.1), UP) for x in (-1.7, -0.6, -0.2, 0.05, 0.4, 0.9, 1.5)], over_texels=True, density=25)


def sheets():
    lamp = shelf((0, 2, 0), 0.6, 0.6)
    glass = lambda color: {"pbrMetallicRoughness": {"baseColorFactor": [*color, 1]},
                           "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}}
    kinds = {
        "blend": ({"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 0.35]}}, (0.65,) * 3),
        "glass": (glass((0.9, 0.5, 0.1)), (0.9, 0.5, 0.1)),
        "half_glass": ({"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 0.5]}, "alphaMode": "BLEND",
                        "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}}, (0.5,) * 3),
    }
    for name, (material, passes) in kinds.items():
        for count in (1, 3, 8):
            if count == 8 and name != "glass":
                continue
            scene = with_floor()
            scene.mesh(fan(lamp), scene.material(0, 1000))
            sheet = scene.material(double_sided=True, **material)
            for k in range(count):
                scene.mesh(fan(shelf((0, 0.5 + 0.1 * k, 0), 6, 6)), sheet)
            yield Case(f"sheet/{name}_{count}", scene, Scaled(Lamp(lamp, 1000), np.power(passes, count)),
                       on_floor())
    scene = with_floor()  # half covered
    scene.mesh(fan(lamp), scene.material(0, 1000))
    half = shelf((1.5, 0.8, 0), 3, 6)
    scene.mesh(fan(half), scene.material(double_sided=True, **glass((0.2, 0.4, 0.8))))
    form = Sum(Lamp(lamp, 1000, behind=[half]), Scaled(Lamp(lamp, 1000, through=[half]), (0.2, 0.4, 0.8)))
    yield Case("sheet/half_covered", scene, form, [((x, 0, 0.1), UP) for x in (-1.3, -0.4, -0.1, 0.06, 0.3, 1.3)], density=10,
               over_texels=True)
    scene = with_floor()  # the sun through two sheets
    for k, color in enumerate(((0.9, 0.5, 0.2), (0.5, 0.8, 0.6))):
        scene.mesh(fan(shelf((0, 0.5 + 0.2 * k, 0), 8, 8)), scene.material(double_sided=True, **glass(color)))
    scene.light("directional", 1000, rotation=towards((0.2, -1, 0.1)))
    yield Case("sheet/sun", scene, Scaled(Sun((0.2, -1, 0.1), 1000), (0.45, 0.4, 0.12)), on_floor())
    scene = with_floor()  # the sky through one
    pane = shelf((0, 0.6, 0), 2, 2)
    scene.mesh(fan(pane), scene.material(double_sided=True, **kinds["blend"][0]))
    yield Case("sheet/sky", scene, Sum(Sky(300, [pane]), Scaled(Lamp(pane, 300), 0.65)), on_floor(), sky=300, over_texels=True)


def cases():
    yield from sky()
    yield from shadows()
    yield from cutouts()
    yield from sheets()
