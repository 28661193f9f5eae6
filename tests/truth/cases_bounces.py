"""Interreflection: closed spaces in equilibrium, patches that send on even light, dim places beside bright ones."""
import math

import numpy as np

from case import UP, Case, MadeScene, box, fan, floor_at, on_floor, placement, polygon, quad, rectangle, towards, turned
from forms import Constant, Lamp, Point, Scaled, Sum, Sun, cells, linear


def prism(outline, height):
    """Closed, fronts inwards. outline: counter-clockwise from above in (x, z) as (x, -z); convex pieces for lid and bottom."""
    triangles, pieces = [], [outline] if np.ndim(outline) == 2 else outline
    for piece in pieces:
        bottom = [(x, 0.0, -z) for x, z in piece]
        triangles += fan(bottom) + fan([(x, height, z) for x, _, z in bottom][::-1])
    return triangles


def sides(outline, height):
    walls = []
    for (x0, z0), (x1, z1) in zip(outline, outline[1:] + outline[:1]):
        walls += quad((x1, 0.0, -z1), (x0, 0.0, -z0), (x0, height, -z0), (x1, height, -z1))
    return walls


def octagon():
    ring = [(math.cos(a) * 1.2, math.sin(a) * 1.2) for a in (2 * math.pi * (k + 0.5) / 8 for k in range(8))]
    return prism(ring, 1.5) + sides(ring, 1.5)


def l_shape():
    outline = [(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 2.5), (0.0, 2.5)]
    pieces = [[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)], [(1.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0)],
              [(0.0, 1.0), (1.0, 1.0), (1.0, 2.5), (0.0, 2.5)]]
    return prism(pieces, 1.2) + sides(outline, 1.2)


def tetrahedron():
    a, b, c, d = (0, 0, 0), (2, 0, 0), (1, 0, -1.7), (0.9, 1.6, -0.6)
    return [(a, b, c), (a, d, b), (b, d, c), (c, d, a)]


SHAPES = {"box": lambda: box((0, 0, 0), (2, 1, 1.5)), "flat_box": lambda: box((0, 0, 0), (4, 0.1, 4)),
          "octagon": octagon, "l_shape": l_shape, "tetrahedron": tetrahedron}


def on_triangles(triangles, seed=5, count=24):
    """Points of the triangles with their normals: middles, and near edges."""
    rng = np.random.default_rng(seed)
    where = []
    for k in range(count):
        a, b, c = (np.asarray(v, float) for v in triangles[(7 * k) % len(triangles)])
        w = rng.dirichlet((1, 1, 1)) * 0.94 + 0.02
        where.append((w[0] * a + w[1] * b + w[2] * c, np.cross(b - a, c - a)))
    return where


def glowing(scene, reflectance, lux, share=1.0, **more):
    """A material that sends out pi L = lux x share whatever it is lit by, where everything around sends out the same: it
    emits what it does not reflect. share: of light that it does not hand on."""
    rho = np.broadcast_to(np.asarray(reflectance, float), 3)
    nits = np.maximum((share - rho) * np.broadcast_to(lux, 3) / math.pi, 0)
    top = float(nits.max())
    values = {"pbrMetallicRoughness": {"baseColorFactor": [*map(float, rho), 1], "metallicFactor": 0}}
    for key, value in more.items():
        values[key] = {**values.get(key, {}), **value} if isinstance(value, dict) else value
    return scene.material(0, top, emissiveFactor=[float(v) for v in nits / top] if top > 0 else [0, 0, 0], **values)


def furnaces():
    lux = 50.0
    for shape, reflectances in (("box", (0.3, 0.9, 0.99, 0.999)), ("l_shape", (0, 0.7, 0.95)), ("tetrahedron", (0.5, 0.9, 0.99)),
                                ("octagon", (0.8,)), ("flat_box", (0.5, 0.95))):
        for rho in reflectances:
            triangles, scene = SHAPES[shape](), MadeScene()
            scene.mesh(triangles, glowing(scene, rho, lux))
            yield Case(f"furnace/{shape}_{rho:g}", scene, Constant(lux), on_triangles(triangles), density=8)
    for name, place in (("tiny", placement(1e-3)), ("huge", placement(1e4)), ("far", placement(move=(8e5, 1e5, -3e5))),
                        ("mirrored", placement(turn=turned((1, 1, 0), 50), mirror=True))):
        triangles, scene = SHAPES["l_shape"](), MadeScene()
        scene.mesh(triangles, glowing(scene, 0.6, lux))
        yield Case(f"furnace/{name}", scene, Constant(lux), on_triangles(triangles), density=8, placed=place)
    triangles, scene = SHAPES["box"](), MadeScene()
    colored = (90.0, 40.0, 5.0)
    scene.mesh(triangles, glowing(scene, (0.9, 0.5, 0.05), colored))
    yield Case("furnace/coloured", scene, Constant(colored), on_triangles(triangles), density=8)
    triangles, scene = SHAPES["l_shape"](), MadeScene()
    for k, triangle in enumerate(triangles):
        scene.mesh([triangle], glowing(scene, (0.05 + 0.9 * (k % 3 == 0), 0.8 * (k % 2), 0.5), colored))
    yield Case("furnace/every_triangle_another", scene, Constant(colored), on_triangles(triangles), density=8)
    yield from furnished()
    yield from textured_furnace()


