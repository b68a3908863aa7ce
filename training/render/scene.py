"""A renderer-independent scene description: plain data and numpy arrays.

Right-handed, z up, in meters. Colors are linear sRGB. `kinds.py` makes random scenes; `cycles.py`, `mitsuba.py` and
`luxcore.py` render them. Each renderer's docstring names the features it omits.
"""

from dataclasses import dataclass, field

import numpy as np


@dataclass
class Mesh:
    """Triangles, shaded smooth with `normals` and flat without; textures need `uvs`."""

    vertices: np.ndarray  # float32 [V,3]
    faces: np.ndarray  # int32 [F,3]
    normals: np.ndarray | None = None  # float32 [V,3]
    uvs: np.ndarray | None = None  # float32 [V,2]


@dataclass
class Material:
    """A surface. `kind` is "diffuse", "plastic" (clear coat over diffuse), "metal", "glass" or "thin_leaf" (diffuse and
    partly transmitting)."""

    kind: str = "diffuse"
    color: tuple = (0.5, 0.5, 0.5)  # albedo; reflectance of metal, transmittance of glass
    roughness: float = 0.3  # 0 is a mirror, 1 is rough; unused by diffuse and thin_leaf
    ior: float = 1.5  # for plastic and glass
    texture: np.ndarray | None = None  # float32 [H,W,3] in 0..1, replaces `color`, repeats over the uvs
    bump: np.ndarray | None = None  # float32 [H,W], heights in meters that tilt the normals, repeats over the uvs
    emission: tuple | None = None  # radiance, W/(sr m^2); an emitting surface reflects nothing


@dataclass
class Instance:
    """A mesh with a material and an affine matrix; `motion` is its movement while the shutter is open."""

    mesh: Mesh
    material: Material
    matrix: np.ndarray = field(default_factory=lambda: np.eye(4, dtype=np.float32))
    motion: np.ndarray | None = None  # float32 [3], meters


@dataclass
class PointLight:
    """A small sphere that emits in all directions."""

    position: tuple
    power: tuple  # radiant intensity, W/sr
    radius: float = 0.02


@dataclass
class Camera:
    """A pinhole, or a thin lens if `aperture` is not 0. `fov` spans the longer side, in degrees."""

    position: tuple
    target: tuple
    fov: float = 50.0
    aperture: float = 0.0  # radius of the lens, meters
    focus: float = 1.0  # focus distance, meters


@dataclass
class Scene:
    """A scene. The environment is a radiance map around z, rows from zenith to nadir; None is black."""

    kind: str
    instances: list
    cameras: list
    lights: list = field(default_factory=list)
    environment: np.ndarray | None = None  # float32 [H,W,3], W = 2H
    fog: float = 0.0  # extinction of a gray homogeneous medium around the scene, 1/m; albedo 0.9

    def reach(self):
        """Distance from the origin to the farthest vertex or camera."""
        points = [i.mesh.vertices @ i.matrix[:3, :3].T + i.matrix[:3, 3] for i in self.instances]
        points.append(np.array([camera.position for camera in self.cameras]))
        return max(float(np.linalg.norm(p, axis=1).max()) for p in points)
