"""Triangle meshes for the random scenes.

Solids stand on z = 0 around the z axis and fit into a unit cube, so the same matrix places any of them.
"""

import numpy as np

from .scene import Mesh


def lattice(xs, ys, holes=()):
    """Flat cells between the lines `xs` and `ys` at z = 0, except the cells (i, j) in `holes`; uvs in meters."""
    x, y = np.meshgrid(xs, ys, indexing="ij")
    points = np.stack([x, y, np.zeros_like(x)], -1)
    mesh = _grid(points, normals=None)
    keep = np.ones((len(xs) - 1, len(ys) - 1), bool)
    for cell in holes:
        keep[cell] = False
    uvs = points[..., :2].reshape(-1, 2)
    return Mesh(mesh.vertices, mesh.faces[np.repeat(keep.ravel(), 2)], uvs=uvs.astype(np.float32))


def plane(width=1.0, depth=1.0):
    return lattice([-width / 2, width / 2], [-depth / 2, depth / 2])


def box():
    sides = [lattice([-0.5, 0.5], [-0.5, 0.5])] * 6
    turns = [((1, 0, 0), (0, 1, 0)), ((0, 1, 0), (1, 0, 0)), ((0, 1, 0), (0, 0, 1)),
             ((0, 0, 1), (0, 1, 0)), ((0, 0, 1), (1, 0, 0)), ((1, 0, 0), (0, 0, 1))]
    matrices = []
    for u, v in turns:
        n = np.cross(u, v)
        matrix = np.eye(4)
        matrix[:3] = np.stack([u, v, n, n / 2 + (0, 0, 0.5)], 1)
        matrices.append(matrix)
    return merge([moved(side, matrix) for side, matrix in zip(sides, matrices)])


def lathe(profile, smooth=True, sides=40):
    """The profile [(radius, height), ...] revolved around z. Without `smooth`, its corners stay sharp."""
    profile = np.asarray(profile, float)
    if not smooth:
        pieces = [piece for piece in zip(profile[:-1], profile[1:]) if (piece[0] != piece[1]).any()]
        return merge([lathe(piece, sides=sides) for piece in pieces])
    angle = np.linspace(2 * np.pi, 0, sides + 1)  # clockwise, so that triangles face outwards
    circle = np.stack([np.cos(angle), np.sin(angle)], -1)
    tangent = np.gradient(profile, axis=0)
    outward = np.stack([tangent[:, 1], -tangent[:, 0]], -1)
    turned = [np.concatenate([p[:, None, :1] * circle, np.broadcast_to(p[:, None, 1:], (len(p), sides + 1, 1))], -1)
              for p in (profile, outward)]
    return _grid(turned[0], turned[1])