def furnished():
    lux = 80.0
    scene, room = MadeScene(), box((0, 0, 0), (3, 2, 3))
    scene.mesh(room, glowing(scene, 0.7, lux))
    blocks = []
    for k in range(6):
        low = (0.3 + 0.45 * k, 0.0 if k % 2 else 0.2, 0.4 + 0.3 * (k % 4))
        blocks.append(box(low, (low[0] + 0.3, low[1] + 0.5 + 0.1 * k, low[2] + 0.35), inwards=False))
        scene.mesh(blocks[-1], glowing(scene, 0.1 + 0.16 * k, lux))
    where = on_triangles(room[4:]) + [w for b in blocks for w in on_triangles(b[2:10], count=3)]
    yield Case("equilibrium/furnished", scene, Constant(lux), where, density=8)
    sheets = {
        "two_sided": (0.6, 1.0, {}),
        "blend": (0.6, 1.0, {"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [0.6] * 3 + [0.4]}}),
        "diffuse_transmission": (0.4, 0.8, {"pbrMetallicRoughness": {"baseColorFactor": [0.8] * 3 + [1]}, "extensions": {
            "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.5, "diffuseTransmissionColorFactor": [0.5] * 3}}}),
        "glass": (0.0, 0.0, {"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1]}, "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 1}}})}
    for name, (rho, share, more) in sheets.items():
        scene = MadeScene()
        scene.mesh(room, glowing(scene, 0.7, lux))
        handed_on = 0.25 if name == "diffuse_transmission" else 0.0
        values = glowing(scene, rho, lux, 1 - handed_on if name != "glass" else 0.0, doubleSided=True, **more)
        for k in range(4):
            scene.mesh(fan(rectangle((0.5 + 0.6 * k, 1, 1.5), (0, 1.2, 0.1 * k), (0.2, 0, 1.4))), values)
        yield Case(f"equilibrium/{name}", scene, Constant(lux), on_triangles(room), density=8)
    scene = MadeScene()  # a court under the sky
    walls = [t for t in box((0, 0, 0), (2, 1.5, 2)) if not all(p[1] == 1.5 for p in t)]
    scene.mesh(walls, glowing(scene, 0.8, lux))
    yield Case("equilibrium/court", scene, Constant(lux), on_triangles(walls), sky=lux / math.pi, density=8)


def textured_furnace():
    """Texels that reflect much emit little: pairs of bytes whose linear values add up to 1."""
    pairs = [(a, b) for a in range(40, 250) for b in range(256) if abs(linear(a) + linear(b) - 1) < 2e-4]
    rng = np.random.default_rng(3)
    chosen = [pairs[i] for i in rng.integers(0, len(pairs), 64)]
    lux, scene, triangles = 60.0, MadeScene(), SHAPES["box"]()
    base = scene.texture([[(chosen[8 * j + i][0],) * 3 + (255,) for i in range(8)] for j in range(8)], True)
    glow = scene.texture([[(chosen[8 * j + i][1],) * 3 + (255,) for i in range(8)] for j in range(8)], True)
    material = scene.material(0, lux / math.pi, emissiveTexture=glow,
                              pbrMetallicRoughness={"baseColorFactor": [1, 1, 1, 1], "baseColorTexture": base})
    scene.mesh(triangles, material, uv=lambda p: ((0.31 * p[0] + 0.47 * p[1]) % 0.97, (0.53 * p[2] + 0.29 * p[1]) % 0.97))
    yield Case("equilibrium/textured", scene, Constant(lux), on_triangles(triangles), density=8)


def patches():
    """A wall that the sun, level with the floor, lights evenly; the black floor sees nothing but the wall."""
    lux, wall = 1e4, rectangle((-1, 0.5, 0), (0, 0.8, 0), (0, 0, 1.2))
    uv = lambda p: ((p[2] + 0.6) / 1.2, (p[1] - 0.1) / 0.8)
    where = [((-1 + d, 0, z), UP) for d, z in ((0.05, 0.1), (0.2, -0.3), (0.5, 0.4), (1, 0), (1.7, -0.8), (2.8, 0.9))]
    rows = [[(200, 30, 30), (30, 220, 90)], [(250, 250, 250), (0, 0, 0)], [(90, 90, 255), (255, 128, 0)]]
    colors = [[[linear(v) * lux / math.pi for v in p] for p in row] for row in rows]
    nits = lambda rho: rho * lux / math.pi
    textured = lambda rows, transform=None: lambda scene: {"pbrMetallicRoughness": {
        "baseColorFactor": [1, 1, 1, 1], "baseColorTexture": {**scene.texture([[(*p, 255) for p in row] for row in rows], True), **(
            {"extensions": {"KHR_texture_transform": transform}} if transform else {})}}}
    # wall's own frame: along y, across z; rows of cells along z
    on_wall = lambda grid: cells((-1, 0.1, -0.6), (0, 0.8, 0), (0, 0, 1.2), [[grid[j][i] for j in range(len(grid))] for i in range(len(grid[0]))])
    kinds = {
        "white": (lambda scene: {"pbrMetallicRoughness": {"baseColorFactor": [0.9] * 3 + [1]}}, Lamp(wall, nits(0.9)), None),
        "coloured": (lambda scene: {"pbrMetallicRoughness": {"baseColorFactor": [0.9, 0.3, 0.01, 1]}},
                     Lamp(wall, [nits(v) for v in (0.9, 0.3, 0.01)]), None),
        "dark": (lambda scene: {"pbrMetallicRoughness": {"baseColorFactor": [0.02] * 3 + [1]}}, Lamp(wall, nits(0.02)), None),
        "half_metal": (lambda scene: {"pbrMetallicRoughness": {"baseColorFactor": [0.8] * 3 + [1], "metallicFactor": 0.5}},
                       Lamp(wall, nits(0.4)), None),
        "textured": (textured(rows), on_wall(colors), None),
        "transformed": (textured(rows, {"scale": [-1, 1], "offset": [1, 0]}), on_wall([row[::-1] for row in colors]), None),
        "vertex_colours": (lambda scene: {"pbrMetallicRoughness": {"baseColorFactor": [0.8] * 3 + [1]}},
                           on_wall([[nits(0.8 * (i + 0.5) / 40) for i in range(40)]]),
                           lambda p: ((p[2] + 0.6) / 1.2,) * 3 + (1,)),
    }
    for name, (more, form, vertex) in kinds.items():
        scene = MadeScene()
        scene.mesh(fan(floor_at()), scene.material())
        scene.mesh(fan(wall), scene.material(**more(scene)), uv=uv, colors=vertex)
        scene.light("directional", lux, rotation=towards((-1, 0, 0)))
        yield Case(f"patch/{name}", scene, form, where, over_texels=True)
    scene = MadeScene()
    scene.mesh(fan(floor_at()), scene.material())
    scene.mesh(fan(wall), scene.material(double_sided=True, pbrMetallicRoughness={"baseColorFactor": [0.8] * 3 + [1]}, extensions={
        "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.75, "diffuseTransmissionColorFactor": [1, 0.5, 0.2]}}))
    scene.light("directional", lux, rotation=towards((1, 0, 0)))  # from behind
    yield Case("patch/shines_through", scene, Lamp(wall, [nits(0.75 * v) for v in (1, 0.5, 0.2)]), where, over_texels=True)
    small = rectangle((-1, 0.3, 0), (0, 0.03, 0), (0, 0, 0.04))
    scene = MadeScene()
    scene.mesh(fan(floor_at()), scene.material())
    scene.mesh(fan(small), scene.material(0.9))
    scene.light("directional", 1e5, rotation=towards((-1, 0, 0)))
    yield Case("patch/small", scene, Lamp(small, 0.9e5 / math.pi), where, over_texels=True)
    # A small spot of light on a white wall: about a point that shines by Lambert's law.
    scene = MadeScene()
    scene.mesh(fan(floor_at()), scene.material())
    scene.mesh(fan(rectangle((-1, 0.6, 0), (0, 1.2, 0), (0, 0, 1.2))), scene.material(0.8))
    lit = polygon((-1, 0.6, 0), (0, 1, 0), (0, 0, 1), 48, 5 * math.tan(0.02) * math.sqrt(math.pi / 48 / math.sin(math.pi / 48) / math.cos(math.pi / 48)))
    scene.light("spot", 25000, {"spot": {"innerConeAngle": 0.02, "outerConeAngle": 0.02}}, translation=[4, 0.6, 0], rotation=towards((-1, 0, 0)))
    yield Case("patch/spot_of_light", scene, Lamp(lit, 0.8 * 1000 / math.pi), [w for w in where if w[0][0] > -0.85], over_texels=True)


def dim():
    """Receivers that get a small share of what others in the same map do."""
    for ratio in (1e2, 1e4):
        scene = MadeScene()  # a panel in the sun beside a floor that one weak lamp lights
        scene.mesh(fan(floor_at()), scene.material())
        scene.mesh(fan(rectangle((-1.9, 0.5, 0), (0, 1, 0), (0, 0, 4))), scene.material())
        scene.mesh(fan(lamp := rectangle((0.5, 1, 0), (0.5, 0, 0), (0, 0, 0.5))), scene.material(0, 100))
        blocker = rectangle((0.2, 0.4, 0.1), (0.4, 0, 0), (0, 0, 0.4))
        scene.mesh(fan(blocker), scene.material(double_sided=True))
        scene.light("directional", 10 * ratio, rotation=towards((-1, 0, 0)))
        yield Case(f"dim/lamp_{ratio:g}", scene, Lamp(lamp, 100, behind=[blocker]),
                   [(p, n) for p, n in on_floor() if p[0] > -1.8], over_texels=True)
        scene = MadeScene()  # the same floor, lit by a patch that is lit by the sun
        scene.mesh(fan(floor_at()), scene.material())
        scene.mesh(fan(rectangle((-1.9, 0.5, 0), (0, 1, 0), (0, 0, 4))), scene.material())
        patch = rectangle((-1.5, 0.6, 0.2), (0, 0.3, 0), (0, 0, 0.3))
        scene.mesh(fan(patch), scene.material(0.9 * 1e2 / ratio))
        scene.light("directional", 1e4, rotation=towards((-1, 0, 0)))
        yield Case(f"dim/patch_{ratio:g}", scene, Lamp(patch, 0.9 * 1e6 / ratio / math.pi),
                   [(p, n) for p, n in on_floor() if p[0] > -1.4], over_texels=True)
        scene = MadeScene()  # lamps that differ
        scene.mesh(fan(floor_at(side=8)), scene.material())
        scene.mesh(fan(screen := rectangle((0, 3, 0), (0, 6, 0), (0, 0, 40))), scene.material(double_sided=True))
        scene.light("point", 10 * ratio, translation=[-2, 1, 0])
        scene.light("point", 10, translation=[2, 1, 0])
        bright = on_floor(side=3, spread=((0, 0), (0.3, 0.2)))
        yield Case(f"dim/behind_screen_{ratio:g}", scene, Behind(screen, Point((-2, 1, 0), 10 * ratio), Point((2, 1, 0), 10)),
                   [((2 + p[0], 0, p[2]), n) for p, n in bright] + [((-2 + p[0], 0, p[2]), n) for p, n in bright], over_texels=True)
    yield from chambers()


class Behind:
    """Lamps on either side of a screen at x = 0."""

    def __init__(self, screen, left, right):
        self.left, self.right = left, right

    def __call__(self, point, normal):
        return (self.left if point[0] < 0 else self.right)(point, normal)


def chambers():
    """Three black chambers in a row, a hatch between each two; the lamp is in the first."""
    for name, side in (("wide", 0.5), ("narrow", 0.15)):
        scene, hatches = MadeScene(), []
        black = scene.material(double_sided=True)
        scene.mesh(box((0, 0, 0), (6, 1.5, 1.5)), black)
        for x in (2, 4):
            y0, y1, z0, z1 = 0.75 - side / 2, 0.75 + side / 2, 0.75 - side / 2, 0.75 + side / 2
            for low, high in (((0, 0), (y0, 1.5)), ((y1, 0), (1.5, 1.5)), ((y0, 0), (y1, z0)), ((y0, z1), (y1, 1.5))):
                scene.mesh(fan([(x, low[0], low[1]), (x, high[0], low[1]), (x, high[0], high[1]), (x, low[0], high[1])]), black)
            hatches.append([(x, y0, z0), (x, y1, z0), (x, y1, z1), (x, y0, z1)])
        lamp = rectangle((0.01, 0.75, 0.75), (0, 1.3, 0), (0, 0, 1.3))
        scene.mesh(fan(lamp), scene.material(0, 1000))

        class Light:
            def __init__(self, hatches):
                self.rooms = [Lamp(lamp, 1000, through=hatches[:k]) for k in range(3)]

            def __call__(self, point, normal):
                return self.rooms[min(2, int(point[0] / 2))](point, normal)

        where = [((x, 0, z), UP) for x, z in ((0.5, 0.4), (1.5, 1), (3.0, 0.7), (3.7, 0.9), (3.4, 0.75))]
        where += [((6, y, z), (-1, 0, 0)) for y, z in ((0.7, 0.75), (0.9, 0.6), (0.4, 1.0))]
        yield Case(f"dim/chambers_{name}", scene, Light(hatches), where, over_texels=True)


def cases():
    yield from furnaces()
    yield from patches()
    yield from dim()
