"""Cameras for the random scenes, placed where there is something to see."""

import numpy as np

from .scene import Camera

TRIES = 16


def cameras(rng, instances, targets, distance, height, count=3, bounds=None, fov=(30, 70)):
    """Cameras at random distances and heights (ranges), each looking at one of the targets, neither inside an object
    nor close behind one, and within `bounds` (x0, x1, y0, y1, z0, z1)."""
    triangles, found = _triangles(rng, instances), []
    for _ in range(count):
        tries = []
        while len(tries) < TRIES and (not tries or tries[-1][0] < 1):
            camera = _camera(rng, targets[rng.integers(len(targets))], distance, height, bounds, fov)
            tries.append((_clearness(triangles, camera), len(tries), camera))
        found.append(max(tries)[2])
    return found


def _camera(rng, target, distance, height, bounds, fov):
    angle, far = rng.uniform(0, 2 * np.pi), np.exp(rng.uniform(*np.log(distance)))
    position = np.array([target[0] + far * np.cos(angle), target[1] + far * np.sin(angle), rng.uniform(*height)])
    if bounds is not None:
        position = np.clip(position, bounds[::2], bounds[1::2])
    focus = np.linalg.norm(np.array(target) - position)
    return Camera(tuple(map(float, position)), tuple(map(float, target)), float(rng.uniform(*fov)), focus=float(focus))


def _clearness(triangles, camera):
    """How clear a camera's view is; 1 is clear. Rays into the image must hit nothing very close, half must reach half
    the target's distance, most must hit something, and together three objects (or all, if there are fewer). The worst
    criterion counts."""
    eye, forward = np.array(camera.position), np.array(camera.target) - np.array(camera.position)
    right = np.cross(forward, (0, 0, 1)) + 1e-9
    right = right / np.linalg.norm(right) * camera.focus * np.tan(np.radians(camera.fov / 2)) * 0.8
    up = np.cross(right, forward) / max(camera.focus, 1e-9)
    grid = (-1, -0.4, 0.4, 1)
    hits = [_first_hit(triangles, eye, forward + a * right + b * up) for a in grid for b in grid]
    distances, owners = np.array([hit[0] for hit in hits]), {hit[1] for hit in hits} - {None}
    wanted = min(3, len(np.unique(triangles[3])))
    return min(1, distances.min() / 0.12, np.median(distances) / 0.5, np.isfinite(distances).mean() / 0.6,
               len(owners) / wanted)


def _first_hit(triangles, eye, ray):
    """Distance to the first triangle hit, in ray lengths, or infinity; and the index of its object."""
    corner, edge1, edge2, owner = triangles
    p = np.cross(ray, edge2)
    det = np.einsum("ij,ij->i", edge1, p)
    inverse = 1 / np.where(np.abs(det) < 1e-12, np.inf, det)
    s = eye - corner
    q = np.cross(s, edge1)
    u, v = np.einsum("ij,ij->i", s, p) * inverse, q @ ray * inverse
    t = np.einsum("ij,ij->i", edge2, q) * inverse
    t = np.where((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-4), t, np.inf)
    nearest = t.argmin()
    return t[nearest], int(owner[nearest]) if np.isfinite(t[nearest]) else None


def _triangles(rng, instances, most=12000):
    """(corner, edge, edge, object) of the scene's largest triangles and a random sample of the others."""
    placed = [i.mesh.vertices @ i.matrix[:3, :3].T + i.matrix[:3, 3] for i in instances]
    corners = np.concatenate([vertices[i.mesh.faces] for vertices, i in zip(placed, instances)]).astype(float)
    owner = np.repeat(np.arange(len(instances)), [len(i.mesh.faces) for i in instances])
    edge1, edge2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    order = np.argsort(-np.linalg.norm(np.cross(edge1, edge2), axis=1))
    keep = np.concatenate([order[:most], rng.permutation(order[most:])[:most]])
    return corners[keep, 0], edge1[keep], edge2[keep], owner[keep]