def sphere(sides=32):
    a = np.linspace(-np.pi / 2, np.pi / 2, sides // 2 + 1)
    return lathe(np.stack([np.cos(a) / 2, np.sin(a) / 2 + 0.5], -1), sides=sides)


def cylinder(sides=40):
    return lathe([(0, 0), (0.5, 0), (0.5, 1), (0, 1)], smooth=False, sides=sides)


def cone(top=0.0, sides=40):
    return lathe([(0, 0), (0.5, 0), (top / 2, 1), (0, 1)], smooth=False, sides=sides)


def torus(thickness=0.15):
    a = np.linspace(0, 2 * np.pi, 25)
    return lathe(np.stack([0.5 - thickness + thickness * np.cos(a), thickness * (1 + np.sin(a))], -1))


def vase(rng, wall=0.03):
    """A random hollow vessel: up the outside of a wavy profile and down the inside."""
    z = np.linspace(0, 1, 24)
    r = 0.3 + 0.12 * np.sin(rng.uniform(2, 8) * z + rng.uniform(0, 6)) + rng.uniform(-0.15, 0.08) * z
    inside = np.stack([r - wall, np.maximum(z, wall)], -1)[::-1]
    return lathe(np.concatenate([[(0, 0)], np.stack([r, z], -1), inside, [(0, wall)]]))


def rounded(power=0.4, sides=40):
    """A shape between a ball (power 1) and a cube (power towards 0)."""
    ball = sphere(sides).vertices.reshape(-1, sides + 1, 3) * 2 - (0, 0, 1)
    points = np.sign(ball) * np.abs(ball) ** power
    return _grid(points / 2 + (0, 0, 0.5), _curvature(points, wrap=True))


def blob(rng, waves=8, strength=0.35, sides=64):
    """A ball displaced by random waves: a pebble with few, a rock with many."""
    ball = sphere(sides).vertices.reshape(-1, sides + 1, 3) * 2 - (0, 0, 1)
    bump = 0
    for i in range(waves):
        direction = rng.normal(size=3) * (1.5 + i / 2)
        bump = bump + np.sin(ball @ direction + rng.uniform(0, 6)) / (1.5 + i / 2)
    points = ball * np.exp(strength * bump)[..., None]
    points = (points - points.min((0, 1))) / np.ptp(points, (0, 1)) - (0.5, 0.5, 0)
    return _grid(points, _curvature(points, wrap=True))


def heightfield(heights, size):
    """Terrain of size x size meters from a square array of heights; uvs in meters."""
    line = np.linspace(-size / 2, size / 2, len(heights))
    x, y = np.meshgrid(line, line, indexing="ij")
    points = np.stack([x, y, heights], -1)
    mesh = _grid(points, _curvature(points, wrap=False))
    return Mesh(mesh.vertices, mesh.faces, mesh.normals, points[..., :2].reshape(-1, 2).astype(np.float32))


def sheet(points):
    """A smooth surface through a grid of points [U,V,3]."""
    return _grid(points, _curvature(points, wrap=False))


def tube(points, radius=0.01, sides=8):
    """A round wire along a polyline [N,3]; `radius` may differ from point to point."""
    points = np.asarray(points, float)
    along = _unit(np.gradient(points, axis=0))
    side = _unit(np.cross(along, (0.31, 0.23, 0.92)))
    up = np.cross(side, along)
    angle = np.linspace(0, 2 * np.pi, sides + 1)[:, None]
    normals = np.cos(angle) * side[:, None] + np.sin(angle) * up[:, None]
    radius = np.broadcast_to(radius, len(points))[:, None, None]
    return _grid(points[:, None] + radius * normals, normals)


def strands(rng, roots, directions, length, width, droop=0.5, segments=3):
    """Grass or fur: a tapering strip of triangles from each root [N,3] along its direction, bending down."""
    n = len(roots)
    direction = _unit(directions + rng.normal(0, 0.25, (n, 3)))
    side = _unit(np.cross(direction, rng.normal(size=(n, 3)))) * width / 2
    length = length * rng.uniform(0.6, 1.2, (n, 1, 1))
    t = np.linspace(0, 1, segments + 1)[None, :, None]
    spine = roots[:, None] + length * (t * direction[:, None] - droop * t**2 * np.array([0, 0, 0.5]))
    taper = side[:, None] * (1 - 0.9 * t)
    strips = np.stack([spine - taper, spine + taper], 2)
    uvs = np.broadcast_to(np.stack(np.meshgrid(t.ravel(), [0.0, 1.0], indexing="ij"), -1), strips.shape[:3] + (2,))
    return _strips(strips, uvs)


def leaves(rng, centers, size):
    """At each center [N,3] a pointed leaf of four triangles, folded along its middle, in a random direction."""
    n = len(centers)
    along = _unit(rng.normal(size=(n, 3))) * size * rng.uniform(0.6, 1.3, (n, 1))
    side = np.cross(along, _unit(rng.normal(size=(n, 3)))) * 0.35
    fold = _unit(np.cross(along, side)) * size * 0.1
    middle = centers + along / 2
    corners = np.stack([centers, middle + side + fold, middle, middle - side + fold, centers + along], 1)
    faces = np.array([[0, 2, 1], [0, 3, 2], [1, 2, 4], [2, 3, 4]])
    uvs = np.tile([[0, 0.5], [0.5, 1], [0.5, 0.5], [0.5, 0], [1, 0.5]], (n, 1))
    return _mesh(corners.reshape(-1, 3), (faces + 5 * np.arange(n)[:, None, None]).reshape(-1, 3), uvs=uvs)


def merge(meshes):
    """Merges meshes into one. Where only some have normals or uvs, the others get substitutes."""
    start = np.cumsum([0] + [len(m.vertices) for m in meshes])
    faces = np.concatenate([m.faces + s for m, s in zip(meshes, start)])
    smooth, mapped = (any(getattr(m, a) is not None for m in meshes) for a in ("normals", "uvs"))
    if smooth:
        meshes = [m if m.normals is not None else _faceted(m) for m in meshes]
        start = np.cumsum([0] + [len(m.vertices) for m in meshes])
        faces = np.concatenate([m.faces + s for m, s in zip(meshes, start)])
    normals = np.concatenate([m.normals for m in meshes]) if smooth else None
    uvs = [m.uvs if m.uvs is not None else m.vertices[:, :2] for m in meshes]
    return _mesh(np.concatenate([m.vertices for m in meshes]), faces, normals, np.concatenate(uvs) if mapped else None)


def moved(mesh, matrix):
    """The mesh transformed by an affine matrix."""
    matrix = np.asarray(matrix, float)
    normals = None if mesh.normals is None else _unit(mesh.normals @ np.linalg.inv(matrix[:3, :3]))
    return _mesh(mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3], mesh.faces, normals, mesh.uvs)


