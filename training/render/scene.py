"""The description of a scene that every renderer of this folder can build: plain data, numpy arrays, no renderer.

Right-handed, z up, metres. Colours are linear sRGB. `kinds.py` makes random scenes; `cycles.py`, `mitsuba.py` and
`luxcore.py` build them. A feature that a renderer lacks (see its docstring) is left out there.
"""

from dataclasses import dataclass, field

import numpy as np


@dataclass
class Mesh:
    """Triangles. `normals` (per vertex) make it smooth, without them it is flat; `uvs` are needed by textures."""

    vertices: np.ndarray  # float32 [V,3]
    faces: np.ndarray  # int32 [F,3]
    normals: np.ndarray | None = None  # float32 [V,3]
    uvs: np.ndarray | None = None  # float32 [V,2]


@dataclass
class Material:
    """One surface. `kind` is "diffuse", "plastic" (a clear coat over diffuse), "metal", "glass" or "thin_leaf"
    (diffuse on both sides, partly let through)."""

    kind: str = "diffuse"
    color: tuple = (0.5, 0.5, 0.5)  # albedo; of metal the reflectance, of glass the transmittance
    roughness: float = 0.3  # 0 is a mirror; 1 is rough; not used by diffuse and thin_leaf
    ior: float = 1.5  # of plastic and glass
    texture: np.ndarray | None = None  # float32 [H,W,3] in 0..1, in place of `color`, repeated over the uvs
    emission: tuple | None = None  # radiance of an emitting surface, W/(sr m^2); such a surface only emits


@dataclass
class Instance:
    """A mesh with a material, placed by an affine matrix; `motion` is how far it moves while the shutter is open."""

    mesh: Mesh
    material: Material
    matrix: np.ndarray = field(default_factory=lambda: np.eye(4, dtype=np.float32))
    motion: np.ndarray | None = None  # float32 [3], metres


@dataclass
class PointLight:
    """A small sphere that shines in all directions."""

    position: tuple
    power: tuple  # radiant intensity, W/sr
    radius: float = 0.02


@dataclass
class Camera:
    """A pinhole, or a thin lens where `aperture` is not 0. `fov` is of the longer side, in degrees."""

    position: tuple
    target: tuple
    fov: float = 50.0
    aperture: float = 0.0  # radius of the lens, metres
    focus: float = 1.0  # distance of what is sharp, metres


@dataclass
class Scene:
    """What is rendered. The environment is a radiance map around z (rows from zenith to nadir), or None for black."""

    kind: str
    instances: list
    cameras: list
    lights: list = field(default_factory=list)
    environment: np.ndarray | None = None  # float32 [H,W,3], W = 2H
    fog: float = 0.0  # extinction of a grey homogeneous medium around everything, 1/m; albedo 0.9

    def reach(self):
        """How far from the origin there is anything."""
        points = [i.mesh.vertices @ i.matrix[:3, :3].T + i.matrix[:3, 3] for i in self.instances]
        points.append(np.array([camera.position for camera in self.cameras]))
        return max(float(np.linalg.norm(p, axis=1).max()) for p in points)