def uv_size(mesh, matrix):
    """Average length in meters of one uv unit on the transformed mesh."""
    corners = (mesh.vertices @ np.asarray(matrix)[:3, :3].T)[mesh.faces], mesh.uvs[mesh.faces]
    (a, b), (u, v) = ((c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]) for c in corners)
    areas = np.linalg.norm(np.cross(a, b), axis=1).sum(), np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum()
    return float((areas[0] / max(areas[1], 1e-9)) ** 0.5)


def surface_points(rng, mesh, n):
    """n random points on a mesh, distributed by area, and their normals."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]].astype(float) for i in range(3))
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    face = rng.choice(len(area), n, p=area / area.sum())
    u, v = rng.random((2, n, 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    return a[face] * (1 - u - v) + b[face] * u + c[face] * v, _unit(normal[face])


def _mesh(vertices, faces, normals=None, uvs=None):
    arrays = [None if a is None else np.ascontiguousarray(a, np.float32) for a in (vertices, normals, uvs)]
    return Mesh(arrays[0], np.ascontiguousarray(faces, np.int32), arrays[1], arrays[2])


def _grid(points, normals):
    """A mesh of quads between neighboring points [U,V,3], split in two; uvs 0..1."""
    nu, nv = points.shape[:2]
    i = np.arange(nu * nv).reshape(nu, nv)
    a, b, c, d = i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]
    faces = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], -2).reshape(-1, 3)
    v, u = np.meshgrid(np.linspace(0, 1, nu), np.linspace(0, 1, nv), indexing="ij")
    normals = None if normals is None else _unit(normals.reshape(-1, 3))
    return _mesh(points.reshape(-1, 3), faces, normals, np.stack([u, v], -1).reshape(-1, 2))


def _strips(strips, uvs):
    """Quads along each strip [N,S,2,3]."""
    n, s = strips.shape[:2]
    i = np.arange(n * s * 2).reshape(n, s, 2)
    a, b, c, d = i[:, :-1, 0], i[:, 1:, 0], i[:, 1:, 1], i[:, :-1, 1]
    faces = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], -2).reshape(-1, 3)
    return _mesh(strips.reshape(-1, 3), faces, uvs=uvs.reshape(-1, 2))


def _curvature(points, wrap):
    """Normals of a grid of points from differences between neighbors; `wrap` closes the seam and both poles."""
    du = np.gradient(points, axis=0)
    dv = np.gradient(points, axis=1)
    if wrap:
        dv[:, 0] = dv[:, -1] = (points[:, 1] - points[:, -2]) / 2
    normals = np.cross(du, dv)
    if wrap:
        normals[0], normals[-1] = normals[1].mean(0), normals[-2].mean(0)
    return normals


def _faceted(mesh):
    """The same mesh with separate vertices and the geometric normal for every triangle."""
    corners = mesh.vertices[mesh.faces]
    normals = _unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    uvs = None if mesh.uvs is None else mesh.uvs[mesh.faces].reshape(-1, 2)
    return _mesh(corners.reshape(-1, 3), np.arange(mesh.faces.size).reshape(-1, 3), np.repeat(normals, 3, 0), uvs)


def _unit(v):
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-12)
